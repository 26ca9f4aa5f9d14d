"""Brakes, motors, engines and governors: closed forms of running up, slowing down and droop."""

import numpy as np
import pytest

import gearblocks as gb

MAP = gb.Table2([0, 100, 200, 400], [0, 1], [[0, 50], [-10, 150], [-15, 200], [-20, 120]])
NEAR = 1e-9  # tens of steps at rtol 1e-11


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("driveline")
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


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


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
def test_a_governor_whose_command_is_at_its_limit_is_no_matter_of_step_sizes(method):
    # its integral stays 0 then: with the error in its rate, which cancels there, it followed rounding in steps of 1e-7 s
    rig = _chain(
        drive=gb.Torque(tau=40.2 * gb.sense("governor.command")), body=gb.Inertia(J=2.3, w0=33.2),
        governor=gb.Governor(target=4.4, gain=0.997, integral_gain=0.244), load=gb.SpeedLoad(coeffs=(0.0, 43.6, 0.0)),
        watch=_Watch(x=gb.sense("governor.command")),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.0, 0.05, 0.1], method=method, rtol=1e-6)
    assert run["body.w"] == pytest.approx(33.2 * np.exp(-run.t * 43.6 / 2.3), rel=1e-5)
    assert run.stats.steps < 300


class _Watch(gb.Block):
    """Shows a signal."""

    flange = gb.Flange("any shaft")
    x = gb.signal("what is watched")

    def physics(self, s):
        yield gb.Shows("x", s.x)
