"""Common subexpressions of the expressions of one generated function: each is printed once and named.

The C compiler finds them itself, where it optimises, but reads every copy; derivatives of a law with tooth friction have
a hundred. Only whole subtrees are taken, as sympy orders them: the same operations in the same order, and the same bits.
What stands in a branch alone stays there. Knows nothing of statements and of where they stand.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy as sp

from gearblocks.laws.functions import EllipseLead

LEAST = 8
"""Nodes of a subtree that is worth a name; a function of anything is."""

_OPAQUE = (sp.Piecewise, EllipseLead)
"""Not looked into: branches of which one is computed, and what is printed in another form."""


class CommonTerms:
    """What expressions have in common, to be defined before the first of them that reads it."""

    def __init__(self, exprs: Iterable[Any]) -> None:
        self._repeated = {x for x, times in _counted(exprs).items() if times > 1 and _has_worth(x)}
        self._seen: set[Any] = set()

    def of(self, expr: Any) -> list[Any]:
        """Those of an expression that earlier calls have not told, inner ones first."""
        found: list[Any] = []
        if self._repeated:
            self._collect(expr, found)
        return found

    def _collect(self, expr: Any, found: list[Any]) -> None:
        if not expr.args or expr in self._seen:
            return
        self._seen.add(expr)
        if not isinstance(expr, _OPAQUE):
            for x in expr.args:
                self._collect(x, found)
        if expr in self._repeated:
            found.append(expr)


def _counted(exprs: Iterable[Any]) -> dict[Any, int]:
    """How often every subtree is printed if each is looked into once."""
    counts: dict[Any, int] = {}
    todo = [x for x in map(sp.sympify, exprs) if x.args]
    while todo:
        expr = todo.pop()
        counts[expr] = counts.get(expr, 0) + 1
        if counts[expr] == 1 and not isinstance(expr, _OPAQUE):
            todo += [x for x in expr.args if x.args]
    return counts


def _has_worth(expr: Any) -> bool:
    """Whether a subtree is a number that is worth a name, and printed as it stands: a quotient is one of products."""
    if isinstance(expr, sp.Pow) and expr.exp.could_extract_minus_sign():
        return False
    if isinstance(expr, sp.Function):
        return True
    return isinstance(expr, (sp.Add, sp.Mul, sp.Pow)) and _size(expr) >= LEAST


def _size(expr: Any) -> int:
    """Nodes, as far as LEAST."""
    todo, found = [expr], 0
    while todo and found < LEAST:
        found += 1
        todo += todo.pop().args
    return found
