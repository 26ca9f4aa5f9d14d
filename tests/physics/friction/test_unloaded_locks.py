"""Locks that nothing loads, beside one that carries everything: their force is 0, computed as rounding of the others.

Closed form: a body at its stop, pressed by a torque that rises from nothing, stays there, and with it whatever hangs at it
by a ratio that moves; it leaves when the torque turns around.
"""

import math

import numpy as np
import pytest

import gearblocks as gb


def _ellipse(rig):
    return rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.2, order=1), external=True))


def _joint(rig):
    return rig.add("joint", gb.UniversalJoint(angle=0.6))


def _freewheel(rig, body):
    lock = rig.add("lock", gb.Freewheel())
    rig.connect(body.b, lock.a)
    rig.connect(rig.add("beyond", gb.Inertia(J=0.7)).a, lock.b)


def _one_way_clutch(rig, body):
    lock = rig.add("lock", gb.OneWayClutch(capacity=0.0))
    rig.connect(body.b, lock.a)
    rig.connect(rig.add("beyond", gb.Inertia(J=0.3)).a, lock.b)


def _stop(rig, body):
    lock = rig.add("lock", gb.HardStop(restitution=0.5, lower=0.0))
    rig.connect(body.b, lock.a)
    rig.connect(rig.add("beyond", gb.Inertia(J=1.3)).a, lock.b)


def _rig(pair, lock, torque):
    rig = gb.Drivetrain("unloaded")
    near, far = rig.add("near", gb.Inertia(J=1.0)), rig.add("far", gb.Inertia(J=0.4))
    between, stop = pair(rig), rig.add("stop", gb.HardStop(restitution=0.3, upper=0.0))
    rig.connect(near.a, between.a)
    rig.connect(far.a, between.b, stop.a)
    rig.connect(far.b, rig.add("load", gb.Torque(tau=torque)).flange)
    lock(rig, near)
    return rig


@pytest.mark.parametrize("method", ["dp5", "rodas", "auto"])
@pytest.mark.parametrize(
    ("pair", "lock"),
    [
        (_ellipse, _freewheel),
        pytest.param(_ellipse, _one_way_clutch, marks=pytest.mark.long),
        (_ellipse, _stop),
        pytest.param(_joint, _freewheel, marks=pytest.mark.long),
        pytest.param(_joint, _one_way_clutch, marks=pytest.mark.long),
        pytest.param(_joint, _stop, marks=pytest.mark.long),
    ],
)
def test_what_nothing_loads_stays_at_rest_until_the_load_turns(pair, lock, method):
    turns = 0.4
    rig = _rig(pair, lock, gb.sin(math.pi / turns * gb.time))
    run = gb.simulate(rig, t=[0.0, 0.1, 0.3, turns + 0.1], method=method, rtol=1e-8)
    for body in ("near", "far", "beyond"):
        assert list(run[f"{body}.w"][:3]) == [0.0, 0.0, 0.0]
    opened = [e.t for e in run.events if e.component == "stop.upper" and e.after == 0.0]
    assert opened == pytest.approx([turns], abs=1e-9)
    assert run["far.w"][-1] < -1e-3
    assert run["stop.torque"][:3] == pytest.approx(-np.sin(math.pi / turns * run.t[:3]), rel=1e-12)


@pytest.mark.parametrize("lock", [_freewheel, _stop])
@pytest.mark.parametrize(
    "torque", [0.1 * gb.time, pytest.param(40 * gb.time**4, marks=pytest.mark.long), 1 - gb.cos(3 * gb.time)]
)
def test_a_soft_rise_is_as_good_as_any(torque, lock):
    run = gb.simulate(_rig(_ellipse, lock, torque), t_end=0.5)
    assert not np.any(run["near.w"]) and not np.any(run["beyond.w"])
    assert run.stats.steps < 200


HELD = {
    "brake": lambda: gb.Brake(capacity=180.0),
    "bearing": lambda: gb.BearingFriction(coulomb=160.0),
    "load": lambda: gb.SpeedLoad(coeffs=(170.0, 0.1, 0.0)),
}


def _hammered(held):
    """A pendulum on a spring between the flanks of a gap, the other side of which frictions hold, or the ground (none)."""
    rig = gb.Drivetrain("hammered")
    swings = rig.add("swings", gb.Inertia(J=0.03, w0=2.0))
    rig.chain(swings, rig.add("spring", gb.Shaft(k=50.0)), rig.add("ground", gb.Fixed()))
    still = rig.add("still", gb.Inertia(J=0.02) if held else gb.Fixed())
    radii, play = (0.025, 0.05), gb.Backlash(half_gap=2e-4)
    mesh = rig.add("mesh", gb.GearMesh(teeth=(20, 40), external=True, r_base=radii, k=5e6, c=100.0, backlash=play))
    rig.connect(mesh.wheel, swings.b)
    rig.connect(mesh.pinion, still.a if held else still.flange)
    for name in held:
        friction = rig.add(name, HELD[name]())
        rig.connect(still.b, friction.flange if name == "load" else friction.a)
    return rig


@pytest.mark.parametrize("held", [("brake", "bearing"), ("bearing", "load"), ("brake", "bearing", "load")])
@pytest.mark.parametrize(("method", "rtol"), [("auto", 1e-6), ("dp5", 1e-8), ("rodas", 1e-8)])
def test_what_several_frictions_hold_stays_when_its_contact_opens(held, method, rtol):
    t = np.linspace(0.0, 0.1, 21)
    run = gb.simulate(_hammered(held), t=t, method=method, rtol=rtol)
    same = gb.simulate(_hammered(()), t=t, method="dp8", rtol=1e-11)
    assert not np.any(run["still.w"])
    assert run["swings.w"] == pytest.approx(same["swings.w"], abs=30 * rtol)
