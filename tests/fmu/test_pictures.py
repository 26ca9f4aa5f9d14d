"""The picture of a train in its FMU: in the documentation, and as the icon that tools show."""

import zipfile
from pathlib import Path

import fmu_export
import gearblocks as gb


def test_the_fmu_of_a_train_shows_its_scheme(tmp_path: Path) -> None:
    rig = gb.Drivetrain("swing")
    rig.chain(rig.add("disc", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=100.0)), rig.add("wall", gb.Fixed()))
    path = fmu_export.export(rig, tmp_path / "swing.fmu")
    with zipfile.ZipFile(path) as archive:
        page, icon = archive.read("documentation/index.html").decode(), archive.read("model.png")
    assert str(rig.draw()) in page and icon.startswith(b"\x89PNG")
    assert fmu_export.check(path).ok
    model = fmu_export.export(gb.build(rig), tmp_path / "model.fmu")
    with zipfile.ZipFile(model) as archive:
        assert "model.png" not in archive.namelist() and "<svg" not in archive.read("documentation/index.html").decode()
