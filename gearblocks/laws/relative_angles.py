"""Relative coordinates in place of angles, without absolute angles that cancel.

Knows nothing of which coordinates a law has.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from gearblocks.laws.symbols import Pool

_ONE: Any = sp.Integer(1)


def in_coordinates(pool: Pool, expr: Any, replace: Mapping[Any, Any]) -> Any:
    """expr with angles replaced by what they are in coordinates.

    Sums that are linear in angles and coordinates are collected, their coefficients brought to lowest terms: otherwise
    absolute angles whose coefficients cancel would stay in the law, be integrated, and drown the deflection after many
    turns.
    """
    new = sp.sympify(expr).xreplace(replace)
    roles = {x: pool.roles[x].role for x in new.free_symbols}
    absolute = {x for x, role in roles.items() if role == "phi"}
    return _collected(new, absolute, absolute | {x for x, role in roles.items() if role == "coordinate"})


def _collected(expr: Any, absolute: set[Any], unknowns: set[Any]) -> Any:
    if not expr.free_symbols & absolute or expr.is_Symbol:
        return expr
    if not expr.is_Add:
        return expr.func(*(_collected(a, absolute, unknowns) for a in expr.args))
    total: dict[Any, list[Any]] = {}
    rest = []
    for term in expr.args:
        slopes = _slopes(term, unknowns)
        if slopes is None:
            rest.append(_collected(term, absolute, unknowns))
        else:
            rest.append(slopes.pop(_ONE, sp.Integer(0)))
            for x, c in slopes.items():
                total.setdefault(x, []).append(c)
    return sp.Add(*(x * sp.cancel(sp.Add(*c)) for x, c in total.items()), *rest)


def _slopes(expr: Any, unknowns: set[Any]) -> dict[Any, Any] | None:
    """Coefficients over the unknowns, with the rest under 1; None where it is not linear in them."""
    if expr in unknowns:
        return {expr: _ONE}
    if not expr.free_symbols & unknowns:
        return {_ONE: expr}
    if not (expr.is_Add or expr.is_Mul):
        return None
    parts = [_slopes(a, unknowns) for a in expr.args]
    if any(part is None for part in parts):
        return None
    if expr.is_Add:
        total: dict[Any, Any] = {}
        for part in parts:
            for x, c in (part or {}).items():
                total[x] = total.get(x, 0) + c
        return total
    moving = [i for i, a in enumerate(expr.args) if a.free_symbols & unknowns]
    if len(moving) > 1:
        return None
    factor = sp.Mul(*(a for i, a in enumerate(expr.args) if i != moving[0]))
    return {x: factor * c for x, c in (parts[moving[0]] or {}).items()}
