"""Random numbers, signals and the growing of a train; determined by the seed alone."""

from __future__ import annotations

from random import Random
from typing import Any

from tests.random.description import BODIES, Part, Train
from tests.random.expressions import TIME, Node, call, either, table

NICE = (0.1, 0.2, 0.25, 0.5, 1.0, 1.0, 2.0, 4.0, 5.0, 10.0, 20.0, 50.0, 100.0, 1000.0)


class Draw(Random):
    """Numbers of three digits, now and then round ones that meet others of the train."""

    def chance(self, p: float) -> bool:
        """True with the probability p."""
        return self.random() < p

    def log(self, low: float, high: float) -> float:
        """Evenly in the logarithm; with one chance in four a round number, where one lies in between."""
        if self.chance(0.25):
            round_ones = [x for x in NICE if low <= x <= high]
            if round_ones:
                return self.choice(round_ones)
        return digits(low * (high / low) ** self.random())

    def even(self, low: float, high: float) -> float:
        """Evenly between two numbers."""
        return digits(low + (high - low) * self.random())

    def either_sign(self, x: float) -> float:
        """x or -x."""
        return x if self.chance(0.5) else -x

    def ratio(self) -> float:
        """A gear ratio."""
        return self.choice((-3.0, -2.0, -1.0, -0.5, 0.5, 1.5, 2.0, 2.0, 2.5, 3.0, 3.0, 4.0, 0.25, 1.0))


def digits(x: float) -> float:
    """x with three digits."""
    return float(f"{x:.3g}")


class Growth:
    """A train that grows: nodes with their inertia, parts, and the run."""

    def __init__(self, family: str, seed: int) -> None:
        self.d = Draw(f"{family} {seed}")
        self.family, self.seed = family, seed
        self.parts: list[Part] = []
        self.inertia: dict[str, float] = {}
        self.slides: set[str] = set()
        self.t_end = self.d.choice((0.5, 1.0, 1.0, 2.0, 3.0))
        self.inputs: list[tuple[str, Any]] = []
        self.drops: list[str] = []
        self.initial: str | None = None
        self.count: dict[str, int] = {}
        self.following: set[str] = set()  # bodies whose start speed follows from a tie
        self.laws = False  # whether gaps have ends, springs rests, and friction laws over the slip

    def name(self, stem: str) -> str:
        """A new name."""
        self.count[stem] = self.count.get(stem, 0) + 1
        return f"{stem}{self.count[stem]}"

    def add(self, stem: str, block: str, at: dict[str, str], **fields: Any) -> str:
        """A part under a new name; fields that are None are left out."""
        name = self.name(stem)
        given = tuple((k, v) for k, v in fields.items() if v is not None)
        self.parts.append(Part(name, block, given, tuple(at.items())))
        return name

    def body(self, J: float | None = None, w0: float | None = None, phi0: float | None = None) -> str:
        """A node with an Inertia; returns the node, which has the name of the body."""
        if J is None:
            J = self.d.log(0.02, 3.0)
        node = self.name("j")
        fields = {"J": J} | ({"phi0": phi0} if phi0 is not None else {}) | ({"w0": w0} if w0 is not None else {})
        self.parts.append(Part(node, "Inertia", tuple(fields.items()), (("a", node),)))
        self.inertia[node] = J
        return node

    def follower(self, J: float | None = None) -> str:
        """A node with an Inertia whose start speed a tie gives."""
        node = self.body(J)
        self.following.add(node)
        return node

    def mass(self, m: float, v0: float | None = None) -> str:
        """A node with a Mass."""
        node = self.name("m")
        fields = {"m": m} | ({"v0": v0} if v0 is not None else {})
        self.parts.append(Part(node, "Mass", tuple(fields.items()), (("a", node),)))
        self.inertia[node] = m
        self.slides.add(node)
        return node

    def bare(self) -> str:
        """A node without a body."""
        node = self.name("n")
        self.inertia[node] = 0.0
        return node

    def speed(self) -> float | None:
        """A start speed: often none or 0, else of either sign."""
        kind = self.d.random()
        if kind < 0.35:
            return None
        return 0.0 if kind < 0.45 else self.d.either_sign(self.d.log(0.5, 30.0))

    def reduced(self, a: str, b: str) -> float:
        """Inertia that an element between two nodes sees; the ground has infinitely much."""
        parts = [self.inertia[n] for n in (a, b) if n in self.inertia and self.inertia[n] > 0]
        if not parts:
            return 0.3
        return 1.0 / sum(1.0 / J for J in parts)

    def stiffness(self, a: str, b: str, low: float = 4.0, high: float = 60.0) -> float:
        """k for an angular frequency between low and high."""
        return digits(self.reduced(a, b) * self.d.log(low, high) ** 2)

    def damping(self, a: str, b: str, k: float) -> float | None:
        """c for a damping ratio from 0.001 to 0.5, or None."""
        if self.d.chance(0.3):
            return None
        return digits(2 * self.d.log(0.001, 0.5) * (k * self.reduced(a, b)) ** 0.5)

    @property
    def rotating(self) -> list[str]:
        """Nodes of inertias."""
        return [n for n, J in self.inertia.items() if J > 0 and n not in self.slides]

    def train(self) -> Train:
        """What has grown. Where three shafts share a tie, every start speed that no tie gives is said."""
        if any(p.block in ("IdealPlanetary", "Differential") for p in self.parts):
            self.parts = [
                p.changed(w0=0.0) if p.block == "Inertia" and p.name not in self.following and p.field("w0") is None
                and p.field("J") > 0 else p
                for p in self.parts
            ]  # fmt: skip
        return Train(
            self.family, self.seed, tuple(self.parts), self.t_end, self.initial, tuple(self.inputs), tuple(self.drops)
        )


def smooth_signal(d: Draw, size: float, t_end: float) -> Any:
    """A number or a smooth law over time, reversing as a rule."""
    w = d.log(1.0, 20.0)
    return d.choice((
        lambda: d.either_sign(size),
        lambda: size * call("sin", w * TIME),
        lambda: d.either_sign(digits(0.5 * size)) + size * call("cos", w * TIME),
        lambda: size * call("sin", w * TIME) * call("cos", digits(0.37 * w) * TIME),
        lambda: soft_start(d.either_sign(size), w),
        lambda: (d.either_sign(size) / t_end) * TIME,
        lambda: size * call("exp", digits(-3.0 / t_end) * TIME),
    ))()  # fmt: skip


def soft_start(size: float, w: float) -> Any:
    """What rises softly from zero; of which kind is told by a digit of its rate."""
    rate, turn = w * TIME, call("tanh", w * TIME)
    kinds = (
        size * (1.0 - call("cos", rate)),
        size * (1.0 - call("cos", rate)),
        size * (call("cos", digits(0.37 * w) * TIME) - call("cos", rate)),
        size * (1.0 - call("exp", -w * TIME)),
        size * turn * turn,
        size * turn * turn * turn,
        size * turn * turn * turn * turn,
    )
    return kinds[round(100 * w) % len(kinds)]


def corner_signal(d: Draw, size: float, t_end: float) -> Any:
    """A law over time with corners or jumps."""
    w, at = d.log(2.0, 25.0), digits(t_end * d.even(0.1, 0.9))
    later = digits(at + (t_end - at) * d.even(0.2, 0.9))
    wave = call("sin", w * TIME)
    return d.choice((
        lambda: size * call("sign", wave),
        lambda: either(size, at < TIME, 0.0),
        lambda: either(d.either_sign(size), at > TIME, digits(-0.7 * size)),
        lambda: either(digits(3 * size) * (TIME - at), at < TIME, 0.0),
        lambda: size * call("Abs", wave),
        lambda: size * call("Max", wave, d.even(-0.5, 0.5)),
        lambda: table((0.0, at, later, t_end), (0.0, size, -size, d.choice((0.0, size)))),
        lambda: table((0.0, at, later), (size, d.choice((0.0, -size)), digits(0.6 * size)), "step"),
        lambda: table((0.0, at, t_end), (0.0, size, digits(-0.5 * size)), "cubic"),
        lambda: table((0.0, digits(0.3 / w), digits(1.0 / w)), (size, -size, size), "linear", True),
        lambda: either(size, Node("<", (wave, d.even(-0.8, 0.8))), 0.0),
    ))()  # fmt: skip


def any_signal(d: Draw, size: float, t_end: float) -> Any:
    """Smooth or with corners."""
    return smooth_signal(d, size, t_end) if d.chance(0.6) else corner_signal(d, size, t_end)


def given_input(g: Growth, size: float) -> Node:
    """A new Input, fed by a table or a number."""
    name = g.name("u")
    fed: Any = g.d.either_sign(size)
    if g.d.chance(0.6):
        fed = table((0.0, digits(0.4 * g.t_end), g.t_end), (0.0, size, g.d.choice((-size, 0.0, size))))
    g.inputs.append((name, fed))
    return Node("input", (name, 0.0))


__all__ = ["BODIES", "Draw", "Growth", "any_signal", "corner_signal", "digits", "given_input", "smooth_signal"]
