"""Starts: between bodies, by accelerations, and of trains that roll as one piece."""

from __future__ import annotations

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, digits
from tests.random.expressions import thing
from tests.random.families import meshes, pieces
from tests.random.families.lossy import lossy_gear

RUBS = ("Clutch", "OneWayClutch", "Freewheel", "Brake", "BearingFriction")


def starts(seed: int) -> Train:
    """A tree of two to six bodies behind shafts, gaps and gears, with one kind of start."""
    g = Growth("starts", seed)
    g.laws = True
    d = g.d
    kind = d.choice(("relative", "relative", "acceleration", "rolling", "rolling", "named", "named"))
    bodies = [g.body()]
    for _ in range(d.randint(1, 5)):
        _extend(g, bodies, kind)
    if kind in ("relative", "acceleration"):
        _own(g, bodies[0], phi0=d.even(-1.0, 1.0), w0=d.even(-20.0, 20.0))
    if kind == "relative":
        _between(g)
    elif kind == "acceleration":
        _accelerations(g, bodies)
    elif kind == "rolling":
        _own(g, d.choice(bodies), w0=d.even(-50.0, 50.0), phi0=d.choice((None, d.even(-1.0, 1.0))))
        g.initial = "rolling"
    else:
        named = ((f"{d.choice(bodies)}.w", d.even(-50.0, 50.0)),)
        if d.chance(0.4):
            named += ((f"{d.choice(bodies)}.phi", d.even(-1.0, 1.0)),)
        g.initial = named
    if kind in ("rolling", "named") and not any(p.field("phi0") for p in g.parts):
        joints = [[b for b in bodies if b in (n for _, n in p.at)] for p in g.parts if p.block in RUBS]
        for body in (bodies[0], *(pair[1] for pair in joints if len(pair) == 2)):
            _own(g, body, phi0=0.0)  # where every piece has an angle the order of parts does not count
    if kind in ("rolling", "named") and d.chance(0.4):
        pieces.dry(g, d.choice(bodies), GROUND, ("Brake", "BearingFriction"))
    pieces.torque(g, d.choice(bodies), smooth=kind == "acceleration")
    if d.chance(0.5):
        pieces.speed_load(g, d.choice(bodies), dry=None if kind != "acceleration" else False)
    if kind in ("rolling", "named") and d.chance(0.4):
        _uneven(g, bodies)
    return g.train()


def _uneven(g: Growth, bodies: list[str]) -> None:
    """A non-circular pair with compliance, at times a shaft behind it."""
    d, a, b = g.d, g.d.choice(bodies), g.body()
    k, ends = g.stiffness(a, b, 10.0, 100.0), (a, b) if g.d.chance(0.5) else (b, a)
    law = thing("RatioLaw.ellipse", e=d.even(0.05, 0.5), order=d.choice((1, 1, 2)))
    phase = d.choice((None, d.even(-2.0, 2.0)))
    g.add("noncircular", "NonCircularGear", dict(zip("ab", ends, strict=True)), law=law, external=d.chance(0.6), k=k,
          c=g.damping(a, b, k), phase=phase)  # fmt: skip
    if d.chance(0.5):
        pieces.shaft(g, b, g.body())


def _own(g: Growth, body: str, **fields: float | None) -> None:
    i = next(i for i, p in enumerate(g.parts) if p.name == body)
    g.parts[i] = g.parts[i].changed(**fields)


def _extend(g: Growth, bodies: list[str], kind: str) -> None:
    d, a = g.d, g.d.choice(bodies)
    which = d.random()
    if which < 0.2:
        bodies.append(pieces.gear(g, a))
        return
    if which < 0.3 and kind in ("rolling", "named"):
        bodies.append(lossy_gear(g, a))
        return
    b = g.body()
    bodies.append(b)
    if which < 0.4 and kind in ("rolling", "named"):
        meshes.mesh(g, a, b, gap=d.chance(0.5))
    elif which < 0.5 and kind in ("rolling", "named"):
        pieces.dry(g, a, b)
    elif which < 0.7 and kind != "acceleration":
        pieces.lash(g, a, b)
    else:
        k = g.stiffness(a, b)
        rest = digits(d.either_sign(d.log(0.001, 0.1))) if d.chance(0.3) else None
        g.add("shaft", "Shaft", {"a": a, "b": b}, k=k, c=g.damping(a, b, k), rest=rest)


def _between(g: Growth) -> None:
    """Twists and their rates at the start, of some elements."""
    d = g.d
    asked = [i for i, p in enumerate(g.parts) if p.block in ("Shaft", "Lash") and d.chance(0.6)]
    for i in asked:
        p = g.parts[i]
        fields = {"phi_rel0": d.even(-0.3, 0.3), "w_rel0": d.even(-10.0, 10.0)}
        if d.chance(0.4):
            del fields[d.choice(("phi_rel0", "w_rel0"))]
        g.parts[i] = p.changed(**fields)


def _accelerations(g: Growth, bodies: list[str]) -> None:
    """One or two bodies behind shafts begin with accelerations that are given."""
    d = g.d
    ends = [p.node("b") for p in g.parts if p.block == "Shaft"]
    for body in d.sample(ends, min(len(ends), d.choice((1, 1, 2)))):
        _own(g, body, alpha0=d.even(-50.0, 50.0))
