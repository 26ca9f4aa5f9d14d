"""Least-squares fit of the dead zone max(abs(x) - 1, 0) sign(x) by an odd polynomial, which papers use in place of the
corners. Knows nothing of blocks.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from fractions import Fraction
from itertools import zip_longest

STEP = 100
"""Points of the fit per half gap."""


@functools.cache
def polynomial_fit(degree: int, interval: float = 2.0) -> tuple[float, ...]:
    """Coefficients of x, x^3, ..., x^degree that fit the dead zone of half gap 1 best.

    Plain least squares over the points k/100 with abs(k/100) <= interval; exact, rounded once. Degree 9 on +-2 gives
    0.0473 x - 0.3320 x^3 + 0.4704 x^5 - 0.1548 x^7 + 0.0163 x^9 to the digits shown.

    The fit is the sum of <f, p> / <p, p> p over polynomials that are orthogonal on the points, by their recurrence
    p_(j+1) = (x^2 - a) p_j - b p_(j-1) with a = <x^2 p_j, p_j> / <p_j, p_j>, b = <p_j, p_j> / <p_(j-1), p_(j-1)>
    (Forsythe 1957, J. SIAM 5(2), 74-88).
    """
    n = (degree + 1) // 2
    points = range(1, int(Fraction(interval) * STEP) + 1)  # odd on both sides: half of them tells all
    # in whole numbers: x = k/100; a polynomial is the list of its factors of k, k^3, k^5, ...
    moments = [sum(k ** (2 * i + 2) for k in points) for i in range(2 * n)]
    zone = [sum(k ** (2 * i + 1) * max(k - STEP, 0) for k in points) for i in range(n)]
    fit = [Fraction(0)] * n
    p, before, size_before = [Fraction(1)], [Fraction(0)], Fraction(1)
    for _ in range(n):
        square, size = [Fraction(0), *p], _product(p, p, moments)
        share = sum((c * z for c, z in zip(p, zone, strict=False)), Fraction(0)) / size
        fit = [c + share * d for c, d in zip_longest(fit, p, fillvalue=Fraction(0))]
        a, b = _product(square, p, moments) / size, size / size_before
        terms = zip_longest(square, p, before, fillvalue=Fraction(0))
        p, before, size_before = [s - a * c - b * d for s, c, d in terms], p, size
    return tuple(float(c * Fraction(STEP) ** (2 * i)) for i, c in enumerate(fit))


def _product(p: Sequence[Fraction], q: Sequence[Fraction], moments: Sequence[int]) -> Fraction:
    """<p, q>: the sum of p q over the points."""
    return sum((a * b * moments[i + j] for i, a in enumerate(p) for j, b in enumerate(q)), Fraction(0))
