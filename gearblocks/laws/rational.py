"""Exact ratios: rational numbers, whole where that suffices (these are fast), fractions elsewhere.

Knows nothing of what a ratio is of.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any, TypeAlias

import sympy as sp

from gearblocks.errors import ModelError

Exact: TypeAlias = "int | Fraction"


def exact(x: float | Fraction) -> Exact:
    """The exact value of a number: a whole number, or a fraction (of a float its binary value)."""
    fraction = Fraction(x)
    return fraction.numerator if fraction.denominator == 1 else fraction


def over(a: Exact, b: Exact) -> Exact:
    """a / b, exactly."""
    if b == 1:
        return a
    if b == -1:
        return -a
    return exact(Fraction(a) / Fraction(b))


def exact_value(expr: Any, values: Mapping[Any, Exact]) -> Exact:
    """The rational number that a coefficient is when every symbol in it has an exact value."""
    expr = sp.sympify(expr)
    if expr.is_Rational:
        return over(int(expr.p), int(expr.q))
    if expr.is_Float:
        return exact(float(expr))
    if expr.is_Symbol:
        return values[expr]
    parts = [exact_value(a, values) for a in expr.args]
    if expr.is_Add:
        return sum(parts)
    if expr.is_Mul:
        product: Exact = 1
        for p in parts:
            product *= p
        return product
    if expr.is_Pow and parts[1].denominator == 1:
        return exact(Fraction(parts[0]) ** int(parts[1]))
    raise ModelError(f"the ratio '{expr}' is no rational number of its parameters")
