"""The reference of heat, roads, feedback, loads that drive, tables that are left, and starts, by closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from tests.random.description import GROUND, Part, Train
from tests.random.expressions import DISTANCE, TEMPERATURE, pulses, sense, table, thing
from tests.random.families import draw
from tests.random.reference import NoEvidenceError, WrongStartError, reference_motion
from tests.random.reference.switches import Switches, Table1

T = np.linspace(0.0, 1.0, 11)


def _train(*parts, **more):
    return Train("closed form", 0, parts, 1.0, **more)


def _wheel(name="j", J=2.0, **fields):
    return Part(name, "Inertia", (("J", J), *fields.items()), (("a", name),))


def test_a_brake_heats_its_disc_by_what_it_takes_and_the_disc_cools_along_an_exponential():
    port = thing("HeatPort", T="disc")
    brake = Part("b", "Brake", (("capacity", 10.0), ("heat", port)), (("a", "j"), ("housing", GROUND)))
    disc = Part("disc", "ThermalMass", (("C", 5.0), ("T0", 300.0)), ())
    motion = reference_motion(_train(_wheel(w0=3.0), brake, disc), T)
    assert motion.rises[0] == pytest.approx((9.0 - np.maximum(3 - 5 * T, 0) ** 2) / 5.0, abs=1e-10)
    wall = Part("wall", "ThermalConductance", (("G", 2.0), ("a", "disc"), ("b", 280.0)), ())
    motion = reference_motion(_train(_wheel(), disc, wall), T)
    assert motion.rises[0] == pytest.approx(-20.0 * (1 - np.exp(-2.0 / 5.0 * T)), abs=1e-9)


def test_a_gear_heats_its_oil_and_a_stop_its_rubber_by_what_is_lost():
    port = thing("HeatPort", T="oil")
    oil = Part("oil", "ThermalMass", (("C", 2.0),), ())
    fields = (("ratio", 3.0), ("efficiency", (0.9, 0.8)), ("heat", port))
    gear = Part("g", "LossyGear", fields, (("a", "a"), ("b", "b")))
    drive = Part("t", "Torque", (("tau", 2.0),), (("flange", "a"),))
    motion = reference_motion(_train(_wheel("a", 1.0, w0=3.0), _wheel("b", 1.0), gear, drive, oil), T)
    w = motion.speeds
    given = 2.0 * motion.angles[0] - 0.5 * (w[0] ** 2 - 9.0) - 0.5 * (w[1] ** 2 - 1.0)
    assert motion.rises[0] == pytest.approx(given / 2.0, abs=1e-9) and motion.rises[0, -1] > 0.04
    stop = Part("s", "HardStop", (("upper", 1.0), ("restitution", 0.5), ("heat", port)), (("a", "j"),))
    motion = reference_motion(_train(_wheel(J=1.0, w0=2.0), stop, oil), T)
    assert motion.rises[0] == pytest.approx(np.where(T < 0.5, 0.0, (2.0 - 0.5) / 2.0), abs=1e-12)


def test_a_law_over_the_temperature_follows_that_of_its_port():
    faded = 2.0 * (1.0 + 0.01 * (TEMPERATURE + -300.0))
    for T_port, torque in ((300.0, 2.0), (350.0, 3.0)):
        fields = (("capacity", faded), ("heat", thing("HeatPort", T=T_port)))
        brake = Part("b", "Brake", fields, (("a", "j"), ("housing", GROUND)))
        motion = reference_motion(_train(_wheel(J=1.0, w0=10.0), brake), T)
        assert motion.speeds[0, -1] == pytest.approx(10.0 - torque, rel=1e-12)


def test_a_chassis_in_the_wind_and_on_a_slope_over_its_way():
    m, area, wind, v0 = 2.0, 3.0, 4.0, 10.0
    air = (("mass", m), ("drag_area", area), ("wind", wind), ("v0", v0))
    motion = reference_motion(_train(Part("c", "Chassis", air, (("a", "c"),))), T)
    u0 = v0 - wind
    assert motion.speeds[0] == pytest.approx(wind + u0 / (1 + 1.2 * area / 2 / m * u0 * T), rel=1e-10)
    hill = table((0.0, 5.0, 5.0001), (0.0, 0.0, 0.1), "linear", False, DISTANCE)
    for rolling, rolls in ((0.0, 0.0), (0.3, 0.3)):
        fields = (("mass", m), ("grade", hill), ("v0", v0), ("rolling", rolling))
        motion = reference_motion(_train(Part("c", "Chassis", fields, (("a", "c"),))), T)
        flat, steep = 9.80665 * rolls, 9.80665 * (np.sin(0.1) + rolls * np.cos(0.1))
        square = v0**2 - 2 * flat * 5.0 - 2 * steep * (motion.angles[0, -1] - 5.0)
        assert motion.speeds[0, -1] ** 2 == pytest.approx(square, rel=1e-5)


def test_a_tyre_carries_a_wheel_and_its_car_to_one_speed():
    fields = (("radius", 0.5), ("stiffness", 1e3), ("grip", 1.0), ("low_speed", 0.5), ("normal_force", 1e3))
    tyre = Part("t", "Tyre", fields, (("wheel", "j"), ("vehicle", "c")))
    car = Part("c", "Chassis", (("mass", 3.0),), (("a", "c"),))
    motion = reference_motion(_train(_wheel(J=1.0, w0=10.0), car, tyre), T)
    impulse = motion.speeds[0] + 0.5 * 3.0 * motion.speeds[1]  # about the contact nothing else acts
    assert impulse == pytest.approx(np.full(11, 10.0), rel=1e-10)
    assert 0.5 * motion.speeds[0, -1] == pytest.approx(motion.speeds[1, -1], rel=1e-9)


@pytest.mark.parametrize(("direction", "sign"), [("forward", 1.0), ("backward", -1.0)])
def test_loads_that_drive_keep_their_sign_or_go_along(direction, sign):
    load = Part("l", "SpeedLoad", (("coeffs", (4.0, 0.0, 0.0)), ("direction", direction)), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(w0=-0.5), load), T)
    assert motion.speeds[0] == pytest.approx(-0.5 + sign * 2.0 * T, abs=1e-12)
    along = Part("l", "SpeedLoad", (("coeffs", (0.0, 3.0, 0.0)), ("direction", "along")), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(w0=sign), along), T)
    assert motion.speeds[0] == pytest.approx(sign * np.exp(1.5 * T), rel=1e-10)


@pytest.mark.parametrize(
    ("beyond", "before", "behind"), [("linear", -2.0, -1.0), ("hold", 0.0, 1.0), (False, 0.0, 1.0)]
)
def test_a_table_goes_on_as_its_ends_do_or_is_held(beyond, before, behind):
    found = Table1(Switches(), (0.0, 1.0, 2.0), (0.0, 2.0, 1.0), "linear", beyond)
    assert (found(-1.0), found(4.0)) == (before, behind)


def test_a_motor_that_reads_an_acceleration_and_one_that_reads_a_gear_alike():
    """L i' = u - R i - k w with u = g J w' is that of an inductance less g k."""
    J, k, L, R, g = 0.5, 0.4, 0.3, 2.0, 0.2
    u = 3.0 + g * sense("j.alpha")
    motor = Part("m", "DCMotor", (("R", R), ("L", L), ("k", k), ("u", u)), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(J=J), motor), T)
    # J w'' = k i',   L i' = 3 + g k i/J - R i - k w
    A = np.array([[0.0, k / J], [-k / L, (g * k / J - R) / L]])
    steady = np.linalg.solve(A, [0.0, -3.0 / L])
    exact = np.array([steady - expm(A * t) @ steady for t in T])
    assert motion.speeds[0] == pytest.approx(exact[:, 0], abs=1e-9)
    leaf = _wheel("b", 0.1)
    gear = Part("g", "IdealGear", (("ratio", 2.0),), (("a", "j"), ("b", "b")))
    read = Part("m", "DCMotor", (("R", R), ("L", L), ("k", k), ("u", 3.0 + g * sense("g.b.tau"))), (("flange", "j"),))
    same = Part(
        "m", "DCMotor", (("R", R), ("L", L), ("k", k), ("u", 3.0 + g * 0.05 * sense("j.alpha"))), (("flange", "j"),)
    )
    one, other = (reference_motion(_train(_wheel(J=J), leaf, gear, x), T) for x in (read, same))
    assert one.speeds == pytest.approx(other.speeds, abs=1e-10)


def test_the_torque_and_the_power_of_a_shaft_are_what_it_does():
    shaft = Part("s", "Shaft", (("k", 8.0), ("c", 0.5)), (("a", "j"), ("b", "i")))
    pushed = [
        Part("t", "Torque", (("tau", value),), (("flange", "i"),))
        for value in (0.5 * sense("s.torque"), -4.0 * sense("s.twist") + -0.25 * sense("s.twist_rate"))
    ]
    one, other = (reference_motion(_train(_wheel(w0=3.0), _wheel("i", 1.0), shaft, x), T) for x in pushed)
    assert one.speeds == pytest.approx(other.speeds, abs=1e-10)


def test_a_start_that_is_not_as_asked_is_wrong():
    shaft = Part("s", "Shaft", (("k", 8.0), ("phi_rel0", 0.2), ("w_rel0", -1.0)), (("a", "j"), ("b", "i")))
    train = _train(_wheel(phi0=0.1, w0=3.0), _wheel("i"), shaft)
    right = np.array([[0.1, 0.3], [3.0, 2.0]])
    assert reference_motion(train, T, given=right).angles[:, 0] == pytest.approx(right[0])
    for i, j in ((0, 1), (1, 1), (0, 0)):
        wrong = right.copy()
        wrong[i, j] += 1e-6
        with pytest.raises(WrongStartError):
            reference_motion(train, T, given=wrong)
    rolls = replace(_train(_wheel(), _wheel("i"), shaft.changed(phi_rel0=None, w_rel0=None)), initial=(("j.w", 2.0),))
    assert reference_motion(rolls, T, given=np.array([[0.0, 0.0], [2.0, 2.0]])).speeds[1, -1] == pytest.approx(2.0)
    for speeds in ([2.0, 2.1], [2.1, 2.1]):
        with pytest.raises(WrongStartError):
            reference_motion(rolls, T, given=np.array([[0.0, 0.0], speeds]))
    asked = _train(_wheel(alpha0=4.0), shaft.changed(phi_rel0=None, w_rel0=None), _wheel("i", phi0=1.0))
    assert reference_motion(asked, T, given=np.array([[0.0, 1.0], [0.0, 0.0]])).speeds[0, 1] > 0  # 8/2 rad/s2
    with pytest.raises(WrongStartError, match="alpha"):
        reference_motion(asked, T, given=np.array([[0.1, 1.0], [0.0, 0.0]]))


@pytest.mark.parametrize(
    ("family", "words"),
    [
        ("heat", ("HeatPort", "ThermalConductance", "temperature", "alpha")),
        ("vehicle", ("Chassis", "Tyre", "Rack", "wind", "distance", "TyreSlip", "wheel_inertia")),
        ("feedback", ("alpha", ".b.tau", ".torque", "power", "along", "backward", "'linear'", "'hold'")),
        ("starts", ("phi_rel0", "w_rel0", "alpha0", "rolling", ".w'")),
    ],
)
def test_a_family_draws_what_it_is_for(family, words):
    text = " ".join(repr(draw(family, seed)) for seed in range(60))
    assert [w for w in words if w not in text] == []


def test_a_clutch_beside_a_gear_of_ratio_one_that_loses_leaves_the_motion_open_and_beside_an_ideal_one_does_not():
    # what the clutch takes, from 0 to its capacity, the gear does not carry and does not lose
    ends = (("a", "j"), ("b", "k"))
    parts = (_wheel(w0=1.0), _wheel("k", 1.0), Part("c", "Clutch", (("capacity", 0.5),), ends))
    parts += (Part("t", "Torque", (("tau", 3.0),), (("flange", "j"),)),)
    with pytest.raises(NoEvidenceError):
        lossy = Part("g", "LossyGear", (("ratio", 1.0), ("efficiency", (0.8, 0.7))), ends)
        reference_motion(_train(*parts, lossy), T)
    motion = reference_motion(_train(*parts, Part("g", "IdealGear", (("ratio", 1.0),), ends)), T)
    assert motion.speeds[1] == pytest.approx(1.0 + T, abs=1e-10)


def test_a_motion_behind_filters_and_by_an_acceleration_follows_the_closed_form():
    drive = Part("d", "Acceleration", (("alpha", 3.0), ("w0", 2.0)), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(), drive), T)
    assert motion.speeds[0] == pytest.approx(2.0 + 3.0 * T, abs=1e-12)
    assert motion.angles[0] == pytest.approx(2.0 * T + 1.5 * T**2, abs=1e-10)
    step = table((0.0, 1.0), (0.0, 5.0))  # a ramp: x = 5 (t - (1 - exp(-f t))/f)
    drive = Part("d", "Speed", (("w", step), ("filter", 4.0)), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(), drive), T)
    assert motion.speeds[0] == pytest.approx(5.0 * (T - (1 - np.exp(-4.0 * T)) / 4.0), abs=1e-10)
    jump = table((0.0, 1e-9, 1.0), (0.0, 1.0, 1.0))  # critical: x = 1 - (1 + f t) exp(-f t)
    drive = Part("d", "Angle", (("phi", jump), ("filter", 6.0)), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(), drive), T)
    assert motion.angles[0] == pytest.approx(1 - (1 + 6 * T) * np.exp(-6 * T), abs=1e-7)


def test_pulses_are_tables_over_time():
    pulse = pulses("pulse", 2.0, period=0.5, duty=0.4, start=0.1, count=1)
    drive = Part("t", "Torque", (("tau", pulse),), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(), drive), T)
    assert motion.speeds[0] == pytest.approx(np.clip(T - 0.1, 0.0, 0.2), abs=1e-12)
    shape = pulses("trapezoid", 2.0, rising=0.2, width=0.2, falling=0.2, period=1.0, offset=1.0)
    drive = Part("t", "Torque", (("tau", shape),), (("flange", "j"),))
    motion = reference_motion(_train(_wheel(), drive), T)
    assert motion.speeds[0, -1] == pytest.approx((1.0 + 2.0 * 0.4) / 2.0, abs=1e-12)


def test_a_bearing_that_drags_alone_slows_along_a_hyperbola():
    drag = Part(
        "b",
        "BearingFriction",
        (("windage", thing("FluidDrag", c=0.5)), ("churning", thing("FluidDrag", c=0.5))),
        (("a", "j"),),
    )
    motion = reference_motion(_train(_wheel(J=1.0, w0=4.0), drag), T)
    assert motion.speeds[0] == pytest.approx(4.0 / (1.0 + 4.0 * T), abs=1e-10)
