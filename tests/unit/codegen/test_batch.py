"""Functions of one batch: what an instance adds to its group."""

import pytest

import gearblocks as gb


def _behind_a_gear(J):
    rig = gb.Drivetrain("gear")
    motor, gear = rig.add("motor", gb.Inertia(J=1.0)), rig.add("gear", gb.IdealGear(ratio=3.0))
    load, drive = rig.add("load", gb.Inertia(J=J)), rig.add("drive", gb.Torque(tau=1.0))
    rig.chain(drive, motor, gear, load)
    return gb.simulate(rig, t=[0.0, 1.0])


def test_an_inertia_that_is_a_sum_counts_whole_behind_a_gear():
    run = _behind_a_gear(gb.Parameter("P", 1.0) + 1.0)
    assert run["motor.alpha"][0] == pytest.approx(1.0 / (1.0 + 2.0 / 9.0), rel=1e-14)
    assert run["motor.alpha"][0] == _behind_a_gear(2.0)["motor.alpha"][0]
