"""Instants at which several things meet: capacities that leave zero smoothly, announced instants on located ones, tables."""

import math

import numpy as np
import pytest

import gearblocks as gb


def test_a_capacity_that_leaves_zero_without_a_slope_engages_at_that_instant_every_time():
    angle = 262.0 * gb.time + 0.9
    u = gb.Table([1.0, 1.3, 2.0, 2.3, 1.0 + math.tau], [0.0, 1.0, 1.0, 0.0, 0.0], periodic=True)(angle)
    rig = gb.Drivetrain("periodic clutch")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1e4))
    rig.connect(rig.add("brake", gb.Brake(capacity=3 * u**2 - 2 * u**3)).a, body.a)
    run = gb.simulate(rig, t_end=1.0)
    modes = [(e.t, e.after) for e in run.events if e.component == "brake"]
    assert len(modes) == 2 * 42
    closes, opens = np.array([t for t, m in modes if m == 1]), np.array([t for t, m in modes if m == 2])
    # joints of the table to the rounding of times of 1 s
    assert np.abs(closes - (0.1 + math.tau * np.arange(len(closes))) / 262.0).max() < 1e-14
    assert np.abs(opens - (1.4 + math.tau * np.arange(len(opens))) / 262.0).max() < 1e-14
    # u is symmetric, so that each closing takes 0.7 + 0.3 rad of the full torque
    assert run["body.w"][-1] == pytest.approx(1e4 - (len(opens) + (len(closes) > len(opens))) / 262.0, rel=1e-9)


def test_steps_of_a_table_are_taken_where_a_located_switch_falls_on_them():
    rig = gb.Drivetrain("two clocks")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    steps = gb.Table([0.0, 0.1, 0.2, 0.3], [1.0, 2.0, 3.0, 1.0], kind="step", periodic=True)
    rig.connect(rig.add("drive", gb.Torque(tau=1e-30 * steps)).flange, body.a)
    # the angle of the body is the time: its table has its joints at the same instants
    saw = gb.Table([0.0, 0.1, 0.2, 0.3], [0.0, 1.0, -1.0, 0.0], periodic=True)(gb.sense("body.phi"))
    rig.connect(rig.add("more", gb.Torque(tau=1e-30 * saw)).flange, body.b)
    run = gb.simulate(rig, t_end=9.95, rtol=1e-10)
    told = [e for e in run.events if e.component == "drive.table"]
    assert len(told) == 99
    assert [e.after for e in told] == list(range(1, 100))


@pytest.mark.parametrize(
    "period", [0.3, *(pytest.param(x, marks=pytest.mark.long) for x in (0.7, 1.1)), math.tau, 1e-3]
)
@pytest.mark.few(1)
def test_a_periodic_table_over_an_angle_is_passed_turn_by_turn(period):
    rig = gb.Drivetrain("saw")
    saw = gb.Table([0.0, 0.3 * period, 0.6 * period, period], [0.0, 1.0, -1.0, 0.0], periodic=True)(
        gb.sense("body.phi")
    )
    rig.connect(rig.add("body", gb.Inertia(J=1.0, w0=1.0)).a, rig.add("drive", gb.Torque(tau=1e-30 * saw)).flange)
    run = gb.simulate(rig, t_end=100.1 * period)
    assert [e.after for e in run.events] == list(range(1, 301))


@pytest.mark.long
def test_conditions_on_sums_of_steps_are_frozen():
    pressed = (
        gb.piecewise((0, gb.time < 0.3), (1, True))
        - gb.piecewise((0, gb.time < 0.6), (1, True))
        + gb.piecewise((0, gb.time < 0.8), (1, True))
    )
    tau = gb.piecewise((1.0, pressed > 0.5), (2.0, True))
    rig = gb.Drivetrain("sums of steps")
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=1.0)
    assert run["body.w"][-1] == pytest.approx(2.0 - 0.5, abs=1e-12)
