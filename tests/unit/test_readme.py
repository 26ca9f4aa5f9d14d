"""What the README tells a new user to type."""

import math
import re
from pathlib import Path

import pytest

README = Path(__file__).parents[2] / "README.md"
BLOCKS = re.findall(r"<!-- tested -->\n```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_the_quickstart_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert len(BLOCKS) == 5
    scope: dict[str, object] = {}
    for block in BLOCKS:
        exec(block, scope)  # noqa: S102  the README's own code
        assert scope["run"].energy.residual < 1e-6  # type: ignore[attr-defined]  # the tolerance of the runs or above it
    assert (tmp_path / "mesh.png").stat().st_size > 10_000
    assert scope["study"].complete and scope["study"].shape == (3, 2)  # type: ignore[attr-defined]
    assert (tmp_path / "study.png").stat().st_size > 10_000
    assert scope["plain"].dropped == ("mesh.backlash",)  # type: ignore[attr-defined]
    assert "1 % of peak(mesh.force, after=0.05) costs " in scope["found"].sentence  # type: ignore[attr-defined]
    force = 50.0 / 3 / (42e-3 * math.cos(math.radians(20)) / 2 * 2)  # three planets share the torque on the base circle
    assert scope["run"]["gear.sun_mesh[1].force"][0] == pytest.approx(force, rel=1e-9)  # type: ignore[index]


def test_the_pictures_are_there() -> None:
    for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README.read_text(encoding="utf-8")):
        assert (README.parent / picture).is_file(), picture
