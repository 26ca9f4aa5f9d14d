"""Derivatives of expressions by the rules of sympy, and with its results: sums, products, powers and chains. sympy asks
after each rule whether what it has found is provably zero, which takes most of its time; here only a 0 is one.

Knows nothing of what symbols stand for.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy as sp

from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import Where


@lru_cache(maxsize=10_000)
def derivative(expr: Any, x: Any) -> Any:
    """d expr/dx over a symbol."""
    expr = sp.sympify(expr)
    if expr == x:
        return sp.Integer(1)
    if x not in symbols_in(expr):
        return sp.Integer(0)
    if expr.is_Add:
        return expr.func(*(derivative(a, x) for a in expr.args))
    if expr.is_Mul:
        factors = expr.args
        slopes = [derivative(a, x) for a in factors]
        return sp.Add(*(sp.Mul(*factors[:i], s, *factors[i + 1 :]) for i, s in enumerate(slopes) if s != 0))
    if expr.is_Pow:
        by_base, by_exponent = derivative(expr.base, x), derivative(expr.exp, x)
        return expr * (by_exponent * sp.log(expr.base) + by_base * expr.exp / expr.base)
    if isinstance(expr, Where):
        return Where(expr.args[0], derivative(expr.args[1], x))
    if type(expr)._eval_derivative is sp.Function._eval_derivative:
        slopes = [derivative(a, x) for a in expr.args]
        return sp.Add(*(expr.fdiff(i) * s for i, s in enumerate(slopes, 1) if not s.is_zero))
    return sp.diff(expr, x)
