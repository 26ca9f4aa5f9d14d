"""Capacities that jump between exactly 0 and more over a speed: the mean of both sides holds it, against closed forms."""

import numpy as np
import pytest

import gearblocks as gb

METHODS = [("auto", 1e-6), ("dp5", 1e-9), ("dp8", 1e-9), ("rodas", 1e-7)]
W = gb.sense("body.w")
ON_ABOVE_3 = gb.piecewise((5, W > 3), (0, True))
BRAKES = {
    "capacity": {"capacity": ON_ABOVE_3},
    "engagement": {"mu": 0.5, "force_max": 10.0, "engagement": ON_ABOVE_3 / 5},
}


def _braked(tau, **brake):
    rig = gb.Drivetrain("governor")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    rig.connect(body.b, rig.add("brake", gb.Brake(**brake)).a)
    return rig


@pytest.mark.parametrize("brake", BRAKES)
@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(3)
def test_a_brake_that_goes_on_above_a_speed_holds_it(brake, method, rtol):
    run = gb.simulate(_braked(2.0, **BRAKES[brake]), t=np.linspace(0.0, 4.0, 41), method=method, rtol=rtol)
    assert np.abs(run["body.w"] - np.minimum(2 * run.t, 3.0)).max() < 10 * rtol
    assert run["brake.torque"][-1] == pytest.approx(2.0, abs=1e-9)
    assert run["brake.loss_power"][-1] == pytest.approx(6.0, abs=1e-9)
    assert run.energy.dissipated["brake"] == pytest.approx(15.0, rel=10 * rtol)
    assert run.energy.residual < 10 * rtol


def test_it_holds_a_speed_turned_around():
    run = gb.simulate(_braked(-2.0, capacity=gb.piecewise((5, W < -3), (0, True))), t_end=4.0)
    assert run["body.w"][-1] == pytest.approx(-3.0, abs=1e-9)
    assert run["brake.loss_power"][-1] == pytest.approx(6.0, abs=1e-9)


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(2)
def test_it_lets_go_on_either_side(method, rtol):
    """The drive drops to -1, where the brake would have to push; comes back; and rises to 7, more than the brake has."""
    tau = gb.Table([0.0, 3.0, 4.0, 6.0], [2.0, -1.0, 2.0, 7.0], "step")
    run = gb.simulate(_braked(tau, capacity=ON_ABOVE_3), t=[2.9, 4.0, 5.9, 7.0], method=method, rtol=rtol)
    assert run["body.w"] == pytest.approx([3.0, 2.0, 3.0, 5.0], abs=30 * rtol)
    assert run["brake.torque"] == pytest.approx([2.0, 0.0, 2.0, 5.0], abs=1e-8)
    assert run["brake.mode"][[1, 3]].tolist() == [2.0, 1.0]  # free, slips


def _clutched(capacity, drive, load, w0):
    rig = gb.Drivetrain("slip")
    a, b = rig.add("a", gb.Inertia(J=1.0, w0=w0)), rig.add("b", gb.Inertia(J=0.5))
    clutch = rig.add("clutch", gb.Clutch(capacity=capacity))
    rig.chain(rig.add("drive", gb.Torque(tau=drive)), a, clutch, b, rig.add("load", gb.Torque(tau=load)))
    return rig


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(2)
def test_a_clutch_that_holds_its_drive_sticks_when_the_other_side_has_come_up(method, rtol):
    """At 3 rad/s from 1.5 s on; b comes up with 2/0.5 until 2.25 s; then both rise with 2/1.5."""
    rig = _clutched(gb.piecewise((5, gb.sense("a.w") > 3), (0, True)), 2.0, 0.0, 0.0)
    run = gb.simulate(rig, t=[1.6, 2.0, 2.2, 3.0], method=method, rtol=rtol)
    assert run["a.w"] == pytest.approx([3.0, 3.0, 3.0, 4.0], abs=30 * rtol)
    assert run["b.w"] == pytest.approx([0.4, 2.0, 2.8, 4.0], abs=30 * rtol)
    assert run["clutch.mode"][-1] == 0.0
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(2)
def test_a_clutch_that_limits_what_it_drives_sticks_when_its_drive_has_come_down(method, rtol):
    """b at 1 rad/s from 0.125 s on against a load of 1; a comes down to it at 1.5 s; then both fall with 1/1.5."""
    rig = _clutched(gb.piecewise((5, gb.sense("b.w") < 1), (0, True)), 0.0, -1.0, 3.0)
    run = gb.simulate(rig, t=[0.125, 0.6, 1.4, 2.5], method=method, rtol=rtol)
    assert run["b.w"] == pytest.approx([1.0, 1.0, 1.0, 1 / 3], abs=30 * rtol)
    assert run["a.w"] == pytest.approx([2.375, 1.9, 1.1, 1 / 3], abs=30 * rtol)
    assert run["clutch.mode"][-1] == 0.0


@pytest.mark.parametrize(("first", "second"), [(5.0, 3.0), (1.5, 1.5), (0.5, 3.0)])
@pytest.mark.few(2)
def test_two_brakes_at_one_limit_hold_its_drive_together(first, second):
    """How they share it nothing tells; together they take 2 N m."""
    rig = gb.Drivetrain("governor")
    one, other = (gb.Brake(capacity=gb.piecewise((x, W > 3), (0, True))) for x in (first, second))
    body, brake = rig.add("body", gb.Inertia(J=1.0)), rig.add("brake", one)
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=2.0)).flange, brake.a, rig.add("other", other).a)
    run = gb.simulate(rig, t_end=4.0)
    assert run["body.w"][-1] == pytest.approx(3.0, abs=1e-9)
    assert run["brake.torque"][-1] + run["other.torque"][-1] == pytest.approx(2.0, abs=1e-8)
