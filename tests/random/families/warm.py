"""Heat of composites and couplings: gearboxes, planetary gears, shafts in segments, converters, belts, splines, tyres."""

from __future__ import annotations

from collections.abc import Callable

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, digits
from tests.random.families import meshes, pieces
from tests.random.families.heat import warmed
from tests.random.families.vehicle import load
from tests.random.families.wide import belt, converter, moving_phase, planetary_gear, rubbing_mesh, segments


def warm(seed: int) -> Train:
    """Two to four bodies in a row of such elements, which give their heat to one to three masses."""
    g = Growth("warm", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    for _ in range(d.choice((1, 1, 2, 3))):
        bodies += d.choice(COUPLES)(g, d.choice(bodies))
    pieces.torque(g, d.choice(bodies))
    if d.chance(0.5):
        pieces.dry(g, d.choice(bodies), GROUND, ("Brake", "BearingFriction"))
    if d.chance(0.3):
        load(g, d.choice(bodies))
    warmed(g)
    return g.train()


def _gearbox(g: Growth, a: str) -> list[str]:
    """Rigid, or with compliance, which leaves a shaft without inertia inside."""
    d, b = g.d, g.follower()
    rigid = d.chance(0.5)
    size = pieces.torque_size(g, a)
    fields = {"ratio": d.ratio(), "efficiency": (d.even(0.5, 1.0), d.even(0.5, 1.0))}
    if d.chance(0.5):
        tau = digits(size * d.log(0.01, 0.3))
        fields["bearing"] = (tau, tau)
    if not rigid:
        k = g.stiffness(a, b)
        fields |= {"k": k, "c": digits(k / d.log(30.0, 400.0)), "half_gap": d.choice((None, d.log(0.001, 0.05)))}
        fields["contact_damping"] = d.choice((None, "always", "clipped"))
    g.add("box", "Gearbox", {"a": a, "b": b}, **fields)
    return [b]


def _mesh(g: Growth, a: str) -> list[str]:
    b = g.body(w0=g.speed())
    meshes.mesh(g, a, b, gap=g.d.chance(0.6))
    return [b]


def _spline(g: Growth, a: str) -> list[str]:
    b = g.body(w0=g.speed())
    meshes.spline(g, a, b)
    return [b]


def _lash(g: Growth, a: str) -> list[str]:
    b = g.body(w0=g.speed())
    pieces.lash(g, a, b)
    return [b]


COUPLES: tuple[Callable[[Growth, str], list[str]], ...] = (
    _gearbox, _gearbox, _mesh, _spline, _lash, converter, belt, planetary_gear, rubbing_mesh,
    segments, moving_phase,
)  # fmt: skip
