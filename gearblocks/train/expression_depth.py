"""Depth of nested expressions: the longest way from a field to a leaf, cases of a Piecewise counted one after the other.

What is made of an expression recurses at every level, as sympy does. Knows nothing of why that failed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from gearblocks.errors import ModelError
from gearblocks.language.expression import Expr
from gearblocks.train.graph import Component
from gearblocks.train.values import numbers_of

_SHALLOW = 50
"""Levels below which an expression is not why a recursion failed."""


def depth(expression: Expr) -> int:
    """Levels of an expression: 1 for a leaf."""
    deepest, open_ones = 0, [(expression, 1)]
    while open_ones:
        e, level = open_ones.pop()
        deepest = max(deepest, level)
        cases = e.op == "Piecewise"
        open_ones += [(a, level + 1 + (i // 2 if cases else 0)) for i, a in enumerate(e.args) if isinstance(a, Expr)]
    return deepest


@contextmanager
def refused_where_too_deep(components: Sequence[Component]) -> Iterator[None]:
    """ModelError that names the deepest field of all, where what is done with the components recurses too far."""
    try:
        yield
    except RecursionError:
        levels, path = max(_depths(components), default=(0, ""))
        if levels < _SHALLOW:
            raise
        raise ModelError(
            f"{path} is an expression of {levels} levels, one inside the other, deeper than Python can follow: give cases in a "
            "row as gb.Table(x, y, kind='step') over what their conditions read, or parts of it as torques of their own"
        ) from None


def _depths(components: Sequence[Component]) -> Iterator[tuple[int, str]]:
    for c in components:
        for path, value, _ in numbers_of(c.block, f"{c.path}."):
            if isinstance(value, Expr):
                yield depth(value), path
