"""The largest and the least of many quantities as sympy nodes that are made in linear time.

sympy asks each pair of arguments which is larger, each time that a node is made anew, and nested ones all the pairs again.
Few arguments are left to sympy; of many only numbers are looked at. Imported where sympy is in use. Knows nothing of signals.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import sympy as sp
from sympy.core.sorting import ordered

_FEW = 4
"""Arguments that sympy may compare with each other."""


class _OfMany:
    """What the two have in common."""

    __slots__ = ()

    def __new__(cls, *args: Any, **_options: Any) -> Any:
        return extremum(cls.__name__, args)


class Max(_OfMany, sp.Max):  # type: ignore[misc]  # sympy carries no types
    """The largest of many."""

    __slots__ = ()


class Min(_OfMany, sp.Min):  # type: ignore[misc]  # sympy carries no types
    """The least of many."""

    __slots__ = ()


_KINDS = {"Max": (sp.Max, Max), "Min": (sp.Min, Min)}


def extremum(name: str, args: Iterable[Any]) -> Any:
    """The "Max" or "Min" of the arguments; those that are of its kind themselves give theirs."""
    plain, of_many = _KINDS[name]
    flat: set[Any] = set()
    for a in map(sp.sympify, args):
        flat |= set(a.args) if isinstance(a, plain) else {a}
    numbers = {a for a in flat if a.is_Number}
    flat = (flat - numbers) | ({plain(*numbers)} if numbers else set())
    if len(flat) <= _FEW:
        return plain(*flat)
    made = sp.Expr.__new__(of_many, *ordered(flat))
    made._argset = frozenset(flat)
    return made
