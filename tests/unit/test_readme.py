"""What the README tells a new user to type."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[2] / "README.md"
BLOCKS = re.findall(r"<!-- tested -->\n```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_the_quickstart_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(BLOCKS) == 2
    scope: dict[str, object] = {}
    for block in BLOCKS:
        exec(block, scope)  # noqa: S102  the README's own code
    assert (tmp_path / "mesh.png").stat().st_size > 10_000
    assert scope["plain"].dropped == ("mesh.backlash",)  # type: ignore[attr-defined]
    assert scope["run"].energy.residual < 1e-7  # type: ignore[attr-defined]


def test_the_pictures_are_there() -> None:
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README.read_text(encoding="utf-8")):
        assert (README.parent / picture).is_file(), picture
