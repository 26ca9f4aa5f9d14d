"""A motion that has no scale yet: sources that rise softly from rest, and forces that barely exceed what holds."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")
T = gb.time

# torque, speed of one inertia of 1 kg m2 after 1 s
QUICK = ("1 - cos", "t^4", "late", "a pulse")
RISES = {
    "1 - cos": (20 * (1 - gb.cos(10 * T)), 20 - 2 * np.sin(10)),
    "t^4": (20 * T**4, 4.0),
    "t - sin": (T - gb.sin(T), 0.5 + np.cos(1.0) - 1),
    "S-curve": (gb.piecewise((200 * T**3 * (10 - 15 * T + 6 * T**2), T < 1), (200, True)), 100.0),
    "sin^3": (gb.sin(3 * T) ** 3, (2 / 3 - np.cos(3) + np.cos(3) ** 3 / 3) / 3),
    "late": (gb.piecewise((5 * (T - 0.5) ** 3, T > 0.5), (0, True)), 5 / 64),
    "over in a tenth": (gb.piecewise((20 * (1 - gb.cos(20 * np.pi * T)), T < 0.1), (0, True)), 2.0),
    "a pulse": (100 * gb.exp(-(((T - 0.6) / 0.01) ** 2)), np.sqrt(np.pi)),
    "t^100": (T**100, 1 / 101),
    "an exponential": (gb.exp(1000 * (T - 1)), 1e-3),
}
OUT_OF_UNDERFLOW = ("a pulse", "t^100", "an exponential")  # followed through 660 e-folds


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name not in QUICK)) for name in RISES])
@pytest.mark.few(1)
def test_a_torque_that_rises_softly_drives_from_rest(name):
    torque, right = RISES[name]
    rig = gb.Drivetrain("soft")
    rig.chain(rig.add("source", gb.Torque(tau=torque)), rig.add("rotor", gb.Inertia(J=1.0)))
    for method in METHODS:
        for rtol in (1e-4, 1e-8):
            run = gb.simulate(rig, t_end=1.0, rtol=rtol, method=method)
            assert run["rotor.w"][-1] == pytest.approx(right, rel=10 * rtol), (method, rtol)
            assert run.stats.steps < (8000 if name in OUT_OF_UNDERFLOW else 2000), (method, rtol)


@pytest.mark.long
@pytest.mark.parametrize("power", [1, pytest.param(2, marks=pytest.mark.long), 4])
def test_a_soft_start_goes_through_a_shaft(power):
    rig = gb.Drivetrain("soft")
    rig.chain(
        rig.add("source", gb.Torque(tau=20 * T**power)), rig.add("a", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k=1000.0, c=1.0)), rig.add("b", gb.Inertia(J=0.5)), rig.add("damper", gb.Damper(c=0.3)),
        rig.add("wall", gb.Fixed()),
    )  # fmt: skip

    def rates(t, y):
        torque = 1000 * (y[0] - y[1]) + y[2] - y[3]
        return [y[2], y[3], 20 * t**power - torque, (torque - 0.3 * y[3]) / 0.5]

    t = np.linspace(0.0, 1.0, 51)
    right = solve_ivp(rates, (0, 1), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-16, max_step=1e-2, t_eval=t).y
    for method in METHODS:
        for rtol in (1e-4, 1e-8):
            run = gb.simulate(rig, t=t, rtol=rtol, method=method)
            for name, values in (("a.w", right[2]), ("b.w", right[3]), ("shaft.twist", right[1] - right[0])):
                assert np.max(abs(run[name] - values)) < 10 * rtol * np.max(abs(values)), (method, rtol, name)


@pytest.mark.long
@pytest.mark.parametrize("power", [1, 3])
def test_a_soft_start_goes_through_a_gear_whose_housing_is_on_a_spring(power):
    """A stiff housing beside slow bodies: 20 t^power N m - shaft - gear 3 : 1 - spring - load, the housing takes 2 of 3."""
    J, k, stiff, c, ratio = (1.0, 50.0, 5.0), 1e3, 1e5, 5.0, 3.0
    rig = gb.Drivetrain("elastic bearing")
    gear, housing = rig.add("gear", gb.IdealGear(ratio=ratio)), rig.add("housing", gb.Inertia(J=J[2]))
    rig.chain(
        rig.add("source", gb.Torque(tau=20 * T**power)), rig.add("shaft", gb.Inertia(J=J[0])), gear,
        rig.add("spring", gb.Shaft(k=k)), rig.add("load", gb.Inertia(J=J[1])),
    )  # fmt: skip
    rig.chain(rig.add("wall", gb.Fixed()), rig.add("bearing", gb.Shaft(k=stiff, c=c)), housing)
    rig.connect(gear.housing, housing.b)

    def rates(t, y):
        shaft, load, held, w_shaft, w_load, w_held = y
        # the side of the gear towards the spring turns with held + (shaft - held)/ratio
        spring = k * (held + (shaft - held) / ratio - load)
        torques = 20 * t**power - spring / ratio, spring, -spring * (1 - 1 / ratio) - stiff * held - c * w_held
        return [w_shaft, w_load, w_held, *(tau / inertia for tau, inertia in zip(torques, J, strict=True))]

    t = np.linspace(0.0, 1.0, 51)
    right = solve_ivp(rates, (0, 1), np.zeros(6), method="DOP853", rtol=1e-12, atol=1e-18, max_step=1e-2, t_eval=t).y
    model = gb.build(rig)
    for method in METHODS:
        for rtol in (1e-6, 1e-8):
            run = gb.simulate(model, t=t, rtol=rtol, method=method)
            for name, values in (("shaft.w", right[3]), ("load.w", right[4]), ("bearing.twist", right[2])):
                assert np.max(abs(run[name] - values)) < 10 * rtol * np.max(abs(values)), (method, rtol, name)


@pytest.mark.long
@pytest.mark.parametrize("excess", [1e-2, 1e-3, 1e-4])
def test_a_bearing_breaks_away_just_below_its_load(excess):
    """T sin 5t against a capacity C = T (1 - excess): slips from sin 5t = C/T until the area under T sin - C is 0."""
    rig = gb.Drivetrain("break-away")
    rig.chain(
        rig.add("source", gb.Torque(tau=20 * gb.sin(5 * T))), rig.add("rotor", gb.Inertia(J=1.0)),
        rig.add("bearing", gb.BearingFriction(coulomb=20 * (1 - excess))),
    )  # fmt: skip
    begin, hold = np.arcsin(1 - excess) / 5, 1 - excess

    def speed(t):  # over 20, written about the peak of the torque so that nothing cancels
        s, s0 = 5 * t - np.pi / 2, 5 * begin - np.pi / 2
        return (np.sin(s) - np.sin(s0) - hold * (s - s0)) / 5

    end = brentq(speed, np.pi / 10 + 1e-9, 2 * np.pi / 5)
    for method in METHODS:
        for rtol in (1e-6, 1e-9, 1e-10):
            run = gb.simulate(rig, t_end=0.5, rtol=rtol, method=method)
            first, second = (e.t for e in run.events[:2])
            assert first == pytest.approx(begin, abs=1e-8)
            assert second == pytest.approx(end, abs=3e-2 * rtol**0.5 * (end - begin) + 1e-8), (method, rtol)
            assert run["rotor.w"][-1] == 0
            assert run.stats.steps < 500, (method, rtol)


@pytest.mark.long
@pytest.mark.parametrize(
    "kink", [pytest.param(0.2, marks=pytest.mark.long), 0.25, pytest.param(0.3, marks=pytest.mark.long)]
)
def test_a_brake_breaks_away_just_before_the_kink_of_its_capacity(kink):
    """Capacity 20 abs(t - kink) + 0.99999 against 1 N m: it slips for 0.5 us before the kink, as long after it, and is
    stopped again after 0.207 us more: (1 + sqrt 2) 0.5 us in all."""
    rig = gb.Drivetrain("kink")
    rig.chain(
        rig.add("source", gb.Torque(tau=1.0)), rig.add("rotor", gb.Inertia(J=1.0)),
        rig.add("brake", gb.Brake(capacity=20 * abs(T - kink) + 0.99999)),
    )  # fmt: skip
    for method in METHODS:
        for rtol in (1e-4, 1e-6, 1e-9, 1e-10):
            run = gb.simulate(rig, t_end=1.0, rtol=rtol, method=method)
            at = [e.t - kink for e in run.events if e.component == "brake"]
            assert at[0] == pytest.approx(-0.5e-6, abs=1e-10)
            assert at[-1] == pytest.approx(0.5e-6 * (1 + np.sqrt(2)), abs=1e-9)


def test_constants_beside_a_small_value_leave_it_its_digits():
    """A branch of 200 N m that does not hold costs the other branch nothing, however small that is."""
    rig = gb.Drivetrain("branches")
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.piecewise((1e-12 * T, T < 2), (200, True)))),
        rig.add("rotor", gb.Inertia(J=1.0)),
    )
    run = gb.simulate(rig, t=[0.25, 0.5, 1.0], rtol=1e-9)
    assert run["rotor.w"] == pytest.approx(0.5e-12 * np.array([0.0625, 0.25, 1.0]), rel=1e-9)


def _held(hold, J, ratio):
    """A rotor driven by 1 - cos 7.37 t, and beside it a gear set at rest: one shaft is held against its load, what hangs
    there is free and nothing loads it."""
    rig = gb.Drivetrain("held beside")
    rotor, source = rig.add("rotor", gb.Inertia(J=1.0)), rig.add("source", gb.Torque(tau=1 - gb.cos(7.37 * T)))
    shaft, load = rig.add("shaft", gb.Inertia(J=J)), rig.add("load", gb.Torque(tau=0.25 + 0.2 * gb.cos(4.84 * T)))
    lock, wall, gear = (
        rig.add("lock", hold),
        rig.add("wall", gb.Fixed()),
        rig.add("gear", gb.IdealPlanetary(ratio=ratio)),
    )
    carrier, ring = rig.add("carrier", gb.Inertia(J=1.0)), rig.add("ring", gb.Inertia(J=0.05))
    rig.chain(source, rotor)
    rig.connect(load.flange, shaft.a, lock.a, gear.sun)
    rig.connect(lock.b if hasattr(lock, "b") else lock.housing, wall.flange)
    rig.connect(carrier.a, gear.carrier)
    rig.connect(ring.a, gear.ring)
    return rig


HOLDS = (gb.Freewheel(), gb.OneWayClutch(capacity=50.0), gb.Brake(capacity=50.0))


@pytest.mark.parametrize("hold", HOLDS, ids=lambda hold: type(hold).__name__)
@pytest.mark.parametrize(("J", "ratio"), [(1.0, 2.0), (0.3, 3.7)])
def test_a_soft_start_beside_what_a_lock_holds(hold, J, ratio):
    """What rounding makes of the free shafts of a gear set is no motion: neither a scale nor an error of steps."""
    model = gb.build(_held(hold, J, ratio))
    for method, rtol in (("auto", 1e-8), ("dp5", 1e-6), ("dp8", 1e-9), ("rodas", 1e-7)):
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        assert run["rotor.w"][-1] == pytest.approx(1 - np.sin(7.37) / 7.37, rel=10 * rtol)
        assert max(abs(run["carrier.w"])) < 1e-11 and run.stats.steps < 400, (method, rtol)
