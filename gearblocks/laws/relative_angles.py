"""Relative coordinates in place of angles, without absolute angles that cancel.

Knows nothing of which coordinates a law has.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import sympy as sp

from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.symbols import Pool

_ONE: Any = sp.Integer(1)


def in_coordinates(pool: Pool, expr: Any, replace: Mapping[Any, Any]) -> Any:
    """expr with angles replaced by what they are in coordinates.

    Sums that are linear in angles and coordinates are collected, their coefficients brought to lowest terms: otherwise
    absolute angles whose coefficients cancel would stay in the law, be integrated, and drown the deflection after many
    turns.
    """
    new = sp.sympify(expr).xreplace(replace)
    roles = {x: pool.roles[x].role for x in symbols_in(new)}
    absolute = {x for x, role in roles.items() if role == "phi"}
    return _collected(new, absolute, absolute | {x for x, role in roles.items() if role == "coordinate"})


def _collected(expr: Any, absolute: set[Any], unknowns: set[Any]) -> Any:
    if not symbols_in(expr) & absolute or expr.is_Symbol:
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
    return sp.Add(*(x * _lowest_terms(sp.Add(*c)) for x, c in total.items()), *rest)


@lru_cache(maxsize=1000)
def _lowest_terms(coefficient: Any) -> Any:
    """A coefficient in lowest terms, which a product of numbers and powers of symbols is as it stands."""
    powers = (a.as_base_exp() for a in sp.Mul.make_args(coefficient))
    if all(base.is_Rational or (base.is_Symbol and exponent.is_Integer) for base, exponent in powers):
        return coefficient
    return sp.cancel(coefficient)


def _slopes(expr: Any, unknowns: set[Any]) -> dict[Any, Any] | None:
    """Coefficients over the unknowns, with the rest under 1; None where it is not linear in them."""
    if expr in unknowns:
        return {expr: _ONE}
    if not symbols_in(expr) & unknowns:
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
    moving = [i for i, a in enumerate(expr.args) if symbols_in(a) & unknowns]
    if len(moving) > 1:
        return None
    factor = sp.Mul(*(a for i, a in enumerate(expr.args) if i != moving[0]))
    return {x: factor * c for x, c in (parts[moving[0]] or {}).items()}
