"""Trains at rest whose load rises from nothing, with locks and lossy gears that it never reaches: their force is 0, computed
as rounding of what holds the rest.

Closed form: what is held stays, exactly, until the load is more than that; the rest has nothing that moves it.
"""

import math

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["auto", "dp5", "rodas"]


ROUNDING = 1e-15  # rad/s: of loads below 3 N m, over half a second at most


def _most(run, names, until=None):
    return max(np.abs(run[f"{name}.w"][:until]).max() for name in names)


def _first(run, *names):
    return min(e.t for e in run.events if e.component in names)


WORM = {
    "worm": lambda: gb.Worm(ratio=-8.0, lead_angle=0.402, friction=0.139),
    "lossy": lambda: gb.LossyGear(ratio=3.3, efficiency=(0.8, 0.7)),
    "freewheel": lambda: gb.Freewheel(),
    "one way": lambda: gb.OneWayClutch(capacity=0.0),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("given", [("j1", "j2"), ("j2", "j4"), ()])
@pytest.mark.parametrize("lock", WORM)
@pytest.mark.few(4)
def test_what_hangs_behind_a_held_carrier_has_no_force(lock, given, method):
    rig = gb.Drivetrain("carrier")
    inertias = {"j1": 0.333, "j2": 0.0903, "j3": 0.162, "j4": 0.1}
    bodies = {n: rig.add(n, gb.Inertia(J=J, w0=0.0) if n in given else gb.Inertia(J=J)) for n, J in inertias.items()}
    axle, lost = rig.add("axle", gb.Differential(ratio=3.5)), rig.add("lost", WORM[lock]())
    held = rig.add("held", gb.BearingFriction(coulomb=0.753, peak=1.5))
    load = rig.add("load", gb.Torque(tau=0.361 * gb.sin(9.71 * gb.time) * gb.cos(3.59 * gb.time)))
    rig.connect(bodies["j1"].a, axle.left)
    rig.connect(bodies["j2"].a, axle.carrier, held.a, load.flange)
    rig.connect(bodies["j3"].a, axle.right, lost.a)
    rig.connect(bodies["j4"].a, lost.b)
    run = gb.simulate(rig, t_end=0.5, method=method, rtol=1e-4)
    assert _most(run, bodies) < ROUNDING
    assert len(run.events) == 0 and run.stats.steps < 50


def _planet(held_by, behind):
    """Sun and ring of a set whose carrier friction holds; a lock that holds nothing and a clutch hang on the ring."""
    rig = gb.Drivetrain("planet")
    inertias = {"sun": 0.842, "carrier": 0.42, "ring": 0.25, "driven": 2.0, "clutched": 0.777, "locked": 0.119}
    bodies = {n: rig.add(n, gb.Inertia(J=J) if n == "ring" else gb.Inertia(J=J, w0=0.0)) for n, J in inertias.items()}
    planets = rig.add("planets", gb.IdealPlanetary(ratio=0.5))
    bearing = rig.add("bearing", gb.BearingFriction(coulomb=0.918))
    clutch = rig.add("clutch", gb.Clutch(capacity=1.56))
    lock = rig.add("lock", behind())
    hold = rig.add("hold", held_by())
    drive = rig.add("drive", gb.Torque(tau=6.9 * gb.sin(5.06 * gb.time)))
    rig.connect(bodies["sun"].a, planets.sun)
    rig.connect(bodies["carrier"].a, planets.carrier, bearing.a, hold.a if hasattr(hold, "a") else hold.flange)
    rig.connect(bodies["ring"].a, planets.ring, clutch.a, lock.b)
    rig.connect(bodies["driven"].a, bearing.housing, drive.flange)
    rig.connect(bodies["clutched"].a, clutch.b)
    rig.connect(bodies["locked"].a, lock.a)
    return rig


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("held_by", [lambda: gb.SpeedLoad(coeffs=(0.159, 0.0, 0.0)), lambda: gb.Brake(capacity=0.159)])
@pytest.mark.parametrize(
    "behind",
    [
        lambda: gb.OneWayClutch(capacity=gb.Table([0.0, 0.9, 1.5], [0.0, 0.0, 2.88])),
        lambda: gb.Freewheel(),
        lambda: gb.LossyGear(ratio=-2.0, efficiency=(0.9, 0.6)),
    ],
)
@pytest.mark.few(3)
def test_what_hangs_on_the_planets_of_a_held_carrier_rests_until_that_lets_go(behind, held_by, method):
    run = gb.simulate(_planet(held_by, behind), t=[0.0, 1e-3, 4e-3, 6e-3], method=method, rtol=1e-6)
    assert _most(run, ("sun", "carrier", "ring", "driven", "clutched", "locked"), 3) < ROUNDING
    lets_go = math.asin(0.159 / 6.9) / 5.06
    assert _first(run, "hold", "bearing") == pytest.approx(lets_go, rel=1e-6)
    assert abs(run["driven.w"][-1]) > 1e-6


def _beside(held_by, other, second=False):
    """As above without the clutch, the driven body held too: a look ahead reaches beyond what each of both holds."""
    rig = gb.Drivetrain("beside")
    inertias = {"sun": 0.842, "carrier": 0.42, "ring": 0.25, "driven": 3.74}
    bodies = {n: rig.add(n, gb.Inertia(J=J) if n == "ring" else gb.Inertia(J=J, w0=0.0)) for n, J in inertias.items()}
    planets = rig.add("planets", gb.IdealPlanetary(ratio=0.5))
    bearing, lock = (
        rig.add("bearing", gb.BearingFriction(coulomb=0.918)),
        rig.add("lock", gb.OneWayClutch(capacity=0.0)),
    )
    hold, wheels = rig.add("hold", held_by()), rig.add("wheels", other())
    drive = rig.add("drive", gb.Torque(tau=6.9 * gb.sin(5.06 * gb.time)))
    rig.connect(bodies["sun"].a, planets.sun)
    rig.connect(bodies["carrier"].a, planets.carrier, bearing.a, hold.a if hasattr(hold, "a") else hold.flange)
    rig.connect(bodies["ring"].a, planets.ring, lock.b)
    rig.connect(bodies["driven"].a, bearing.housing, drive.flange, wheels.a if hasattr(wheels, "a") else wheels.flange)
    if second:
        _second_set(rig, lock)
    else:
        rig.connect(rig.add("locked", gb.Inertia(J=0.119, w0=0.0)).a, lock.a)
    return rig


def _second_set(rig, lock):
    """A planetary set on the far side of the lock, a body behind a clutch on its ring."""
    planets, idle = rig.add("second", gb.IdealPlanetary(ratio=1.5)), rig.add("idle", gb.Clutch(capacity=15.0, peak=1.1))
    ring, carrier = rig.add("second_ring", gb.Inertia(J=2.04, w0=0.0)), rig.add("second_carrier", gb.Inertia(J=0.282))
    rig.connect(lock.a, planets.sun)
    rig.connect(ring.a, planets.ring, idle.a)
    rig.connect(carrier.a, planets.carrier)
    rig.connect(rig.add("last", gb.Inertia(J=0.1, w0=0.0)).a, idle.b)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("held_by", [lambda: gb.SpeedLoad(coeffs=(0.159, 0.0, 0.0)), lambda: gb.Brake(capacity=0.159)])
@pytest.mark.parametrize(
    "other",
    [
        lambda: gb.Vehicle(mass=2.0, wheel_radius=0.3, rolling=0.0524),
        lambda: gb.Brake(capacity=0.0524 * 2.0 * 9.80665 * 0.3),
    ],
)
@pytest.mark.few(3)
def test_a_look_ahead_ends_where_something_else_lets_go(other, held_by, method):
    lets_go = math.asin((0.159 + 0.0524 * 2.0 * 9.80665 * 0.3) / 6.9) / 5.06
    run = gb.simulate(_beside(held_by, other), t=[0.0, 1e-3, 0.9 * lets_go, 1.2 * lets_go], method=method, rtol=1e-6)
    assert _most(run, ("sun", "carrier", "ring", "driven", "locked"), 3) < ROUNDING
    assert _first(run, "hold", "wheels", "wheels.rolling", "bearing") == pytest.approx(lets_go, rel=1e-6)


@pytest.mark.parametrize(("method", "rtol"), [("rodas", 1e-6), ("rodas", 1e-8), ("auto", 1e-9)])
@pytest.mark.few(1)
def test_a_body_behind_a_clutch_that_carries_nothing_has_the_rounding_of_what_it_hangs_at(method, rtol):
    load, car = gb.SpeedLoad(coeffs=(0.159, 0.0, 0.0)), gb.Vehicle(mass=2.0, wheel_radius=0.3, rolling=0.0524)
    run = gb.simulate(_beside(lambda: load, lambda: car, second=True), t_end=0.003, method=method, rtol=rtol)
    assert _most(run, ("last", "second_ring", "sun", "driven")) < ROUNDING
    assert run.stats.steps < 100


def _behind_two_gears(lock, drives):
    """Two lossy gears in a row between three bodies of 1 kg m2, the first with a bearing torque; a body behind a lock."""
    rig = gb.Drivetrain("behind")
    last, between, first, locked = (rig.add(n, gb.Inertia(J=1.0)) for n in ("last", "between", "first", "locked"))
    heavy = rig.add("heavy", gb.LossyGear(ratio=1.0, loss_table=((0.0, 0.7, 0.6, 0.3, 0.3),)))
    light = rig.add("light", gb.LossyGear(ratio=1.0, loss_table=((0.0, 0.7, 0.5, 0.0, 0.0),)))
    one_way, load = rig.add("lock", lock()), rig.add("load", gb.Torque(tau=4.0 * gb.time))
    rig.connect(last.a, heavy.a, *((one_way.a,) if drives else (one_way.b,)))
    rig.connect(locked.a, one_way.b if drives else one_way.a)
    rig.connect(between.a, heavy.b, light.a)
    rig.connect(first.a, light.b, load.flange)
    return rig


@pytest.mark.parametrize("method", [*METHODS, "dp8"])
@pytest.mark.parametrize(
    ("lock", "drives", "follows"),
    [
        (lambda: gb.Freewheel(), True, 2.0),
        (lambda: gb.Freewheel(), False, 1.0),
        (lambda: gb.OneWayClutch(capacity=5.0), True, 2.0),
        (lambda: gb.OneWayClutch(capacity=5.0), False, 2.0),
    ],
)
@pytest.mark.few(4)
def test_a_look_ahead_ends_where_gears_let_go_that_hold_for_now(lock, drives, follows, method):
    """The load, less the half that the second gear takes, is more than the bearing torque from 0.15 s on."""
    run = gb.simulate(_behind_two_gears(lock, drives), t=[0.0, 0.15, 0.3], method=method, rtol=1e-8)
    assert _most(run, ("first", "last", "locked"), 2) < 1e-12
    assert _first(run, "heavy", "light") == pytest.approx(0.15, abs=1e-7)
    assert run["last.w"][-1] == pytest.approx(1.2 / (follows + 0.9) * 0.15**2 / 2.0, rel=1e-7)
    assert run["locked.w"][-1] == pytest.approx(run["last.w"][-1] if follows == 2.0 else 0.0, abs=1e-12)
