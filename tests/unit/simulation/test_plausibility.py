"""What studies, regimes and linear tools are given for parameters is doubted as what runs are given: once for each path."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from gearblocks.errors import GearblocksWarning

SECTION = gb.stroboscopic("drive")
PEAK: dict[str, Any] = {"quantity": gb.peak("mesh.force"), "t_end": 1e-5, "threads": 1}
REGIME: dict[str, Any] = {"section": SECTION, "transient": 2}
WORDS = r"GearMesh mesh\.module = 4 m .* is implausible, more than 0\.1 m; 4 mm is written as "


@pytest.fixture(scope="module")
def rig() -> gb.Drivetrain:
    made, drive = gb.Drivetrain("rig"), gb.Parameter("drive", 1e3, "rad/s")
    mesh = gb.GearMesh(teeth=(23, 41), external=True, module=4e-3, pressure_angle=0.35, k=2e4, damping_ratio=0.1)
    made.chain(
        made.add("ground", gb.Fixed()), made.add("shaft", gb.Shaft(k=10.0, c=0.1)), made.add("pinion", gb.Inertia(J=1e-3)),
        made.add("mesh", mesh), made.add("wheel", gb.Inertia(J=1e-3)), made.add("tau", gb.Torque(tau=gb.cos(drive * gb.time))),
    )  # fmt: skip
    return made


def _told(ask: Callable[[], Any]) -> list[str]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        ask()
    mine = [one for one in found if issubclass(one.category, GearblocksWarning)]
    assert all(Path(one.filename) == Path(__file__) for one in mine)
    return [str(one.message) for one in mine]


@pytest.mark.parametrize(
    "ask",
    [
        lambda rig: gb.sweep(rig, {"module": [4e-3, 2.0, 4.0]}, **PEAK),
        lambda rig: gb.sweep(rig, {"mesh.module": np.array([4.0, 4e-3]), "shaft.k": [1.0, 2.0]}, **PEAK),
        lambda rig: gb.study(rig, [{"mesh.module": 4}, {"mesh.module": "3 mm"}], **PEAK),
        lambda rig: gb.study(rig, {"mesh.module": [4.0, 4.0], "pinion.w": [1.0, 2.0]}, **PEAK),
        lambda rig: gb.speed_sweep(rig, "mesh.module", [3e-3, 4.0], keep=2, **REGIME),
        lambda rig: gb.bifurcation(rig, "mesh.module", [3.0, 4.0], keep=3, longest=1, **REGIME),
        lambda rig: gb.bifurcation(rig, "mesh.module", 4.0, keep=3, longest=1, carry=False, threads=1, **REGIME),
    ],
)
def test_a_row_with_a_module_in_millimetres_is_warned_of_once_by_its_largest_number(
    rig: gb.Drivetrain, ask: Any
) -> None:
    (words,) = _told(lambda: ask(rig))
    assert re.fullmatch(WORDS + r'\{"mesh\.module": \["4 mm"\]\}', words)


@pytest.mark.parametrize(
    "ask",
    [
        lambda rig, given: gb.sweep(rig, {"shaft.k": [1.0, 2.0, 3.0]}, parameters=given, **PEAK),
        lambda rig, given: gb.speed_sweep(rig, "drive", [1e3, 2e3], keep=2, parameters=given, **REGIME),
        lambda rig, given: gb.classify(rig, SECTION, transient=2, keep=3, longest=1, lasting=0, parameters=given),
        lambda rig, given: gb.spectrum(rig, section=SECTION, transient=600, longest=1, samples=8, parameters=given),
        lambda rig, given: gb.modes(rig, parameters=given),
        lambda rig, given: gb.linearize(rig, parameters=given),
        lambda rig, given: gb.campbell(rig, "drive", [1e3, 2e3], orders=[1.0], parameters=given),
    ],
)
def test_parameters_of_what_looks_at_many_points_are_warned_of_once(rig: gb.Drivetrain, ask: Any) -> None:
    (words,) = _told(lambda: ask(rig, {"module": 4}))
    assert words.endswith('; 4 mm is written as parameters={"mesh.module": "4 mm"}')
    assert _told(lambda: ask(rig, {"module": "4 mm"})) == []


def test_an_fmu_is_warned_of_too(rig: gb.Drivetrain, tmp_path: Path) -> None:
    assert len(_told(lambda: fmu_export.export(rig, tmp_path / "rig.fmu", parameters={"module": 4.0}))) == 1


@pytest.mark.parametrize("row", [["3 mm", "0.2 m"], [2e-3, 0.1], np.linspace(1e-3, 9e-3, 3)])
def test_plausible_rows_and_those_with_their_unit_pass(rig: gb.Drivetrain, row: Any) -> None:
    assert _told(lambda: gb.sweep(rig, {"mesh.module": row}, **PEAK)) == []
    assert _told(lambda: gb.bifurcation(rig, "mesh.module", row, keep=3, longest=1, carry=False, **REGIME)) == []
