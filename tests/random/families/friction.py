"""Dry friction: clutches, brakes, bearings, freewheels side by side, with peaks, tables, pulsing capacities, static starts."""

from __future__ import annotations

from tests.random.description import GROUND, Train
from tests.random.draw import Growth
from tests.random.families import pieces


def friction(seed: int) -> Train:
    """A train with one to six friction elements."""
    g = Growth("friction", seed)
    d = g.d
    rest = d.chance(0.35)
    bodies = [g.body(w0=None if rest else g.speed())]
    for _ in range(d.randint(1, 4)):
        _extend(g, bodies, rest)
    for _ in range(d.randint(0, 3)):
        kind = d.random()
        if kind < 0.75:
            pieces.dry(g, d.choice(bodies), GROUND)
        else:
            pieces.speed_load(g, d.choice(bodies))
    if d.chance(0.2) and len(bodies) > 2:
        pieces.dry(g, *d.sample(bodies, 2))
    if d.chance(0.35):
        pieces.shaft(g, d.choice(bodies), GROUND)
    for _ in range(d.randint(1, 2)):
        pieces.torque(g, d.choice(bodies))
    if d.chance(0.1):
        vehicle(g, d.choice(bodies))
    return g.train()


def vehicle(g: Growth, node: str) -> None:
    """A vehicle on the wheels; it holds at rest."""
    d = g.d
    mass, radius = d.log(0.5, 20.0), d.choice((0.1, 0.3))
    g.add("car", "Vehicle", {"flange": node}, mass=mass, wheel_radius=radius, drag_area=d.choice((None, d.log(0.1, 3.0))),
          rolling=d.log(0.005, 0.2), grade=d.choice((None, None, d.even(-0.1, 0.1))))  # fmt: skip


def _extend(g: Growth, bodies: list[str], rest: bool) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.1:
        bodies.append(pieces.gear(g, a))
        return
    if kind < 0.18:
        bodies.extend(pieces.planetary(g, a))
        return
    b = g.body(w0=None if rest else g.speed())
    bodies.append(b)
    if kind < 0.55:
        pieces.dry(g, a, b)
    elif kind < 0.65:
        pieces.hysteresis_shaft(g, a, b)
    elif kind < 0.7:
        coupling(g, a, b)
    else:
        pieces.shaft(g, a, b, smooth=False)


def coupling(g: Growth, a: str, b: str) -> None:
    """A synchronizer or a dog clutch that closes and opens once."""
    d = g.d
    at, off = d.even(0.1, 0.5) * g.t_end, d.even(0.6, 0.95) * g.t_end
    from tests.random.expressions import table

    engaged = d.choice((1.0, table((0.0, round(at, 4), round(off, 4)), (-1.0, 1.0, -1.0), "step")))
    if d.chance(0.4):
        g.add("dog", "DogClutch", {"a": a, "b": b}, engaged=engaged)
    else:
        capacity = pieces.torque_size(g, a)
        g.add("sync", "Synchronizer", {"a": a, "b": b}, engaged=engaged, capacity=capacity)
