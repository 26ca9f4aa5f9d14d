"""`gearblocks draw`: a picture of a train from a shell."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

from gearblocks.cli.main import main


def test_draw_writes_svg(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "gearbox.svg"
    assert main(["draw", "automatic_gearbox", "-o", str(picture)]) == 0
    assert capsys.readouterr().out == f"wrote {picture}\n"
    assert ElementTree.parse(picture).getroot().tag == "{http://www.w3.org/2000/svg}svg"
    plain = picture.read_text(encoding="utf-8")
    assert main(["draw", "automatic_gearbox", "--values", "-o", str(picture)]) == 0
    assert "J = 0.18 kg m2</text>" in picture.read_text(encoding="utf-8") and "J = 0.18 kg m2</text>" not in plain


def test_draw_refuses_another_ending_before_the_train_is_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["draw", "no_such_model", "-o", str(tmp_path / "x.png")]) == 2
    assert "must end in .svg" in capsys.readouterr().err
