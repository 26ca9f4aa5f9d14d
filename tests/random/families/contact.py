"""Contacts: gaps with and without compliance, stops, starts on corners and in contact, several at once."""

from __future__ import annotations

from tests.random.description import GROUND, Train
from tests.random.draw import Growth
from tests.random.families import meshes, pieces


def contact(seed: int) -> Train:
    """A train with one to four contacts."""
    g = Growth("contact", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    for _ in range(d.randint(1, 4)):
        _extend(g, bodies)
    for _ in range(d.randint(0, 2)):
        pieces.stop(g, d.choice(bodies), GROUND)
    if d.chance(0.25) and len(bodies) > 1:
        pieces.stop(g, *d.sample(bodies, 2))
    if d.chance(0.35):
        d.choice((pieces.shaft, pieces.lash))(g, d.choice(bodies), GROUND)
    for _ in range(d.randint(1, 2)):
        pieces.torque(g, d.choice(bodies))
    if d.chance(0.25):
        pieces.damper(g, d.choice(bodies), GROUND)
    return g.train()


def _extend(g: Growth, bodies: list[str]) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.08:
        bodies.append(pieces.gear(g, a))
        return
    if kind < 0.13:
        bodies.extend(pieces.planetary(g, a))
        return
    b = g.body(w0=g.speed())
    bodies.append(b)
    if kind < 0.35:
        pieces.lash(g, a, b)
    elif kind < 0.55:
        meshes.mesh(g, a, b, gap=True)
    elif kind < 0.67:
        meshes.spline(g, a, b)
    elif kind < 0.78:
        meshes.rigid_play(g, a, b)
    elif kind < 0.84:
        meshes.noncircular(g, a, b, gap=True)
    else:
        pieces.shaft(g, a, b, smooth=False)
