"""Gearbox, launch and differential of models/: steady states in closed form, what holds and what slips, the ledger."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb


def _shipped(name):
    path = Path(__file__).parents[3] / "models" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"{name}_model", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


gearbox, launch, axle = (_shipped(name) for name in ("automatic_gearbox", "dual_clutch", "limited_slip_differential"))


@pytest.fixture(scope="module")
def driving():
    """60 s at the default tolerance."""
    return gb.simulate(gearbox.build(), t_end=gearbox.T_END)


@pytest.fixture(scope="module")
def start():
    """The launch."""
    return gb.simulate(launch.build(), t_end=launch.T_END)


# -- the automatic gearbox --------------------------------------------------------------------------------------------

ENGAGED = {1: {"c1", "b2"}, 2: {"c1", "b1"}, 3: {"c1", "c2"}, 4: {"c2", "b1"}}


def _settled(run, gear, names=("c1", "c2", "b1", "b2")):
    """Where the gear is in and no shift runs, and its two elements hold."""
    stuck = np.all([run[f"{n}.mode"] == 0 for n in ENGAGED[gear]], axis=0)
    free = np.all([run[f"{n}.mode"] == 2 for n in set(names) - ENGAGED[gear]], axis=0)
    return stuck & free


def test_the_car_is_driven_up_and_down_through_all_gears(driving):
    gears = np.rint(driving["control.gear"][np.abs(driving["control.gear"] % 1) < 1e-9]).astype(int)
    sequence = [gears[0], *gears[1:][np.diff(gears) != 0]]
    assert sequence == [1, 2, 3, 4, 3, 2, 1, 2, 3, 4, 3, 4, 3, 2, 1]


@pytest.mark.parametrize("gear", [1, 2, 3, 4])
def test_each_gear_has_its_ratio(driving, gear):
    at = _settled(driving, gear) & (driving["ring.w"] > 1.0)
    assert at.sum() > 10
    # slips are exactly 0; what is left is the rounding of speeds of 250 rad/s
    assert np.abs(driving["turbine.w"][at] - gearbox.GEARS[gear - 1] * driving["ring.w"][at]).max() < 1e-11


def test_what_is_stuck_does_not_slip_by_a_bit(driving):
    for name in ("c1", "c2", "b1", "b2", "brake"):
        stuck = driving[f"{name}.mode"] == 0
        assert stuck.any()
        assert np.array_equal(driving[f"{name}.w_rel"][stuck], np.zeros(stuck.sum())), name


def test_clutches_hold_no_more_than_they_can(driving):
    for name, most in (("c1", 400.0), ("c2", 400.0), ("b1", 300.0), ("b2", 600.0)):
        limit = most * np.maximum(driving[f"control.{name}"], 0.0)
        # one part in 1e9 of the capacity: where a limit is met, it is met to the rounding of the event's time
        assert (np.abs(driving[f"{name}.torque"]) <= limit + 1e-9 * most).all(), name


def test_the_car_stands_still_where_the_brake_holds_it(driving):
    end = driving.t > 58.0
    assert np.array_equal(driving["car.v"][end], np.zeros(end.sum()))
    assert np.ptp(driving["brake.phi_rel"][end]) == 0.0
    # the idling engine pulls through the stalled converter: 2.6 - 0.6/0.86 nu at nu = 0 is the torque ratio
    creep = driving["converter.torque"][-1] * gearbox.GEARS[0] * gearbox.FINAL
    assert driving["brake.torque"][-1] == pytest.approx(creep, rel=1e-5)  # the half shafts have come to rest


@pytest.mark.long
def test_nothing_is_lost_from_the_ledger(driving, start):
    assert driving.energy.residual < 1e-7  # ten times less than the default tolerance
    assert start.energy.residual < 1e-7


@pytest.mark.long
def test_default_tolerance_is_enough_for_the_whole_drive(driving):
    t = np.linspace(0.0, 60.0, 601)
    plain, exact = (gb.simulate(gearbox.build(), t=t, rtol=rtol) for rtol in (1e-6, 1e-10))
    # thresholds turn errors of speed into errors of time: 1e-4 of the scale of a sum of fourteen shifts
    for name in ("car.v", "car.s", "ring.w"):
        assert np.abs(plain[name] - exact[name]).max() < 1e-4 * np.abs(exact[name]).max(), name


# -- the launch -------------------------------------------------------------------------------------------------------


def test_the_hill_hold_keeps_the_car_at_exactly_zero_speed(start):
    held = start["hill_hold.mode"] == 0
    assert held[0]
    assert start.t[held].max() > 1.0
    for name in ("car.v", "hill_hold.w_rel", "hill_hold.phi_rel"):
        assert np.array_equal(start[name][held], np.zeros(held.sum())), name
    weight = launch.MASS * 9.80665 * np.sin(launch.GRADE) * launch.RADIUS
    assert start["hill_hold.torque"][0] == pytest.approx(-weight, rel=1e-9)


def test_the_car_starts_without_rolling_back(start):
    assert start["car.v"].min() >= 0.0
    assert np.diff(start["car.s"]).min() > -1e-9  # the sum of two integrated angles, right to the tolerance of the run


def test_the_brake_opens_where_clutch_and_weight_exceed_it(start):
    event = next(e for e in start.events if e.component == "hill_hold" and e.before == 0)
    at = np.flatnonzero(start.t <= event.t)[-1]
    capacity = np.interp(event.t, launch.HOLD.x, launch.HOLD.y)
    weight = launch.MASS * 9.80665 * np.sin(launch.GRADE) * launch.RADIUS
    assert start["half_shafts.torque"][at] - weight == pytest.approx(capacity, rel=1e-6)  # the tolerance of the run


def test_the_torque_goes_over_from_one_clutch_to_the_other_without_a_gap(start):
    shift = (start.t > 4.9) & (start.t < 5.5)
    assert (np.abs(start["K1.torque"][shift]) + start["K2.torque"][shift]).min() > 40.0
    modes = {name: start[f"{name}.mode"] for name in ("K1", "K2")}
    assert ((modes["K1"][shift] != 2) & (modes["K2"][shift] != 2)).any()  # both carry
    first, second = (start.t > 3.5) & (start.t < 4.8), start.t > 6.5
    for at, ratio, name in ((first, launch.FIRST, "K1"), (second, launch.SECOND, "K2")):
        assert (modes[name][at] == 0).all()
        assert np.abs(start["crank.w"][at] - ratio * start["output.w"][at]).max() < 1e-11  # rounding of 200 rad/s


# -- the differential -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def road():
    """8 s with and without the clutch."""
    t = np.linspace(0.0, 8.0, 1601)
    return [gb.simulate(make(), t=t, rtol=1e-9) for make in (axle.build, axle.unlocked)]


@pytest.mark.long
def test_on_dry_road_both_wheels_turn_as_one(road):
    locked, _ = road
    dry = locked.t < 2.0
    assert (locked["clutch.mode"][dry] == 0).all()
    assert np.array_equal(locked["clutch.w_rel"][dry], np.zeros(dry.sum()))


def test_on_ice_the_slow_wheel_gets_twice_the_clutch_torque_more(road):
    locked, _ = road
    ice = (locked.t > 2.1) & (locked.t < 5.0)
    assert (locked["clutch.mode"][ice] == -1).all()
    torque = axle.PRELOAD + axle.BIAS * np.abs(locked["propshaft.torque"][ice])
    assert np.abs(locked["clutch.torque"][ice] - torque).max() < 1e-9 * torque.max()
    inertia, radius = 1.1, axle.RADIUS
    left, right = (
        inertia * locked[f"wheel_{side}.alpha"][ice] + radius * locked[f"tyre_{side}.force"][ice]
        for side in ("left", "right")
    )
    assert np.abs(right - left - 2 * torque).max() < 1e-9 * torque.max()
    assert np.abs(right + left - locked["propshaft.torque"][ice]).max() < 1e-9 * right.max()


def test_the_clutch_pulls_the_car_off_the_ice(road):
    locked, plain = road
    at = np.searchsorted(locked.t, 5.0)
    assert locked["car.v"][at] - locked["car.v"][400] > 2 * (plain["car.v"][at] - plain["car.v"][400])


def test_the_plain_differential_pulls_with_twice_the_force_on_ice(road):
    _, plain = road
    ice = (plain.t > 4.0) & (plain.t < 5.0)  # the left wheel spins up slowly by then
    spin = 1.1 * (plain["wheel_left.alpha"] - plain["wheel_right.alpha"])[ice] / axle.RADIUS
    force = plain["tyre_right.force"][ice] - plain["tyre_left.force"][ice]
    assert np.abs(force - spin).max() < 1e-9 * plain["tyre_right.force"][ice].max()


def test_the_ledger_of_the_axle_closes(road):
    for run in road:
        assert run.energy.residual < 1e-10
