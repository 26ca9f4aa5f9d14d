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


def test_a_vehicle_with_fading_rolling_resistance_stands_still():
    rig = _chain(
        drive=gb.Torque(tau=gb.piecewise((0, gb.time < 1), (300, True))), wheels=gb.Inertia(J=1.0),
        car=gb.Vehicle(mass=1000.0, wheel_radius=0.3, rolling=0.02, rolling_speed=0.1),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.5, 1.0, 5.0], rtol=1e-9)
    assert (run["car.v"][:2] == 0).all()
    assert run["car.v"][2] > 2.0


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
