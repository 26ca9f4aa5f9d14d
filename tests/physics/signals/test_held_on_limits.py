"""Torques that jump over an angle and drive back from both sides: what is at rest on the limit stays, without a friction."""

import math

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")
PHI = gb.sense("body.phi")


def _body(tau, *, drag=None, w0=0.0, behind=None):
    """A torque on a body of 1 kg m2, with a damper to the ground, with a shaft to a body behind it that turns."""
    rig = gb.Drivetrain("held")
    torque, body = rig.add("torque", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=1.0, w0=w0))
    rig.connect(torque.flange, body.a)
    if drag is not None:
        damper = rig.add("drag", gb.Damper(c=drag))
        rig.connect(damper.a, body.b)
        rig.connect(damper.b, rig.add("ground", gb.Fixed()).flange)
    if behind is not None:
        shaft, other = rig.add("shaft", gb.Shaft(k=1.0)), rig.add("other", gb.Inertia(J=1.0, w0=behind))
        rig.connect(shaft.a, body.b)
        rig.connect(shaft.b, other.a)
    return gb.build(rig)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("condition", [gb.sin(8 * PHI) > 0, PHI > 0])
def test_what_starts_on_a_limit_rests_there_until_its_load_exceeds_the_jump(condition, method):
    """w' = t - 2 share = 0 until 2 s, and (t - 2) after."""
    run = gb.simulate(_body(gb.time + gb.piecewise((-2, condition), (0, True))), t=np.linspace(0, 3, 31), method=method)
    resting = run.t <= 2.0
    assert np.abs(run["body.w"][resting]).max() == np.abs(run["body.phi"][resting]).max() == 0.0
    assert np.abs(run["torque.torque"][1:20]).max() < 1e-12
    assert run["body.w"][-1] == pytest.approx(0.5, rel=1e-6)
    assert run["body.phi"][-1] == pytest.approx(1 / 6, rel=1e-6)
    assert [e.t for e in run.events if e.after == 1.0 or e.before == 0.5] == [pytest.approx(2.0, abs=1e-9)]


@pytest.mark.parametrize("method", METHODS)
def test_a_body_that_turns_behind_a_shaft_pulls_it_off(method):
    """The shaft carries sin t while its other end swings at 1 rad/s: 0.5 at pi/6."""
    run = gb.simulate(_body(gb.piecewise((-0.5, PHI > 0), (0.5, True)), behind=1.0), t_end=0.6, method=method)
    left = [e.t for e in run.events if e.before == 0.5]
    assert left == [pytest.approx(math.pi / 6, rel=1e-5)]
    resting = run.t <= math.pi / 6 - 1e-4
    assert np.abs(run["body.w"][resting]).max() == 0.0
    assert -run["shaft.torque"][resting] == pytest.approx(np.sin(run.t[resting]), abs=1e-5)
    assert run["body.w"][-1] > 0.0
    assert abs(run.energy.residual) < 1e-5


@pytest.mark.parametrize("method", METHODS)
def test_swings_that_fade_end_in_rest_where_the_tolerance_tells_them_no_more(method):
    """Each half takes 2/3 D v^2 of v, without an end; at rest until a ramp exceeds the torque, at 6 s."""
    ramp = gb.Table([0.0, 4.0, 10.0], [0.0, 0.0, 3.0])
    model = _body(ramp + gb.piecewise((-1, PHI > 0), (1, True)), drag=10.0, w0=0.1)
    run = gb.simulate(model, t=np.linspace(0, 7, 71), method=method, rtol=1e-4)
    rest = next(e.t for e in run.events if e.after == 0.5)
    assert rest < 4.0
    assert len(run.events) < 20000
    resting = (run.t > rest) & (run.t <= 6.0)
    assert np.abs(run["body.w"][resting]).max() < 1e-12
    assert np.abs(run["body.phi"][resting]).max() < 1e-8
    assert run["body.w"][-1] == pytest.approx(0.5 * (0.1 - 0.01 * (1 - math.exp(-10.0))), rel=1e-2)
    assert abs(run.energy.residual) < 1e-3


@pytest.mark.parametrize("method", METHODS)
def test_swings_without_a_loss_go_on(method):
    run = gb.simulate(_body(gb.piecewise((-1, PHI > 0), (1, True)), w0=0.1), t_end=29.9, method=method)
    assert len(run.events) == 149
    at = np.isin(run.t, [e.t for e in run.events])
    assert np.abs(run["body.w"][at]) == pytest.approx(0.1, rel=1e-5)


def test_a_limit_that_moves_does_not_hold():
    """phi follows 0.1 t in swings about it, of the speed by which it started off: 0.1 rad/s."""
    run = gb.simulate(_body(gb.piecewise((-1, 0.1 * gb.time < PHI), (1, True))), t_end=2.0)
    assert all(e.after != 0.5 for e in run.events)
    assert np.abs(run["body.w"] - 0.1).max() == pytest.approx(0.1, rel=1e-3)
