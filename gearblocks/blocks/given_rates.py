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
_PIECES = 100
_ALLOWED = 2e-3  # of the largest change: corners and jumps inside a piece


def rate_problems(name: str, value: Any, rate_name: str, rate: Any) -> Iterator[str]:
    """One sentence where `rate` is not the time derivative of `value`."""
    one, other = as_expr(value), as_expr(rate)
    known = {"time", "parameter", "table"}
    if not all(leaf.op in known and _over_time(leaf) for e in (one, other) for leaf in e.leaves()):
        return
    for end in _SPANS:
        joints = np.linspace(0.0, end, _PIECES + 1)
        x = np.array([_at(one, t) for t in joints])
        half = end / _PIECES / 2
        inner = ((joints[:-1] + joints[1:]) / 2)[:, None] + half * np.array([-1.0, 1.0]) / math.sqrt(3.0)
        steps = half * np.array([_at(other, t) for t in inner.ravel()]).reshape(inner.shape).sum(axis=1)
        found = x[0] + np.concatenate([[0.0], np.cumsum(steps)])
        off, size = np.abs(found - x), max(np.ptp(x), np.ptp(found))
        worst = int(np.argmax(off))
        if not off[worst] <= _ALLOWED * size:
            yield (
                f"{rate_name} is not the rate of {name}: up to t = {joints[worst]:.4g} s {name} changes by "
                f"{x[worst] - x[0]:.6g}, and the integral of {rate_name} is {found[worst] - x[0]:.6g}; leave w and alpha out, "
                "which follow from phi, or take Acceleration(alpha=...) where alpha is meant; what is measured comes as Inputs"
            )
            return


def _over_time(leaf: Expr) -> bool:
    return leaf.op != "table" or leaf.args[1].op == "time"


def _at(value: Expr, t: float) -> float:
    def leaf(x: Expr) -> float:
        if x.op == "time":
            return t
        return float(x.args[0].si) if x.op == "parameter" else float(x.args[0].values(t))

    return float(evaluate(value, leaf))
