"""Where one number decides between stuck and sliding: equality, rounding, capacities that come and go."""

import numpy as np
import pytest
from scipy.optimize import brentq

import gearblocks as gb

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left
METHODS = [
    {"method": "dp5"},
    {"method": "dp8"},
    {"method": "rodas"},
    {"method": "auto"},
    {"method": "rk4", "step": 0.01},
]
EVERY_METHOD = pytest.mark.parametrize("options", METHODS, ids=lambda options: options["method"])


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode after) of one element."""
    return [(e.t, e.after) for e in run.events if e.component == name]


# -- equality ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_torque_of_exactly_the_capacity_is_held_and_one_bit_more_is_not(way):
    tau = gb.Parameter("tau", 10.0)
    rig = _chain(drive=gb.Torque(tau=tau), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=10.0))
    held = gb.simulate(rig, t_end=10.0, parameters={"tau": way * 10.0})
    assert (held["body.phi"] == 0.0).all() and held.events == ()
    assert (held["brake.mode"] == 0.0).all()
    loose = gb.simulate(rig, t_end=10.0, parameters={"tau": way * 10.0 * (1 + 1e-9)})
    assert loose["brake.mode"][-1] == way
    assert loose["body.w"][-1] == pytest.approx(way * 1e-7, rel=1e-6)


def test_a_torque_that_exceeds_the_capacity_by_rounding_is_held():
    rig = _chain(drive=gb.Torque(tau=0.1 + 0.2), body=gb.Inertia(J=0.7), brake=gb.Brake(capacity=0.3))
    run = gb.simulate(rig, t_end=10.0)
    assert (run["brake.mode"] == 0.0).all() and (run["body.phi"] == 0.0).all()


def test_a_stuck_clutch_holds_what_friction_at_rest_says_not_that_of_a_slip():
    mu = gb.Table([0.0, 1.0], [0.5, 0.2])
    clutch = gb.Clutch(mu=mu, force_max=8.0, engagement=1.0)
    run = gb.simulate(
        _chain(drive=gb.Torque(tau=gb.time), body=gb.Inertia(J=1.0), clutch=clutch, end=gb.Fixed()), t_end=4.5
    )
    ((t, after),) = _modes(run, "clutch")
    assert (t, after) == (pytest.approx(4.0, rel=1e-9), -1.0)


# -- one event after another ------------------------------------------------------------------------------------------


@pytest.mark.long
@EVERY_METHOD
def test_a_swinging_torque_breaks_a_body_away_until_it_has_given_its_speed_back(options):
    rig = _chain(drive=gb.Torque(tau=5.0 * gb.sin(gb.time)), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=3.0))
    run = gb.simulate(rig, t_end=10.0, rtol=1e-10, **options)
    away = float(np.arcsin(0.6))
    stop = brentq(lambda t: 5 * (np.cos(away) - np.cos(t)) - 3 * (t - away), 2.0, 3.7)
    found = _modes(run, "brake")
    assert [mode for _, mode in found] == [1.0, 0.0, -1.0, 0.0, 1.0, 0.0]
    assert [t for t, _ in found] == pytest.approx([x + i * np.pi for i in range(3) for x in (away, stop)], rel=1e-7)


def test_a_body_pushed_back_through_rest_goes_on_through_what_happens_later():
    push = gb.piecewise((-5.0, gb.time < 1), (-1.0, True))
    rig = _chain(drive=gb.Torque(tau=push), body=gb.Inertia(J=1.0, w0=1.4), brake=gb.Brake(capacity=2.0))
    run = gb.simulate(rig, t=[2.0])
    assert _modes(run, "brake") == [(pytest.approx(0.2, rel=EXACT), -1.0)]
    assert run["body.w"][0] == pytest.approx(-3 * 0.8 + 1.0, rel=EXACT)


# -- what comes at once -----------------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize(
    ("load", "capacity", "way"),
    [
        (3.0, 2.0, 1.0),
        pytest.param(3.0, 2.0, -1.0, marks=pytest.mark.long),
        pytest.param(2.0, 3.0, 1.0, marks=pytest.mark.long),
        (2.0, 3.0, -1.0),
    ],
)
def test_where_load_and_capacity_rise_from_nothing_together_the_stronger_wins(way, load, capacity):
    rise = gb.piecewise((0.0, gb.time < 1), (gb.time - 1, True))
    rig = _chain(
        drive=gb.Torque(tau=way * load * rise), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=capacity * rise)
    )
    run = gb.simulate(rig, t_end=3.0)
    assert run["body.w"][-1] == pytest.approx(way * max(load - capacity, 0.0) * 2.0, rel=1e-9, abs=1e-15)
    assert run["brake.mode"][-1] == (way if load > capacity else 0.0)


@pytest.mark.long
@pytest.mark.parametrize("w0", [10.0, 0.0])
def test_a_clutch_whose_capacity_comes_down_to_nothing_is_free_until_it_rises_again(w0):
    capacity = gb.Table([0, 1, 2, 3], [6.0, 0.0, 0.0, 6.0])
    rig = _chain(
        drive=gb.Torque(tau=1.0),
        one=gb.Inertia(J=1.0, w0=w0),
        clutch=gb.Clutch(capacity=capacity),
        two=gb.Inertia(J=1.0),
    )
    run = gb.simulate(rig, t=[0.5, 1.5, 1.9, 2.5])
    assert list(run["clutch.mode"]) == [-1.0 if w0 else 0.0, 2.0, 2.0, -1.0]
    assert run["two.w"][2] == run["two.w"][1]
    assert run["two.w"][3] - run["two.w"][2] == pytest.approx(0.75, rel=EXACT)  # 6 (t - 2) for half a second
    assert _modes(run, "clutch")[-2:] == [(1.0, 2.0), (2.0, -1.0)]


@pytest.mark.long
def test_without_location_what_meets_its_speed_sticks_at_the_end_of_the_step():
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=5.0), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t_end=3.0, method="rk4", step=1e-3, locate=False)
    assert run["clutch.mode"][-1] == 0.0
    # locks up to a step late, in which the slip turns by 10 rad/s2 times 1 ms
    assert run["one.w"][-1] == run["two.w"][-1] == pytest.approx(5.0, abs=1e-2)
    assert [after for _, after in _modes(run, "clutch")] == [0.0]


@pytest.mark.long
@pytest.mark.parametrize("block", [gb.Clutch(capacity=gb.time - 0.2), gb.Clutch(capacity=gb.sin(gb.time - 0.2))])
@pytest.mark.few(1)
def test_a_clutch_whose_capacity_rises_from_below_zero_takes_hold(block):
    rig = gb.Drivetrain("train")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=1.0)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(one, rig.add("clutch", block), two)
    run = gb.simulate(rig, t_end=0.5)
    ((t, before, after),) = [(e.t, e.before, e.after) for e in run.events if e.component == "clutch"]
    assert (t, before, after) == (pytest.approx(0.2, rel=1e-9), 2.0, -1.0)
    given = 0.3**2 / 2 if block.capacity.op != "sin" else 1 - np.cos(0.3)
    assert run["two.w"][-1] == pytest.approx(given, rel=1e-6)
