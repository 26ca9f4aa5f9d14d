"""Switches of piecewise laws with frozen sides, and expression trees as functions with such switches.

While a phase of smooth motion is integrated every law runs on its frozen side; the values tell when a side ends.
Knows nothing of gearblocks.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from tests.random.expressions import Node


class NoEvidenceError(Exception):
    """The reference does not know, and says why."""


class Context:
    """What signals read: time, the values X, rates V and accelerations A of all rows, further states s, computed values aux;
    small: a speed that counts as none."""

    __slots__ = ("A", "V", "X", "aux", "s", "small", "t")

    def __init__(self) -> None:
        self.t = 0.0
        self.X: Any = ()
        self.V: Any = ()
        self.A: Any = ()
        self.s: Any = ()
        self.aux: list[float] = []
        self.small = 0.0


Signal = Callable[[Context], float]


class Switches:
    """value[i] >= 0 belongs to mode[i] = 1; a table has two values, the distances from the edges of its segment."""

    def __init__(self) -> None:
        self.value: list[float] = []
        self.mode: list[int] = []  # 1 or 0; of a table's lower edge: the segment; of its upper edge: None
        self.jumps: dict[int, int] = {}  # index of an edge -> index where its segment stands
        self.phases: list[tuple[int, float]] = []  # (row, factor) of angles that laws over angles read; row -1: time
        self.on_flip: dict[int, Callable[[], None]] = {}
        self.on_strike: list[Callable[[], None]] = []
        self.fresh = True

    def new(self) -> int:
        """A new switch."""
        self.value.append(1.0)
        self.mode.append(1)
        return len(self.value) - 1

    def __call__(self, i: int, value: float, at_zero: int = 1) -> int:
        """Notes the value; the frozen mode. at_zero: that of a value that begins at 0."""
        self.value[i] = value
        if self.fresh:
            self.mode[i] = 1 if value > 0 else at_zero if value == 0 else 0
        return self.mode[i]

    def margins(self) -> list[float]:
        """>= 0 while every mode is right."""
        return [v if (i in self.jumps or m) else -v for i, (v, m) in enumerate(zip(self.value, self.mode, strict=True))]

    def flip(self, i: int) -> None:
        """The side behind the value's zero."""
        if i in self.jumps:
            at = self.jumps[i]
            self.mode[at] += -1 if i == at else 1
        else:
            self.mode[i] = 1 - self.mode[i]
        if i in self.on_flip:
            self.on_flip[i]()


class Table1:
    """A table with frozen segments: linear, cubic (not-a-knot, or periodic) or step; outside held, repeated, or going on."""

    def __init__(
        self, switches: Switches, x: tuple[float, ...], y: tuple[float, ...], kind: str, beyond: bool | str
    ) -> None:
        periodic = beyond is True
        self.sw, self.x, self.y, self.kind, self.periodic = switches, list(x), list(y), kind, periodic
        self.goes_on = beyond == "linear"
        self.low, self.high = switches.new(), switches.new()
        switches.jumps[self.low] = switches.jumps[self.high] = self.low
        self.c: Any = None
        if kind == "cubic":
            self.c = CubicSpline(x, y, bc_type="periodic" if periodic else "not-a-knot").c.T.tolist()

    def locate(self, x: float, weight: float = 1.0) -> tuple[int, float, float]:
        """Segment, its left end, and x; notes the distances from its edges, times a weight > 0."""
        sw, n = self.sw, len(self.x) - 1
        period = self.x[-1] - self.x[0]
        if sw.fresh:
            turns = math.floor((x - self.x[0]) / period) if self.periodic else 0
            sw.mode[self.low] = bisect_right(self.x, x - turns * period) - 1 + turns * n
        segment = sw.mode[self.low]
        if self.periodic:
            turns, i = divmod(segment, n)
            left, right = self.x[i] + turns * period, self.x[i + 1] + turns * period
        else:
            i = segment
            left = self.x[i] if i >= 0 else -math.inf
            right = self.x[i + 1] if i < n else math.inf
        sw.value[self.low] = (x - left) * weight if left > -math.inf else 1.0
        sw.value[self.high] = (right - x) * weight if right < math.inf else 1.0
        return i, left, x

    def __call__(self, x: float, weight: float = 1.0) -> float:
        i, left, x = self.locate(x, weight)
        if self.goes_on:
            i = min(max(i, 0), len(self.x) - 2)
            left = self.x[i]
        if i < 0:
            return self.y[0]
        if i >= len(self.x) - 1 or self.kind == "step":
            return self.y[i]
        d = x - left
        if self.c is not None:
            a, b, c, e = self.c[i]
            return float(e + d * (c + d * (b + d * a)))
        return self.y[i] + d * (self.y[i + 1] - self.y[i]) / (self.x[i + 1] - self.x[i])


class Table2:
    """A bilinear table, held at its edges."""

    def __init__(self, switches: Switches, fields: dict[str, Any]) -> None:
        if fields.get("kind", "linear") != "linear":
            raise NoEvidenceError("a cubic map")
        self.x, self.y, self.z = fields["x"], fields["y"], fields["z"]
        self.axes = [Table1(switches, a, a, "linear", False) for a in (self.x, self.y)]

    def __call__(self, x: float, y: float) -> float:
        places = []
        for axis, points, at in zip(self.axes, (self.x, self.y), (x, y), strict=True):
            i, _, _ = axis.locate(at)
            if i < 0:
                places.append((0, 0.0))
            elif i >= len(points) - 1:
                places.append((len(points) - 2, 1.0))
            else:
                places.append((i, (at - points[i]) / (points[i + 1] - points[i])))
        (i, a), (j, b) = places
        z = self.z
        low = z[i][j] * (1 - b) + z[i][j + 1] * b
        high = z[i + 1][j] * (1 - b) + z[i + 1][j + 1] * b
        return float(low * (1 - a) + high * a)


FUNCTIONS = {
    "sin": math.sin, "cos": math.cos, "exp": math.exp, "tanh": math.tanh, "atan": math.atan, "sqrt": math.sqrt,
}  # fmt: skip


class Compiler:
    """Expression trees as functions of a Context."""

    def __init__(self, switches: Switches, senses: Callable[[str], Signal], inputs: dict[str, Any]) -> None:
        self.sw, self.senses, self.inputs = switches, senses, inputs

    def __call__(self, x: Any, local: Signal | None = None) -> Signal:
        """local: what the twist, or a table without an argument inside a law, goes over; None: time."""
        if not isinstance(x, Node):
            number = float(x)
            return lambda c: number
        if x.op == "time":
            return lambda c: c.t
        if x.op in ("twist", "slip", "distance"):
            assert local is not None
            return local
        if x.op == "sense":
            return self.senses(x.args[0])
        if x.op == "input":
            return self(self.inputs[x.args[0]])
        if x.op == "parameter":
            return self(x.args[1])
        if x.op == "table":
            return self._table(x, local)
        if x.op in ("sin", "cos"):
            self._phase(x.args[0])
        return self._operation(x.op, [self(a, local) for a in x.args])

    def _table(self, x: Node, local: Signal | None) -> Signal:
        xs, ys, kind, periodic, over = x.args
        found = Table1(self.sw, xs, ys, kind, periodic)
        at = (local or (lambda c: c.t)) if over is None else self(over, local)
        if over is not None:
            self._phase(over)
        return lambda c: found(at(c))

    def _phase(self, x: Any) -> None:
        """Notes how fast the argument of a wave runs, for the sampling of events."""
        factor = 1.0
        while isinstance(x, Node) and x.op == "*" and not isinstance(x.args[0], Node):
            factor, x = factor * x.args[0], x.args[1]
        if isinstance(x, Node) and x.op == "time":
            self.sw.phases.append((-1, abs(factor)))
        elif isinstance(x, Node) and x.op == "sense" and x.args[0].endswith(".phi"):
            row = getattr(self.senses(x.args[0]), "row", None)
            if row is not None:
                self.sw.phases.append((row, abs(factor)))

    def _operation(self, op: str, a: list[Signal]) -> Signal:
        sw = self.sw
        if op == "+":
            return lambda c: a[0](c) + a[1](c)
        if op == "*":
            return lambda c: a[0](c) * a[1](c)
        if op == "/":
            return lambda c: a[0](c) / a[1](c)
        if op in FUNCTIONS:
            f = FUNCTIONS[op]
            return lambda c: f(a[0](c))
        if op == "both":
            return lambda c: bool(a[0](c)) & bool(a[1](c))
        if op == "one":
            return lambda c: bool(a[0](c)) | bool(a[1](c))
        if op == "not":
            return lambda c: not a[0](c)
        i = sw.new() if op not in ("either", "cases") else -1
        if op == "<":
            return lambda c: sw(i, a[1](c) - a[0](c), at_zero=0)
        if op == ">":
            return lambda c: sw(i, a[0](c) - a[1](c), at_zero=0)
        if op in ("either", "cases"):

            def choose(c: Context) -> float:
                found = [x(c) for x in a]  # all of them, so that every switch is fresh
                return next((v for v, holds in zip(found[:-1:2], found[1::2], strict=True) if holds), found[-1])

            return choose
        if op == "Heaviside":
            return lambda c: 1.0 if sw(i, a[0](c)) else 0.0
        if op == "Abs":
            return lambda c: (lambda v: v if sw(i, v) else -v)(a[0](c))
        if op == "sign":
            return lambda c: 1.0 if sw(i, a[0](c)) else -1.0
        if op in ("Min", "Max"):
            largest = op == "Max"

            def extreme(c: Context) -> float:
                one, other = a[0](c), a[1](c)
                return one if bool(sw(i, one - other)) == largest else other

            return extreme
        raise NoEvidenceError(f"the function {op}")


def ellipse(
    e: float, order: int
) -> tuple[Callable[[float], float], Callable[[float], float], Callable[[float], float]]:
    """F, F' and F'' of a pair of elliptic gears: tan(n F/2) = K tan(n phi/2), K = (1 + e)/(1 - e)."""
    K = (1 + e) / (1 - e)

    def F(phi: float) -> float:
        s, c = math.sin(order * phi / 2), math.cos(order * phi / 2)
        return phi + 2 / order * math.atan2((K - 1) * s * c, c * c + K * s * s)

    def m(phi: float) -> float:
        s, c = math.sin(order * phi / 2), math.cos(order * phi / 2)
        return K / (c * c + K * K * s * s)

    def dm(phi: float) -> float:
        s, c = math.sin(order * phi / 2), math.cos(order * phi / 2)
        return -K * (K * K - 1) * order * s * c / (c * c + K * K * s * s) ** 2

    return F, m, dm


def is_zero(x: Any) -> bool:
    """Whether an array vanishes but for rounding."""
    return bool(np.abs(x).max(initial=0.0) < 1e-10)
