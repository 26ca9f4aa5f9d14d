"""Converters, belts, brakes, engines, governors and vehicles: closed forms, power balance, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

NAN = float("nan")
MAP = gb.Table2([0, 100, 200, 400], [0, 1], [[0, 50], [-10, 150], [-15, 200], [-20, 120]])
CAPACITY = gb.Table([-1.0, 0.0, 0.8, 1.0, 1.2], [2.5e-3, 2.5e-3, 2.2e-3, 0.0, -1e-3])
RATIO = gb.Table([-1.0, 0.0, 0.85, 1.0], [2.4, 2.2, 1.0, 1.0])
FLUID = {"capacity": gb.Table([0.0, 1.0], [4e-3, 0.0]), "ratio": gb.Table([0.0, 1.0], [1.0, 1.0])}
NEAR = 1e-9  # tens of steps at rtol 1e-11


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("driveline")
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


# -- torque converter -------------------------------------------------------------------------------------------------


def test_a_fluid_coupling_brings_two_bodies_together_as_a_logistic_curve(distance):
    c, J_i, J_t, w_i, w_t = 4e-3, 0.3, 0.9, 120.0, 20.0
    rig = _chain(a=gb.Inertia(J=J_i, w0=w_i), fluid=gb.TorqueConverter(**FLUID), b=gb.Inertia(J=J_t, w0=w_t))
    t = np.linspace(0, 3, 31)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    momentum, J = J_i * w_i + J_t * w_t, J_i + J_t
    # T = c (w_i - w_t) w_i, so the slip x obeys x' = -a x (1 + b x)
    a, b = c * momentum / J * (1 / J_i + 1 / J_t), J_t / momentum
    x = (w_i - w_t) * np.exp(-a * t) / (1 + b * (w_i - w_t) * (1 - np.exp(-a * t)))
    assert distance(run["a.w"] - run["b.w"], x) < NEAR
    assert distance(J_i * run["a.w"] + J_t * run["b.w"], momentum) < 1e-13  # rounding
    assert run.energy.residual < 1e-10
    lost = (J_i * w_i**2 + J_t * w_t**2 - J_i * run["a.w"][-1] ** 2 - J_t * run["b.w"][-1] ** 2) / 2
    assert run.energy.dissipated["fluid"] == pytest.approx(lost, rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_converter_at_stall_multiplies_the_torque_and_its_stator_holds_the_rest(way, distance):
    tau, J, c, ratio = way * 90.0, 0.2, 2.5e-3, 2.2
    rig = _chain(
        drive=gb.Torque(tau=tau), engine=gb.Inertia(J=J), converter=gb.TorqueConverter(capacity=CAPACITY, ratio=RATIO),
        hold=gb.Fixed(),
    )  # fmt: skip
    t = np.linspace(0, 2, 21)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    top = np.sqrt(abs(tau) / c)
    assert distance(run["engine.w"], way * top * np.tanh(c * top * t / J)) < NEAR
    assert distance(run["converter.torque"], ratio * run["converter.impeller_torque"]) < 1e-14
    assert distance(run["hold.torque"], -run["converter.torque"]) < 1e-14


def test_a_converter_loses_what_it_does_not_pass_on():
    rig = _chain(
        drive=gb.Torque(tau=200.0), a=gb.Inertia(J=0.2), converter=gb.TorqueConverter(capacity=CAPACITY, ratio=RATIO),
        b=gb.Inertia(J=2.0), load=gb.SpeedLoad(coeffs=(0.0, 0.5, 0.0)),
    )  # fmt: skip
    for start in ({}, {"a.w": -50.0, "b.w": 30.0}, {"a.w": 20.0, "b.w": 300.0}):
        run = gb.simulate(rig, t=np.linspace(0, 20, 201), rtol=1e-9, initial=start)
        assert (run["converter.loss_power"] >= -1e-9 * np.abs(run["converter.loss_power"]).max()).all()
        power = run["converter.impeller.power"] + run["converter.turbine.power"]
        assert np.allclose(power, -run["converter.loss_power"], rtol=1e-12, atol=1e-9)
        assert run.energy.residual < 1e-8
    nu = run["converter.speed_ratio"]
    assert nu[0] == pytest.approx(15.0, rel=1e-9)
    assert run["converter.torque"][0] < 0  # the turbine drives: it is braked
    assert 0.85 < nu[-1] < 0.95


# -- belts ------------------------------------------------------------------------------------------------------------


def test_a_creeping_belt_slips_in_proportion_to_its_torque(distance):
    ratio, stiffness, tau = 2.5, 500.0, 4.0
    rig = _chain(
        drive=gb.Torque(tau=tau), a=gb.Inertia(J=0.03, w0=100.0),
        belt=gb.BeltDrive(ratio=ratio, slip=gb.Creep(stiffness=stiffness, low_speed=1e-3)),
        b=gb.Inertia(J=0.3, w0=40.0), load=gb.SpeedLoad(coeffs=(0.0, 0.25, 0.0)),
    )  # fmt: skip
    run = gb.simulate(rig, t=[40.0], rtol=1e-9)  # settles in J/c = 2 s
    w_b = ratio * tau / 0.25
    assert run["b.w"][0] == pytest.approx(w_b, rel=1e-7)
    assert run["belt.slip"][0] == pytest.approx(tau / stiffness, rel=1e-7)
    assert run["a.w"][0] == pytest.approx(ratio * w_b / (1 - tau / stiffness), rel=1e-7)
    assert run["belt.loss_power"][0] == pytest.approx(tau * run["a.w"][0] * tau / stiffness, rel=1e-6)
    assert run["belt.a.tau"][0] + run["belt.b.tau"][0] == pytest.approx((ratio - 1) * tau, rel=1e-7)  # the frame
    assert run.energy.residual < 1e-9


def test_a_slow_belt_is_a_viscous_coupling(distance):
    ratio, c = 3.0, 2.0
    slow = gb.Creep(stiffness=c * 1e9, low_speed=1e9)
    rig = _chain(a=gb.Inertia(J=0.1, w0=60.0), belt=gb.BeltDrive(ratio=ratio, slip=slow), b=gb.Inertia(J=0.5))
    t = np.linspace(0, 0.2, 21)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    sliding = run["a.w"] - ratio * run["b.w"]
    assert distance(sliding, 60.0 * np.exp(-c * (1 / 0.1 + ratio**2 / 0.5) * t)) < NEAR


def test_a_stiff_belt_tends_to_the_rigid_one_and_an_overloaded_one_slides():
    def rig(slip: gb.Creep | None) -> gb.Drivetrain:
        belt = gb.BeltDrive(ratio=2.0, slip=slip)
        return _chain(drive=gb.Torque(tau=5.0), a=gb.Inertia(J=0.1), belt=belt, b=gb.Inertia(J=0.4))

    rigid = gb.simulate(rig(None), t=[1.0])["a.w"][0]
    assert rigid == pytest.approx(5.0 / (0.1 + 0.4 / 4), rel=1e-13)
    soft = [
        gb.simulate(rig(gb.Creep(stiffness=k, low_speed=1.0)), t=[1.0], rtol=1e-9)["a.w"][0] - rigid for k in (1e3, 1e4)
    ]
    assert soft[0] / soft[1] == pytest.approx(10, rel=0.02)  # first order in 1/stiffness
    assert rig(gb.Creep(stiffness=1e3, low_speed=1.0)).without("belt.slip")["belt"] == gb.BeltDrive(ratio=2.0)
    sliding = gb.simulate(rig(gb.Creep(stiffness=1e4, low_speed=1.0, limit=1.0)), t=[0.0, 10.0], rtol=1e-8)
    assert sliding["b.w"][1] == pytest.approx(
        2.0 * 10.0 * 1.0 / 0.4, rel=1e-3
    )  # the limit is met to (limit/stiffness slip)^2
    assert abs(sliding["belt.torque"]).max() < 2.0


# -- brakes and motors ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_an_eddy_current_brake_slows_down_along_its_law(way):
    tau, w_n, J, w0, excitation = 3.0, 20.0, 0.5, 90.0, 0.8
    brake = gb.EddyCurrentBrake(tau_nominal=tau, w_nominal=w_n, excitation=excitation)
    t = np.linspace(0, 8, 41)
    run = gb.simulate(_chain(body=gb.Inertia(J=J, w0=way * w0), brake=brake), t=t, rtol=1e-11)
    w = way * run["body.w"]
    # (w + w_n^2/w) w' = -2 excitation tau w_n / J
    passed = (w0**2 - w**2) / 2 + w_n**2 * np.log(w0 / w)
    assert np.allclose(passed, 2 * excitation * tau * w_n / J * t, rtol=1e-8, atol=1e-7)
    assert np.allclose(run["brake.torque"], -2 * way * excitation * tau / (w_n / w + w / w_n), rtol=1e-13)
    assert run.energy.dissipated["brake"] == pytest.approx(J / 2 * (w0**2 - w[-1] ** 2), rel=1e-9)
    assert run.energy.residual < 1e-10


def test_an_eddy_current_brake_on_a_housing_turns_it_along():
    rig = gb.Drivetrain("housing")
    a, b = rig.add("a", gb.Inertia(J=0.5, w0=50.0)), rig.add("b", gb.Inertia(J=0.25))
    brake = rig.add("brake", gb.EddyCurrentBrake(tau_nominal=3.0, w_nominal=20.0))
    rig.connect(a.a, brake.flange)
    rig.connect(b.a, brake.housing)
    run = gb.simulate(rig, t=[100.0], rtol=1e-10)
    assert run["a.w"][0] == pytest.approx(50.0 * 0.5 / 0.75, rel=1e-8)
    assert run["b.w"][0] == pytest.approx(run["a.w"][0], rel=1e-8)


def test_a_dc_motor_runs_up_as_its_two_linear_equations_say(distance):
    from scipy.linalg import expm

    R, L, k, J, u, i0 = 0.8, 5e-3, 0.3, 2e-3, 24.0, 2.0
    rig = _chain(motor=gb.DCMotor(R=R, L=L, k=k, u=u), rotor=gb.Inertia(J=J))
    t = np.linspace(0, 0.2, 41)
    run = gb.simulate(rig, t=t, initial={"motor.i": i0}, rtol=1e-11)
    A = np.array([[-R / L, -k / L], [k / J, 0.0]])
    rest = np.array([0.0, u / k])
    true = np.array([rest + expm(A * x) @ (np.array([i0, 0.0]) - rest) for x in t])
    assert distance(run["motor.current"], true[:, 0]) < NEAR
    assert distance(run["rotor.w"], true[:, 1]) < NEAR
    assert np.allclose(run["motor.torque"], k * run["motor.current"], rtol=1e-14)
    assert run.energy.residual < 1e-10


# -- engine and governor ----------------------------------------------------------------------------------------------


def test_an_engine_turns_by_its_map(reference, distance):
    rig = _chain(
        engine=gb.Engine(torque_map=MAP, throttle=gb.Input("throttle", start=0.6)), body=gb.Inertia(J=0.8, w0=20.0)
    )
    t = np.linspace(0, 2, 41)
    run = gb.simulate(rig, t=t, rtol=1e-11)

    def torque(w: float) -> float:
        return float(np.interp(w, MAP.x, 0.6 * np.asarray(MAP.z)[:, 1] + 0.4 * np.asarray(MAP.z)[:, 0]))

    true = reference(lambda t, y, _: (torque(y[0]) / 0.8,), (20.0,), t, lambda t, y: (y[0] - 100.0, y[0] - 200.0))
    assert distance(run["body.w"], true[:, 0]) < NEAR
    assert distance(run["engine.torque"], [torque(w) for w in run["body.w"]]) < 1e-12
    braking = gb.simulate(rig, t=[0.0], inputs={"throttle": 0.0}, initial={"body.w": 100.0})
    assert braking["engine.torque"][0] == pytest.approx(-10.0)
    assert run.energy.residual < 1e-10


def test_a_proportional_governor_leaves_its_droop(distance):
    gain, J, c, target = 0.05, 0.5, 0.2, 50.0
    rig = _chain(
        drive=gb.Torque(tau=30 * gb.sense("governor.command")), body=gb.Inertia(J=J, w0=45.0),
        governor=gb.Governor(target=target, gain=gain, bias=0.2, lower=-1.0), load=gb.SpeedLoad(coeffs=(0.0, c, 0.0)),
    )  # fmt: skip
    t = np.linspace(0, 3, 31)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    settled = 30 * (0.2 + gain * target) / (c + 30 * gain)
    assert distance(run["body.w"], settled + (45.0 - settled) * np.exp(-(c + 30 * gain) * t / J)) < NEAR
    assert run["governor.error"][-1] == pytest.approx(target - settled, rel=1e-4)


def test_a_governor_at_its_limit_does_not_wind_up(distance):
    gain, integral, J = 0.02, 0.01, 2.0
    rig = _chain(
        drive=gb.Torque(tau=100 * gb.sense("governor.command")), body=gb.Inertia(J=J),
        governor=gb.Governor(target=200.0, gain=gain, integral_gain=integral, time_constant=0.05),
        load=gb.SpeedLoad(coeffs=(0.0, 0.1, 0.0)), watch=_Watch(x=gb.sense("governor.command")),
    )  # fmt: skip
    run = gb.simulate(rig, t=np.linspace(0, 60, 601), rtol=1e-9)
    assert abs(run["body.w"][-1] - 200.0) < 1e-6  # no droop is left
    assert run["governor.command"][-1] == pytest.approx(0.2, rel=1e-6)
    assert run["body.w"].max() < 230.0  # with wind-up the integral would have grown to 3 in the first two seconds
    early = run.t < 1.5  # the command is at its limit 1: it follows the actuator alone
    assert distance(run["governor.command"][early], 1 - np.exp(-run.t[early] / 0.05)) < 1e-7


class _Watch(gb.Block):
    """Shows a signal."""

    flange = gb.Flange("any shaft")
    x = gb.signal("what is watched")

    def physics(self, s):
        yield gb.Shows("x", s.x)


# -- vehicle ----------------------------------------------------------------------------------------------------------


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


# -- universal joint --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [None, 0.4])
@pytest.mark.parametrize("angle", [0.0, 0.3, -0.3, 1.2])
def test_the_tie_of_a_universal_joint_is_that_of_its_cross(angle, phase):
    import sympy as sp

    from gearblocks.laws.symbols import Pool, Symbols

    joint = gb.UniversalJoint(angle=angle, phase=phase)
    s = Symbols(joint, Pool(), frozenset())
    zero = next(x.zero for x in joint.physics(s) if isinstance(x, gb.Tie))
    own = {s.angle: angle, **({} if phase is None else {s.phase: phase})}
    driven = sp.lambdify(s.a.phi, sp.solve(zero.subs(own), s.b.phi)[0])
    at = np.linspace(-20.0, 20.0, 4001)
    shifted, turned = at + (phase or 0.0), np.array([driven(x) for x in at])
    cross = np.unwrap(np.arctan2(np.sin(shifted), np.cos(angle) * np.cos(shifted)))
    assert np.ptp(turned + (phase or 0.0) - cross) < 1e-12  # a whole number of turns apart at most
    assert (np.diff(turned) > 0).all()


@pytest.mark.parametrize("phase", [None, 0.7])
def test_two_bodies_on_a_universal_joint_swap_energy_along_its_ratio(phase, distance):
    angle, J_a, J_b, w0 = 0.6, 0.1, 0.5, 30.0
    joint = gb.UniversalJoint(angle=angle, phase=phase)
    rig = _chain(a=gb.Inertia(J=J_a, w0=w0), joint=joint, b=gb.Inertia(J=J_b))
    run = gb.simulate(rig, t=np.linspace(0, 3, 301), rtol=1e-11)
    at = run["a.phi"] + (phase or 0.0)
    ratio = np.cos(angle) / (1 - np.sin(angle) ** 2 * np.cos(at) ** 2)
    assert distance(run["b.w"], ratio * run["a.w"]) < 1e-13  # rounding
    whole = J_a + J_b * ratio**2  # free: whole w_a^2 keeps its value
    assert distance(run["a.w"], w0 * np.sqrt(whole[0] / whole)) < NEAR  # hundreds of steps
    assert distance(run["joint.torque"], J_b * run["b.alpha"]) < 1e-12
    largest = np.abs(run["joint.a.power"]).max()
    assert np.abs(run["joint.a.power"] + run["joint.b.power"]).max() < 1e-12 * largest
    assert run.energy.residual < 1e-10


def test_two_universal_joints_a_quarter_turn_apart_pass_the_speed_on_evenly():
    rig = _chain(
        drive=gb.Speed(w=10.0), a=gb.Inertia(J=0.1), first=gb.UniversalJoint(angle=0.6), tube=gb.Inertia(J=0.02),
        second=gb.UniversalJoint(angle=0.6, phase=np.pi / 2), b=gb.Inertia(J=0.5),
    )  # fmt: skip
    run = gb.simulate(rig, t=np.linspace(0, 3, 301), rtol=1e-9)
    assert np.ptp(run["b.w"]) < 1e-12
    assert run["tube.w"].max() == pytest.approx(10.0 / np.cos(0.6), rel=1e-3)  # sampled
    assert run["tube.w"].min() == pytest.approx(10.0 * np.cos(0.6), rel=1e-3)


def test_a_universal_joint_at_angle_zero_is_a_rigid_shaft():
    rig = _chain(drive=gb.Torque(tau=3.0), a=gb.Inertia(J=0.1), joint=gb.UniversalJoint(angle=0.0), b=gb.Inertia(J=0.5))
    run = gb.simulate(rig, t=[2.0], rtol=1e-9)
    assert run["b.w"][0] == pytest.approx(10.0, rel=1e-13)


# -- refusals and files -----------------------------------------------------------------------------------------------


def _converter(**changed: object) -> gb.Block:
    return gb.TorqueConverter(**{"capacity": CAPACITY, "ratio": RATIO, **changed})


def _car(**changed: object) -> gb.Block:
    return gb.Vehicle(**{"mass": 1000.0, "wheel_radius": 0.3, **changed})


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: _converter(capacity=3.0), "capacity = 3.0 must be a linear or cubic gb.Table over the speed ratio"),
        (lambda: _converter(ratio=gb.Table([0, 1], [2, 1], kind="step")), "ratio = Table(2 points, step"),
        (lambda: _converter(ratio=gb.Table([0, 1], [1, 1], periodic=True)), "not periodic"),
        (
            lambda: _converter(ratio=gb.Table([0, 0.7, 1], [2, 1.9, 1])),
            "more power than they take, most at a speed ratio at",
        ),
        (lambda: _converter(capacity=gb.Table([0, 1], [2e-3, 1e-3])), "above the last point"),
        (lambda: _converter(capacity=gb.Table([0, 1], [-2e-3, 0])), "below the first point"),
        (lambda: gb.BeltDrive(ratio=0), "ratio = 0 must not be 0"),
        (lambda: gb.BeltDrive(ratio=NAN), "ratio = nan must be a finite number"),
        (lambda: gb.BeltDrive(ratio=2, slip=0.01), "slip = 0.01 must be an effect object"),
        (lambda: gb.BeltDrive(ratio=2, slip=gb.Creep(stiffness=NAN, low_speed=1.0)), "slip.stiffness = nan N m"),
        (
            lambda: gb.BeltDrive(ratio=2, slip=gb.Creep(stiffness=1.0, low_speed=0.0)),
            "slip.low_speed = 0.0 rad/s must be > 0",
        ),
        (lambda: gb.UniversalJoint(angle=1.6), "angle = 1.6 rad must be < 1.5"),
        (lambda: gb.UniversalJoint(angle=NAN), "angle = nan rad must be a finite number"),
        (lambda: gb.EddyCurrentBrake(tau_nominal=-1.0, w_nominal=1.0), "tau_nominal = -1.0 N m must be >= 0"),
        (lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=0), "w_nominal = 0.0 rad/s must be > 0"),
        (lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, excitation=-1), "excitation = -1 must be >= 0"),
        (
            lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, excitation=NAN),
            "excitation = nan must be a finite",
        ),
        (lambda: gb.DCMotor(R=1.0, L=0.0, k=0.1, u=1.0), "L = 0.0 H must be > 0"),
        (lambda: gb.DCMotor(R=1.0, L=1.0, k=NAN, u=1.0), "k = nan N m/A must be a finite number"),
        (lambda: gb.Engine(torque_map=100.0, throttle=1.0), "torque_map = 100.0 must be a gb.Table2"),
        (lambda: gb.Engine(torque_map=MAP, throttle=NAN), "throttle = nan must be a finite number"),
        (lambda: gb.Engine(torque_map=MAP), "Engine needs throttle"),
        (lambda: gb.Governor(target=1.0, gain=0.0), "gain = 0.0 s/rad must be > 0"),
        (lambda: gb.Governor(target=1.0, gain=1.0, lower=1.0), "lower = 1.0 must be < upper = 1.0"),
        (lambda: gb.Governor(target=NAN, gain=1.0), "target = nan rad/s must be a finite number"),
        (lambda: _car(mass=0), "mass = 0.0 kg must be > 0"),
        (lambda: _car(drag_area=-1.0), "drag_area = -1.0 m2 must be >= 0"),
        (lambda: _car(grade=NAN), "grade = nan rad must be a finite number"),
        (lambda: _car(grade=5), "grade = 5 rad must be within +-1.5"),
        (lambda: _car(rolling_speed=0.1), "rolling_speed needs rolling"),
        (
            lambda: _car(tyre=gb.TyreSlip(stiffness=1.0, grip=1.0, low_speed=1.0, shape=3)),
            "tyre.shape = 3.0 must be <= 2",
        ),
        (lambda: _car(tyre=0.1), "tyre = 0.1 must be an effect object"),
    ],
)
def test_bad_values_are_refused_in_words(make, words: str) -> None:
    with pytest.raises(gb.ModelError) as caught:
        gb.Drivetrain("rig").add("x", make())
    assert words in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    "block",
    [
        _converter(), gb.BeltDrive(ratio=2.5, slip=gb.Creep(stiffness=500.0, low_speed=5.0, limit=40.0)),
        gb.BeltDrive(ratio=1.5), gb.UniversalJoint(angle=0.3, phase=0.1),
        gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=3.0, excitation=gb.Input("e", start=1.0)),
        gb.DCMotor(R=1.0, L=0.1, k=0.1, u=gb.Parameter("u", 12.0, "V")), gb.Engine(torque_map=MAP, throttle=gb.time / 10),
        gb.Governor(target=10.0, gain=1.0, integral_gain=0.1), _car(drag_area=0.6, tyre=gb.TyreSlip(
            stiffness=1e4, grip=0.9, low_speed=1.0), grade=gb.Table([0, 10], [0, 0.1])),
    ],
    ids=lambda block: type(block).__name__,
)  # fmt: skip
def test_a_block_survives_its_file(block: gb.Block, tmp_path: Path) -> None:
    rig = _chain(
        first=gb.Inertia(J=1.0, w0=3.0),
        block=block,
        **({"last": gb.Inertia(J=2.0)} if sum(not f.ground for f in block.flanges.values()) > 1 else {}),
    )
    rig.to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert repr(again["block"]) == repr(block)
    assert gb.build(again).program.key == gb.build(rig).program.key
    one, other = (gb.simulate(x, t=[0.3])["first.w"][0] for x in (rig, again))
    assert one == other
