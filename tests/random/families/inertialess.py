"""Friction, locks and lossy gears beside shafts without inertia: in a row with shafts and gaps between bodies."""

from __future__ import annotations

from random import Random
from typing import Any

from tests.random.description import GROUND, Part, Train
from tests.random.draw import Growth, digits
from tests.random.families import pieces

RUBS = ("Clutch", "Clutch", "OneWayClutch", "Freewheel", "BearingFriction", "Brake")


def inertialess(seed: int) -> Train:
    """A train with one or two rows of elements without inertia between them."""
    g = Growth("inertialess", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    for _ in range(d.choice((1, 1, 2))):
        a = d.choice(bodies)
        b = GROUND if d.chance(0.2) else g.body(w0=g.speed())
        (_row_with_gear if b != GROUND and d.chance(0.5) else _row_with_friction)(g, a, b)
        bodies += [b] if b != GROUND else []
    if d.chance(0.4):
        pieces.dry(g, d.choice(bodies), GROUND, ("Brake", "BearingFriction"))
    if d.chance(0.3):
        pieces.speed_load(g, d.choice(bodies))
    pieces.torque(g, bodies[-1])
    if d.chance(0.5):
        pieces.torque(g, d.choice(bodies))
    if d.chance(0.3):
        _gear_beside_friction(g, d.choice(bodies))
    _bent_load(g, bodies)
    return g.train()


def _bent_load(g: Growth, bodies: list[str]) -> None:
    """At times a load whose torque bends over the speed, straight at the end of a shaft; aside: all else is drawn as it was."""
    r = Random(f"bent {g.seed}")
    if r.random() > 0.25 or any(p.block == "Lash" and p.field("contact_damping") is None for p in g.parts):
        return  # beside gaps at their clip the balance is singular, and rounds after the first are not told (decision 12)
    a, node, size = r.choice(bodies), g.bare(), digits(pieces.torque_size(g, bodies[0]))
    k = digits(size * 10.0 ** r.uniform(1.0, 2.5))
    g.add("shaft", "Shaft", {"a": a, "b": node}, k=k, c=r.choice((None, digits(k / 100.0))))
    w = 10.0 ** r.uniform(0.0, 1.5)  # k over c1 is how fast the twist fades: explicit methods of the draw follow it
    if r.random() < 0.7:
        coeffs = (0.0, digits(k / 10.0 ** r.uniform(2.0, 3.5)), digits(size / w**2 * 10.0 ** r.uniform(0.0, 2.0)))
        g.add("pump", "SpeedLoad", {"flange": node}, coeffs=coeffs)
    else:  # far from its largest torque
        g.add("eddy", "EddyCurrentBrake", {"flange": node}, tau_nominal=digits(50.0 * size), w_nominal=digits(20.0 * w))


def _gear_beside_friction(g: Growth, a: str) -> None:
    """A lossy gear and, straight beside it, friction or a stop to a further body, or to the ground as well."""
    d, b, node = g.d, g.body(w0=g.speed()), g.bare()
    size = digits(pieces.torque_size(g, a))
    tau = (digits(size * d.log(0.01, 0.3)), digits(size * d.log(0.01, 0.3)))
    driven = d.chance(0.6)
    fields: dict[str, Any] = {"efficiency": (d.even(0.5, 1.0), d.even(0.4, 1.0))}
    if d.chance(0.5):
        fields["bearing"] = tau if driven else (tau[0], tau[0])
    ends = (a, node) if driven else (node, a)
    g.add("lossy", "LossyGear", dict(zip("ab", ends, strict=True)), ratio=d.ratio(), **fields)
    for _ in range(d.choice((1, 1, 2))):
        kind, other = d.choice(("Clutch", "Clutch", "OneWayClutch", "Freewheel")), b
        ends = (node, other) if d.chance(0.5) else (other, node)
        own = (
            {} if kind == "Freewheel" else {"capacity": pieces.capacity_signal(g, size), "peak": d.choice((None, 1.2))}
        )
        g.add(kind.lower(), kind, dict(zip("ab", ends, strict=True)), **own)
    if d.chance(0.2):
        pieces.stop(g, node, b)


def _compliant(g: Growth, a: str, b: str, size: float, clipped: bool = False) -> None:
    """A damped shaft or gap; stiff enough to be told from the bodies' motion. clipped: the damping of the gap is."""
    d = g.d
    k = digits(size * d.log(10.0, 300.0))
    c = digits(k / d.log(30.0, 400.0))
    if d.chance(0.35):
        gap = d.log(0.001, 0.05)
        g.add("lash", "Lash", {"a": a, "b": b}, k=k, c=c, half_gap=gap, contact_damping=None if clipped else "always")
    else:
        g.add("shaft", "Shaft", {"a": a, "b": b}, k=k, c=c)


def _row_with_friction(g: Growth, a: str, b: str) -> None:
    """Shaft and friction, or friction between two shafts."""
    d = g.d
    size = digits(pieces.torque_size(g, a) * d.log(0.2, 2.0))
    node = g.bare()
    _compliant(g, a, node, size)
    other = b
    if d.chance(0.3):
        other = g.bare()
    kind = d.choice(RUBS)
    fields: dict[str, Any] = {}
    if kind in ("Clutch", "OneWayClutch", "Brake"):
        fields = {"capacity": pieces.capacity_signal(g, size), "peak": d.choice((None, None, 1.2))}
        if d.chance(0.3):
            mu = d.even(0.1, 0.5)
            fields = {"mu": mu, "force_max": digits(size / 0.2), "engagement": d.choice((1.0, 0.5))}
    elif kind == "BearingFriction":
        fields = {"coulomb": size, "viscous": d.choice((None, digits(size / d.log(5.0, 50.0))))}
    names = ("a", "housing") if kind in ("BearingFriction", "Brake") else ("a", "b")
    ends = (node, other) if d.chance(0.5) else (other, node)
    at = {n: e for n, e in zip(names, ends, strict=True) if e != GROUND or n != "housing"}
    if ends[0] == GROUND and names[1] == "housing":
        at = {"a": ends[1]}
    g.add(kind.lower(), kind, at, **fields)
    if other != b:
        _compliant(g, other, b, size)


def _row_with_gear(g: Growth, a: str, b: str) -> None:
    """A lossy gear before, behind or between shafts."""
    d = g.d
    size = digits(pieces.torque_size(g, a))
    where = d.choice(("before", "behind", "between"))
    one = g.bare() if where != "before" else a
    other = g.bare() if where != "behind" else b
    clipped = Random(f"clipped {g.seed} {len(g.parts)}").random() < 0.5  # aside: all else is drawn as it was
    if one != a:
        _compliant(g, a, one, size, clipped)
    eta = (d.even(0.6, 1.0), d.even(0.6, 1.0))
    tau = digits(size * d.log(0.01, 0.3))
    fields: dict[str, Any] = {"efficiency": eta}
    if d.chance(0.5) or where == "between":
        fields["bearing"] = (tau, tau)
    if d.chance(0.25):
        fields = {"loss_table": ((0.0, *eta, tau, tau), (d.log(1.0, 20.0), *(digits(0.9 * x) for x in eta), tau, tau))}
    g.add("lossy", "LossyGear", {"a": one, "b": other}, ratio=d.ratio(), **fields)
    if other != b:
        _compliant(g, other, b, size, clipped)


def with_inertias(train: Train, share: float) -> Train:
    """The train with small inertias at its nodes without any, a share of its smallest one."""
    own = {p.node("a") for p in train.bodies}
    least = min(p.field("J") for p in train.bodies)
    bare = [n for n in train.nodes() if n not in own]
    return train.with_parts(
        (*train.parts, *(Part(f"at_{n}", "Inertia", (("J", share * least),), (("a", n),)) for n in bare))
    )
