"""Feedback of torques, powers, twists and accelerations; loads that drive or keep their sign; tables that are left."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, digits, smooth_signal
from tests.random.expressions import TIME, TWIST, Node, call, sense, table
from tests.random.families import pieces


def feedback(seed: int) -> Train:
    """A train of two to five bodies with one to three signals of it, and what drives."""
    g = Growth("feedback", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    springs: list[tuple[str, str, str]] = []
    for _ in range(d.randint(1, 3)):
        a, b = d.choice(bodies), g.body(w0=g.speed())
        bodies.append(b)
        springs.append((_spring(g, a, b), a, b))
    for _ in range(d.randint(1, 3)):
        d.choice(
            (_of_torque, _of_torque, _of_power, _of_acceleration, _of_leaf, _capacity, driving, driving, left, left)
        )(g, bodies, springs)
    if d.chance(0.4):
        pieces.damper(g, d.choice(bodies), GROUND)
    if d.chance(0.3) and not any(p.field("direction") == "along" for p in g.parts):
        pieces.dry(g, d.choice(bodies), GROUND)
    pieces.torque(g, d.choice(bodies))
    return g.train()


def _spring(g: Growth, a: str, b: str) -> str:
    k = g.stiffness(a, b, 4.0, 40.0)
    return g.add("shaft", "Shaft", {"a": a, "b": b}, k=k, c=g.damping(a, b, k))


def _of_torque(g: Growth, bodies: list[str], springs: list[Any]) -> None:
    """A torque in proportion to that of a shaft, bound or not."""
    d, (name, _, _) = g.d, g.d.choice(springs)
    node = d.choice(bodies)
    torque, size = sense(f"{name}.torque"), pieces.torque_size(g, node)
    rate = digits(size / d.log(5.0, 100.0))
    pieces.torque(g, node, d.choice((
        d.even(-0.5, 0.5) * torque, size * call("tanh", digits(1.0 / size) * torque),
        call("Min", call("Max", d.even(-0.9, 0.9) * torque, -size), size), -rate * sense(f"{name}.twist_rate"),
        digits(0.3 * size) * call("sin", sense(f"{name}.twist")),
    )))  # fmt: skip


def _of_power(g: Growth, bodies: list[str], springs: list[Any]) -> None:
    """A torque, or a brake, that follows a power."""
    d, (name, _, _) = g.d, g.d.choice(springs)
    node = d.choice(bodies)
    size = pieces.torque_size(g, node)
    damped = next(p for p in g.parts if p.name == name).field("c") is not None
    power = sense(f"{name}.{d.choice(('a.power', 'loss_power' if damped else 'a.power'))}")
    bound = call("tanh", digits(1.0 / (size * d.log(1.0, 30.0))) * power)
    if d.chance(0.5):
        pieces.torque(g, node, d.even(-1.0, 1.0) * size * bound)
    else:
        g.add("eddy", "EddyCurrentBrake", {"flange": node}, tau_nominal=size, w_nominal=d.log(2.0, 50.0),
              excitation=bound * bound)  # fmt: skip


def _of_acceleration(g: Growth, bodies: list[str], _: Any) -> None:
    """A motor whose voltage reads an acceleration."""
    _motor(g, g.d.choice(bodies), sense(f"{g.d.choice(bodies)}.alpha"), 1.0)


def _of_leaf(g: Growth, bodies: list[str], _: Any) -> None:
    """A motor whose voltage reads the torque of a gear, or of a clutch, that moves one body alone."""
    d, node = g.d, g.d.choice(bodies)
    if d.chance(0.5):
        leaf = g.follower()
        name = g.add("gear", "IdealGear", {"a": node, "b": leaf}, ratio=d.ratio())
        read = sense(f"{name}.b.{d.choice(('tau', 'tau', 'power'))}")
    else:
        leaf = g.body(w0=g.speed())
        size = digits(g.inertia[leaf] * d.log(1.0, 30.0))
        name = g.add("clutch", "Clutch", {"a": node, "b": leaf}, capacity=pieces.capacity_signal(g, size))
        read = sense(f"{name}.torque")
    _motor(g, d.choice(bodies), read, g.inertia[leaf])


def _motor(g: Growth, node: str, read: Node, size: float) -> None:
    d = g.d
    k, L = d.log(0.1, 2.0), d.log(0.05, 1.0)
    gain = digits(k * d.log(0.003, 0.1) / size)
    bound = digits(k * d.log(2.0, 30.0))
    u: Any = smooth_signal(d, bound, g.t_end)
    u = u + (gain * read if d.chance(0.4) else bound * call("tanh", digits(gain / bound) * read))
    g.add("motor", "DCMotor", {"flange": node}, R=d.log(0.3, 5.0), L=L, k=k, u=u)


def _capacity(g: Growth, bodies: list[str], springs: list[Any]) -> None:
    """A brake or a clutch that is pressed by the torque of a shaft."""
    d, (name, _, b) = g.d, g.d.choice(springs)
    torque = sense(f"{name}.torque")
    size = pieces.torque_size(g, b)
    capacity = digits(0.3 * size) + d.even(0.1, 0.6) * call("Abs", torque)
    leaf = g.body(w0=g.speed())
    g.add("clutch", "Clutch", {"a": d.choice(bodies), "b": leaf}, capacity=capacity)


def driving(g: Growth, bodies: list[str], _: Any) -> None:
    """A load that goes along with the motion, or keeps its sign."""
    d, node = g.d, g.d.choice(bodies)
    size, J = pieces.torque_size(g, node), g.inertia[node]
    direction = d.choice(("along", "forward", "backward"))
    c0, c1 = d.choice((0.0, digits(0.3 * size))), digits(J * d.log(0.05, 1.0) / g.t_end)
    coeffs = (c0, d.choice((0.0, c1)), d.choice((0.0, digits(0.01 * c1))))
    if direction == "along":
        coeffs = (coeffs[0], c1, 0.0)
    g.add("load", "SpeedLoad", {"flange": node}, coeffs=coeffs, direction=direction)
    if d.chance(0.3):
        pieces.speed_load(g, node, dry=False)


def left(g: Growth, bodies: list[str], _: Any) -> None:
    """A table that the run leaves: over time, a speed, a twist, a slip."""
    d, node = g.d, g.d.choice(bodies)
    size, beyond = pieces.torque_size(g, node), g.d.choice(("linear", "linear", "hold"))
    kind = d.random()
    if kind < 0.25:
        x = (0.0, digits(0.2 * g.t_end), digits(0.5 * g.t_end))
        pieces.torque(
            g,
            node,
            table(
                x, (0.0, size, d.choice((0.0, digits(0.5 * size)))), "linear", beyond, TIME if d.chance(0.5) else None
            ),
        )
    elif kind < 0.5:
        w = d.log(0.5, 5.0)
        y = (digits(0.5 * size), 0.0, digits(-0.3 * size))
        pieces.torque(g, node, table((-w, 0.0, w), y, "linear", beyond, sense(f"{node}.w")))
    elif kind < 0.75:
        b = g.body(w0=g.speed())
        x, k = d.log(0.005, 0.1), g.stiffness(node, b)
        y = digits(k * x)
        law = table((-x, 0.0, x), (digits(-2 * y), 0.0, y), "linear", beyond)
        g.add(
            "shaft",
            "Shaft",
            {"a": node, "b": b},
            torque=law if d.chance(0.5) else digits(0.2 * k) * TWIST + table(*law.args[:4], TWIST),
            c=g.damping(node, b, k),
        )
    else:
        w = d.log(0.5, 8.0)
        law = table((d.choice((0.0, -1.0)), w), (digits(0.2 * size), digits(0.5 * size)), "linear", beyond)
        g.add("bearing", "BearingFriction", {"a": node, "housing": GROUND}, torque=law, peak=d.choice((None, 1.3)))
