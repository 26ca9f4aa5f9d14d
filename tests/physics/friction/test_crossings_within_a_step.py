"""Crossings that lie within one step: what sticks or lets go for a moment only."""

import numpy as np
import pytest

import gearblocks as gb


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode after) of one element."""
    return [(e.t, e.after) for e in run.events if e.component == name]


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6])
def test_a_body_that_would_turn_back_for_a_moment_sticks_in_that_moment(depth):
    """w = (t - 1)^2 - depth but for the stop; the brake holds it from w = 0 until t = 1, then it starts anew."""
    rig = _chain(
        drive=gb.Torque(tau=0.5 + 2 * (gb.time - 1)),
        body=gb.Inertia(J=1.0, w0=1.0 - depth),
        brake=gb.Brake(capacity=0.5),
    )
    run = gb.simulate(rig, t_end=3.0)
    assert [after for _, after in _modes(run, "brake")] == [0.0, 1.0]
    assert [t for t, _ in _modes(run, "brake")] == pytest.approx([1 - np.sqrt(depth), 1.0], rel=1e-9)
    assert run["body.w"][-1] == pytest.approx(4.0, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("depth", [1e-2, pytest.param(1e-4, marks=pytest.mark.long), 1e-6])
@pytest.mark.parametrize("end", [1.9, 2.3])
@pytest.mark.few(1)
def test_a_brake_whose_hold_falls_below_the_load_for_a_moment_lets_go_in_that_moment(depth, end):
    """It holds 5 - depth + (t - 1)^2, and slides with 4/5 of that: the load of 5 takes the body along for good."""
    hold = 5.0 - depth + (gb.time - 1) ** 2
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=0.8 * hold, peak=1.25))
    run = gb.simulate(rig, t_end=end)
    ((t, after),) = _modes(run, "brake")
    assert (t, after) == (pytest.approx(1 - np.sqrt(depth), rel=1e-9), 1.0)
    gain = (1 + 0.8 * depth) * (end - t) - 0.8 * ((end - 1) ** 3 - (t - 1) ** 3) / 3
    assert run["body.w"][-1] == pytest.approx(gain, rel=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("depth", [1e-1, 1e-2])
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
def test_a_brake_that_lets_go_once_a_second_does_so_every_time(depth, rtol):
    """At rest nothing but the capacity changes, and no step may be so long that one of its 20 dips is missed."""
    capacity = 6.0 - (1 + depth) * gb.cos(2 * np.pi * (gb.time - 0.5))
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=capacity))
    run = gb.simulate(rig, t_end=20.0, rtol=rtol)
    modes = _modes(run, "brake")
    assert [after for _, after in modes] == [1.0, 0.0] * 20
    first = 0.5 - np.arccos(1 / (1 + depth)) / (2 * np.pi)
    assert [t for t, after in modes if after == 1.0] == pytest.approx([first + i for i in range(20)], rel=1e-9)
