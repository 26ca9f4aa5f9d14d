"""Bodies at rest behind stiff contacts, open or just touching, that locks set in motion late in the run."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, digits
from tests.random.expressions import table, thing
from tests.random.families import meshes, pieces


def late(seed: int) -> Train:
    """A train of three to six bodies, of which one turns as a rule."""
    g = Growth("late", seed)
    d = g.d
    bodies = [g.body(w0=digits(d.either_sign(d.log(1.0, 30.0))))]
    for _ in range(d.randint(2, 5)):
        a, b = d.choice(bodies[-2:]), g.body(w0=None if d.chance(0.85) else g.speed())
        bodies.append(b)
        _between(g, a, b)
    if d.chance(0.3):
        _between(g, *d.sample(bodies, 2))
    for _ in range(d.randint(0, 2)):
        (pieces.dry if d.chance(0.6) else pieces.damper)(g, d.choice(bodies), GROUND)
    if d.chance(0.6):
        at = round(d.even(0.1, 0.9) * g.t_end, 4)
        size = d.either_sign(pieces.torque_size(g, bodies[0]))
        pieces.torque(g, bodies[0], table((0.0, at), (0.0, size), "step"))
    return g.train()


def _between(g: Growth, a: str, b: str) -> None:
    kind = g.d.random()
    if kind < 0.45:
        _stiff(g, a, b)
    elif kind < 0.75:
        _lock(g, a, b)
    elif kind < 0.85:
        meshes.spline(g, a, b)
    elif kind < 0.95:
        meshes.rigid_play(g, a, b)
    else:
        pieces.shaft(g, a, b)


def _stiff(g: Growth, a: str, b: str) -> None:
    """A gap whose contacts last for a hundredth of the run or less."""
    k = g.stiffness(a, b, 40.0, 800.0)
    fields: dict[str, Any] = {"k": k, "half_gap": g.d.choice((0.0, g.d.log(1e-4, 1e-2), g.d.log(0.005, 0.1)))}
    if g.d.chance(0.5):
        fields["contact_damping"] = thing("HuntCrossley", restitution=g.d.even(0.1, 0.95))
    else:
        fields["c"] = g.damping(a, b, k)
        fields["contact_damping"] = g.d.choice((None, "clipped_force", "always"))
    g.drops.append(g.add("lash", "Lash", {"a": a, "b": b}, **fields))


def _lock(g: Growth, a: str, b: str) -> None:
    """A dog clutch, synchronizer or clutch that closes late, and opens again now and then."""
    d = g.d
    on, off = round(d.even(0.2, 0.7) * g.t_end, 4), round(d.even(0.75, 0.98) * g.t_end, 4)
    times, values = ((0.0, on, off), (-1.0, 1.0, -1.0)) if d.chance(0.4) else ((0.0, on), (-1.0, 1.0))
    kind, size = d.random(), pieces.torque_size(g, a)
    if kind < 0.5:
        g.add("dog", "DogClutch", {"a": a, "b": b}, engaged=table(times, values, "step"))
    elif kind < 0.65:
        g.add("sync", "Synchronizer", {"a": a, "b": b}, engaged=table(times, values, "step"), capacity=size)
    else:
        held = tuple(size if value > 0 else 0.0 for value in values)
        g.add("clutch", "Clutch", {"a": a, "b": b}, capacity=table(times, held, "step"))
