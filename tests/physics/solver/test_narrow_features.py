"""Features of a law narrower than a step: no method and no tolerance steps over them."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")
W, PHI = gb.sense("rotor.w"), gb.sense("rotor.phi")


def bearing(rise: float, speed: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("spin-down")
    friction = gb.BearingFriction(coulomb=1.0, stribeck=gb.Stribeck(rise=rise, speed=speed))
    rig.chain(rig.add("rotor", gb.Inertia(J=1.0, w0=50.0)), rig.add("bearing", friction))
    return rig


def stop_time(rise: float, speed: float) -> float:
    """Integral of J dw / T(w) from rest to 50 rad/s, in pieces about the rise."""
    ends = [0.0, *(speed * np.array([0.3, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])), 50.0]
    pieces = pairwise(ends)
    return sum(
        quad(lambda w: 1 / (1 + rise * np.exp(-((w / speed) ** 2))), a, b, epsabs=0, epsrel=1e-13)[0] for a, b in pieces
    )


RISES = ((1.0, 0.5), (1.0, 0.1), (0.3, 0.01), (3.0, 0.01), (3.0, 1.0), (0.45, 0.31))
# where an embedded estimate passes zero inside the rise, and where a step ends on its first part
PASSED = (
    (2.0, 0.3),
    (2.317, 0.2929),
    (2.994, 0.8077),
    (2.597, 0.121),
    (1.711, 0.698),
    (2.832, 0.05156),
    (0.3755, 0.981),
)


@pytest.mark.parametrize("method", METHODS)
def test_a_spin_down_over_a_stribeck_rise_stops_in_time(method):
    model = gb.build(bearing(1.0, 0.5))
    for rise, speed in RISES + PASSED:
        right = stop_time(rise, speed)
        for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
            numbers = {"bearing.stribeck.rise": rise, "bearing.stribeck.speed": speed}
            run = gb.simulate(model, t_end=1.2 * right, rtol=rtol, method=method, parameters=numbers)
            assert run.events[-1].t == pytest.approx(right, rel=10 * rtol), (rise, speed, rtol)


def drop(t, p, w):
    return -1 - 2 * (1 - np.tanh((w - 20) / 0.05))


def hump(t, p, w):
    return -1 + 0.8 * np.exp(-(((w - 20) / 0.1) ** 2))


def regularised_sign(t, p, w):
    return -(w - 20) / np.sqrt((w - 20) ** 2 + 1e-4) - 0.4


def relative_slip(t, p, w):
    x = 2000 * (w - 20) / np.sqrt(w**2 + 4)
    return -x / np.sqrt(1 + x**2) - 0.4


def relative_hump(t, p, w):
    return 0.8 * np.exp(-(1e6 * (w - 20) ** 2 / (w**2 + 9))) - 1


def resonance(t, p, w):
    return -1 + 0.9 / (1 + ((w - 20) / 0.05) ** 2)


def pulse_in_time(t, p, w):
    return 2000 * np.exp(-(((t - 17) / 0.01) ** 2)) - 1


def step_in_time(t, p, w):
    return 5 * np.tanh((t - 17) / 0.01) - 1


def bump_over_the_angle(t, p, w):
    return 300 * np.exp(-(((p - 50) / 0.2) ** 2)) - 0.1


def bump_in_every_turn(t, p, w):
    return 30 * np.exp(300 * (np.cos(p) - 1)) - 1


QUICK = (drop, relative_slip, relative_hump, pulse_in_time, bump_in_every_turn)
# start speed, duration, largest step of the reference
USERS = {
    drop: (50.0, 35.0, 0.01), hump: (50.0, 35.0, 0.02), regularised_sign: (50.0, 30.0, 0.002), resonance: (50.0, 35.0, 0.02),
    relative_slip: (50.0, 25.0, 0.01), relative_hump: (50.0, 35.0, 0.01),
    pulse_in_time: (50.0, 30.0, 0.005), step_in_time: (50.0, 30.0, 0.005), bump_over_the_angle: (30.0, 3.0, 0.001),
    bump_in_every_turn: (30.0, 1.5, 0.0005),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    "law", [pytest.param(f, id=f.__name__, marks=[pytest.mark.long] * (f not in QUICK)) for f in USERS]
)
def test_a_narrow_function_that_a_user_writes_is_seen(law):
    w0, end, step = USERS[law]
    rig = gb.Drivetrain("narrow")
    rig.chain(rig.add("source", gb.Torque(tau=law(gb.time, PHI, W))), rig.add("rotor", gb.Inertia(J=1.0, w0=w0)))
    right = solve_ivp(
        lambda t, y: [y[1], law(t, *y)], (0, end), [0, w0], method="DOP853", rtol=1e-12, atol=1e-12, max_step=step
    ).y[:, -1]
    for method in METHODS:
        for rtol in (1e-4, 1e-6):
            run = gb.simulate(rig, t_end=end, rtol=rtol, method=method)
            assert run["rotor.w"][-1] == pytest.approx(right[1], abs=30 * rtol * w0), (method, rtol)
            assert run["rotor.phi"][-1] == pytest.approx(right[0], rel=30 * rtol), (method, rtol)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("law", "gained"),
    [
        (1 / (1 + gb.exp(-(gb.time - 0.5) / 5e-4)), 0.5),
        (gb.exp(1000 * (gb.time - 1) - 0.5) * 1e3, np.exp(-0.5)),
    ],
    ids=["a soft step", "an exponential"],
)
@pytest.mark.few(3)
def test_exponents_far_beyond_what_a_number_holds_are_those_that_were_written(law, gained, method):
    """exp(1000 - 2000 t) is not exp(1000) exp(-2000 t)."""
    rig = gb.Drivetrain("soft step")
    rig.chain(rig.add("source", gb.Torque(tau=law)), rig.add("rotor", gb.Inertia(J=1.0, w0=3.0)))
    run = gb.simulate(rig, t_end=1.0, rtol=1e-8, method=method)
    assert run["rotor.w"][-1] - 3.0 == pytest.approx(gained, abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("limit", [0.5, 0.05])
def test_a_belt_that_creeps_at_its_limit_is_seen_to_turn(limit):
    """Its torque goes from one limit to the other over a part of 4 limit/stiffness of the speed."""
    stiffness, low, load = 200.0, 2.0, 1.5
    rig = gb.Drivetrain("belt")
    shaft, pulley = rig.add("shaft", gb.Inertia(J=0.1, w0=10.0)), rig.add("pulley", gb.Inertia(J=0.05))
    creep = gb.Creep(stiffness=stiffness, low_speed=low, limit=limit)
    belt = rig.add("belt", gb.BeltDrive(ratio=2.0, slip=creep))
    source = rig.add("source", gb.Torque(tau=-load * gb.sin(9 * gb.time)))
    rig.connect(shaft.a, belt.a, source.flange)
    rig.connect(belt.b, pulley.a)

    def rates(t, y):
        x = stiffness * (y[0] - 2 * y[1]) / np.hypot(y[0], low)
        tau = x / np.hypot(1, x / limit)
        return [(-load * np.sin(9 * t) - tau) / 0.1, 2 * tau / 0.05]

    right = solve_ivp(rates, (0, 2), [10.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-12, max_step=1e-3).y[:, -1]
    for method in METHODS:
        for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8):
            run = gb.simulate(rig, t_end=2.0, rtol=rtol, method=method)
            found = [run["shaft.w"][-1], run["pulley.w"][-1]]
            assert found == pytest.approx(right, abs=300 * rtol), (method, rtol)


def test_far_from_its_rise_a_bearing_takes_the_steps_that_it_takes_without():
    """The rise costs steps where it is passed, and nowhere else."""
    with_rise = gb.simulate(bearing(1.0, 0.01), t_end=49.0, rtol=1e-6)
    assert not with_rise.events
    assert with_rise.stats.steps < 20
