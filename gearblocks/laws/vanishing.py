"""Zero test of expressions of a law: f(x, m) = 0 for all real x and for every value that each mode m can take.

Over the reals f is asked at a few points (Schwartz 1980, Zippel 1979), which expanding it would take far longer than. Over
the modes nothing is sampled: with S the sets of modes that stand in one product of f, f is a sum of f_S(m_S), and it is zero
everywhere if it is where the modes of one S take all their values and all others a fixed one. Where these are too many, or no
point lies in what f is defined for, it counts as not zero; so does what is zero by a relation between exponentials of
different arguments alone. Knows nothing of which values modes take together in a run.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from math import nan, prod
from random import Random
from typing import Any

import numpy as np
import sympy as sp

from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import Table2At, TableAt, Where
from gearblocks.laws.law import Law

_SATURATING = (sp.exp, sp.tanh, sp.coth, sp.sinh, sp.cosh, sp.erf, sp.erfc)

_MOST = 4096  # combinations of modes that are asked
_POINTS, _TRIES = 4, 10  # real points for each, and how often they are drawn
_ROUNDING = 1e-12  # of the largest of the terms that cancel
_FUNCTIONS = {sp.sin: np.sin, sp.cos: np.cos, sp.tan: np.tan, sp.exp: np.exp, sp.atan: np.arctan}

Sets = frozenset[frozenset[Any]]


def vanishes(expr: Any, law: Law) -> bool:
    """Whether an expression of the law is zero whatever its modes, tables, parameters and coordinates are; False also where
    that is not found out."""
    expr = sp.sympify(expr)
    if expr == 0 or not expr.free_symbols:
        return bool(expr == 0)
    expr, values = _with_modes_as_symbols(_with_moderate_arguments(expr), law)
    combinations = _combinations(expr, values)
    return combinations is not None and _is_zero_in(expr, list(values), combinations)


def _with_moderate_arguments(expr: Any) -> Any:
    """The expression with the arguments of exponentials and their kin as independent real symbols: exp(-((t - 17)/0.01)^2) is
    exactly 0 in floating point at every point that is drawn, and 1 + tanh(t - 40) too."""
    arguments: dict[Any, Any] = {}
    calls: dict[Any, Any] = {}
    for call in sorted((x for x in expr.atoms(*_SATURATING) if x.free_symbols), key=str):
        (x,) = call.args
        sign = -1 if x.could_extract_minus_sign() else 1
        symbol = arguments.setdefault(sp.expand(sign * x), sp.Symbol(f"argument {len(arguments)}", real=True))
        calls[call] = call.func(sign * symbol)
    return expr.xreplace(calls)


# -- modes ------------------------------------------------------------------------------------------------------------


def _with_modes_as_symbols(expr: Any, law: Law) -> tuple[Any, dict[Any, tuple[float, ...]]]:
    """The expression with tables and whole numbers as independent real symbols and conditions on constants as modes, and the
    values of each mode in it."""
    free = sorted(expr.atoms(TableAt, Table2At, sp.floor), key=str)
    conditions = sorted(expr.atoms(sp.Heaviside), key=str)
    new = {x: sp.Symbol(f"value {i}", real=True) for i, x in enumerate(free)}
    constant = {x: sp.Symbol(f"condition {i}", real=True) for i, x in enumerate(conditions)}
    expr = expr.xreplace({**new, **constant})
    values: dict[Any, tuple[float, ...]] = dict.fromkeys(constant.values(), (1.0, 0.0))
    for x in expr.free_symbols & law.pool.roles.keys():
        if (found := _values(law, x)) is not None:
            values[x] = found
    return expr, {x: values[x] for x in sorted(values, key=str) if x in expr.free_symbols}


def _values(law: Law, symbol: Any) -> tuple[float, ...] | None:
    """The values that a symbol takes if it is a mode; None for a real one, the number of a segment of a table among them."""
    meaning = law.pool.roles[symbol]
    if meaning.role == "direction":
        return (1.0, 0.0, -1.0)
    if meaning.role == "stuck":
        return (0.0, 1.0)
    if meaning.role != "mode":
        return None
    switch = law.switches[meaning.of.number]
    if switch.table is not None:
        return None
    return (1.0, 0.0) if switch.is_sign else (1.0, 0.0, -1.0)


def _combinations(expr: Any, values: Mapping[Any, tuple[float, ...]]) -> list[tuple[float, ...]] | None:
    """Values of all modes that have to be asked; None where these are too many."""
    sets = _products(expr, values.keys(), {})
    if sets is None or sum(prod(len(values[x]) for x in s) for s in sets) > _MOST:
        return None
    found: dict[tuple[float, ...], None] = {}
    for s in sets:
        choices = (choices if x in s else choices[:1] for x, choices in values.items())
        found.update(dict.fromkeys(product(*choices)))
    return list(found)


def _products(expr: Any, modes: Any, known: dict[Any, Sets | None]) -> Sets | None:
    """The largest sets of modes that stand in one product of the expression written out; None where these are too many."""
    if expr in known:
        return known[expr]
    inside = frozenset(symbols_in(expr) & modes)
    found: Sets | None = frozenset([inside])
    if len(inside) > 1 and expr.is_Add:
        parts = [_products(a, modes, known) for a in expr.args]
        found = None if None in parts else _largest({s for p in parts if p is not None for s in p})
    elif len(inside) > 1 and (expr.is_Mul or (expr.is_Pow and expr.exp.is_Integer and expr.exp > 0)):
        factors = list(expr.args) if expr.is_Mul else [expr.base] * int(min(expr.exp, len(inside)))
        for factor in factors:
            part = _products(factor, modes, known)
            if found is None or part is None or len(found) * len(part) > _MOST:
                found = None
                break
            found = _largest({a | b for a in (found if factor is not factors[0] else [frozenset[Any]()]) for b in part})
    known[expr] = found
    return found


def _largest(sets: set[frozenset[Any]]) -> Sets:
    """The sets that lie in no other one."""
    kept: list[frozenset[Any]] = []
    for s in sorted(sets, key=lambda s: (-len(s), sorted(map(str, s)))):
        if not any(s <= other for other in kept):
            kept.append(s)
    return frozenset(kept)


# -- numbers ----------------------------------------------------------------------------------------------------------


def _is_zero_in(expr: Any, modes: list[Any], combinations: list[tuple[float, ...]]) -> bool:
    """Whether the expression is zero in these combinations of modes, asked at a few points where it is defined."""
    symbols = sorted(expr.free_symbols - set(modes), key=lambda x: str(x.name))
    random, left = Random(20), combinations
    for _ in range(_TRIES):
        drawn = [[random.uniform(0.2, 1.2) for _ in range(_POINTS)] for _ in symbols]
        known = {x: np.tile(column, len(left)) for x, column in zip(symbols, drawn, strict=True)}
        known |= {x: np.repeat(column, _POINTS) for x, column in zip(modes, np.array(left).T, strict=True)}
        with np.errstate(all="ignore"):
            terms = [np.broadcast_to(_number(term, known), len(left) * _POINTS) for term in sp.Add.make_args(expr)]
            rest, size = np.abs(sum(terms)), np.max(np.abs(terms), axis=0)
            if np.any(rest > _ROUNDING * size):
                return False
        undefined = np.isnan(np.asarray(rest)).reshape(len(left), _POINTS).all(axis=1)
        left = [modes_there for modes_there, nowhere in zip(left, undefined, strict=True) if nowhere]
        if not left:
            return True
    whole = ({x: sp.Integer(int(v)) for x, v in zip(modes, there, strict=True)} for there in left)
    return all(sp.expand(expr.xreplace(there)) == 0 for there in whole)


def _number(expr: Any, known: dict[Any, Any]) -> Any:
    """Values of an expression at all points, NaN where it is not defined; `known` grows by every part that was computed."""
    if expr in known:
        return known[expr]
    parts = [_number(a, known) for a in expr.args]
    if expr.is_Number or expr.is_NumberSymbol:
        value: Any = np.float64(expr)
    elif expr.is_Add:
        value = sum(parts)
    elif expr.is_Mul:
        value = prod(parts)
    elif expr.is_Pow:
        value = np.float64(parts[0]) ** parts[1]
    elif type(expr) in _FUNCTIONS:
        value = _FUNCTIONS[type(expr)](*parts)
    elif isinstance(expr, Where):
        value = np.where(np.greater(parts[0], 0.5), parts[1], 0.0)
    else:
        points, back = np.unique(
            np.stack(np.broadcast_arrays(*parts), -1).reshape(-1, len(parts)), axis=0, return_inverse=True
        )
        value = np.array([_value(expr.func, point) for point in points])[back.reshape(-1)]
    known[expr] = value
    return value


def _value(function: Any, point: Any) -> float:
    """Value of a function of sympy's; NaN where it has none that is real."""
    try:
        return float(function(*map(sp.Float, point)))
    except (TypeError, ValueError, ArithmeticError):
        return nan
