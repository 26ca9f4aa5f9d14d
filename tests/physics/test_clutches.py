"""Clutches, brakes and couplings that lock: closed forms of locking, holding, slipping and letting go."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import gearblocks as gb

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode before, mode after) of one element."""
    return [(e.t, e.before, e.after) for e in run.events if e.component == name]


# -- clutch -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("w1", "w2"), [(100.0, 0.0), (-30.0, 20.0), (5.0, 80.0)])
@pytest.mark.parametrize("J2", [2.0, 0.03])
def test_a_clutch_locks_when_and_as_hot_as_momentum_says(w1, w2, J2):
    J1, capacity = 1.0, 50.0
    rig = _chain(one=gb.Inertia(J=J1, w0=w1), clutch=gb.Clutch(capacity=capacity), two=gb.Inertia(J=J2, w0=w2))
    run = gb.simulate(rig, t_end=5.0)
    reduced = J1 * J2 / (J1 + J2)
    ((t, before, after),) = _modes(run, "clutch")
    assert (before, after) == (np.sign(w2 - w1), 0.0)
    assert t == pytest.approx(reduced * abs(w1 - w2) / capacity, rel=1e-9)
    assert run.energy.dissipated["clutch"] == pytest.approx(reduced * (w1 - w2) ** 2 / 2, rel=1e-9)
    assert run["one.w"][-1] == pytest.approx((J1 * w1 + J2 * w2) / (J1 + J2), rel=1e-12)
    assert run["one.w"][-1] == run["two.w"][-1]
    assert run["clutch.phi_rel"][-1] == pytest.approx((w2 - w1) * t / 2, rel=1e-9)
    assert run.energy.residual < 1e-12


def test_the_torque_of_a_clutch_is_that_on_its_second_flange():
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=4.0), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t=[0.1])
    assert run["clutch.torque"][0] == run["clutch.b.tau"][0] == 4.0  # b is slower and driven forward
    assert run["clutch.loss_power"][0] == pytest.approx(4.0 * (10.0 - 2 * 0.4), rel=1e-12)
    assert run["clutch.w_rel"][0] == pytest.approx(-9.2, rel=1e-12)
    assert run["clutch.mode"][0] == -1.0


def test_a_stuck_clutch_does_not_creep_in_a_million_seconds():
    tau = 3.0 * gb.sin(0.7 * gb.time)
    rig = _chain(
        drive=gb.Torque(tau=tau), one=gb.Inertia(J=1.0, w0=2.0), clutch=gb.Clutch(capacity=5.0), two=gb.Inertia(J=2.0)
    )
    t = np.concatenate([np.linspace(0, 10, 101), np.linspace(20, 1e6, 50)])
    run = gb.simulate(rig, t=t, rtol=1e-3)
    held = run["clutch.mode"] == 0.0
    assert held[t > 2].all()
    assert (run["clutch.w_rel"][held] == 0.0).all()
    assert len(set(run["clutch.phi_rel"][held])) == 1
    assert np.array_equal(run["one.w"][held], run["two.w"][held])
    assert (np.abs(run["clutch.torque"][held]) <= 5.0).all()


def test_a_clutch_is_free_where_its_capacity_is_not_positive():
    capacity = gb.piecewise((-3.0, gb.time < 1), (0.0, gb.time < 2), (4.0, gb.time < 3), (-1.0, True))
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=capacity), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t=[0.5, 1.5, 2.5, 3.5])
    assert list(run["clutch.mode"]) == [2.0, 2.0, -1.0, 2.0]
    assert list(run["clutch.torque"]) == [0.0, 0.0, 4.0, 0.0]
    assert run["one.w"] == pytest.approx([10.0, 10.0, 8.0, 6.0], rel=EXACT)
    assert _modes(run, "clutch") == [(2.0, 2.0, -1.0), (3.0, -1.0, 2.0)]


def test_a_clutch_without_capacity_is_no_storm_of_events():
    rig = _chain(
        drive=gb.Torque(tau=gb.sin(gb.time)),
        one=gb.Inertia(J=1.0),
        clutch=gb.Clutch(capacity=0.0),
        two=gb.Inertia(J=1.0),
    )
    run = gb.simulate(rig, t_end=50.0)
    assert len(run.events) == 0
    assert run["two.w"][-1] == 0.0
    assert (run["clutch.mode"] == 2.0).all()


def test_a_capacity_that_grazes_the_held_torque_does_not_let_go():
    capacity = 6 - sp.cos(2 * sp.pi * gb.time) * (1 - 1e-9)  # at least 5 + 1e-9
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=capacity))
    run = gb.simulate(rig, t_end=5.0)
    assert (run["body.phi"] == 0.0).all()
    assert (run["brake.mode"] == 0.0).all()
    deeper = 6 - sp.cos(2 * sp.pi * gb.time) * (1 + 1e-2)
    run = gb.simulate(
        rig.set({"brake.capacity": deeper}), t_end=5.0, max_step=0.05
    )  # nothing else moves that asks for it
    assert len(_modes(run, "brake")) == 10  # slips at the start, in four dips and at the end


def test_friction_over_slip_stops_as_its_differential_equation_says():
    mu0, slope, force, J, w0 = 0.3, 0.02, 10.0, 0.5, 12.0
    mu = gb.Table([0.0, 20.0], [mu0, mu0 + 20 * slope])
    rig = _chain(
        one=gb.Inertia(J=J, w0=w0),
        clutch=gb.Clutch(mu=mu, force_max=force, engagement=1.0, geometry=2.0),
        end=gb.Fixed(),
    )
    run = gb.simulate(rig, t_end=10.0, rtol=1e-11)
    c = 2.0 * force * slope
    ((t, _, _),) = (e for e in _modes(run, "clutch") if e[2] == 0.0)
    assert t == pytest.approx(J / c * np.log(1 + w0 * slope / mu0), rel=1e-9)
    assert run.energy.dissipated["clutch"] == pytest.approx(J * w0**2 / 2, rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_stuck_clutch_lets_go_at_its_peak_and_slips_with_less(way):
    mu = gb.Table([0.0, 1.0], [0.4, 0.4])
    clutch = gb.Clutch(mu=mu, force_max=10.0, engagement=0.5, geometry=1.5, peak=1.25)
    rig = _chain(drive=gb.Torque(tau=way * gb.time), one=gb.Inertia(J=1.0), clutch=clutch, end=gb.Fixed())
    run = gb.simulate(rig, t=[3.0, 3.74, 4.0, 5.0])
    slip_torque, most = 3.0, 3.75
    ((t, _, after),) = _modes(run, "clutch")
    assert t == pytest.approx(most, rel=1e-9)
    assert after == -way
    assert run["clutch.torque"] == pytest.approx(
        [3.0 * way, 3.74 * way, slip_torque * way, slip_torque * way], rel=1e-9
    )
    assert run["one.w"][-1] == pytest.approx(way * ((25 - most**2) / 2 - slip_torque * (5 - most)), rel=1e-8)


# -- brake and bearing ------------------------------------------------------------------------------------------------


def test_a_brake_stops_and_holds_a_load():
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0, w0=1.0), brake=gb.Brake(capacity=10.0))
    run = gb.simulate(rig, t=[0.1, 0.3, 10.0, 1000.0])
    assert run["body.phi"] == pytest.approx([0.1 - 2.5 * 0.01, 0.1, 0.1, 0.1], rel=EXACT)
    assert list(run["body.w"][1:]) == [0.0, 0.0, 0.0]
    assert list(run["brake.torque"]) == [10.0, 5.0, 5.0, 5.0]  # against forward motion, then against the load
    assert run["brake.phi_rel"][-1] == pytest.approx(0.1, rel=EXACT)


def test_a_brake_on_a_turning_housing_acts_on_both():
    rig = gb.Drivetrain("brake")
    body, frame = rig.add("body", gb.Inertia(J=1.0, w0=8.0)), rig.add("frame", gb.Inertia(J=3.0))
    brake = rig.add("brake", gb.Brake(capacity=6.0))
    rig.connect(body.b, brake.a)
    rig.connect(frame.b, brake.housing)
    run = gb.simulate(rig, t=[0.5, 2.0])
    assert run["brake.torque"][0] == 6.0
    assert run["brake.w_rel"] == pytest.approx([8.0 - 0.5 * 8.0, 0.0], rel=EXACT)
    assert run["body.w"][-1] == run["frame.w"][-1] == pytest.approx(2.0, rel=EXACT)


def test_a_bearing_with_dry_and_viscous_friction_runs_down_to_rest():
    J, w0, coulomb, viscous = 0.5, 20.0, 0.4, 0.1
    rig = _chain(body=gb.Inertia(J=J, w0=w0), bearing=gb.BearingFriction(coulomb=coulomb, viscous=viscous))
    run = gb.simulate(rig, t_end=20.0, rtol=1e-11)
    ((t, _, _),) = _modes(run, "bearing")
    assert t == pytest.approx(J / viscous * np.log(1 + viscous * w0 / coulomb), rel=1e-9)
    assert run["body.w"][-1] == 0.0
    assert run.energy.dissipated["bearing"] == pytest.approx(J * w0**2 / 2, rel=1e-9)


def test_a_bearing_has_more_friction_near_rest():
    bearing = gb.BearingFriction(coulomb=1.0, viscous=0.2, stribeck=gb.Stribeck(rise=0.5, speed=2.0), peak=1.2)
    rig = _chain(drive=gb.Torque(tau=gb.time), body=gb.Inertia(J=1.0), bearing=bearing)
    run = gb.simulate(rig, t=np.linspace(0, 6, 61), rtol=1e-10)
    ((t, before, after),) = _modes(run, "bearing")
    assert (before, after) == (0.0, 1.0)
    assert t == pytest.approx(1.2 * 1.5, rel=1e-9)
    slips = run["bearing.mode"] == 1.0
    w = run["body.w"][slips]
    assert run["bearing.torque"][slips] == pytest.approx(1.0 + 0.5 * np.exp(-((w / 2.0) ** 2)) + 0.2 * w, rel=EXACT)


def test_a_bearing_takes_its_friction_from_a_table():
    table = gb.Table([0.0, 2.0, 10.0], [0.6, 0.3, 0.9])
    rig = _chain(body=gb.Inertia(J=1.0, w0=-8.0), bearing=gb.BearingFriction(torque=table))
    run = gb.simulate(rig, t=np.linspace(0, 20, 41), rtol=1e-9)
    slips = run["bearing.mode"] == -1.0
    expected = np.interp(np.abs(run["body.w"][slips]), table.x, table.y)
    assert run["bearing.torque"][slips] == pytest.approx(-expected, rel=EXACT)
    assert run["body.w"][-1] == 0.0


# -- one way ----------------------------------------------------------------------------------------------------------


def test_a_freewheel_rectifies_an_oscillating_torque():
    rig = _chain(
        drive=gb.Torque(tau=gb.cos(gb.time)), one=gb.Inertia(J=1.0), wheel=gb.Freewheel(), two=gb.Inertia(J=1.0)
    )
    run = gb.simulate(rig, t=np.linspace(0, 20, 201), rtol=1e-11)
    # together until pi/2 with w = sin(t)/2; then b keeps 1/2, a falls back to sin(t) - 1/2 and meets it at 5 pi/2
    times = [np.pi / 2, 5 * np.pi / 2, 5 * np.pi / 2]
    found = [t for t, _, _ in _modes(run, "wheel")]
    assert found[0] == pytest.approx(times[0], rel=1e-9)
    after = run.t > np.pi / 2
    assert run["two.w"][after] == pytest.approx(0.5, abs=1e-9)
    assert run["one.w"][after] == pytest.approx(np.sin(run.t[after]) - 0.5, abs=1e-9)
    assert (run["wheel.w_rel"] >= -1e-9).all()


def test_a_one_way_clutch_drives_forward_whatever_the_torque():
    clutch = gb.OneWayClutch(mu=0.5, force_max=1.0, engagement=0.0)
    rig = _chain(drive=gb.Torque(tau=1e6), one=gb.Inertia(J=1.0), clutch=clutch, two=gb.Inertia(J=3.0))
    run = gb.simulate(rig, t=[1.0])
    assert run["clutch.torque"][0] == pytest.approx(0.75e6, rel=EXACT)
    assert run["clutch.w_rel"][0] == 0.0


@pytest.mark.parametrize("engagement", [0.0, 0.8])
def test_a_one_way_clutch_lets_b_ahead_beyond_its_break_away_torque(engagement):
    clutch = gb.OneWayClutch(mu=0.5, force_max=4.0, engagement=engagement, geometry=2.0, peak=1.5)
    rig = _chain(
        one=gb.Inertia(J=1.0), clutch=clutch, two=gb.Inertia(J=1.0), drive=gb.Torque(tau=gb.time)
    )  # half of the torque on b passes to a
    run = gb.simulate(rig, t=[10.0], rtol=1e-10)
    most = 1.5 * 0.5 * 2.0 * 4.0 * engagement if engagement else 1e-4 * 0.5 * 2.0 * 4.0
    ((t, before, after),) = _modes(run, "clutch")
    assert (before, after) == (0.0, 1.0)
    assert t == pytest.approx(2 * most, rel=1e-9)
    drag = 0.5 * 2.0 * 4.0 * engagement
    assert run["clutch.torque"][0] == -drag
    assert run["one.w"][0] == pytest.approx(t**2 / 4 + drag * (10 - t), rel=1e-8)


def test_a_one_way_clutch_with_a_capacity_and_none_breaks_away_at_zero():
    rig = _chain(
        one=gb.Inertia(J=1.0), clutch=gb.OneWayClutch(capacity=gb.piecewise((0.0, gb.time < 1), (2.0, True))),
        two=gb.Inertia(J=1.0), drive=gb.Torque(tau=1.0),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.5, 2.0])
    assert list(run["clutch.mode"]) == [1.0, 0.0]  # w_rel = 1 at 1 s falls by 3 per second
    assert run["clutch.torque"] == pytest.approx([0.0, -0.5], rel=EXACT)


# -- teeth ------------------------------------------------------------------------------------------------------------


def test_dogs_close_with_the_impulse_that_momentum_asks():
    J1, J2, w1, w2 = 1.0, 3.0, 10.0, -2.0
    engaged = gb.piecewise((0.0, gb.time < 1), (1.0, gb.time < 2), (0.0, True))
    rig = _chain(
        one=gb.Inertia(J=J1, w0=w1),
        dog=gb.DogClutch(engaged=engaged),
        two=gb.Inertia(J=J2, w0=w2),
        load=gb.Torque(tau=8.0),
    )
    run = gb.simulate(rig, t=[0.5, 1.5, 3.0])
    before = w2 + 8.0 / J2
    common = (J1 * w1 + J2 * before) / (J1 + J2)
    assert run["one.w"][1] == run["two.w"][1] == pytest.approx(common + 8.0 / 4 * 0.5, rel=EXACT)
    assert run["dog.impulse"] == pytest.approx([0.0, J2 * (common - before), J2 * (common - before)], rel=EXACT)
    assert run["dog.torque"] == pytest.approx([0.0, -8.0 / 4, 0.0], rel=EXACT)  # b is held back, a is taken along
    assert list(run["dog.mode"]) == [2.0, 0.0, 2.0]
    reduced = J1 * J2 / (J1 + J2)
    assert run.energy.dissipated["dog"] == pytest.approx(reduced * (w1 - before) ** 2 / 2, rel=EXACT)
    assert run.energy.residual < EXACT


def test_a_synchroniser_brings_to_one_speed_before_its_teeth_lock():
    cone = gb.piecewise((0.0, gb.time < 0.5), (4.0, gb.time < 3), (0.0, True))
    block = gb.Synchronizer(capacity=cone, engaged=gb.piecewise((0.0, gb.time < 1), (1.0, gb.time < 4), (0.0, True)))
    load = gb.Torque(tau=gb.piecewise((0.0, gb.time < 3), (900.0, True)))
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), sleeve=block, two=gb.Inertia(J=3.0), load=load)
    run = gb.simulate(rig, t=[0.4, 1.5, 2.0, 2.5, 3.5, 4.5])
    slip = -10.0 + 4.0 * (1 + 1 / 3) * (run.t[1:3] - 0.5)
    assert run["sleeve.w_rel"][:3] == pytest.approx([-10.0, *slip], rel=EXACT)  # the teeth wait
    assert list(run["sleeve.mode"]) == [2.0, -1.0, -1.0, 0.0, 0.0, 2.0]
    assert list(run["sleeve.w_rel"][3:5]) == [0.0, 0.0]
    assert run["sleeve.locked"][4] == 1.0
    assert run["sleeve.torque"][4] == pytest.approx(-900.0 / 4, rel=EXACT)  # far beyond the cone, which is gone
    assert run["one.w"][4] == pytest.approx(2.5 + 900.0 / 4 * 0.5, rel=EXACT)
    assert run.energy.dissipated["sleeve"] == pytest.approx(0.75 * 100 / 2, rel=1e-9)  # no impact


# -- loads that stick -------------------------------------------------------------------------------------------------


def test_a_load_with_a_dry_part_holds_the_shaft_up_to_it():
    drive = gb.piecewise((0.0, gb.time < 10), (0.3, gb.time < 12), (0.5, True))
    rig = _chain(drive=gb.Torque(tau=drive), body=gb.Inertia(J=0.5, w0=3.0), load=gb.SpeedLoad(coeffs=(0.4, 0.2, 0.0)))
    run = gb.simulate(rig, t=[9.0, 11.0, 13.0], rtol=1e-10)
    assert [e[0] for e in _modes(run, "load")] == pytest.approx(
        [0.5 / 0.2 * np.log(1 + 0.2 * 3.0 / 0.4), 12.0], rel=1e-9
    )
    assert list(run["body.w"][:2]) == [0.0, 0.0]
    assert run["load.torque"][:2] == pytest.approx([0.0, -0.3], abs=1e-15)
    assert run["body.w"][2] == pytest.approx(0.1 / 0.2 * (1 - np.exp(-0.2 / 0.5)), rel=1e-9)


def test_rolling_resistance_holds_a_vehicle_on_a_gentle_slope():
    grade, m, r, rolling = gb.Parameter("grade", 0.0), 1200.0, 0.3, 0.02
    rig = _chain(
        wheels=gb.Inertia(J=4.0, w0=10.0), car=gb.Vehicle(mass=m, wheel_radius=r, rolling=rolling, grade=grade)
    )
    weight = m * 9.80665
    for angle in (0.0, 0.019, -0.019):
        run = gb.simulate(rig, t_end=400.0, parameters={"grade": angle})
        brake = r * weight * (rolling * np.cos(angle) + np.sin(angle))
        assert _modes(run, "car.rolling")[0][0] == pytest.approx((m * r**2 + 4.0) * 10.0 / brake, rel=1e-9)
        assert run["car.v"][-1] == 0.0
        assert run["car.resistance"][-1] == pytest.approx(-weight * np.sin(angle), rel=1e-12, abs=1e-9)
    run = gb.simulate(rig, t_end=20.0, parameters={"grade": 0.021})
    assert run["car.v"][-1] < 0.0  # steeper than the resistance: it rolls back


# -- every way to run it ----------------------------------------------------------------------------------------------


METHODS = [{"method": "dp5"}, {"method": "dp8"}, {"method": "rodas"}, {"method": "rk4", "step": 0.01}]


@pytest.mark.parametrize("options", METHODS, ids=lambda options: options["method"])
def test_every_method_locks_and_lets_go_at_the_same_times(options):
    clutch = gb.Clutch(capacity=20.0, peak=1.1)
    drive = gb.Torque(tau=30.0 * gb.time)
    rig = _chain(drive=drive, one=gb.Inertia(J=1.0, w0=10.0), clutch=clutch, two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t_end=3.0, rtol=1e-9, **options)
    # slip 10 + 15 t^2 - 40 t = 0; then half of the torque passes: 22 at 44/30 s
    times = [(40 - np.sqrt(1600 - 600)) / 30, 44 / 30]
    assert [t for t, _, _ in _modes(run, "clutch")] == pytest.approx(times, rel=1e-9)
    assert [m for _, _, m in _modes(run, "clutch")] == [0.0, -1.0]


def examples(count):
    """The same `count` examples in every run, no search for smaller ones, no time limit."""
    return settings(
        max_examples=count, derandomize=True, deadline=None, database=None, phases=[Phase.generate],
        suppress_health_check=[HealthCheck.too_slow],
    )  # fmt: skip


def _row(kinds, numbers, order, flips):
    """Three bodies in a row with a friction element between each two; the components added in any order, ends flipped."""
    J, w, cap = numbers
    wave = [c * (1 + sp.sin((i + 2) * gb.time)) for i, c in enumerate(cap)]
    made = {
        "clutch": lambda i: gb.Clutch(capacity=wave[i], peak=1.25),
        "mu": lambda i: gb.Clutch(mu=gb.Table([0, 5], [0.5, 0.3]), force_max=2 * cap[i], engagement=1.0),
        "dog": lambda i: gb.DogClutch(engaged=sp.sin((i + 2) * gb.time)),
    }
    parts = {f"body{i}": gb.Inertia(J=J[i], w0=w[i]) for i in range(3)}
    parts |= {f"link{i}": made[kinds[i]](i) for i in range(2)}
    parts |= {"brake": gb.Brake(capacity=cap[2]), "drive": gb.Torque(tau=3.0 * gb.sin(2 * gb.time))}
    rig = gb.Drivetrain("row")
    handles = {name: rig.add(name, parts[name]) for name in (list(parts)[i] for i in order)}
    for i in range(2):
        ends = ("b", "a") if flips[i] else ("a", "b")
        rig.connect(handles[f"body{i}"].b, getattr(handles[f"link{i}"], ends[0]))
        rig.connect(handles[f"body{i + 1}"].a, getattr(handles[f"link{i}"], ends[1]))
    rig.connect(handles["drive"].flange, handles["body0"].a)
    rig.connect(handles["brake"].a, handles["body2"].b)
    return rig


@examples(8)
@given(
    st.tuples(*(st.sampled_from(["clutch", "mu", "dog"]) for _ in range(2))),
    st.tuples(
        st.tuples(*(st.integers(1, 4) for _ in range(3))),
        st.tuples(*(st.integers(-9, 9) for _ in range(3))),
        st.tuples(*(st.integers(1, 5) for _ in range(3))),
    ),
    st.permutations(range(7)), st.tuples(st.booleans(), st.booleans()),
)  # fmt: skip
def test_the_order_of_components_and_the_sense_of_flanges_change_nothing(kinds, numbers, order, flips):
    t = np.linspace(0, 5, 51)
    one = gb.simulate(_row(kinds, numbers, range(7), (False, False)), t=t, rtol=1e-10)
    two = gb.simulate(_row(kinds, numbers, order, flips), t=t, rtol=1e-10)
    for body in ("body0", "body1", "body2"):
        assert np.abs(one[f"{body}.w"] - two[f"{body}.w"]).max() < 1e-8  # 100 rtol times speeds of up to 9
    sense = {"link0": -1.0 if flips[0] else 1.0, "link1": -1.0 if flips[1] else 1.0}

    def changes(run, signs):
        """Changes of mode; before and after of impacts are speeds."""
        modes = (-1.0, 0.0, 1.0, 2.0)
        found = [e for e in run.events if e.component in ("link0", "link1", "brake")]
        found = [e for e in found if e.kind != "impact" and e.before in modes and e.after in modes]
        turned = [[signs.get(e.component, 1.0) * m if abs(m) == 1 else m for m in (e.before, e.after)] for e in found]
        return sorted((round(e.t, 6), e.component, *m) for e, m in zip(found, turned, strict=True))

    assert changes(one, {}) == changes(two, sense)
    assert one.energy.residual < 1e-8
