"""Mixed trains up to 15 bodies: every kind of element beside every other."""

from __future__ import annotations

from tests.random.description import GROUND, Train
from tests.random.draw import Growth
from tests.random.families import meshes, pieces
from tests.random.families.control import source
from tests.random.families.friction import coupling, vehicle
from tests.random.families.lossy import lossy_gear


def mixed(seed: int) -> Train:
    """A train of three to fifteen bodies."""
    g = Growth("mixed", seed)
    d = g.d
    rest = d.chance(0.25)
    bodies = [g.body(w0=None if rest else g.speed())]
    size = d.randint(3, 15)
    while len(bodies) < size:
        extend(g, bodies, rest)
    for _ in range(d.randint(1, 4)):
        _attach(g, d.choice(bodies))
    if d.chance(0.4):
        a, b = d.sample(bodies, 2)
        d.choice((pieces.shaft, pieces.damper, pieces.dry))(g, a, b)
    for _ in range(d.randint(1, 3)):
        pieces.torque(g, d.choice(bodies))
    return g.train()


def extend(g: Growth, bodies: list[str], rest: bool) -> None:
    """One more body, or two, behind an element of any kind."""
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.1:
        bodies.append(pieces.gear(g, a))
    elif kind < 0.17:
        bodies.append(lossy_gear(g, a))
    elif kind < 0.25:
        bodies.extend(pieces.planetary(g, a))
    elif kind < 0.29:
        bodies.append(meshes.noncircular(g, a))
    else:
        b = g.body(w0=None if rest else g.speed())
        bodies.append(b)
        _between(g, a, b)


def _between(g: Growth, a: str, b: str) -> None:
    d = g.d
    kind = d.random()
    if kind < 0.35:
        pieces.shaft(g, a, b, smooth=False)
    elif kind < 0.55:
        pieces.dry(g, a, b)
    elif kind < 0.63:
        pieces.lash(g, a, b)
    elif kind < 0.73:
        meshes.mesh(g, a, b, gap=d.chance(0.6))
    elif kind < 0.79:
        meshes.spline(g, a, b)
    elif kind < 0.84:
        pieces.hysteresis_shaft(g, a, b)
    elif kind < 0.89:
        meshes.rigid_play(g, a, b)
    elif kind < 0.94:
        coupling(g, a, b)
    else:
        pieces.maxwell(g, a, b)


def _attach(g: Growth, node: str) -> None:
    d = g.d
    kind = d.random()
    if kind < 0.3:
        pieces.dry(g, node, GROUND)
    elif kind < 0.45:
        pieces.speed_load(g, node)
    elif kind < 0.6:
        pieces.shaft(g, node, GROUND)
    elif kind < 0.7:
        pieces.stop(g, node, GROUND)
    elif kind < 0.75:
        vehicle(g, node)
    elif kind < 0.85:
        source(g, node, node)
    else:
        pieces.damper(g, node, GROUND)
