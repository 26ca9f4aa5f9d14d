"""States of blocks, and outputs of blocks that feed back."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import gearblocks as gb

NEAR = 1e-8  # tens to hundreds of steps at rtol 1e-12, the shaft 100 times faster than the control


class DCMotor(gb.Block):
    """DC motor with its current as a state."""

    shaft = gb.Flange("output shaft")
    R: float = gb.param("resistance", "ohm", gt=0)
    L: float = gb.param("inductance", "H", gt=0)
    k: float = gb.param("torque constant", "N m/A")
    u = gb.signal("terminal voltage", "V")
    i = gb.State("current", "A")

    def physics(self, s):
        yield gb.Acts(s.shaft, s.k * s.i)
        yield gb.Rate(s.i, (s.u - s.R * s.i - s.k * s.shaft.w) / s.L)
        yield gb.Shows("torque", s.k * s.i, "N m")
        yield gb.Energy(stored=s.L * s.i**2 / 2, loss=s.R * s.i**2)


class Integrator(gb.Block):
    """Shows the integral of a signal; has no flange of its own but needs a shaft to sit on."""

    flange = gb.Flange("shaft")
    u = gb.signal("rate")
    z = gb.State("integral")

    def physics(self, s):
        yield gb.Rate(s.z, s.u)
        yield gb.Shows("value", s.z)


def test_a_motor_with_a_current_answers_like_its_two_equations(reference, distance):
    R, L, k, J, c = 1.0, 5e-3, 0.2, 2e-3, 1e-3
    rig = gb.Drivetrain("motor")
    motor, rotor = (
        rig.add("motor", DCMotor(R=R, L=L, k=k, u=12.0 + 3 * gb.sin(40 * gb.time))),
        rig.add("rotor", gb.Inertia(J=J)),
    )
    load = rig.add("load", gb.SpeedLoad(coeffs=(0.0, c, 0.0)))
    rig.chain(motor, rotor, load)
    t = np.linspace(0, 0.5, 101)
    run = gb.simulate(rig, t=t, initial={"motor.i": 2.0}, rtol=1e-12)
    true = reference(
        lambda t, y, _: ((12 + 3 * np.sin(40 * t) - R * y[0] - k * y[1]) / L, (k * y[0] - c * y[1]) / J), (2.0, 0.0), t
    )
    assert distance(run["motor.torque"], k * true[:, 0]) < NEAR
    assert distance(run["rotor.w"], true[:, 1]) < NEAR
    assert run.energy.residual < 1e-11
    assert run.energy.dissipated["motor"] == pytest.approx(
        run.energy.supplied["motor"] + L / 2 * 4 - L / 2 * true[-1, 0] ** 2 - J / 2 * true[-1, 1] ** 2
        - run.energy.dissipated["load"], rel=1e-8,
    )  # fmt: skip


@pytest.mark.long
def test_a_speed_control_with_proportional_and_integral_part(reference, distance):
    J, k, c, kp, ki, target = (0.02, 0.3), 500.0, 0.5, 0.8, 4.0, 30.0
    rig = gb.Drivetrain("control")
    motor, shaft, load = (
        rig.add("motor", gb.Inertia(J=J[0])),
        rig.add("shaft", gb.Shaft(k=k, c=c)),
        rig.add("load", gb.Inertia(J=J[1])),
    )
    error = gb.Parameter("target", target, "rad/s") - gb.sense("load.w")
    integral = rig.add("integral", Integrator(u=error))
    drive = rig.add("drive", gb.Torque(tau=kp * error + ki * gb.sense("integral.value")))
    brake = rig.add("brake", gb.Torque(tau=sp.Piecewise((0, gb.time < 1), (-3, True))))
    rig.chain(drive, integral, motor, shaft, load, brake)
    t = np.linspace(0, 3, 151)
    run = gb.simulate(rig, t=t, rtol=1e-12)

    def rates(t, y, modes):
        twist, w1, w2, z = y
        tau = k * twist + c * (w2 - w1)
        e = target - w2
        return (w2 - w1, (kp * e + ki * z + tau) / J[0], (-tau + (-3 if modes[0] > 0 else 0)) / J[1], e)

    true = reference(rates, np.zeros(4), t, lambda t, y: (t - 1.0,))
    assert distance(run["motor.w"], true[:, 1]) < NEAR
    assert distance(run["load.w"], true[:, 2]) < NEAR
    assert distance(run["integral.value"], true[:, 3]) < NEAR
    settled = gb.simulate(rig, t=[60.0], rtol=1e-10, parameters={"target": 12.0})
    assert settled["load.w"][0] == pytest.approx(12.0, rel=1e-8)  # the integral part leaves no error
    assert settled["drive.torque"][0] == pytest.approx(3.0, rel=1e-7)


def test_a_spring_made_of_feedback_swings_like_a_spring(distance):
    rig = gb.Drivetrain("feedback spring")
    body = rig.add("body", gb.Inertia(J=2.0, phi0=0.3))
    drive = rig.add("drive", gb.Torque(tau=-50 * gb.sense("body.phi")))
    rig.chain(drive, body)
    t = np.linspace(0, 4, 101)
    run = gb.simulate(rig, t=t, rtol=1e-12)
    assert distance(run["body.phi"], 0.3 * np.cos(5 * t)) < NEAR


def test_a_relay_on_a_sensed_speed_switches_at_its_threshold():
    rig = gb.Drivetrain("relay")
    body = rig.add("body", gb.Inertia(J=1.0))
    drive = rig.add("drive", gb.Torque(tau=sp.Piecewise((2, gb.sense("body.w") < 3), (0.5, True))))
    rig.chain(drive, body)
    run = gb.simulate(rig, t=[1.0, 2.0, 4.0], rtol=1e-9)
    assert np.allclose(run["body.w"], [2.0, 3 + 0.5 * 0.5, 3 + 0.5 * 2.5], rtol=1e-12)
    assert [e.t for e in run.events] == pytest.approx([1.5], rel=1e-13)


@pytest.mark.long
def test_a_sense_may_read_an_output_that_reads_another():
    rig = gb.Drivetrain("in a row")
    body = rig.add("body", gb.Inertia(J=1.0))
    one = rig.add("one", gb.Torque(tau=2 * gb.time))
    two = rig.add("two", gb.Torque(tau=3 * gb.sense("one.torque")))
    three = rig.add("three", gb.Torque(tau=gb.sense("two.torque") + 1))
    rig.connect(body.a, one.flange, two.flange, three.flange)
    run = gb.simulate(rig, t=[2.0], rtol=1e-9)
    assert run["three.torque"][0] == pytest.approx(13.0)
    assert run["body.w"][0] == pytest.approx(7 * 4 + 2, rel=1e-12)


@pytest.mark.parametrize("path", ["two.torque", "body.alpha", "one.torque"])
def test_a_loop_without_a_state_is_refused(path):
    rig = gb.Drivetrain("algebraic")
    body = rig.add("body", gb.Inertia(J=1.0))
    one = rig.add("one", gb.Torque(tau=0.5 * gb.sense(path)))
    two = rig.add("two", gb.Torque(tau=0.5 * gb.sense("one.torque")))
    rig.connect(body.a, one.flange, two.flange)
    with pytest.raises(gb.ModelError, match=path.replace(".", r"\.")):
        gb.build(rig)


def test_a_sense_of_what_does_not_exist_names_the_near_ones():
    rig = gb.Drivetrain("typo")
    body, drive = rig.add("body", gb.Inertia(J=1.0)), rig.add("drive", gb.Torque(tau=gb.sense("body.W")))
    rig.chain(drive, body)
    with pytest.raises(gb.ModelError, match=r"body\.w"):
        gb.build(rig)


class Lag(gb.Block):
    """A torque that follows a signal, from its value at the start."""

    shaft = gb.Flange("where the torque acts")
    u = gb.signal("signal", "N m")
    x = gb.State("torque", "N m")

    def physics(self, s):
        yield gb.Start(s.x, s.u)
        yield gb.Rate(s.x, s.u - s.x)
        yield gb.Acts(s.shaft, s.x)


def test_a_state_cannot_start_from_what_is_sensed():
    rig = gb.Drivetrain("lag")
    rig.connect(rig.add("body", gb.Inertia(J=1.0)).a, rig.add("lag", Lag(u=gb.sense("body.w"))).shaft)
    with pytest.raises(gb.ModelError, match=r"'lag': the state 'x' starts from the sensed output 'body\.w'"):
        gb.build(rig)


@pytest.mark.parametrize("filter", [None, 3.0])
@pytest.mark.parametrize("source", ["speed", "angle"])
def test_what_is_sensed_cannot_prescribe_a_motion(source, filter):
    rig = gb.Drivetrain("led")
    rig.add("leader", gb.Inertia(J=1.0))
    sensed = gb.sense("leader.w")
    motion = gb.Speed(w=sensed, filter=filter) if source == "speed" else gb.Angle(phi=sensed, filter=filter)
    rig.chain(rig.add("motion", motion), rig.add("body", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ModelError, match=r"sensed output .*leader\.w.* cannot prescribe a rigid motion"):
        gb.build(rig)


@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.few(1)
def test_a_voltage_that_saturates_over_an_acceleration_is_that_of_scipy(beside):
    """A law that is narrow in what follows from the torques; beside: another signal that they read."""
    J, k, L, R, most = 0.05, 0.5, 0.05, 0.4, 9.0
    rig = gb.Drivetrain("saturating")
    u = 3.0 + most * sp.tanh(0.2 * gb.sense("rotor.alpha"))
    rig.chain(rig.add("motor", gb.DCMotor(R=R, L=L, k=k, u=u)), rig.add("rotor", gb.Inertia(J=J)))
    if beside:
        rig.connect(rig.add("drag", gb.Torque(tau=-0.1 * gb.sense("rotor.w"))).flange, rig["rotor"].a)
    t = np.linspace(0, 1, 21)
    run = gb.simulate(rig, t=t, rtol=1e-12)

    def rates(_, y):
        w, i = y
        alpha = (k * i - 0.1 * w * beside) / J
        return [alpha, (3.0 + most * np.tanh(0.2 * alpha) - R * i - k * w) / L]

    found = solve_ivp(rates, (0, 1), [0.0, 0.0], "DOP853", t_eval=t, rtol=1e-13, atol=1e-12)
    assert np.allclose(run["rotor.w"], found.y[0], rtol=1e-8, atol=1e-8)
    assert np.abs(run["rotor.alpha"]).max() > 20.0  # far into both flat parts
