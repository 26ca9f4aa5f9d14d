"""Springs: stiff ones, slow ones, ones that vary, at odd scales, for a long time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.errors import SimulationError
from gearblocks.hard.judging import RTOL, Check, Meter, below, count, fact, largest
from gearblocks.hard.parts import line, swing
from gearblocks.language.contributions import Contribution

CALLS = 150_000


def stiffness_ratio(meter: Meter) -> Iterator[Check]:
    """The stiff pair turns as one body of J = 2."""
    rig = line(
        "stiff and soft",
        ("one", gb.Inertia(J=1.0)), ("stiff", gb.Shaft(k=1e12)), ("two", gb.Inertia(J=1.0)),
        ("soft", gb.Shaft(k=1.0)), ("three", gb.Inertia(J=1.0, w0=1.0)),
    )  # fmt: skip
    run = meter.simulate(rig, t_end=20.0)
    w = math.sqrt(1.5)
    yield below("phi3 off by", largest(run["three.phi"] - run.t / 3 - 2 / 3 * np.sin(w * run.t) / w), 1e-4)
    yield count("calls", meter.rhs_calls, CALLS)


def node_of_tiny_inertia(meter: Meter) -> Iterator[Check]:
    """Two springs of 2 in a row are one of 1, whether the node between has J = 1e-12 or none.

    From rest the node swings by 0.5 rad/s at 2e6 rad/s, with 1e-13 of the energy of the train.
    """
    w, t = math.sqrt(2.0), np.linspace(0.0, 20.0, 201)
    for J in (0.0, 1e-12):
        rig = line(
            "tiny node",
            ("one", gb.Inertia(J=1.0)), ("left", gb.Shaft(k=2.0)), ("node", gb.Inertia(J=J)),
            ("right", gb.Shaft(k=2.0)), ("two", gb.Inertia(J=1.0, w0=1.0)),
        )  # fmt: skip
        run = meter.simulate(rig, t=t)
        exact = t / 2 + np.sin(w * t) / (2 * w)
        yield below(f"J = {J:g}: phi2 off by", largest(run["two.phi"] - exact), 1e-4)
    yield count("calls", meter.rhs_calls, CALLS)


def inertia_ratio(meter: Meter) -> Iterator[Check]:
    """A body of 1e-9 on a body of 1: momentum stays, the heavy one hardly slows."""
    light, heavy = gb.Inertia(J=1e-9), gb.Inertia(J=1.0, w0=1.0)
    rig = line("feather", ("light", light), ("shaft", gb.Shaft(k=1.0, damping_ratio=0.01)), ("heavy", heavy))
    run = meter.simulate(rig, t_end=10.0)
    yield below("w2 off by", abs(run["heavy.w"][-1] - 1.0), 1e-6)
    yield below("momentum off by", largest(1e-9 * run["light.w"] + run["heavy.w"] - 1.0), 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def three_hundred_periods(meter: Meter) -> Iterator[Check]:
    """x'' = -x over 300 periods: energy and phase."""
    run = meter.simulate(swing("pendulum", gb.Shaft(k=1.0), phi0=1.0), t_end=2 * math.pi * 300)
    phi, w = run["body.phi"], run["body.w"]
    yield below("energy drifts by", largest(phi**2 + w**2 - 1.0), 1e-3)
    yield below("phase off by", abs(math.atan2(-w[-1], phi[-1])), 1e-2)


def ten_million_periods(meter: Meter) -> Iterator[Check]:
    """Accuracy for ever, or a run that says where it lost it."""
    promise = 1e-6
    rig, end = swing("pendulum", gb.Shaft(k=1.0), phi0=1.0), 2 * math.pi * 1e7
    try:
        run = meter.simulate(rig, t=np.linspace(0.0, end, 100_001), residual=promise)
    except SimulationError as error:
        yield fact(f"refused: {error}", "energy" in error.cause and error.time < end)
        return
    phi, w = run["body.phi"][-1], run["body.w"][-1]
    yield below("energy drifts by", abs(phi**2 + w**2 - 1.0), promise)
    yield below("phase off by", abs(math.atan2(-w, phi)), 1e-3)


def resonance(meter: Meter) -> Iterator[Check]:
    """x'' + x = cos t grows as t/2 sin t."""
    run = meter.simulate(swing("resonance", gb.Shaft(k=1.0), tau=gb.cos(gb.time)), t_end=1000.0)
    exact = run.t / 2 * np.sin(run.t)
    yield below("off by", largest(run["body.phi"] - exact) / largest(exact), 1e-4)


def mathieu(meter: Meter) -> Iterator[Check]:
    """On both sides of a stability boundary, 200 periods."""
    period, periods = 2 * math.pi, 200
    for d, verdict in ((0.201, "grows"), (0.19575, "stays")):
        rig = swing("mathieu", gb.Shaft(k=d + 0.1 * gb.cos(gb.time)), phi0=1.0)
        run = meter.simulate(rig, t=[0.0, periods * period])
        step = _monodromy(d, period)
        exact = np.linalg.matrix_power(step, periods) @ [1.0, 0.0]
        ours = np.array([run["body.phi"][-1], run["body.w"][-1]])
        off = float(np.linalg.norm(ours - exact) / np.linalg.norm(exact))
        yield below(f"d = {d}: trace {np.trace(step):.4f}, {verdict}, off by", off, 0.01)


def _monodromy(d: float, period: float) -> Any:
    """The matrix that carries (x, x') over one period, by DOP853 at 1e-13."""
    from scipy.integrate import solve_ivp

    def rates(t: float, y: Any) -> Any:
        k = d + 0.1 * math.cos(t)
        return [y[2], y[3], -k * y[0], -k * y[1]]

    found = solve_ivp(rates, (0.0, period), [1.0, 0.0, 0.0, 1.0], "DOP853", rtol=1e-13, atol=1e-15)
    return found.y[:, -1].reshape(2, 2)


def negative_stiffness(meter: Meter) -> Iterator[Check]:
    """x'' = x on the way into its saddle: the error grows as e^t, not faster."""
    rig = swing("saddle", gb.Shaft(k=-1.0, allow_negative=True), phi0=1.0, w0=-1.0)
    run = meter.simulate(rig, t_end=20.0)
    yield below("off by", largest(run["body.phi"] - np.exp(-run.t)), 100 * RTOL * math.exp(20.0))


def rectangular_stiffness(meter: Meter) -> Iterator[Check]:
    """x'' + 0.02 x' + k(t) x = 1 with a stiffness that jumps twice a period."""
    period, periods = 2 * math.pi / 0.7, 200
    k = gb.Table([0.0, 0.6 * period, period], [1.2, 0.8, 1.2], kind="step", periodic=True)
    run = meter.simulate(swing("rectangle", gb.Shaft(k=k, c=0.02), tau=1.0), t=[0.0, periods * period])
    y = _over_rectangles(period, periods)
    off = np.array([run["body.phi"][-1], run["body.w"][-1]]) - y
    yield below("off by", largest(off), 1e-4)


def _over_rectangles(period: float, periods: int) -> Any:
    """(x, x') at the end, by DOP853 at 1e-12, begun anew at every jump of the stiffness."""
    from scipy.integrate import solve_ivp

    y = np.zeros(2)
    for i in range(periods):
        for k, a, b in ((1.2, 0.0, 0.6), (0.8, 0.6, 1.0)):

            def rates(_t: float, x: Any, k: float = k) -> Any:
                return [x[1], 1.0 - 0.02 * x[1] - k * x[0]]

            span = ((i + a) * period, (i + b) * period)
            y = solve_ivp(rates, span, y, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return y


def late_start(meter: Meter) -> Iterator[Check]:
    """1 kHz for 1 ms from t = 1e9 s, where a double of time has steps of 1.2e-7 s."""
    w = 2 * math.pi * 1000
    rig = swing("late", gb.Shaft(k=w**2), phi0=1.0)
    late = 1e9 + 1e-3
    span = late - 1e9
    run = meter.simulate(rig, t=[1e9, late], t_start=1e9)
    plain = meter.simulate(rig, t=[0.0, span])
    yield below("off a start at 0 by", abs(run["body.phi"][-1] - plain["body.phi"][-1]), 1e-4)
    yield below("off closed form by", abs(run["body.phi"][-1] - math.cos(w * span)), 1e-4)


def micro_units(meter: Meter) -> Iterator[Check]:
    """J = 1e-18, k = 1e-9, an angle of 1e-9 rad."""
    w = math.sqrt(1e9)
    run = meter.simulate(swing("micro", gb.Shaft(k=1e-9), J=1e-18, phi0=1e-9), t_end=1e-3)
    yield below("off by", largest(run["body.phi"] - 1e-9 * np.cos(w * run.t)) / 1e-9, 1e-2)


def tolerance_ladder(meter: Meter) -> Iterator[Check]:
    """x'' + 0.1 x' + x + x^3 = sin 1.3 t: the error follows the tolerance down."""
    from scipy.integrate import solve_ivp

    spring = gb.Shaft(torque=gb.twist + gb.twist**3, c=0.1)
    model = gb.build(swing("duffing", spring, tau=gb.sin(1.3 * gb.time)))

    def rates(t: float, y: Any) -> Any:
        return [y[1], math.sin(1.3 * t) - 0.1 * y[1] - y[0] - y[0] ** 3]

    exact = solve_ivp(rates, (0.0, 50.0), [0.0, 0.0], "DOP853", rtol=2.3e-14, atol=1e-17).y[:, -1]
    ladder, errors = [10.0**-k for k in range(3, 14)], []
    for rtol in ladder:
        run = meter.simulate(model, t=[0.0, 50.0], rtol=rtol)
        errors.append(largest([run["body.phi"][-1] - exact[0], run["body.w"][-1] - exact[1]]))
    worst = max(error / rtol for error, rtol in zip(errors, ladder, strict=True) if rtol >= 1e-10)
    yield below("error/rtol", worst, 100.0)
    rise = max(after / before for before, after in pairwise(errors))
    yield below(f"{' '.join(f'{e:.0e}' for e in errors)}: next/last", rise, 2.0)


class Lag(gb.Block):
    """A current that follows the speed within 1e-6 s and drives the shaft by 1e-4 (1 - i)."""

    flange = gb.Flange("driven flange")
    i = gb.State("current", "A")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """i' = -1e6 (i - w), torque 1e-4 (1 - i)."""
        yield gb.Rate(s.i, -1e6 * (s.i - s.flange.w))
        yield gb.Acts(s.flange, (1 - s.i) / 10000)
        yield gb.Shows("i", s.i, "A")


def time_scales(meter: Meter) -> Iterator[Check]:
    """1e-6 s and 1e4 s in one train."""
    rig = gb.Drivetrain("time scales")
    rig.chain(rig.add("lag", Lag()), rig.add("body", gb.Inertia(J=1.0)))
    run = meter.simulate(rig, t_end=1e5)
    yield below("w off by", largest(run["body.w"] + np.expm1(-1e-4 * run.t)), 1e-5)
    yield count("calls", meter.rhs_calls, CALLS)
