"""A torque that jumps about an angle that changes over time: a positioner follows its set point, at rest or in swings."""

from math import exp

import numpy as np
import pytest

import gearblocks as gb

LONG = pytest.mark.long
METHODS = [pytest.param(m, marks=() if m == "dp5" else LONG) for m in ("dp5", "dp8", "rodas", "auto")]
STEP = gb.piecewise((1.0, gb.time < 30.0), (2.0, True))
RAMP = gb.Table([0.0, 30.0, 40.0, 100.0], [1.0, 1.0, 2.0, 2.0])
CURVE = 1.0 + 0.005 * gb.maximum(gb.time - 30.0, 0.0) ** 2
SINE = 0.5 * gb.sin(gb.time)


def _positioner(target, beside):
    """1 N m up below the target and down beyond it, on 1 kg m2, beside what takes a part of each swing."""
    rig = gb.Drivetrain("positioner")
    drive = gb.Torque(tau=gb.piecewise((1.0, gb.sense("body.phi") < target), (-1.0, True)))
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.chain(rig.add("drive", drive), body, rig.add("beside", beside))
    if isinstance(beside, gb.Clutch):
        rig.connect(rig.add("load", gb.Inertia(J=3.0)).a, rig["beside"].b)
    if isinstance(beside, gb.Damper):
        rig.connect(rig.add("ground", gb.Fixed()).flange, rig["beside"].b)
    return gb.build(rig)


BESIDE = {"brake": gb.Brake(capacity=0.3), "damper": gb.Damper(c=3.0), "clutch": gb.Clutch(capacity=0.3)}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize("target", [STEP, RAMP], ids=["step", "ramp"])
def test_what_rests_on_its_limit_follows_a_set_point_that_goes_on(target, beside, method):
    run = gb.simulate(_positioner(target, BESIDE[beside]), t=[29.0, 32.0, 39.0, 99.0], method=method)
    assert run["body.phi"][[0, 3]] == pytest.approx([1.0, 2.0], abs=1e-6)
    assert run["body.w"][[0, 3]] == pytest.approx(0.0, abs=1e-9)
    if target is RAMP:
        assert run["body.phi"][1:3] == pytest.approx([1.2, 1.9], abs=0.02)
    elif beside == "brake":  # 0.7 rad/s2 up to the limit, and 1.3 back from there
        speed, left = (2 * 0.7) ** 0.5, 2.0 - (2 / 0.7) ** 0.5
        assert run["body.phi"][1] == pytest.approx(2.0 + speed * left - 0.65 * left**2, rel=1e-5)
    assert run.energy.residual < 2e-5


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rtol", [1e-4, pytest.param(1e-6, marks=LONG), 1e-9])
@pytest.mark.parametrize("beside", BESIDE)
def test_a_limit_that_sets_off_by_and_by_takes_along_what_rests_on_it(beside, rtol, method):
    """On the mean of both sides: its torque is 0.01 N m beside what the other asks for, too much of the damper at 63 s."""
    run = gb.simulate(_positioner(CURVE, BESIDE[beside]), t=[29.0, 31.0, 45.0, 60.0, 70.0], method=method, rtol=rtol)
    gone = run.t - 30.0
    end = 3 if beside == "damper" else 5
    assert run["body.phi"][1:end] == pytest.approx(1.0 + 0.005 * gone[1:end] ** 2, rel=10 * rtol)
    assert run["body.w"][1:end] == pytest.approx(0.01 * gone[1:end], abs=10 * rtol)
    asked = {"brake": 0.31 + 0 * gone, "damper": 0.01 + 0.03 * gone, "clutch": 0.04 + 0 * gone}[beside]
    assert run["drive.torque"][2:end] == pytest.approx(asked[2:end], rel=1e-4)
    if beside == "damper":
        leaves = next(e.t for e in run.events if e.component == "drive.switch 2" and e.t > 31.0)
        assert leaves == pytest.approx(63.0, abs=1e3 * rtol)
        assert run["body.w"][4] == pytest.approx((1 - 0.01 * exp(-21.0)) / 3, rel=10 * rtol)
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("beside", "rtol"), [("brake", 1e-4), ("brake", 1e-9), ("damper", 1e-4), ("damper", 1e-6)])
def test_it_follows_a_set_point_that_goes_to_and_fro(beside, rtol, method):
    """Friction that turns with the motion lets it off its limit for some swings at each turn."""
    element = gb.Damper(c=0.8) if beside == "damper" else BESIDE[beside]
    run = gb.simulate(_positioner(SINE, element), t=np.linspace(45.0, 60.0, 16), method=method, rtol=rtol)
    assert run["body.phi"] == pytest.approx(0.5 * np.sin(run.t), abs=max(4 * rtol, 1e-5))
    assert run["body.w"] == pytest.approx(0.5 * np.cos(run.t), abs=max(500 * rtol, 5e-3))  # its swings
    assert run.stats.events < 40000
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_swings_about_a_limit_that_goes_steadily_on_do_not_end_in_rest(rtol):
    """Beside the body the limit goes at 0.1 rad/s, and the brake slips one way: what it takes is what the torque gives."""
    run = gb.simulate(_positioner(0.1 * gb.time, BESIDE["brake"]), t=np.linspace(20.0, 60.0, 81), rtol=rtol)
    way, speed = run["body.phi"] - 0.1 * run.t, run["body.w"] - 0.1
    energy = 0.5 * speed**2 + np.where(way < 0, -0.7, 1.3) * way
    assert np.abs(way).max() < 0.01
    assert energy == pytest.approx(energy[0], rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
def test_what_starts_on_a_limit_with_its_speed_goes_with_it(method):
    rig = gb.Drivetrain("positioner on its way")
    drive = gb.Torque(tau=gb.piecewise((1.0, gb.sense("body.phi") < 0.3 * gb.time), (-1.0, True)))
    rig.chain(
        rig.add("drive", drive), rig.add("body", gb.Inertia(J=1.0, w0=0.3)), rig.add("brake", gb.Brake(capacity=0.2))
    )
    run = gb.simulate(rig, t=[0.0, 1.0, 100.0], method=method)
    assert run["body.phi"] == pytest.approx([0.0, 0.3, 30.0], abs=1e-9)
    assert run["drive.torque"][1:] == pytest.approx(0.2, rel=1e-9)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
def test_the_impulse_that_ends_the_swings_works(rtol):
    """On a body that moves: by some parts of the tolerance of its energy."""
    run = gb.simulate(_positioner(0.1 * gb.time, gb.Damper(c=3.0)), t=[20.0], rtol=rtol)
    assert any(e.after == 0.5 for e in run.events)
    assert run.energy.residual < 0.3 * rtol


def test_a_set_point_of_a_caller_moves_what_rests():
    model = _positioner(gb.Input("target", 1.0), BESIDE["brake"])
    rested = gb.simulate(model, t_end=20.0)
    assert rested["body.w"][-1] == 0.0
    gone = gb.simulate(model, t_start=20.0, t_end=50.0, initial=rested, inputs={"target": 2.0})
    assert gone["body.phi"][-1] == pytest.approx(2.0, abs=1e-6)
    ramp = gb.Table([20.0, 25.0, 35.0, 60.0], [1.0, 1.0, 0.0, 0.0])
    gone = gb.simulate(model, t_start=20.0, t_end=50.0, initial=rested, inputs={"target": ramp})
    assert gone["body.phi"][-1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_what_strikes_a_stop_while_its_speed_is_held_is_let_off(restitution, method):
    """At 0.5 rad/s from 0.5 s on, against the stop at 2.25 s; below its speed the torque is 1 N m all along."""
    rig = gb.Drivetrain("governed against a stop")
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((1.0, gb.sense("body.w") < 0.5), (-1.0, True))))
    rig.chain(
        drive, rig.add("body", gb.Inertia(J=1.0)), rig.add("stop", gb.HardStop(upper=1.0, restitution=restitution))
    )
    run = gb.simulate(rig, t=[2.0, 2.35, 9.0], method=method)
    assert run["body.w"] == pytest.approx([0.5, -0.5 * restitution + 0.1 if restitution else 0.0, 0.0], abs=1e-9)
    assert run["body.phi"][[0, 2]] == pytest.approx([0.875, 1.0], abs=1e-9)
    assert run["drive.torque"][1:] == pytest.approx(1.0, abs=1e-12)
