"""Which trains can be stepped in lanes, and the text of their laws."""

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.model.build import make_program


def _free(*parts, **more) -> gb.Drivetrain:
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(f"part{i}", part) for i, part in enumerate(parts)))
    return rig


J = gb.Inertia(J=1.0)
SHAFT = gb.Shaft(k=100.0, c=1.0)
WITH = {
    "shafts": (J, SHAFT, J),
    "a gap": (J, gb.Lash(k=100.0, c=1.0, half_gap=0.1), J),
    "an angle that nothing reads": (gb.Torque(tau=1.0), J),
    "a smooth law": (gb.Torque(tau=gb.sin(3.0 * gb.time)), J, SHAFT, J),
}
WITHOUT = {
    "friction": (J, gb.Clutch(capacity=1.0), J),
    "a gear": (J, gb.IdealGear(ratio=2.0), gb.Inertia(J=2.0), SHAFT, J, gb.Speed(w=1.0)),
    "a wave in time": (gb.Torque(tau=sp.Abs(sp.sin(3.0 * gb.time))), J),
    "a node without inertia": (J, SHAFT, gb.Shaft(k=50.0, c=1.0), J),
}


@pytest.mark.parametrize("name", WITH)
def test_trains_whose_sides_follow_from_the_state_have_lanes(name):
    text = make_program(_free(*WITH[name]).train()).lanes
    assert "gb_lane_run.h" in text
    assert "double *restrict" not in text


@pytest.mark.parametrize("name", WITHOUT)
def test_trains_with_other_switches_or_groups_that_follow_have_none(name):
    assert make_program(_free(*WITHOUT[name]).train()).lanes == ""


def test_long_trains_have_none():
    parts = [part for _ in range(40) for part in (J, SHAFT)]
    assert make_program(_free(*parts, J).train()).lanes == ""
