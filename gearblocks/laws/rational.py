"""Exact ratios: whole numbers where they suffice (they are fast), fractions elsewhere."""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

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
