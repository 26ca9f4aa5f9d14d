"""Break-aways between looks: a held torque leaves its bounds for a part of a step and comes back within them."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad
from scipy.optimize import brentq

import gearblocks as gb

METHODS = ("dp8", "dp5", "rodas")


def braked(capacity, tau, *parts):
    """A torque on a braked inertia of 1 kg m2."""
    rig = gb.Drivetrain("braked")
    rig.chain(
        rig.add("load", gb.Torque(tau=tau)),
        rig.add("m", gb.Inertia(J=1.0)),
        rig.add("brake", gb.Brake(capacity=capacity)),
    )
    for chain in parts:
        rig.chain(*(rig.add(name, block) for name, block in chain))
    return gb.build(rig)


def slides_from(excess, capacity, tau, guess, end):
    """(break-away, time of rest, angle between) of J = 1 that slides forward from rest: independent quadratures."""
    start = brentq(excess, *guess)
    speed = lambda t: quad(lambda x: tau(x) - capacity(x), start, t, epsabs=1e-14, epsrel=1e-12)[0]  # noqa: E731
    probe = np.linspace(start, end, 400)[1:]
    stop = next(t for t in probe if t > start + 1e-9 and speed(t) < 0)
    rest = brentq(speed, stop - probe[1] + probe[0], stop, xtol=1e-14)
    return start, rest, quad(speed, start, rest, epsabs=1e-15, epsrel=1e-11)[0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("at", "sharp", "load"),
    [(0.3552, 160.5, 0.37), pytest.param(0.5671, 45.8, 0.2, marks=pytest.mark.long), (0.8123, 900.0, 0.05)],
)
@pytest.mark.few(1)
def test_a_short_dip_of_the_capacity_lets_the_shaft_go(method, at, sharp, load):
    t = sp.sympify(gb.time)
    model = braked(1.5 - 1.49 * sp.exp(-((sharp * (t - at)) ** 2)), load)
    capacity = lambda x: 1.5 - 1.49 * np.exp(-((sharp * (x - at)) ** 2))  # noqa: E731
    start, rest, angle = slides_from(
        lambda x: load - capacity(x), capacity, lambda x: load, (at - 3 / sharp, at), at + 5 / sharp
    )
    for rtol in (1e-3, 1e-6):
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        assert [e.component for e in run.events] == ["brake", "brake"]
        assert abs(run.events[0].t - start) < 1e-12
        assert abs(run.events[1].t - rest) < 10 * rtol * (rest - start)
        assert abs(run["m.phi"][-1] - angle) < 10 * rtol * angle


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_short_pulse_of_the_load_lets_the_shaft_go(method):
    t = sp.sympify(gb.time)
    tau = lambda x: 0.2 + 2 * np.exp(-((200 * (x - 0.6)) ** 2))  # noqa: E731
    model = braked(1.0, 0.2 + 2 * sp.exp(-((200 * (t - sp.Rational(3, 5))) ** 2)))
    start, rest, angle = slides_from(lambda x: tau(x) - 1.0, lambda x: 1.0, tau, (0.58, 0.6), 0.63)
    run = gb.simulate(model, t_end=1.0, method=method, rtol=1e-7)
    assert np.allclose([e.t for e in run.events], [start, rest], rtol=0, atol=1e-7)
    assert abs(run["m.phi"][-1] - angle) < 1e-5 * angle


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_short_pull_backwards_lets_the_shaft_go(method):
    t = sp.sympify(gb.time)
    tau = lambda x: 1.5 * np.exp(-((120 * (x - 0.4)) ** 2)) - 0.1  # noqa: E731
    model = braked(1.0, sp.Rational(1, 10) - 1.5 * sp.exp(-((120 * (t - sp.Rational(2, 5))) ** 2)))
    start, rest, angle = slides_from(lambda x: tau(x) - 1.0, lambda x: 1.0, tau, (0.37, 0.4), 0.43)
    run = gb.simulate(model, t_end=1.0, method=method, rtol=1e-7)
    assert np.allclose([e.t for e in run.events], [start, rest], rtol=0, atol=1e-7)
    assert abs(run["m.phi"][-1] + angle) < 1e-5 * angle


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_capacity_over_the_angle_of_another_shaft_lets_go_in_every_period(method):
    phi = gb.sense("cam.phi")
    cam = [("free", gb.Torque(tau=gb.Parameter("none", 0.0))), ("cam", gb.Inertia(J=1.0, w0=20.0))]
    model = braked(1.0 + 0.999 * gb.cos(30 * phi), 0.01, cam)
    period = 2 * np.pi / 600
    first = (np.pi - np.arccos(0.99 / 0.999)) / 600
    for rtol in (1e-4, 1e-6, 1e-9):
        run = gb.simulate(model, t_end=0.5, method=method, rtol=rtol)
        away = [e.t for e in run.events if e.component == "brake" and e.before == 0]
        expected = [first + k * period for k in range(60) if first + k * period < 0.5]
        assert np.allclose(away, expected, rtol=0, atol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_capacity_that_dips_below_the_load_just_before_both_vanish_is_seen(method):
    # the load passes 0 at 0.5; the capacity touches its least value a little before, below the load
    model = braked(40 * (gb.time - 0.494) ** 2 + 2e-4, 0.5 * (0.5 - gb.time))
    start = brentq(lambda x: 0.5 * (0.5 - x) - 40 * (x - 0.494) ** 2 - 2e-4, 0.3, 0.494)
    for rtol in (1e-3, 1e-8):
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        assert abs(run.events[0].t - start) < 1e-10


@pytest.mark.long
def test_two_held_shafts_let_go_each_at_its_own_dip():
    t = sp.sympify(gb.time)
    rig = gb.Drivetrain("two")
    one, other = (1.5 - 1.4 * sp.exp(-((300 * (t - at)) ** 2)) for at in (0.31, 0.67))
    rig.chain(
        rig.add("load", gb.Torque(tau=0.3)), rig.add("a", gb.Inertia(J=1.0)), rig.add("gear", gb.IdealGear(ratio=2.0)),
        rig.add("b", gb.Inertia(J=0.5)), rig.add("clutch", gb.Clutch(capacity=one)), rig.add("c", gb.Inertia(J=0.2)),
        rig.add("brake", gb.Brake(capacity=other)),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=1.0, rtol=1e-6)
    away = {e.component: e.t for e in run.events if e.before == 0}
    assert away.keys() == {"clutch", "brake"}
    for name, at in (("clutch", 0.31), ("brake", 0.67)):
        start = brentq(lambda x, at=at: 0.6 - 1.5 + 1.4 * np.exp(-((300 * (x - at)) ** 2)), at - 0.01, at)
        assert abs(away[name] - start) < 1e-12
