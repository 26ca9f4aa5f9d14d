"""A corner that a run starts on: argument and slope are 0 there, and what lies just ahead decides about its side."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

import gearblocks as gb

TIME, PHI, W = gb.time, gb.sense("body.phi"), gb.sense("body.w")
PERIOD = 2.0 * np.pi / 5.0

SETTINGS = [
    {},
    {"rtol": 1e-3},
    {"rtol": 1e-10},
    {"method": "dp5"},
    {"method": "rodas"},
    {"method": "auto"},
]
QUICK = [SETTINGS[0], *(pytest.param(x, marks=pytest.mark.long) for x in SETTINGS[1:])]
"""The first of them; the others are in the long tier."""


def _train(tau, w0=0.0, phi0=0.0):
    rig = gb.Drivetrain("corner")
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=1.0, w0=w0, phi0=phi0)))
    return rig


def _dip(x):
    return np.cos(5.0 * x) - 1.0


OVER_TIME = {
    "size": (1 + sp.Abs(gb.cos(5 * TIME) - 1), lambda t: 1 - _dip(t)),
    "largest": (1 + sp.Max(gb.cos(5 * TIME), 1), lambda t: 2),
    "least": (1 + sp.Min(gb.cos(5 * TIME), 1), lambda t: 2 + _dip(t)),
    "held at the touch": (gb.piecewise((3, gb.cos(5 * TIME) >= 1), (1, True)), lambda t: 1),
    "held but for the touch": (gb.piecewise((3, gb.cos(5 * TIME) < 1), (1, True)), lambda t: 3),
    "cubed": (1 + sp.Abs((gb.cos(5 * TIME) - 1) ** 3), lambda t: 1 - _dip(t) ** 3),
    "scaled by parts that round": (1 + sp.Abs(0.3 * gb.cos(5 * TIME) - 0.1 * 3), lambda t: 1 - 0.3 * _dip(t)),
    "squared": (1 + sp.Max(0, -(TIME**2)) + sp.Max(0, TIME**2), lambda t: 1 + t**2),
    "cubic": (sp.Abs(TIME**3) + sp.Max(0, -(TIME**3)), lambda t: t**3),
    "sine cubed": (sp.Max(0, -(gb.sin(TIME) ** 3)) + sp.Max(0, gb.sin(TIME) ** 3), lambda t: abs(np.sin(t) ** 3)),
    "crossing that its phase rounds": (sp.Abs(gb.cos(5 * TIME + np.pi / 2)), lambda t: abs(np.sin(5 * t))),
    "of order four": (1 + sp.Min(0, 1 - TIME**2 / 2 - gb.cos(TIME)), lambda t: 2 - t**2 / 2 - np.cos(t)),
}

MANY = ("largest", "held but for the touch", "cubed", "scaled by parts that round", "squared", "cubic")


@pytest.mark.parametrize("settings", QUICK, ids=str)
@pytest.mark.parametrize("law", [pytest.param(law, marks=[pytest.mark.long] * (law in MANY)) for law in OVER_TIME])
@pytest.mark.few(1)
def test_a_corner_over_time_takes_the_side_ahead(law, settings):
    tau, true = OVER_TIME[law]
    run = gb.simulate(_train(tau), t_end=3.0, **settings)
    gained = quad(true, 0.0, 3.0, limit=200, points=[PERIOD * k / 4 for k in range(1, 10)])[0]
    largest = quad(lambda t: abs(true(t)), 0.0, 3.0, limit=200)[0]
    assert run["body.w"][-1] == pytest.approx(gained, abs=10.0 * settings.get("rtol", 1e-6) * max(largest, 1.0))


def _over_angle(push):
    """Torques over the angle that are `push` throughout but for the touches of 1."""
    return {
        "held at the touch": gb.piecewise((3 * push, gb.cos(5 * PHI) >= 1), (push, True)),
        "held but for the touch": gb.piecewise((push, gb.cos(5 * PHI) < 1), (3 * push, True)),
        "scaled by parts that round": gb.piecewise((3 * push, 0.1 * 3 * gb.cos(5 * PHI) >= 0.3), (push, True)),
        "excess": push + sp.Max(0, gb.cos(5 * PHI) - 1),
        "cubed": push * (1 + sp.sign((gb.cos(5 * PHI) - 1) ** 3)) + push,
    }


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
@pytest.mark.parametrize("push", [0.5, -0.5])
@pytest.mark.parametrize("law", _over_angle(1.0))
@pytest.mark.few(1)
def test_a_corner_over_an_angle_is_left_at_once_from_rest(law, push, settings):
    run = gb.simulate(_train(_over_angle(push)[law]), t_end=1.0, **settings)
    assert run["body.w"][-1] == pytest.approx(push, rel=10.0 * settings.get("rtol", 1e-6))


@pytest.mark.parametrize("phi0", [PERIOD, -PERIOD, 4 * PERIOD])
@pytest.mark.parametrize("law", _over_angle(1.0))
@pytest.mark.few(1)
def test_it_is_so_at_the_corners_of_later_turns(law, phi0):
    run = gb.simulate(_train(_over_angle(0.5)[law], phi0=phi0), t_end=1.0)
    assert run["body.w"][-1] == pytest.approx(0.5, rel=2e-5)


@pytest.mark.long
@pytest.mark.parametrize("settings", SETTINGS, ids=str)
@pytest.mark.parametrize("w0", [0.0, 2.0, -2.0])
@pytest.mark.few(1)
def test_a_size_over_an_angle_keeps_the_energy_of_its_potential(w0, settings):
    """w^2/2 of tau = push + abs(cos(5 phi) - 1) is w0^2/2 + push phi + phi - sin(5 phi)/5, across many touches."""
    push = -0.5 if w0 < 0.0 else 0.5
    run = gb.simulate(_train(push + sp.Abs(gb.cos(5 * PHI) - 1), w0=w0), t_end=2.0, **settings)
    phi, w = run["body.phi"][-1], run["body.w"][-1]
    potential = (push + 1.0) * phi - np.sin(5.0 * phi) / 5.0
    assert w**2 / 2 == pytest.approx(w0**2 / 2 + potential, abs=30.0 * settings.get("rtol", 1e-6) * max(w**2, 1.0))


@pytest.mark.long
def test_a_side_that_waits_for_a_push_is_chosen_with_it():
    """At rest on the corner until the push comes; then away from it at once."""
    push = gb.piecewise((0, TIME < 0.3), (0.5, True))
    kick = gb.piecewise((1.5, (gb.cos(5 * PHI) >= 1) & (TIME >= 0.3)), (0, True))
    run = gb.simulate(_train(push + kick), t_end=1.0)
    assert run["body.w"][-1] == pytest.approx(0.35, rel=1e-5)


def test_a_body_that_stands_on_the_corner_stays_there():
    run = gb.simulate(_train(gb.piecewise((0, gb.cos(5 * PHI) >= 1), (1, True))), t_end=10.0)
    assert run["body.w"][-1] == 0.0
    assert not run.events


@pytest.mark.long
def test_parameters_decide_whether_it_touches():
    level, size = gb.Parameter("level", 1.0), gb.Parameter("size", 1.0)
    model = _train(gb.piecewise((3, size * gb.cos(5 * TIME) >= level), (1, True)))
    for values, share in (
        ({}, 0.0),
        ({"level": 2.0, "size": 2.0}, 0.0),
        ({"size": 2.0}, 1.0 / 3.0),
        ({"level": -1.0}, 1),
    ):
        w = gb.simulate(model, t_end=PERIOD, parameters=values)["body.w"][-1]
        assert w == pytest.approx(PERIOD * (1.0 + 2.0 * share), rel=1e-5), values


def test_rounding_near_a_corner_that_is_left_slowly_does_not_stop_the_run():
    """phi runs ahead of w0 t by 20 (t^2/2 - (1 - cos 3t)/9), which is rounding of phi at first: the law is no more."""
    tau = 20 * (1 - gb.cos(3 * TIME)) + sp.Min(0, PHI - 20 * TIME)
    run = gb.simulate(_train(tau, w0=20.0), t_end=1.0, method="dp5")
    assert run["body.phi"][-1] == pytest.approx(20.0 + 20.0 * (0.5 - (1.0 - np.cos(3.0)) / 9.0), rel=1e-5)
    assert len(run.events) < 10
