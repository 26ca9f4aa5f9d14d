"""Lossy gears: efficiencies, bearing torques and tables, reversals, beside springs, friction, planetaries."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, any_signal, digits
from tests.random.expressions import TIME, call
from tests.random.families import pieces


def lossy(seed: int) -> Train:
    """A train with one to three lossy gears."""
    g = Growth("lossy", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    ends = [bodies[0]]
    for _ in range(d.choice((1, 1, 1, 2, 2, 3))):
        a = d.choice(bodies)
        if d.chance(0.3):
            b = g.body(w0=g.speed())
            pieces.shaft(g, a, b)
            bodies.append(b)
            a = b
        b = lossy_gear(g, a)
        bodies.append(b)
        ends.append(b)
    for _ in range(d.randint(0, 2)):
        _beside(g, bodies)
    _loads(g, bodies, ends)
    return g.train()


def _beside(g: Growth, bodies: list[str]) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.35:
        b = g.body(w0=g.speed())
        pieces.shaft(g, a, b)
        bodies.append(b)
    elif kind < 0.5:
        bodies.append(pieces.gear(g, a))
    elif kind < 0.6:
        bodies.extend(pieces.planetary(g, a))
    elif kind < 0.75:
        pieces.dry(g, a, GROUND, ("Brake", "BearingFriction"))
    elif kind < 0.85:
        b = g.body(w0=g.speed())
        pieces.dry(g, a, b, ("Clutch", "Clutch", "Freewheel"))
        bodies.append(b)
    else:
        pieces.shaft(g, a, GROUND)


def _loads(g: Growth, bodies: list[str], ends: list[str]) -> None:
    d = g.d
    size = pieces.torque_size(g, ends[-1])
    reversing: Any = size * call("sin", d.log(2.0, 25.0) * TIME)
    pieces.torque(g, ends[-1], reversing if d.chance(0.6) else any_signal(d, size, g.t_end))
    if d.chance(0.5):
        pieces.torque(g, d.choice(bodies))
    if d.chance(0.35):
        pieces.speed_load(g, d.choice(bodies))
    if d.chance(0.25):
        pieces.damper(g, d.choice(bodies), GROUND)


def lossy_gear(g: Growth, a: str) -> str:
    """A gear with losses to a new body; its speed follows."""
    d = g.d
    b = g.follower()
    kind = d.random()
    ratio = d.ratio()
    if kind < 0.5:
        one = d.even(0.4, 1.0)
        g.add("lossy", "LossyGear", {"a": a, "b": b}, ratio=ratio, efficiency=(one, d.choice((one, d.even(0.3, 1.0)))))
    elif kind < 0.72:
        tau = digits(g.inertia[a] * d.log(0.3, 10.0))
        efficiency = (d.even(0.5, 1.0), d.even(0.5, 1.0))
        g.add("lossy", "LossyGear", {"a": a, "b": b}, ratio=ratio, efficiency=efficiency, bearing=(tau, tau))
    elif kind < 0.9:
        rows, w = [], 0.0
        for _ in range(d.randint(1, 4)):
            tau = d.choice((0.0, digits(g.inertia[a] * d.log(0.3, 5.0))))
            rows.append((w, d.even(0.5, 1.0), d.even(0.5, 1.0), tau, tau))
            w = digits(w + d.log(0.5, 15.0))
        g.add("lossy", "LossyGear", {"a": a, "b": b}, ratio=ratio, loss_table=tuple(rows))
    else:
        lead = d.even(0.25, 0.8)
        g.add(
            "worm",
            "Worm",
            {"a": a, "b": b},
            ratio=d.choice((5.0, 10.0, -8.0)),
            lead_angle=lead,
            friction=d.even(0.01, 0.15),
        )
    return b
