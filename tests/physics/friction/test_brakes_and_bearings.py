"""Brakes, bearings and loads with dry friction: closed forms of slowing down, standing and breaking away."""

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode before, mode after) of one element."""
    return [(e.t, e.before, e.after) for e in run.events if e.component == name]


# -- brake and bearing ------------------------------------------------------------------------------------------------


def test_a_brake_stops_and_holds_a_load():
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0, w0=1.0), brake=gb.Brake(capacity=10.0))
    run = gb.simulate(rig, t=[0.1, 0.3, 10.0, 1000.0])
    assert run["body.phi"] == pytest.approx([0.1 - 2.5 * 0.01, 0.1, 0.1, 0.1], rel=EXACT)
    assert list(run["body.w"][1:]) == [0.0, 0.0, 0.0]
    assert list(run["brake.torque"]) == [10.0, 5.0, 5.0, 5.0]  # against forward motion, then against the load
    assert run["brake.phi_rel"][-1] == pytest.approx(0.1, rel=EXACT)


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
def test_a_bearing_takes_its_friction_from_a_table():
    table = gb.Table([0.0, 2.0, 10.0], [0.6, 0.3, 0.9])
    rig = _chain(body=gb.Inertia(J=1.0, w0=-8.0), bearing=gb.BearingFriction(torque=table))
    run = gb.simulate(rig, t=np.linspace(0, 20, 41), rtol=1e-9)
    slips = run["bearing.mode"] == -1.0
    expected = np.interp(np.abs(run["body.w"][slips]), table.x, table.y)
    assert run["bearing.torque"][slips] == pytest.approx(-expected, rel=EXACT)
    assert run["body.w"][-1] == 0.0


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


@pytest.mark.long
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
