"""Rigid impacts: one after the other ever faster, at the very start, several at once."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import Check, Meter, below, count, fact, largest

PRESSED = -1.0
"""Torque on a body of J = 1 that presses it to its stop."""


def _bouncing(restitution: float, *bodies: str, phi0: float = 1.0) -> gb.Drivetrain:
    """Bodies of J = 1, each pressed on a stop of its own at 0."""
    rig = gb.Drivetrain("bouncing")
    for name in bodies:
        body = rig.add(name, gb.Inertia(J=1.0, phi0=phi0))
        stop = rig.add(f"{name}_stop", gb.HardStop(lower=0.0, restitution=restitution))
        rig.connect(rig.add(f"{name}_load", gb.Torque(tau=PRESSED)).flange, body.a, stop.a)
    return rig


def zeno(meter: Meter) -> Iterator[Check]:
    """Impacts pile up at 3 sqrt 2 = 4.2426 s; then rest."""
    run = meter.simulate(_bouncing(0.5, "ball"), t_end=10.0)
    x, w = run["ball.phi"], run["ball.w"]
    rest = run.t > 3 * math.sqrt(2.0) + 1e-6
    yield fact(f"reaches t = {run.t[-1]:g} s", run.t[-1] == 10.0)
    yield below("x at rest", largest(x[rest]), 1e-6)
    yield below("deepest", -float(x.min()), 1e-9)
    energy = w**2 / 2 + x
    yield below("energy rises by", float(np.diff(energy).max()), 1e-9)
    yield count("events", run.stats.events, 1999)


def contact_at_start(meter: Meter) -> Iterator[Check]:
    """On its stop at t = 0 and pressed on: stays."""
    run = meter.simulate(_bouncing(0.5, "ball", phi0=0.0), t_end=1.0)
    yield below("x", largest(run["ball.phi"]), 1e-9)


def two_at_once(meter: Meter) -> Iterator[Check]:
    """Two equal bodies without loss bounce seven times each in 20 s, together."""
    run = meter.simulate(_bouncing(1.0, "left", "right"), t_end=20.0)
    yield below("apart by", largest(run["left.phi"] - run["right.phi"]), 1e-9)
    yield below("deepest", -min(float(run[f"{x}.phi"].min()) for x in ("left", "right")), 1e-9)
    hits = [round(float(run[f"{x}_stop.impacts"][-1])) for x in ("left", "right")]
    yield fact(f"{hits[0]} and {hits[1]} impacts", hits == [7, 7])


def three_in_a_row(meter: Meter) -> Iterator[Check]:
    """One body runs into two that touch, restitution 1: Newton's rule at both contacts at once."""
    ends = []
    for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
        run = meter.simulate(_row(order), t_end=1.0)
        ends.append([float(run[f"{x}.w"][-1]) for x in ("one", "two", "three")])
    w = ends[0]
    yield below(f"w = {w[0]:.6g}, {w[1]:.6g}, {w[2]:.6g}: momentum off by", abs(sum(w) - 1.0), 1e-12)
    yield below("energy over before by", sum(x * x for x in w) - 1.0, 1e-12)
    yield below("gaps close", max(w[0] - w[1], w[1] - w[2]), 1e-12)
    yield below("order changes w by", largest(np.ptp(np.array(ends), axis=0)), 1e-12)


def _row(order: tuple[int, ...]) -> gb.Drivetrain:
    """Three bodies of J = 1 with w = 1, 0, 0 and gaps of 0 between them, added in any order."""
    rig = gb.Drivetrain("row")
    names, speeds = ("one", "two", "three"), (1.0, 0.0, 0.0)
    bodies = {i: rig.add(names[i], gb.Inertia(J=1.0, w0=speeds[i])) for i in order}
    for i in order:
        if i < 2:
            stop = rig.add(f"stop{i}", gb.HardStop(lower=0.0, restitution=1.0))
            rig.connect(bodies[i].a, stop.a)
            rig.connect(stop.b, bodies[i + 1].a)
    return rig
