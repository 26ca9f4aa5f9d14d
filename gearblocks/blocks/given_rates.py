"""Agreement of a quantity over time with a rate that is given beside it: x(T) - x(0) = integral of the rate.

Looked at where both are known before a run: expressions of time, numbers, Parameters and Tables over time. Knows nothing of
what they are the angle or the speed of.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from gearblocks.language.expression import Expr, as_expr, evaluate

_SPANS = (0.1, 1.0, 10.0)  # s
_PIECES, _MOST = 100, 3200  # of a span: at first, and at most
_ALLOWED = 2e-3  # of the largest change: corners and jumps inside a piece
_SURE = 0.2 * _ALLOWED  # between an integral and that of twice as many pieces: vibrations inside a piece are not seen


def rate_problems(name: str, value: Any, rate_name: str, rate: Any) -> Iterator[str]:
    """One sentence where `rate` is not the time derivative of `value`."""
    one, other = as_expr(value), as_expr(rate)
    known = {"time", "parameter", "table"}
    if not all(leaf.op in known and _over_time(leaf) for e in (one, other) for leaf in e.leaves()):
        return
    for end in _SPANS:
        pieces, unsure = _PIECES, True
        joints, found = _integral(other, end, pieces)
        while unsure and pieces < _MOST:
            pieces *= 2
            rough, (joints, found) = found, _integral(other, end, pieces)
            unsure = float(np.abs(found[::2] - rough).max()) > _SURE * np.ptp(found)
        if unsure:
            continue
        x = np.array([_at(one, t) for t in joints])
        found += x[0]
        off, size = np.abs(found - x), max(np.ptp(x), np.ptp(found))
        worst = int(np.argmax(off))
        if not off[worst] <= _ALLOWED * size:
            yield (
                f"{rate_name} is not the rate of {name}: up to t = {joints[worst]:.4g} s {name} changes by "
                f"{x[worst] - x[0]:.6g}, and the integral of {rate_name} is {found[worst] - x[0]:.6g}; leave w and alpha out, "
                "which follow from phi, or take Acceleration(alpha=...) where alpha is meant; what is measured comes as Inputs"
            )
            return


def _integral(rate: Expr, end: float, pieces: int) -> tuple[Any, Any]:
    """Joints of so many pieces, and the integral up to each: two points of Gauss a piece."""
    joints, half = np.linspace(0.0, end, pieces + 1), end / pieces / 2
    inner = ((joints[:-1] + joints[1:]) / 2)[:, None] + half * np.array([-1.0, 1.0]) / math.sqrt(3.0)
    steps = half * np.array([_at(rate, t) for t in inner.ravel()]).reshape(inner.shape).sum(axis=1)
    return joints, np.concatenate([[0.0], np.cumsum(steps)])


def _over_time(leaf: Expr) -> bool:
    return leaf.op != "table" or leaf.args[1].op == "time"


def _at(value: Expr, t: float) -> float:
    def leaf(x: Expr) -> float:
        if x.op == "time":
            return t
        return float(x.args[0].si) if x.op == "parameter" else float(x.args[0].values(t))

    return float(evaluate(value, leaf))
