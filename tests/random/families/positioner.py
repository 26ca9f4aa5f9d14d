"""Relays: torques that jump about an angle or a speed and drive back from both sides, beside what takes a part of their
swings or stands in their way: friction, lossy gears, dampers, clutches, stops, springs, loads and set points over time."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, any_signal, digits, smooth_signal
from tests.random.expressions import TIME, Node, call, either, rewrite, sense, table
from tests.random.families import pieces
from tests.random.families.lossy import lossy_gear


def positioner(seed: int) -> Train:
    """A train with one or two relays."""
    g = Growth("positioner", seed)
    d = g.d
    g.t_end = d.choice((2.0, 5.0, 10.0, 20.0))
    bodies = [g.body(J=d.log(0.1, 3.0), w0=d.choice((None, None, 0.0, d.even(-3.0, 3.0))))]
    for _ in range(d.choice((0, 1, 1, 1, 2, 2, 3))):
        bodies.append(_behind(g, d.choice(bodies)))
    sizes = [relay(g, d.choice(bodies), bodies) for _ in range(d.choice((1, 1, 1, 2)))]
    for _ in range(d.choice((0, 1, 1, 2))):
        _beside(g, d.choice(bodies), d.choice(sizes))
    for _ in range(d.choice((0, 0, 1, 2))):
        size = digits(d.choice(sizes) * d.log(0.05, 1.5))
        pieces.torque(g, d.choice(bodies), any_signal(d, size, g.t_end))
    return g.train()


def _behind(g: Growth, a: str) -> str:
    """One more body, behind something."""
    d = g.d
    kind = d.random()
    if kind < 0.3:
        return lossy_gear(g, a)
    if kind < 0.45:
        return pieces.gear(g, a)
    b = g.body(J=d.log(0.1, 3.0))
    if kind < 0.65:
        g.add("clutch", "Clutch", {"a": a, "b": b}, capacity=digits(pieces.torque_size(g, a) * d.log(0.05, 1.0)))
    elif kind < 0.75:
        pieces.damper(g, a, b)
    elif kind < 0.8:
        pieces.dry(g, a, b)
    else:
        pieces.shaft(g, a, b)
    return b


def _beside(g: Growth, node: str, size: float) -> None:
    """What takes a part of the swings, or stands in their way."""
    d = g.d
    own = digits(size * d.log(0.02, 1.2))
    kind = d.random()
    if kind < 0.35:
        capacity: Any = own if d.chance(0.7) else pieces.capacity_signal(g, own)
        g.add("brake", "Brake", {"a": node, "housing": GROUND}, capacity=capacity, peak=d.choice((None, None, 1.3)))
    elif kind < 0.55:
        viscous = d.choice((None, digits(own / d.log(2.0, 50.0))))
        g.add("bearing", "BearingFriction", {"a": node, "housing": GROUND}, coulomb=own, viscous=viscous)
    elif kind < 0.75:
        pieces.damper(g, node, GROUND)
    elif kind < 0.85:
        pieces.speed_load(g, node)
    elif kind < 0.93:
        pieces.stop(g, node, GROUND)
    else:
        pieces.dry(g, node, GROUND)


def relay(g: Growth, node: str, bodies: list[str]) -> float:
    """A torque that jumps where a quantity of its own or of another body passes its set point; returns its size."""
    d = g.d
    size = digits(max(g.inertia[node], 0.05) * d.log(0.5, 20.0))
    read = node if d.chance(0.75) else d.choice(bodies)
    kind = d.random()
    phi, w = sense(f"{read}.phi"), sense(f"{read}.w")
    quantity, scale = (phi, 1.0) if kind < 0.6 else (w, 3.0) if kind < 0.85 else (phi + d.log(0.05, 1.0) * w, 1.0)
    if kind < 0.1 and len(bodies) > 1:
        quantity = phi - sense(f"{d.choice([b for b in bodies if b != read])}.phi")
    target = _set_point(g, digits(d.either_sign(scale * d.log(0.1, 2.0))))
    back = d.choice((size, size, digits(size * d.log(0.2, 2.0)), 0.0 if kind >= 0.6 else size))
    g.add("relay", "Torque", {"flange": node}, tau=either(size, quantity < target, digits(-back)))
    return min(size, back) or size


def _set_point(g: Growth, size: float) -> Any:
    """A number, or what goes on over time: steps, ramps, curves."""
    d = g.d
    at = digits(g.t_end * d.even(0.2, 0.7))
    later = digits(at + (g.t_end - at) * d.even(0.2, 0.9))
    return d.choice((
        lambda: size, lambda: size, lambda: size,
        lambda: either(size, at > TIME, digits(-0.5 * size)),
        lambda: table((0.0, at, later, g.t_end + 1.0), (size, size, digits(2 * size), digits(2 * size))),
        lambda: digits(size / g.t_end) * TIME,
        lambda: size + digits(0.5 * size) * call("sin", d.log(0.3, 5.0) * TIME),
        lambda: smooth_signal(d, size, g.t_end),
    ))()  # fmt: skip


def widened(train: Train, width: float) -> Train:
    """The train with steep lines in place of the jumps of its relays: across a part of what they read, 1 rad or 1 rad/s."""

    def line(x: Any) -> Any:
        if not (isinstance(x, Node) and x.op == "either" and x.args[1].op == "<"):
            return x
        up, condition, down = x.args
        quantity, target = condition.args
        if quantity == TIME or target == TIME or not isinstance(quantity, Node):
            return x
        slope, middle = (up - down) / width, 0.5 * (up + down)
        return call("Max", down, call("Min", up, middle + slope * (target - quantity)))

    return train.with_parts(
        p.changed(tau=rewrite(p.field("tau"), line)) if p.name.startswith("relay") else p for p in train.parts
    )
