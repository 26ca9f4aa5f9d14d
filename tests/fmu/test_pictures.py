"""The picture of a train in its FMU: in the documentation, and as the icon that tools show."""

import pickle
import zipfile
from pathlib import Path

import pytest

import fmu_export
import gearblocks as gb
from fmu_export.exporter import ICON


def _swing() -> gb.Drivetrain:
    rig = gb.Drivetrain("swing")
    rig.chain(rig.add("disc", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=100.0)), rig.add("wall", gb.Fixed()))
    return rig


def test_the_fmu_of_a_train_shows_its_scheme(tmp_path: Path) -> None:
    rig = _swing()
    path = fmu_export.export(rig, tmp_path / "swing.fmu", platforms=())
    with zipfile.ZipFile(path) as archive:
        page, icon = archive.read("documentation/index.html").decode(), archive.read("model.png")
    assert str(rig.draw()) in page and icon.startswith(b"\x89PNG")
    assert '<div class="wide">\n<table>' in page and ".wide { overflow-x: auto; }" in page
    width = float(str(rig.draw()).split('width="')[1].split('"')[0])
    assert (
        f'<div class="wide" style="--least: {round(0.75 * width)}px"><svg' in page
    )  # on a telephone it is moved aside
    assert "overflow-wrap: break-word" in page and "0.5rem 100% no-repeat scroll" in page  # the hint that it goes on


@pytest.mark.long
def test_an_fmu_with_pictures_passes_every_check(tmp_path: Path) -> None:
    path = fmu_export.export(_swing(), tmp_path / "swing.fmu")
    with zipfile.ZipFile(path) as archive:
        assert ICON in archive.namelist()
    assert fmu_export.check(path).ok


@pytest.mark.long
def test_the_fmu_of_a_built_model_shows_the_same_scheme_and_one_of_a_pickle_has_none(tmp_path: Path) -> None:
    rig = _swing()
    model = gb.build(rig)
    path = fmu_export.export(model, tmp_path / "model.fmu")
    with zipfile.ZipFile(path) as archive:
        assert str(rig.draw()) in archive.read("documentation/index.html").decode() and ICON in archive.namelist()
    again = fmu_export.export(pickle.loads(pickle.dumps(model)), tmp_path / "again.fmu")
    with zipfile.ZipFile(again) as archive:
        assert ICON not in archive.namelist() and "<svg" not in archive.read("documentation/index.html").decode()
