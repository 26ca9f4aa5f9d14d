"""Locks that nothing loads, beside one that carries everything: their force is 0, computed as rounding of the others.

Closed form: a body at its stop, pressed by a torque that rises from nothing, stays there, and with it whatever hangs at it
by a ratio that moves; it leaves when the torque turns around.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

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
@pytest.mark.few(1)
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


@pytest.mark.long
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


@pytest.mark.long
@pytest.mark.parametrize("held", [("brake", "bearing"), ("bearing", "load"), ("brake", "bearing", "load")])
@pytest.mark.parametrize(("method", "rtol"), [("auto", 1e-6), ("dp5", 1e-8), ("rodas", 1e-8)])
def test_what_several_frictions_hold_stays_when_its_contact_opens(held, method, rtol):
    t = np.linspace(0.0, 0.1, 21)
    run = gb.simulate(_hammered(held), t=t, method=method, rtol=rtol)
    same = gb.simulate(_hammered(()), t=t, method="dp8", rtol=1e-11)
    assert len(run.events) < 60
    assert run["swings.w"] == pytest.approx(same["swings.w"], abs=30 * rtol)


@pytest.mark.long
@pytest.mark.parametrize(
    "gear",
    [
        {"efficiency": (0.7, 0.7)},
        {"efficiency": (0.9, 0.6)},
        {"loss_table": ((0.0, 0.675, 0.666, 0.308, 0.308), (1.0, 0.783, 0.639, 0.063, 0.063))},
    ],
)
@pytest.mark.parametrize("ratio", [-1.0, 2.5])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_what_a_brake_leaves_for_the_gear_and_the_freewheel_behind_it_is_rounding(gear, ratio, method):
    rig = gb.Drivetrain("held")
    bodies = [rig.add(name, gb.Inertia(J=J)) for name, J in (("near", 0.2), ("middle", 0.366), ("far", 0.337))]
    rig.chain(bodies[0], rig.add("gear", gb.LossyGear(ratio=ratio, **gear)), bodies[1])
    wheel = rig.add("wheel", gb.Freewheel())
    rig.connect(wheel.a, bodies[1].b)
    rig.connect(wheel.b, bodies[2].a)
    rig.connect(rig.add("brake", gb.Brake(capacity=8.0)).a, bodies[0].a)
    rig.connect(rig.add("drive", gb.Torque(tau=sp.Abs(gb.sin(20.0 * gb.time)))).flange, bodies[0].a)
    run = gb.simulate(rig, t_end=2.0, method=method)
    assert all(np.max(np.abs(run[f"{body}.w"])) < 1e-15 for body in ("near", "middle", "far"))
    assert run.stats.steps < 100


RADII, GAP = (0.02, 2.0 / 17.0 * 0.4), 1e-3  # of a mesh inside of a ring


def _struck(k, c, J, w0):
    """When a contact ends whose damping is clipped at its spring, and the speeds then; a freewheel takes the third along."""
    pinion, wheel = RADII

    def rates(_, y):
        spring, speed = k * max(y[0], 0.0), wheel * y[1] - pinion * y[2]
        push = spring + float(np.clip(c * speed, -spring, spring))
        return [speed, -wheel * push / J[0], pinion * push / (J[1] + J[2])]

    def apart(_, y):
        return y[0] + 1e-18

    apart.terminal, apart.direction = True, -1
    found = solve_ivp(rates, (0.0, 9.0), [0.0, w0, 0.0], "DOP853", rtol=1e-10, atol=1e-15, events=apart, max_step=2e-3)
    return found.t[-1], *found.y[1:, -1]


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("c", [100.0, 4000.0])
@pytest.mark.parametrize(("k", "J"), [(24900.0, (1.82, 0.0282, 0.0455)), (8e4, (0.5, 0.4, 0.9))])
def test_a_contact_that_its_damping_eats_up_leaves_a_freewheel_nothing_but_rounding(k, J, c, method):
    rig = gb.Drivetrain("clipped")
    strikes = rig.add("strikes", gb.Inertia(J=J[0], w0=3.0, phi0=0.7))
    struck, far = (
        rig.add("struck", gb.Inertia(J=J[1], phi0=0.7 * RADII[1] / RADII[0])),
        rig.add("far", gb.Inertia(J=J[2])),
    )
    play = gb.Backlash(half_gap=GAP)
    mesh = rig.add(
        "mesh",
        gb.GearMesh(teeth=(17, 40), external=False, r_base=RADII, k=k, c=c, backlash=play, contact_damping="clipped"),
    )
    rig.connect(mesh.wheel, strikes.b)
    rig.connect(mesh.pinion, struck.a)
    wheel = rig.add("wheel", gb.Freewheel())
    rig.connect(wheel.a, struck.b)
    rig.connect(wheel.b, far.a)
    ends, first, second = _struck(k, c, J, 3.0)
    meets = GAP / (3.0 * RADII[1])
    run = gb.simulate(rig, t_end=meets + ends + 0.3 * meets, method=method, rtol=1e-8)  # before the other flank is met
    speeds = [run[f"{body}.w"][-1] for body in ("strikes", "struck", "far")]
    assert speeds == pytest.approx([first, second, second], rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize(
    ("k", "c", "J", "error"),
    [
        (24900.0, 300.0, (1.82, 0.0282, 0.0455), 5.16e-5),
        (24900.0, 636.0, (1.82, 0.0282, 0.0455), 5.16e-5),
        (8e4, 900.0, (0.5, 0.05, 0.02), 8e-5),
    ],
)
@pytest.mark.parametrize("beside", ["nothing", "two locks"])
def test_the_same_while_a_mesh_rattles(beside, k, c, J, error, method):
    """Beside a body that two locks hold forces are sampled, else enclosed. Closed form: no force inside of the mesh changes
    the sum of momenta in parts of the radii."""
    rig = gb.Drivetrain("clipped")
    wheel, pinion, far = (rig.add(n, gb.Inertia(J=j)) for n, j in zip(("wheel", "pinion", "far"), J, strict=True))
    block = gb.GearMesh(
        teeth=(17, 40), external=False, r_base=RADII, k=k, c=c, contact_damping="clipped",
        backlash=gb.Backlash(half_gap=3.6e-5), transmission_error=gb.Harmonic(cos=(error,), driven_by=38.9),
    )  # fmt: skip
    mesh = rig.add("mesh", block)
    rig.connect(mesh.wheel, wheel.b)
    rig.connect(mesh.pinion, pinion.a)
    freewheel = rig.add("freewheel", gb.Freewheel())
    rig.connect(freewheel.a, pinion.b)
    rig.connect(freewheel.b, far.a)
    if beside == "two locks":
        still = rig.add("still", gb.Inertia(J=0.2))
        rig.connect(still.a, rig.add("bearing", gb.BearingFriction(coulomb=2.0)).a)
        rig.connect(still.b, rig.add("stop", gb.HardStop(restitution=0.0, upper=0.0, lower=-0.2)).a)
    run = gb.simulate(rig, t_end=0.4, method=method, rtol=1e-8)
    behind = (J[1] * run["pinion.w"] + J[2] * run["far.w"]) / RADII[0]
    before = J[0] * run["wheel.w"] / RADII[1]
    assert np.max(np.abs(behind + before)) < 1e-12 * np.max(np.abs(before))
    assert len(run.events) < 60


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("held", [(1.7, 0.0713), (1.1, 0.7, 0.3), (0.6, 0.6, 0.6)])
@pytest.mark.few(3)
def test_a_load_that_begins_at_zero_leaves_an_unloaded_freewheel_as_it_is(method, held):
    """A clutch of 3 |sin 20 t| N m from rest, on brakes side by side at the sun; the freewheel joins ring and carrier."""
    rig = gb.Drivetrain("from rest")
    sun, ring, carrier, drive = (
        rig.add(n, gb.Inertia(J=J)) for n, J in (("sun", 0.0331), ("ring", 2.74), ("carrier", 1.0), ("drive", 1.0))
    )
    free = rig.add("free", gb.Inertia(J=0.1))
    planetary, freewheel = rig.add("planetary", gb.IdealPlanetary(ratio=0.5)), rig.add("freewheel", gb.Freewheel())
    clutch = rig.add("clutch", gb.Clutch(capacity=3.0 * sp.Abs(gb.sin(20.0 * gb.time))))
    shaft, drag = rig.add("shaft", gb.Shaft(k=339.0, c=0.124)), rig.add("drag", gb.BearingFriction(coulomb=6.24))
    rig.connect(ring.a, planetary.ring, freewheel.a, drag.a)
    rig.connect(free.a, drag.housing)
    rig.connect(free.b, rig.add("load", gb.SpeedLoad(coeffs=(0.0, 0.0405, 0.001))).flange)
    rig.connect(sun.a, planetary.sun, clutch.a)
    rig.connect(sun.b, *(rig.add(f"brake{i}", gb.Brake(capacity=x)).a for i, x in enumerate(held)))
    rig.connect(carrier.a, planetary.carrier, freewheel.b)
    rig.connect(carrier.b, shaft.a)
    rig.connect(shaft.b, rig.add("ground", gb.Fixed()).flange)
    rig.connect(drive.a, clutch.b)
    rig.connect(drive.b, rig.add("torque", gb.Torque(tau=29.6)).flange)
    breaks = math.asin(sum(held) / 3.0) / 20.0
    run = gb.simulate(rig, t=[0.0, breaks - 1e-6, breaks + 0.01], method=method, rtol=1e-7)
    assert max(abs(run[f"{name}.w"][1]) for name in ("sun", "ring", "carrier")) < 1e-14  # what rounds
    assert run["sun.w"][2] > 0.0
    assert [e.component for e in run.events if e.t == 0.0] == ["clutch"]  # which begins to slip
    assert next(e.t for e in run.events if e.component == "brake0") == pytest.approx(breaks, abs=1e-7)
