"""Vehicles and tyres: coasting, slopes, standing still, grip."""

import numpy as np
import pytest

import gearblocks as gb

NEAR = 1e-9  # tens of steps at rtol 1e-11


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("driveline")
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


def test_a_vehicle_coasts_down_as_an_arctangent(distance):
    m, r, area, rolling, v0, J = 1200.0, 0.3, 0.7, 0.012, 30.0, 4.0
    rig = _chain(
        wheels=gb.Inertia(J=J, w0=v0 / r), car=gb.Vehicle(mass=m, wheel_radius=r, drag_area=area, rolling=rolling)
    )
    t = np.linspace(0, 60, 61)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    whole = m + J / r**2
    a, b = rolling * m * 9.80665 / whole, 1.2 * area / 2 / whole
    angle = np.arctan(v0 * np.sqrt(b / a)) - np.sqrt(a * b) * t
    assert angle[-1] > 0  # it is still rolling
    assert distance(run["car.v"], np.sqrt(a / b) * np.tan(angle)) < NEAR
    way = np.log(np.cos(angle) / np.cos(angle[0])) / b
    assert distance(run["car.s"], way) < NEAR
    lost = whole / 2 * (v0**2 - run["car.v"][-1] ** 2)
    assert run.energy.dissipated["car"] == pytest.approx(lost, rel=1e-9)
    assert np.allclose(run["car.force"] * r, -J * run["wheels.alpha"], rtol=1e-10)


def test_a_slope_pulls_with_the_weight_along_it():
    m, r, grade = 1000.0, 0.25, gb.Parameter("grade", 0.05, "rad")
    rig = _chain(wheels=gb.Inertia(J=1.0), car=gb.Vehicle(mass=m, wheel_radius=r, grade=grade))
    run = gb.simulate(rig, t=np.linspace(0, 10, 11), rtol=1e-10)
    speed = -m * 9.80665 * np.sin(0.05) / (m + 1.0 / r**2) * run.t
    assert np.allclose(run["car.v"], speed, rtol=1e-12, atol=1e-12)
    assert run.energy.supplied["car"] == pytest.approx((m + 1.0 / r**2) / 2 * speed[-1] ** 2, rel=1e-10)


@pytest.mark.long
def test_a_vehicle_with_fading_rolling_resistance_stands_still():
    rig = _chain(
        drive=gb.Torque(tau=gb.piecewise((0, gb.time < 1), (300, True))), wheels=gb.Inertia(J=1.0),
        car=gb.Vehicle(mass=1000.0, wheel_radius=0.3, rolling=0.02, rolling_speed=0.1),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.5, 1.0, 5.0], rtol=1e-9)
    assert (run["car.v"][:2] == 0).all()
    assert run["car.v"][2] > 2.0


@pytest.mark.long
def test_tyres_slip_by_what_their_force_asks(distance):
    m, r, area, stiffness = 1200.0, 0.3, 0.7, 8e4
    tyre = gb.TyreSlip(stiffness=stiffness, grip=0.9, low_speed=0.2)
    rig = _chain(
        drive=gb.Torque(tau=200.0), wheels=gb.Inertia(J=2.0, w0=20.0 / r),
        car=gb.Vehicle(mass=m, wheel_radius=r, drag_area=area, rolling=0.01, tyre=tyre),
    )  # fmt: skip
    run = gb.simulate(rig, t=np.linspace(0, 5, 51), initial={"car.v": 20.0}, rtol=1e-9)
    assert run.energy.residual < 1e-8
    slip = (r * run["wheels.w"] - run["car.v"]) / np.sqrt(run["car.v"] ** 2 + 0.04)
    assert np.allclose(run["car.slip"], slip, rtol=1e-9, atol=1e-12)
    most = 0.9 * m * 9.80665
    assert distance(run["car.force"], most * np.sin(np.arctan(stiffness * slip / most))) < 1e-12
    assert np.allclose(run["car.flange.tau"], -r * run["car.force"], rtol=1e-13)
    stiff = rig.set({"car.tyre.stiffness": 8e6})
    rigid = gb.simulate(rig.without("car.tyre"), t=[5.0], rtol=1e-9)["car.v"][0]
    errors = [abs(gb.simulate(x, t=[5.0], initial={"car.v": 20.0})["car.v"][0] - rigid) for x in (rig, stiff)]
    assert errors[1] < errors[0] / 30  # the slip falls as 1/stiffness


def test_a_tyre_gives_no_more_than_its_grip():
    tyre = gb.TyreSlip(stiffness=8e4, grip=0.4, low_speed=0.2, shape=1.6)
    rig = _chain(
        drive=gb.Torque(tau=1500.0 * gb.time),
        wheels=gb.Inertia(J=2.0, w0=20.0 / 0.3),
        car=gb.Vehicle(mass=1200.0, wheel_radius=0.3, tyre=tyre),
    )
    run = gb.simulate(rig, t=np.linspace(0, 3, 301), initial={"car.v": 20.0})
    most = 0.4 * 1200.0 * 9.80665
    assert run["car.force"].max() <= most
    assert run["car.force"].max() > 0.99 * most
    assert run["car.force"][-1] < 0.8 * most  # shape 1.6 falls beyond the peak: sin(1.6 pi/2) = 0.59
    assert run["wheels.w"][-1] * 0.3 > 10 * run["car.v"][-1]


@pytest.mark.parametrize(("grade", "v0"), [(0.3, 20.0), (-0.15, 20.0), (0.3, -20.0), (0.0, -20.0)])
def test_rolling_resistance_on_a_slope_is_that_of_the_normal_force(grade, v0):
    m, r, rolling, J, g = 1000.0, 0.25, 0.2, 5.0, 9.80665
    car = gb.Vehicle(mass=m, wheel_radius=r, rolling=rolling, grade=grade)
    run = gb.simulate(_chain(wheels=gb.Inertia(J=J, w0=v0 / r), car=car), t=np.linspace(0, 2, 21), rtol=1e-10)
    against = m * g * rolling * np.cos(grade) * np.sign(v0)
    speed = v0 - (m * g * np.sin(grade) + against) / (m + J / r**2) * run.t
    assert (speed * v0 > 0).all()  # it does not come to rest
    assert np.allclose(run["car.v"], speed, rtol=1e-10)
    assert np.allclose(run["car.resistance"], against, rtol=1e-12)
    way = run["car.s"][-1] - run["car.s"][0]
    assert run.energy.dissipated["car"] == pytest.approx(against * way, rel=1e-9)
    assert run.energy.supplied["car"] == pytest.approx(-m * g * np.sin(grade) * way, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("grade", [0.1, -0.15])
def test_what_rolling_resistance_holds_on_a_slope_is_shown(grade):
    car = gb.Vehicle(mass=1000.0, wheel_radius=0.25, rolling=0.2, grade=grade)
    run = gb.simulate(_chain(wheels=gb.Inertia(J=5.0), car=car), t=[0.0, 1.0])
    assert (run["car.v"] == 0).all()
    assert np.allclose(run["car.resistance"], -1000.0 * 9.80665 * np.sin(grade), rtol=1e-12)


@pytest.mark.parametrize("shape", [1.3, 1.65, 2.0])
def test_a_tyre_of_any_shape_has_the_stiffness_asked_for_and_the_curve_of_its_formula(shape):
    m, stiffness, grip = 1200.0, 5e4, 0.8
    tyre = gb.TyreSlip(stiffness=stiffness, grip=grip, low_speed=0.2, shape=shape)
    car = gb.Vehicle(mass=m, wheel_radius=0.3, tyre=tyre)
    rig = _chain(drive=gb.Torque(tau=2000.0 * gb.time), wheels=gb.Inertia(J=2.0, w0=20.0 / 0.3), car=car)
    run = gb.simulate(rig, t=np.linspace(0, 1, 101), initial={"car.v": 20.0}, rtol=1e-9)
    slip, force, most = run["car.slip"], run["car.force"], grip * m * 9.80665
    little = (slip > 1e-6) & (stiffness * slip < 0.05 * most)
    assert little.sum() > 5
    assert np.allclose(force[little], stiffness * slip[little], rtol=3e-3)  # (0.05)^2 in the next term
    assert np.allclose(force, most * np.sin(shape * np.arctan(stiffness * slip / (shape * most))), rtol=1e-9)


# -- wind, slope and rolling resistance along the way -------------------------------------------------------------------


def test_a_car_in_the_wind_comes_to_the_speed_of_the_air():
    m, r, area, wind, v0 = 900.0, 0.3, 0.8, 12.0, 30.0
    rig = _chain(wheels=gb.Inertia(J=0.0, w0=v0 / r), car=gb.Vehicle(mass=m, wheel_radius=r, drag_area=area, wind=wind))
    t = np.linspace(0.0, 200.0, 21)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    u0, k = v0 - wind, 1.2 * area / 2 / m
    assert np.allclose(run["car.v"], wind + u0 / (1 + k * u0 * t), rtol=1e-9, atol=0)  # u' = -k u^2
    assert run.energy.residual < 1e-10 and run.energy.supplied["car"] < 0  # the wind from behind holds the air back
    u = run["car.v"][-1] - wind
    assert run.energy.dissipated["car"] == pytest.approx(m / 2 * (u0**2 - u**2), rel=1e-9)


def test_a_slope_over_the_way_gives_back_what_it_took():
    m, r, J, v0 = 1000.0, 0.3, 5.0, 20.0
    way = gb.Table([0.0, 50.0, 100.0, 150.0, 200.0], [0.0, 0.1, 0.0, -0.1, 0.0])
    car = gb.Vehicle(mass=m, wheel_radius=r, wheel_inertia=J, grade=way(gb.distance))
    run = gb.simulate(_chain(wheels=gb.Inertia(J=0.0, w0=v0 / r), car=car), t_end=12.0, rtol=1e-10)
    s = np.linspace(0.0, 200.0, 200001)
    height = np.concatenate([[0.0], np.cumsum(np.sin(way.values((s[1:] + s[:-1]) / 2)) * (s[1] - s[0]))])
    inside = run["car.s"] < 200.0
    climbed = np.interp(run["car.s"], s, height)[inside]
    whole = m + J / r**2
    assert np.allclose(whole / 2 * (v0**2 - run["car.v"][inside] ** 2), m * 9.80665 * climbed, rtol=0, atol=1e-4 * m)
    assert run["car.s"][-1] > 200.0 and run["car.v"][-1] == pytest.approx(v0, rel=1e-9)


@pytest.mark.long
def test_rolling_resistance_that_jumps_along_the_way_brakes_by_two_parabolas():
    m, r, v0, g = 800.0, 0.25, 15.0, 9.80665
    rolling = gb.Table([0.0, 100.0, 100.0, 200.0], [0.01, 0.01, 0.05, 0.05])(gb.distance)
    car = gb.Vehicle(mass=m, wheel_radius=r, rolling=rolling)
    run = gb.simulate(_chain(wheels=gb.Inertia(J=0.0, w0=v0 / r), car=car), t_end=60.0, rtol=1e-10)
    end = 100.0 + (v0**2 - 2 * 0.01 * g * 100.0) / (2 * 0.05 * g)
    assert run["car.v"][-1] == 0.0 and run["car.s"][-1] == pytest.approx(end, rel=1e-10)
    assert run.energy.dissipated["car"] == pytest.approx(m / 2 * v0**2, rel=1e-10)


@pytest.mark.long
def test_wheels_of_the_vehicle_are_inertias_on_its_shaft():
    kw = {"mass": 1200.0, "wheel_radius": 0.3, "drag_area": 0.7, "rolling": 0.012}
    inside = _chain(drive=gb.Torque(tau=300.0), car=gb.Vehicle(wheel_inertia=4.0, **kw))
    beside = _chain(drive=gb.Torque(tau=300.0), wheels=gb.Inertia(J=4.0), car=gb.Vehicle(**kw))
    one, two = (gb.simulate(rig, t=[0.0, 5.0, 10.0], rtol=1e-11) for rig in (inside, beside))
    for name in ("car.v", "car.s", "car.force", "car.resistance"):
        assert np.allclose(one[name], two[name], rtol=1e-12, atol=0), name


# -- a chassis with its wheels --------------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_chassis_on_a_wheel_that_rolls_is_the_vehicle():
    road = {"mass": 1200.0, "drag_area": 0.7, "rolling": 0.012, "wind": -5.0, "grade": 0.02 * gb.sin(gb.distance / 50)}
    car = _chain(drive=gb.Torque(tau=300.0), wheels=gb.Inertia(J=4.0), car=gb.Vehicle(wheel_radius=0.3, **road))
    parts = _chain(
        drive=gb.Torque(tau=300.0), wheels=gb.Inertia(J=4.0), rack=gb.Rack(radius=0.3), car=gb.Chassis(**road)
    )
    one, two = (gb.simulate(rig, t=[0.0, 10.0, 20.0], rtol=1e-11) for rig in (car, parts))
    for name in ("car.v", "car.s", "car.resistance"):
        assert np.allclose(one[name], two[name], rtol=1e-11, atol=0), name
    assert two.energy.dissipated["car"] == pytest.approx(one.energy.dissipated["car"], rel=1e-11)
    assert two.energy.residual < 1e-11


@pytest.mark.long
def test_two_driven_axles_pull_as_one_of_twice_the_stiffness():
    m, r, g = 1200.0, 0.3, 9.80665
    tyre = gb.TyreSlip(stiffness=5e4, grip=0.9, low_speed=0.5)
    one = _chain(
        drive=gb.Torque(tau=300.0), wheels=gb.Inertia(J=4.0), car=gb.Vehicle(mass=m, wheel_radius=r, tyre=tyre)
    )
    two = gb.Drivetrain("two axles")
    car = two.add("car", gb.Chassis(mass=m))
    for axle in ("front", "rear"):
        half = gb.Tyre(radius=r, stiffness=2.5e4, grip=0.9, low_speed=0.5, normal_force=m * g / 2)
        drive, wheels = two.add(f"drive_{axle}", gb.Torque(tau=150.0)), two.add(f"wheels_{axle}", gb.Inertia(J=2.0))
        two.chain(drive, wheels, two.add(f"tyre_{axle}", half), car)
    a, b = (gb.simulate(rig, t=[0.0, 2.0, 5.0], rtol=1e-11) for rig in (one, two))
    assert np.allclose(a["car.v"], b["car.v"], rtol=1e-10, atol=0)
    assert np.allclose(a["car.slip"], b["tyre_rear.slip"], rtol=1e-9, atol=1e-15)
    assert b.energy.dissipated["tyre_front"] == pytest.approx(a.energy.dissipated["car"] / 2, rel=1e-9)


@pytest.mark.long
def test_an_axle_without_grip_spins_while_the_other_pulls():
    rig = gb.Drivetrain("ice at the rear")
    car = rig.add("car", gb.Chassis(mass=1000.0))
    for axle, grip in (("front", 1.0), ("rear", 0.05)):
        tyre = gb.Tyre(radius=0.3, stiffness=5e4, grip=grip, low_speed=0.5, normal_force=5e3)
        drive, wheels = rig.add(f"drive_{axle}", gb.Torque(tau=600.0)), rig.add(f"wheels_{axle}", gb.Inertia(J=1.0))
        rig.chain(drive, wheels, rig.add(f"tyre_{axle}", tyre), car)
    run = gb.simulate(rig, t_end=1.0, rtol=1e-8)
    assert run["wheels_rear.w"][-1] > 20 * run["wheels_front.w"][-1] * 0.3
    assert run["tyre_rear.force"][-1] == pytest.approx(0.05 * 5e3, rel=2e-3)
    assert run.energy.residual < 1e-7


@pytest.mark.long
def test_a_trailer_is_pulled_by_its_share_of_the_force():
    rig = gb.Drivetrain("with a trailer")
    car, trailer = rig.add("car", gb.Chassis(mass=1500.0)), rig.add("trailer", gb.Chassis(mass=500.0, rolling=0.01))
    rig.chain(rig.add("pull", gb.Force(f=1000.0)), car, rig.add("hitch", gb.Shaft(rigid=True)), trailer)
    run = gb.simulate(rig, t_end=10.0, rtol=1e-10)
    resistance = 0.01 * 500.0 * 9.80665
    a = (1000.0 - resistance) / 2000.0
    assert run["car.v"][-1] == pytest.approx(10.0 * a, rel=1e-12)
    assert abs(run["hitch.torque"][-1]) == pytest.approx(500.0 * a + resistance, rel=1e-10)


@pytest.mark.long
def test_a_chassis_stands_on_a_slope_that_its_rolling_resistance_holds():
    rig = gb.Drivetrain("parked")
    grade = gb.Table([0.0, 1.0, 2.0], [0.0, 0.0, 0.04])
    rig.add("car", gb.Chassis(mass=1000.0, rolling=0.02, grade=grade))
    run = gb.simulate(rig, t=[0.0, 1.49, 4.0])
    assert list(run["car.v"][:2]) == [0.0, 0.0] and run["car.v"][2] < 0  # tan(grade) passes 0.02 at 1.5 s


@pytest.mark.parametrize(
    ("block", "says"),
    [
        (lambda: gb.Vehicle(mass=1.0, wheel_radius=1.0, wind=3.0), "wind needs drag_area"),
        (lambda: gb.Chassis(mass=1.0, grade=2.0), r"grade = 2.0 rad must be < 1.5"),
        (lambda: gb.Chassis(mass=1.0, rolling=-0.1), "rolling = -0.1 must be >= 0"),
        (
            lambda: gb.Tyre(radius=0.3, stiffness=1.0, grip=1.0, low_speed=0.1, normal_force=0.0),
            "normal_force = 0.0 N must be > 0",
        ),
        (lambda: gb.Speed(w=gb.distance), "contains gb.distance, which only a Vehicle or a Chassis knows"),
    ],
)
def test_vehicles_that_cannot_be_are_refused_by_name(block, says):
    rig = gb.Drivetrain("rig")
    with pytest.raises(gb.ModelError, match=says):
        rig.add("part", block())


# -- rolling resistance and loads that come to nothing -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rolling", "says"),
    [
        (gb.Table([0.0, 1.0], [0.01, -0.01]), "rolling = Table.* comes to -0.01, and must be >= 0"),
        (gb.Table([0.0, 1.0], [0.01, -0.01])(gb.distance), "rolling = Table.* comes to -0.01, and must be >= 0"),
        (0.01 * gb.time - 0.02, "is -0.02 at t = 0, and must be >= 0: .*; gb.maximum"),
        (gb.Input("f_r", start=-0.02), "is -0.02 at t = 0"),
    ],
)
@pytest.mark.parametrize("kind", [gb.Chassis, lambda **more: gb.Vehicle(wheel_radius=0.3, **more)])
def test_rolling_resistance_that_would_drive_is_refused_by_name(kind, rolling, says):
    rig = gb.Drivetrain("rig")
    with pytest.raises(gb.ModelError, match=says):
        rig.add("car", kind(mass=100.0, rolling=rolling))


@pytest.mark.parametrize("rolling_speed", [None, 1e-4])
def test_rolling_resistance_that_comes_below_zero_is_none(rolling_speed):
    """v' = -g max(0, 0.1 - 0.2 t): it drove the car on from 0.5 s."""
    car = gb.Chassis(mass=100.0, v0=3.0, rolling=0.1 - 0.2 * gb.time, rolling_speed=rolling_speed)
    rig = gb.Drivetrain("coasting")
    rig.add("car", car)
    run = gb.simulate(rig, t=np.linspace(0.0, 1.0, 11), rtol=1e-10)
    t = np.minimum(run.t, 0.5)
    assert np.allclose(run["car.v"], 3.0 - 9.80665 * (0.1 * t - 0.1 * t**2), rtol=1e-9)
    assert run.energy.dissipated["car"] == pytest.approx(50.0 * (9.0 - run["car.v"][-1] ** 2), rel=1e-8)


_LOADS = {
    "a table to zero": gb.Table([0.0, 0.2], [800.0, 0.0]),
    "a table through zero": gb.Table([0.0, 0.1, 0.3], [800.0, 0.0, -800.0]),
    "cases": gb.piecewise((800.0, gb.time < 0.1), (0.0, True)),
    "a largest": gb.maximum(800.0 * (1.0 - 5.0 * gb.time), 0.0),
    "a wave": 800.0 * gb.cos(10.0 * gb.time),
    "never": gb.Input("load"),
}


@pytest.mark.parametrize("load", _LOADS.values(), ids=_LOADS)
@pytest.mark.parametrize("v0", [0.5, 6.0])
def test_a_wheel_in_the_air_has_no_force(load, v0):
    """NaN, or the force of a load of the other sign, before; v0 = 6: it rolls when it is lifted."""
    rig = _chain(
        wheel=gb.Inertia(J=5.0, w0=20.0),
        tyre=gb.Tyre(radius=0.3, stiffness=2e4, grip=0.8, low_speed=0.2, normal_force=load),
        rider=gb.Chassis(mass=80.0, v0=v0),
    )
    run = gb.simulate(rig, t=[0.0, 0.05, 0.2, 0.25, 0.3], rtol=1e-9)
    assert run["tyre.force"][2:] == pytest.approx(0.0, abs=0.0)
    assert run["rider.v"][2] == run["rider.v"][4] and run["wheel.w"][2] == run["wheel.w"][4]
    momentum = 80.0 * run["rider.v"] + 5.0 * run["wheel.w"] / 0.3
    assert np.allclose(momentum, momentum[0], rtol=1e-8) and run.energy.residual < 1e-8
    assert (run["rider.v"][1] > v0) == (v0 < 6.0 and not isinstance(load, gb.Input))


def test_a_tyre_lands_again():
    """Lifted from 0.1 s to 0.2 s the wheel spins up freely; grip then takes the slip off again."""
    load = gb.Table([0.0, 0.1, 0.1, 0.2, 0.2, 1.0], [800.0, 800.0, 0.0, 0.0, 800.0, 800.0])
    rig = _chain(
        drive=gb.Torque(tau=30.0), wheel=gb.Inertia(J=0.5, w0=20.0),
        tyre=gb.Tyre(radius=0.3, stiffness=2e4, grip=0.8, low_speed=0.2, normal_force=load),
        rider=gb.Chassis(mass=80.0, v0=6.0),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.1, 0.15, 0.2, 1.0], rtol=1e-9)
    assert np.allclose(np.diff(run["wheel.w"][:3]), 30.0 / 0.5 * 0.05, rtol=1e-6)
    assert np.ptp(run["rider.v"][:3]) < 1e-9
    assert run["wheel.w"][3] * 0.3 == pytest.approx(run["rider.v"][3], rel=1e-2)
