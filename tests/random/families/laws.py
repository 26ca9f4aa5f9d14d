"""Gaps with ends of their own, exponents, rests, and laws of friction over the slip, beside what the other families have."""

from __future__ import annotations

from tests.random.description import GROUND, Train
from tests.random.draw import Growth
from tests.random.families import pieces


def laws(seed: int) -> Train:
    """A train with two to five of them."""
    g = Growth("laws", seed)
    g.laws = True
    d = g.d
    bodies = [g.body(w0=g.speed())]
    for _ in range(d.randint(1, 3)):
        _extend(g, bodies)
    for _ in range(d.randint(1, 2)):
        d.choice((pieces.dry, pieces.dry, pieces.lash, pieces.shaft))(g, d.choice(bodies), GROUND)
    for _ in range(d.randint(1, 2)):
        pieces.torque(g, d.choice(bodies))
    return g.train()


def _extend(g: Growth, bodies: list[str]) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.1:
        bodies.append(pieces.gear(g, a))
        return
    b = g.body(w0=g.speed())
    bodies.append(b)
    if kind < 0.5:
        pieces.lash(g, a, b)
    elif kind < 0.75:
        pieces.dry(g, a, b)
    else:
        pieces.shaft(g, a, b)
