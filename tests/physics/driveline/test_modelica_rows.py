"""Rows of the dictionary of docs/modelica.md, typed as they stand there, against closed forms and scipy."""

from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

import gearblocks as gb

T = np.linspace(0.0, 1.0, 11)
NEAR = 1e-8  # what the rows promise; runs are at rtol 1e-10


def _run(*parts: tuple[str, gb.Block], t: Any = T) -> Any:
    rig = gb.Drivetrain("row")
    rig.chain(*(rig.add(name, block) for name, block in parts))
    return gb.simulate(rig, t=t, rtol=1e-10)


def _solved(rates: Any, start: list[float], t: Any = T) -> Any:
    return solve_ivp(rates, (t[0], t[-1]), start, rtol=1e-11, atol=1e-11, t_eval=t, max_step=0.01 * t[-1]).y


def _near(found: Any, wanted: Any) -> None:
    assert np.abs(found - wanted).max() < NEAR * np.abs(wanted).max()


def test_a_torque_between_two_shafts_is_torque2() -> None:
    rig = gb.Drivetrain("Torque2")
    a, b, torque = rig.add("a", gb.Inertia(J=2.0)), rig.add("b", gb.Inertia(J=1.0)), rig.add("t", gb.Torque(tau=3.0))
    rig.connect(torque.housing, a.a)
    rig.connect(torque.flange, b.a)
    run = gb.simulate(rig, t=T, rtol=1e-10)
    _near(run["a.w"], -1.5 * T)
    _near(run["b.w"], 3.0 * T)


def test_a_rack_has_one_over_the_ratio_and_a_lever_of_the_second_class_its_ratio() -> None:
    rack = gb.Rack(radius=1 / 20)
    _near(
        _run(("t", gb.Torque(tau=2.0)), ("J", gb.Inertia(J=0.1)), ("g", rack), ("m", gb.Mass(m=8.0)))["m.v"], 5 / 6 * T
    )
    lever = gb.IdealGear(ratio=3)
    run = _run(("f", gb.Force(f=6.0)), ("m1", gb.Mass(m=1.0)), ("lever", lever), ("m2", gb.Mass(m=9.0)))
    _near(run["m1.v"], 3.0 * T)
    _near(run["m2.v"], T)


@pytest.mark.parametrize(
    ("bearing", "law"),
    [
        (gb.BearingFriction(torque=0.5 + 0.3 * gb.exp(-0.2 * gb.slip)), lambda w: 0.5 + 0.3 * np.exp(-0.2 * w)),
        (gb.BearingFriction(coulomb=0.4, viscous=0.5 - 0.4), lambda w: 0.4 + 0.1 * w),  # tau_pos=[0, 0.4; 1, 0.5]
    ],
    ids=["f_p", "tau_pos"],
)
def test_bearing_friction_of_both_forms(bearing: Any, law: Any) -> None:
    run = _run(("rotor", gb.Inertia(J=1.0, w0=10.0)), ("friction", bearing))
    _near(run["rotor.w"], _solved(lambda _, y: [-law(y[0])], [10.0])[0])
    assert run["friction.torque"][0] == pytest.approx(law(10.0), rel=1e-9)  # as Modelica's tau


def test_an_eddy_current_brake_has_the_square_of_the_excitation_and_the_opposite_sign_of_tau() -> None:
    brake = gb.EddyCurrentBrake(tau_nominal=10.0, w_nominal=8.0, excitation=0.5**2)
    run = _run(("rotor", gb.Inertia(J=1.0, w0=20.0)), ("brake", brake))
    w = _solved(lambda _, y: [-0.25 * 20.0 / (8.0 / y[0] + y[0] / 8.0)], [20.0])[0]
    _near(run["rotor.w"], w)
    _near(run["brake.torque"], -0.25 * 2 * 10.0 * (w / 8.0) / (1 + (w / 8.0) ** 2))


@pytest.mark.parametrize(
    ("load", "w0", "wanted"),
    [
        (gb.SpeedLoad(coeffs=(0, 0, 0.05), direction="backward"), -4.0, 1 / (-0.25 + 0.05 * T)),
        (gb.SpeedLoad(coeffs=(0, 0.5, 0), direction="forward"), 2.0, 2.0 * np.exp(0.5 * T)),
    ],
    ids=["quadratic", "linear"],
)
def test_loads_with_a_torque_direction_keep_their_sign(load: Any, w0: float, wanted: Any) -> None:
    _near(_run(("rotor", gb.Inertia(J=1.0, w0=w0)), ("load", load))["rotor.w"], wanted)


def test_a_spring_damper_at_a_fixed_with_a_place_of_its_own() -> None:
    k, c, m = 40.0, 1.0, 2.0
    wall, spring = gb.Fixed(phi0=0.5), gb.Shaft(k=k, c=c, rest=0.3)
    run = _run(("wall", wall), ("spring", spring), ("mass", gb.Mass(m=m, s0=1.0, v0=0.2)))
    s, v = _solved(lambda _, y: [y[1], (-k * (y[0] - 0.8) - c * y[1]) / m], [1.0, 0.2])
    _near(run["mass.s"], s)
    _near(run["spring.torque"], -k * (s - 0.8) - c * v)  # on b: minus Modelica's f


def test_a_vehicle_with_an_inclination_wind_and_wheels_with_inertia() -> None:
    car = gb.Vehicle(mass=1e3, wheel_radius=0.3, drag_area=0.7, grade=sympy.atan(0.03), wind=-5.0, wheel_inertia=3.0)
    run = _run(("drive", gb.Torque(tau=300.0)), ("shaft", gb.Inertia(J=1.0)), ("car", car), t=10.0 * T)
    climb = 1e3 * 9.80665 * np.sin(np.arctan(0.03))
    rate = lambda _, y: [(1e3 - 0.6 * 0.7 * (y[0] + 5) * abs(y[0] + 5) - climb) / (1e3 + 4.0 / 0.09)]  # noqa: E731
    _near(run["car.v"], _solved(rate, [0.0], 10.0 * T)[0])


def test_an_acceleration_that_drives_a_compliant_train() -> None:
    source = gb.Acceleration(alpha=gb.sin(3 * gb.time), w0=2.0)
    run = _run(("source", source), ("shaft", gb.Shaft(k=50.0, c=0.5)), ("body", gb.Inertia(J=2.0, w0=2.0)))

    def rate(t: float, y: Any) -> list[float]:
        w, phi = 2 + (1 - np.cos(3 * t)) / 3, 2 * t + t / 3 - np.sin(3 * t) / 9
        return [y[1], (-50.0 * (y[0] - phi) - 0.5 * (y[1] - w)) / 2.0]

    _near(run["body.w"], _solved(rate, [0.0, 2.0])[1])


def test_a_clutch_with_the_fields_of_modelica() -> None:
    clutch = gb.Clutch(mu=0.4, force_max=50.0, engagement=0.5, geometry=0.3)
    run = _run(("a", gb.Inertia(J=1.0, w0=10.0)), ("clutch", clutch), ("b", gb.Inertia(J=2.0)))
    _near(run["clutch.torque"], np.full(11, 0.3 * 0.4 * 0.5 * 50.0))  # on b: minus Modelica's tau
    _near(run["clutch.w_rel"], -10.0 + 4.5 * T)


def test_a_conductor_between_two_capacitors() -> None:
    rig = gb.Drivetrain("heat")
    rig.add("hot", gb.ThermalMass(C=10.0, T0=400.0))
    rig.add("cold", gb.ThermalMass(C=30.0, T0=300.0))
    rig.add("between", gb.ThermalConductance(G=2.0, a="hot", b="cold"))
    _near(gb.simulate(rig, t=10.0 * T, rtol=1e-10)["hot.T"], 325.0 + 75.0 * np.exp(-2.0 * (1 / 10 + 1 / 30) * 10.0 * T))


def test_the_ratio_of_an_ideal_planetary_set_is_ring_over_sun() -> None:
    rig, ratio = gb.Drivetrain("set"), 2.5
    bodies = {n: rig.add(n, gb.Inertia(J=J)) for n, J in (("sun", 1.0), ("carrier", 2.0), ("ring", 3.0))}
    gear = rig.add("gear", gb.IdealPlanetary(ratio=ratio))
    for name, body in bodies.items():
        rig.connect(body.a, getattr(gear, name))
    rig.connect(rig.add("drive", gb.Torque(tau=5.0)).flange, bodies["sun"].a)
    run = gb.simulate(rig, t=T, rtol=1e-10)
    rows = [[1, 0, 0, 1], [0, 2, 0, -1 - ratio], [0, 0, 3, ratio], [1, -1 - ratio, ratio, 0]]
    alpha = np.linalg.solve(rows, [5.0, 0.0, 0.0, 0.0])
    for name, a in zip(bodies, alpha, strict=False):
        _near(run[f"{name}.w"], a * T)
