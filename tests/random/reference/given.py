"""Motions that are given by accelerations or behind filters, and pulses, written anew from the catalogue.

speed' = alpha;   x' = f (w - x);   x'' = f^2 (u - x) - 2 d f x' (critical d = 1, Butterworth d = sqrt(1/2)), and Bessel's
x'' = f (f (u - x) - 1.3617 x')/0.6180, as further states that a tie makes a body follow.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from tests.random.description import Part, Train
from tests.random.expressions import Node, rewrite
from tests.random.reference.switches import Context
from tests.random.reference.system import System, Tie

SECOND = {
    "critical": (1.0, 2.0),
    "butterworth": (1.0, math.sqrt(2.0)),
    "bessel": (0.6180339887498948, 1.3616541287161306),
}
"""a x'' = f^2 (u - x) - b f x'."""


def written(train: Train) -> Train:
    """The train with its pulses and trapezoids as tables over time."""
    change = lambda x: _table(x, train.t_end) if isinstance(x, Node) and x.op in ("pulse", "trapezoid") else x  # noqa: E731
    parts = (p.changed(**{n: rewrite(v, change) for n, v in p.fields}) for p in train.parts)
    return replace(train, parts=tuple(parts))


def _table(x: Node, t_end: float) -> Node:
    size, fields = x.args[0], dict(x.args[1])
    period, start, offset, count = (
        fields.get(n, v) for n, v in (("period", 0.0), ("start", 0.0), ("offset", 0.0), ("count", None))
    )
    edges: list[tuple[float, float]] = [(min(0.0, start) - period, offset)]
    n = 0
    while (count is None or n < count) and start + n * period <= t_end:
        t = start + n * period
        if x.op == "pulse":
            edges += [(t, offset + size), (t + fields["duty"] * period, offset)]
        else:
            top = t + fields["rising"], t + fields["rising"] + fields["width"]
            edges += [
                (t, offset),
                *((at, offset + size) for at in dict.fromkeys(top)),
                (top[1] + fields["falling"], offset),
            ]
        n += 1
    found: dict[float, float] = dict(edges)
    return Node(
        "table", (tuple(found), tuple(found.values()), "step" if x.op == "pulse" else "linear", False, Node("time"))
    )


def follows_states(p: Part) -> bool:
    """Whether a motion is given by what is integrated."""
    return p.block == "Acceleration" or p.field("filter") is not None


def motion(s: System, p: Part) -> None:
    """The motion of a node that states tell."""
    node = p.node("flange")
    row = s.node(node)
    s.J[s.index[node]] += 1.0  # any: its tie gives what it needs
    if p.block == "Acceleration":
        _tie(s, row, (s.state(p.field("w0", 0.0)),), s.compile(p.field("alpha")))
        return
    turned = p.block == "Angle"
    u, f = s.compile(p.field("phi" if turned else "w")), p.field("filter")
    s.context.t = 0.0
    x = s.state(u(s.context))
    kind = p.field("filter_type", "critical" if turned else "first order")
    if kind == "first order":
        _tie(s, row, (x,), lambda c: f * (u(c) - c.s[x]))
        return
    a, b = SECOND[kind]
    v = s.state()
    rate = lambda c: (f * f * (u(c) - c.s[x]) - b * f * c.s[v]) / a  # noqa: E731
    if turned:
        _tie(s, row, (v,), rate, x)
        return
    s.laws.append(lambda c, out: out.__setitem__(-1 - v, rate(c)))
    s.laws.append(lambda c, out: out.__setitem__(-1 - x, c.s[v]))
    s.nonlinear.append(Tie(lambda q, w, c: (row @ s.N, c.s[x], c.s[v]), starts=(row, lambda c: 0.0)))


def _tie(s: System, row: Any, states: tuple[int], rate: Any, angle: int | None = None) -> None:
    """The speed of a row is the first state, whose rate is its acceleration; angle: the state of its angle."""
    (k,) = states

    def law(c: Context, out: list[float]) -> None:
        out[-1 - k] = rate(c)
        if angle is not None:
            out[-1 - angle] = c.s[k]

    s.laws.append(law)
    start = (lambda c: 0.0) if angle is None else (lambda c: s.start[angle])
    s.nonlinear.append(Tie(lambda q, v, c: (row @ s.N, c.s[k], rate(c)), starts=(row, start)))


def begin(s: System) -> None:
    """States as they begin, for start values that follow from them."""
    s.context.s = np.array(s.start)
