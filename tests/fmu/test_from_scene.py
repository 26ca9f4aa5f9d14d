"""A scene as an FMU: its train, started as the scene starts it."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from lxml import etree

import fmu_export
import gearblocks as gb


def _scene(**changed: object) -> gb.Scene:
    rig = gb.Drivetrain("wound up")
    shaft = rig.add("shaft", gb.Shaft(k=200.0, c=0.1))
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", start=2.0, unit="N m")))
    rig.chain(drive, rig.add("disc", gb.Inertia(J=0.1)), shaft, rig.add("wall", gb.Fixed()))
    scene = gb.Scene(
        rig,
        t_end=0.7,
        quantity=gb.peak("disc.phi"),
        inputs={"tau": 5.0},
        parameters={"shaft.k": 100.0},
        initial="static",
    )
    return scene.changed(**changed)


def _description(path: Path) -> tuple[dict[str, str], float]:
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    starts = {v.get("name"): v[0].get("start") for v in root.find("ModelVariables")}
    return starts, float(root.find("DefaultExperiment").get("stopTime"))


def test_an_fmu_of_a_scene_starts_and_ends_as_the_scene_does(tmp_path: Path) -> None:
    starts, end = _description(fmu_export.export(_scene(), tmp_path / "scene.fmu", platforms=()))
    assert end == 0.7
    assert float(starts["tau"]) == 5.0 and float(starts["shaft.k"]) == 100.0
    assert float(starts["shaft.coordinate.start"]) == pytest.approx(
        -5.0 / 100.0
    )  # wound up by the input of the scene, forward
    given = fmu_export.export(_scene(), tmp_path / "given.fmu", platforms=(), t_end=2.0, parameters={"shaft.k": 250.0})
    starts, end = _description(given)
    assert end == 2.0 and float(starts["shaft.coordinate.start"]) == pytest.approx(-5.0 / 250.0)


def test_an_input_that_follows_time_is_said_to_come_from_outside(tmp_path: Path) -> None:
    scene = _scene(inputs={"tau": gb.Table([0, 1], [5.0, 6.0])}, initial=None)
    with pytest.warns(gb.GearblocksWarning, match="the input 'tau' follows time in the scene") as told:
        path = fmu_export.export(scene, tmp_path / "scene.fmu", platforms=())
    assert float(_description(path)[0]["tau"]) == 2.0 and Path(told[0].filename) == Path(__file__)
    with pytest.raises(gb.ParameterError, match="export takes a gb"):
        fmu_export.export("rig", tmp_path / "scene.fmu")  # type: ignore[arg-type]
