"""Values that are admissible but hardly meant are warned of, at the line that gave them."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import GearblocksWarning


def pair(module: float | str) -> gb.GearMesh:
    return gb.GearMesh(teeth=(23, 41), external=True, module=module, pressure_angle=0.35, k=2e8)


def test_a_module_in_millimetres_is_warned_of_where_it_is_added_and_set() -> None:
    rig = gb.Drivetrain("rig")
    words = r'GearMesh mesh\.module = 3 m \(normal module\) is implausible, more than 0\.1 m; 3 mm is written as module="3 mm"'
    with pytest.warns(GearblocksWarning, match=words) as added:
        rig.add("mesh", pair(3))
    assert Path(added[0].filename) == Path(__file__)
    with pytest.warns(GearblocksWarning, match=r"module = 2 m .* is implausible") as changed:
        rig.set({"mesh.module": 2.0})
    assert Path(changed[0].filename) == Path(__file__)


@pytest.mark.parametrize("module", [3e-3, 0.1, "3 mm", "0.2 m"])
def test_a_plausible_module_and_one_with_its_unit_pass(module: float | str) -> None:
    gb.Drivetrain("rig").add("mesh", pair(module))


def test_a_module_that_a_run_is_given_is_warned_of_too() -> None:
    rig = gb.Drivetrain("rig")
    mesh = rig.add("mesh", pair(4e-3))
    rig.chain(rig.add("pinion", gb.Inertia(J=1e-3, w0=1.0)), mesh, rig.add("wheel", gb.Inertia(J=1e-3)))
    words = r'GearMesh mesh\.module = 4 m .* is implausible.*; 4 mm is written as parameters=\{"mesh\.module": "4 mm"\}'
    with pytest.warns(GearblocksWarning, match=words) as given:
        gb.simulate(rig, t_end=1e-5, parameters={"module": 4.0})
    assert Path(given[0].filename) == Path(__file__)
    with pytest.warns(GearblocksWarning, match=words):
        gb.simulate(rig, t_end=1e-5, parameters={"module": np.float64(4.0)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gb.simulate(rig, t_end=1e-5, parameters={"mesh.module": "4 mm", "mesh.k": 2e8})
