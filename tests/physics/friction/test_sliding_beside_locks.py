"""Friction that jumps over the slip, held on its jump, beside locks that pass its torque on: balances of torques."""

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["auto", "dp5", "dp8", "rodas"]
STEP = gb.Table([0.0, 2.0], [4.0, 5.0], "step")  # N m below and above 2 rad/s
RAMP = 4.5 + 0.1 * gb.time  # between both until 5 s
LOCKS = {
    "clutch": lambda: gb.Clutch(capacity=50.0),
    "peak": lambda: gb.Clutch(capacity=5.0, peak=1.1),
    "dog": lambda: gb.DogClutch(engaged=1.0),
    "freewheel": gb.Freewheel,
    "one way": lambda: gb.OneWayClutch(capacity=20.0),
    "stop": lambda: gb.HardStop(lower=0.0, restitution=0.0),
}


def _driven_through(lock, sense, w0, order=1):
    """The load on one body, the friction on another one, and the lock between them."""
    parts = {"first": gb.Inertia(J=1.0, w0=w0 * sense), "lock": LOCKS[lock](), "last": gb.Inertia(J=3.0, w0=w0 * sense)}
    parts |= {"load": gb.Torque(tau=RAMP * sense), "rub": gb.BearingFriction(torque=STEP)}
    rig = gb.Drivetrain("through a lock")
    h = {name: rig.add(name, parts[name]) for name in list(parts)[::order]}
    ends = (
        (h["lock"].a, h["lock"].b) if sense > 0 else (h["lock"].b, h["lock"].a)
    )  # one-way locks push along the motion
    rig.connect(h["load"].flange, h["first"].a)
    rig.connect(h["first"].b, ends[0])
    rig.connect(h["last"].a, ends[1])
    rig.connect(h["last"].b, h["rub"].a)
    return rig


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("lock", "sense"), [(lock, sense) for lock in LOCKS for sense in (1.0, -1.0)])
@pytest.mark.few(1)
def test_a_lock_passes_on_what_holds_the_jump(lock, sense, method):
    t = np.array([0.0, 1.0, 3.0, 4.5, 6.0, 7.0])
    run = gb.simulate(_driven_through(lock, sense, 2.0, int(sense)), t=t, method=method, rtol=1e-9)
    beyond = np.maximum(t - 5.0, 0.0)
    passed = 4.5 + 0.1 * t - 0.1 * beyond / 4.0
    for body in ("first", "last"):
        assert run[f"{body}.w"] == pytest.approx(sense * (2.0 + 0.1 * beyond**2 / 2 / 4.0), rel=1e-8)
    assert run["lock.torque"] == pytest.approx(passed, rel=1e-8)
    assert [(e.component, e.before, e.after) for e in run.events] == [("rub.table", 0.0, 0.5), ("rub.table", 0.5, 1.0)]
    assert run.events[-1].t == pytest.approx(5.0, rel=1e-8)
    assert run.energy.residual < 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("w0", [1.5, 2.25])
@pytest.mark.few(3)
def test_the_jump_is_met_from_either_side_while_the_lock_holds(w0, method):
    run = gb.simulate(_driven_through("clutch", 1.0, w0), t=[4.0], method=method, rtol=1e-9)
    # 4 w' = 4.5 + t/10 - 4 from below, - 5 from above
    rate = 0.5 if w0 < 2 else -0.5
    met = (-rate + np.copysign(np.sqrt(rate**2 + 0.8 * (2.0 - w0)), rate)) / 0.1
    assert [e.after for e in run.events] == [0.5]
    assert run.events[0].t == pytest.approx(met, rel=1e-8)
    assert run["last.w"][-1] == pytest.approx(2.0, rel=1e-8)
    assert run["lock.torque"][-1] == pytest.approx(4.9, rel=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("ratio", [2.0, 1.7])
def test_the_brake_of_a_planetary_set_holds_its_part_of_the_mean(ratio):
    rig = gb.Drivetrain("two speeds")
    planetary = rig.add("set", gb.IdealPlanetary(ratio=ratio))
    sun = rig.add("sun", gb.Inertia(J=0.5, w0=2.0 * (1 + ratio)))
    carrier, ring = rig.add("carrier", gb.Inertia(J=2.0)), rig.add("ring", gb.Inertia(J=1.0, w0=0.0))
    rig.connect(rig.add("load", gb.Torque(tau=RAMP / (1 + ratio))).flange, sun.a)
    rig.connect(sun.b, planetary.sun)
    rig.connect(carrier.a, planetary.carrier)
    rig.connect(ring.a, planetary.ring)
    rig.connect(carrier.b, rig.add("rub", gb.BearingFriction(torque=STEP)).a)
    rig.connect(ring.b, rig.add("brake", gb.Brake(capacity=20.0)).a)
    run = gb.simulate(rig, t=[0.0, 2.0, 4.0], rtol=1e-9)
    assert run["carrier.w"] == pytest.approx([2.0] * 3, rel=1e-8)
    assert run["ring.w"] == pytest.approx([0.0] * 3, abs=1e-12)
    assert np.abs(run["brake.torque"]) == pytest.approx(np.array([4.5, 4.7, 4.9]) * ratio / (1 + ratio), rel=1e-8)
    assert run.energy.residual < 1e-8


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_lock_is_never_held_beyond_its_capacity(method):
    """It holds until the mean asks for 4.925 N m, though the upper side would from 4 s on; then it slips, and what it passes
    on keeps the friction behind it on its jump."""
    rig = _driven_through("clutch", 1.0, 2.0).set({"lock.capacity": 4.925})
    t = np.linspace(0.0, 5.0, 101)
    run = gb.simulate(rig, t=t, method=method, rtol=1e-9)
    slips = np.maximum(t - 4.25, 0.0)
    assert [e.t for e in run.events if e.component == "lock"] == [pytest.approx(4.25, rel=1e-8)]
    assert run["lock.torque"] == pytest.approx(np.minimum(4.5 + 0.1 * t, 4.925), rel=1e-8)
    assert run["first.w"] == pytest.approx(2.0 + 0.1 * slips**2 / 2, rel=1e-8)
    assert run["last.w"] == pytest.approx(np.full(len(t), 2.0), rel=1e-8)
    assert run.energy.residual < 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.few(1)
def test_a_freewheel_that_one_side_presses_and_the_other_opens_carries_nothing(sense, method):
    """The load is on the body with the friction; the one behind the freewheel goes with it until the load is above both."""
    rig = gb.Drivetrain("dragged")
    body, other = (rig.add(name, gb.Inertia(J=J, w0=2.0 * sense)) for name, J in (("body", 1.0), ("other", 3.0)))
    rub = rig.add("rub", gb.BearingFriction(torque=STEP))
    rig.connect(rig.add("load", gb.Torque(tau=RAMP * sense)).flange, body.a, rub.a)
    wheel = rig.add("wheel", gb.Freewheel())
    rig.connect(body.b, wheel.a if sense > 0 else wheel.b)
    rig.connect(other.a, wheel.b if sense > 0 else wheel.a)
    t = np.array([0.0, 2.0, 4.5, 6.0, 7.0])
    run = gb.simulate(rig, t=t, method=method, rtol=1e-9)
    beyond = np.maximum(t - 5.0, 0.0)
    for name in ("body", "other"):
        assert run[f"{name}.w"] == pytest.approx(sense * (2.0 + 0.1 * beyond**2 / 2 / 4.0), rel=1e-8)
    assert run["wheel.torque"] == pytest.approx(0.1 * beyond * 3.0 / 4.0, abs=1e-8)
    assert run.energy.residual < 1e-8
