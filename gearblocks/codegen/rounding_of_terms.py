"""Sizes of time terms: sums of the sizes of their summands, of which rounding is a part.

A load that starts softly (1 - cos, 1 - exp, a difference of waves) is a small difference of large numbers: its rounding is
far above its own last bits, in steps that a small move in time does not show. To first order in the rounding of each sum.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from gearblocks.codegen.hoisting import HoistedTerm, Hoister
from gearblocks.laws.symbols import TIMED


def size_of_term(hoister: Hoister, item: HoistedTerm) -> Any | None:
    """The size of a time term in constants, inputs and time; None where it is its own absolute value."""
    expr = hoister.written_out(item.expr)
    return size_of(expr) if item.level == TIMED and _adds_up(expr) else None


def size_of(expr: Any) -> Any:
    """The size of an expression."""
    if not _adds_up(expr):
        return sp.Abs(expr)
    if expr.is_Pow:
        return sp.Abs(expr.exp) * sp.Abs(expr.base) ** (expr.exp - 1) * size_of(expr.base)
    return expr.func(*map(size_of, expr.args))


def _adds_up(expr: Any) -> bool:
    """Whether its value is that of a sum, or made of such by products and powers."""
    if expr.is_Pow:
        return bool(expr.exp.is_Number) and _adds_up(expr.base)
    return bool(expr.is_Add) or (bool(expr.is_Mul) and any(map(_adds_up, expr.args)))
