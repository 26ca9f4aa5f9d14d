"""Fluid couplings, torque converters and belts: closed forms and power balance."""

import numpy as np
import pytest

import gearblocks as gb

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


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
def test_a_slow_belt_is_a_viscous_coupling(distance):
    ratio, c = 3.0, 2.0
    slow = gb.Creep(stiffness=c * 1e9, low_speed=1e9)
    rig = _chain(a=gb.Inertia(J=0.1, w0=60.0), belt=gb.BeltDrive(ratio=ratio, slip=slow), b=gb.Inertia(J=0.5))
    t = np.linspace(0, 0.2, 21)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    sliding = run["a.w"] - ratio * run["b.w"]
    assert distance(sliding, 60.0 * np.exp(-c * (1 / 0.1 + ratio**2 / 0.5) * t)) < NEAR


@pytest.mark.long
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
    assert rig(gb.Creep(stiffness=1e3, low_speed=1.0)).without("belt.slip")["belt"].part == gb.BeltDrive(ratio=2.0)
    sliding = gb.simulate(rig(gb.Creep(stiffness=1e4, low_speed=1.0, limit=1.0)), t=[0.0, 10.0], rtol=1e-8)
    assert sliding["b.w"][1] == pytest.approx(
        2.0 * 10.0 * 1.0 / 0.4, rel=1e-3
    )  # the limit is met to (limit/stiffness slip)^2
    assert abs(sliding["belt.torque"]).max() < 2.0
