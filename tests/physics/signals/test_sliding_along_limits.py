"""Conditions whose both sides drive the motion back: it slides along the limit (Filippov 1960), against closed forms."""

import math

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

METHODS = [("auto", 1e-6), ("dp5", 1e-9), ("dp8", 1e-9), ("rodas", 1e-7)]
W = gb.sense("body.w")


def _run(tau, *loads, w0=0.0, t_end=2.0, method="auto", rtol=1e-6, **arguments):
    rig = gb.Drivetrain("wheel")
    flanges = [rig.add("body", gb.Inertia(J=1.0, w0=w0)).a, rig.add("drive", gb.Torque(tau=tau)).flange]
    flanges += [rig.add(f"load{i}", gb.Torque(tau=x)).flange for i, x in enumerate(loads)]
    rig.connect(*flanges)
    return gb.simulate(rig, t=np.linspace(0.0, t_end, 41), method=method, rtol=rtol, **arguments)


@pytest.mark.parametrize(("method", "rtol"), METHODS)
def test_a_controller_that_goes_on_and_off_holds_its_speed(method, rtol):
    run = _run(gb.piecewise((2, W < 1), (-1, True)), method=method, rtol=rtol)
    assert np.abs(run["body.w"] - np.minimum(2 * run.t, 1.0)).max() < 10 * rtol
    assert np.abs(run["drive.torque"][run.t > 0.5]).max() < 1e-12  # nothing is needed to hold it
    assert [(e.component, e.after) for e in run.events] == [("drive.switch 1", 0.5)]
    assert run.events[0].t == pytest.approx(0.5, abs=1e-12)
    assert run.energy.supplied["drive"] == pytest.approx(0.5, rel=10 * rtol)
    assert run.energy.residual < 10 * rtol


@pytest.mark.long
@pytest.mark.parametrize(("method", "rtol"), METHODS)
def test_it_lets_go_when_its_torque_no_longer_suffices(method, rtol):
    """Held from 1 rad/s on while the load 2 sin 3t - 1/2 lies between what both sides can bear."""
    run = _run(gb.piecewise((3, W < 1), (-1, True)), 2 * gb.sin(3 * gb.time) - 0.5, w0=1.0, method=method, rtol=rtol)
    lets_go = math.asin(0.75) / 3  # 2 sin 3t - 1/2 = 1
    back = math.pi / 3 - lets_go  # and drives it on until then, slows it down after that
    held = (run.t > 0) & (run.t < lets_go)
    assert np.abs(run["body.w"] - 1.0)[held].max() < max(1e-11, 1e-3 * rtol)
    assert np.abs(run["drive.torque"] - 0.5 + 2 * np.sin(3 * run.t))[held].max() < 1e-9
    first = run.events[1]
    assert (first.before, first.after) == (0.5, 0.0)
    assert first.t == pytest.approx(lets_go, abs=20 * rtol)
    between = (run.t > lets_go) & (run.t < back)
    above = 1 - 2 / 3 * (np.cos(3 * run.t) - math.cos(3 * lets_go)) - 1.5 * (run.t - lets_go)
    assert np.abs(run["body.w"] - above)[between].max() < 20 * rtol


@pytest.mark.long
@pytest.mark.parametrize(("method", "rtol"), METHODS)
def test_a_limit_that_moves_is_followed(method, rtol):
    run = _run(gb.piecewise((5, gb.sin(2 * gb.time) + 1 > W), (-5, True)), t_end=6.0, method=method, rtol=rtol)
    held = run.t > 1.0
    assert np.abs(run["body.w"] - np.sin(2 * run.t) - 1.0)[held].max() < 10 * rtol
    assert np.abs(run["drive.torque"] - 2 * np.cos(2 * run.t))[held].max() < 1e-6
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(1)
def test_friction_written_as_a_sign_sticks_as_a_brake_does(method, rtol):
    pull = 4 * gb.sin(2 * gb.time)
    by_hand = _run(gb.piecewise((-2, W > 0), (2, True)), pull, w0=3.0, t_end=5.0, method=method, rtol=rtol)
    rig = gb.Drivetrain("brake")
    body, brake = rig.add("body", gb.Inertia(J=1.0, w0=3.0)), rig.add("drive", gb.Brake(capacity=2.0))
    rig.connect(body.a, brake.a, rig.add("pull", gb.Torque(tau=pull)).flange)
    braked = gb.simulate(rig, t=by_hand.t, method=method, rtol=rtol)
    assert np.abs(by_hand["body.w"] - braked["body.w"]).max() < 30 * rtol
    assert np.abs(by_hand["drive.torque"] + braked["drive.torque"]).max() < 1e-3
    assert by_hand.energy.dissipated.get("drive", 0.0) == pytest.approx(0.0)  # a source of its own
    assert sum(e.after == 0.5 for e in by_hand.events) == 1


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_errors_while_it_slides_fall_with_the_order_of_the_method(method):
    """y' = 3 - w on a limit over two speeds: a shaft that winds up at the controlled rate."""
    errors = []
    for rtol in (1e-5, 1e-7, 1e-9):
        rig = gb.Drivetrain("winder")
        a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=0.5))
        shaft = rig.add("shaft", gb.Shaft(k=100.0))
        drive = rig.add("drive", gb.Torque(tau=gb.piecewise((60, gb.sense("a.w") < 1), (-60, True))))
        rig.connect(a.a, drive.flange)
        rig.connect(a.b, shaft.a)
        rig.connect(shaft.b, b.a)
        run = gb.simulate(rig, t=np.linspace(0.0, 2.0, 41), method=method, rtol=rtol)
        start = run.events[0].t
        after = run.t > start
        # from the reversal on, b swings on a shaft whose other end turns at 1 rad/s
        w, phi = np.sqrt(200.0), run.t[after] - start
        run_up = gb.simulate(rig, t=[0.0, start * (1 - 1e-13)], method="dp8", rtol=1e-12)
        w0, twist = run_up["b.w"][-1] - 1.0, run_up["shaft.twist"][-1]
        expected = 1.0 + w0 * np.cos(w * phi) - w * twist * np.sin(w * phi)
        errors.append(np.abs(run["b.w"][after] - expected).max())
        assert np.abs(run["a.w"][after] - 1.0).max() < 1e-10
    assert errors[0] < 1e-3
    assert errors[2] < 1e-7
    assert errors[2] < 1e-3 * errors[0]


@pytest.mark.long
def test_two_controllers_on_two_wheels_hold_both():
    rig = gb.Drivetrain("two")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=0.5))
    damper = rig.add("damper", gb.Damper(c=1.5))
    up = rig.add("up", gb.Torque(tau=gb.piecewise((6, gb.sense("a.w") < 2), (-1, True))))
    down = rig.add("down", gb.Torque(tau=gb.piecewise((-3, gb.sense("b.w") > 1.5), (1, True))))
    rig.connect(a.a, up.flange)
    rig.connect(a.b, damper.a)
    rig.connect(damper.b, b.a)
    rig.connect(b.b, down.flange)
    run = gb.simulate(rig, t_end=3.0)
    assert run["a.w"][-1] == pytest.approx(2.0, abs=1e-10)
    assert run["b.w"][-1] == pytest.approx(1.5, abs=1e-10)
    assert run["up.torque"][-1] == pytest.approx(0.75, abs=1e-8)  # what the damper takes at 0.5 rad/s
    assert run["down.torque"][-1] == pytest.approx(-0.75, abs=1e-8)
    assert run.energy.residual < 1e-5


@pytest.mark.long
def test_a_limit_over_a_power_is_held():
    """w^2 and a feedback of both: event functions that are not affine in the states."""
    run = _run(gb.piecewise((3, W * W + 0.1 * W < 1.1), (-2, True)), 0.5 * gb.cos(4 * gb.time), rtol=1e-8)
    assert np.abs(run["body.w"] - 1.0)[run.t > 0.6].max() < 1e-7
    assert np.abs(run["drive.torque"] + 0.5 * np.cos(4 * run.t))[run.t > 0.6].max() < 1e-6


@pytest.mark.long
def test_maxima_and_steps_of_tables_slide_as_pieces_do():
    levels = gb.Table([-100.0, 0.0, 100.0], [2.0, -2.0, -2.0], kind="step")(W)
    run = _run(sp.Max(levels, -3), w0=1.0)
    assert np.abs(run["body.w"] - np.maximum(1 - 2 * run.t, 0.0)).max() < 1e-5
    assert run["body.phi"][-1] == pytest.approx(0.25, abs=1e-5)


@pytest.mark.long
def test_a_held_run_repeats_bit_for_bit():
    rig = gb.Drivetrain("wheel")
    tau = gb.piecewise((3, W < 1), (-1, True))
    load = rig.add("load", gb.Torque(tau=0.7 * gb.sin(3 * gb.time)))
    rig.connect(rig.add("body", gb.Inertia(J=1.0)).a, rig.add("drive", gb.Torque(tau=tau)).flange, load.flange)
    once = gb.simulate(rig, t=[0.0, 1.0, 2.0])
    again = gb.simulate(rig, t=[0.0, 1.0, 2.0])
    for name in ("body.w", "body.phi", "drive.torque"):
        assert (once[name] == again[name]).all()
    assert once["body.w"][-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.long
def test_what_a_stuck_clutch_carries_along_is_held_with_its_drive():
    """J = 2 rises at 1 rad/s^2 to the limit and stays there."""
    rig = gb.Drivetrain("clutch")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=1.0))
    clutch = rig.add("clutch", gb.Clutch(capacity=50.0))
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((2, gb.sense("a.w") < 1), (-1, True))))
    rig.connect(a.a, drive.flange)
    rig.connect(a.b, clutch.a)
    rig.connect(clutch.b, b.a)
    for method in ("auto", "dp5", "dp8", "rodas"):
        run = gb.simulate(rig, t_end=3.0, method=method)
        assert np.abs(run["a.w"] - np.minimum(run.t, 1.0)).max() < 1e-11
        assert np.abs(run["b.w"] - run["a.w"]).max() < 1e-11


def _behind_a_one_way_clutch(load):
    """A controller on a driven wheel, and another wheel that a one-way clutch takes along, and lets ahead beyond 0.3 N m."""
    rig = gb.Drivetrain("one way")
    first, second = rig.add("first", gb.Inertia(J=1.0)), rig.add("second", gb.Inertia(J=1.0))
    clutch = rig.add("clutch", gb.OneWayClutch(capacity=0.3))
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((5.0, gb.sense("first.w") < 2.0), (-1.0, True))))
    rig.connect(first.a, clutch.a, drive.flange)
    rig.connect(second.a, clutch.b, rig.add("load", gb.Torque(tau=load)).flange)
    return gb.build(rig)


@pytest.mark.parametrize("method", ["auto", "dp5", "rodas"])
def test_a_clutch_that_one_side_alone_would_open_holds_by_the_mean(method):
    """2.5 rad/s2 until 2 rad/s; the other side asks -0.5 N m of the clutch, the mean none, until the load asks 0.3 N m."""
    load = gb.Table([0.0, 1.0, 4.0], [0.0, 0.0, 0.6])
    run = gb.simulate(_behind_a_one_way_clutch(load), t=np.linspace(0, 3.5, 36), method=method)
    held = (run.t > 0.85) & (run.t <= 2.5)
    for name in ("first.w", "second.w"):
        assert run[name][held] == pytest.approx(2.0, abs=1e-9)
    assert run["clutch.torque"][held] == pytest.approx(-0.2 * np.maximum(run.t[held] - 1.0, 0.0), abs=1e-9)
    assert run["first.w"][-1] == pytest.approx(2.0, abs=1e-9)
    assert run["second.w"][-1] == pytest.approx(2.1, abs=1e-6)
    assert [e.t for e in run.events if e.component == "clutch"][-1] == pytest.approx(2.5, abs=1e-6)
    assert abs(run.energy.residual) < 1e-6
