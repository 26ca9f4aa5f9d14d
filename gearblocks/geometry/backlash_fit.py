"""Least-squares fit of the dead zone max(abs(x) - 1, 0) sign(x) by an odd polynomial, which papers use in place of the
corners. Knows nothing of blocks.
"""

from __future__ import annotations

import functools
from fractions import Fraction

STEP = 100
"""Points of the fit per half gap."""


@functools.cache
def polynomial_fit(degree: int, interval: float = 2.0) -> tuple[float, ...]:
    """Coefficients of x, x^3, ..., x^degree that fit the dead zone of half gap 1 best.

    Plain least squares over the points k/100 with abs(k/100) <= interval; exact, rounded once. Degree 9 on +-2 gives
    0.0473 x - 0.3320 x^3 + 0.4704 x^5 - 0.1548 x^7 + 0.0163 x^9 to the digits shown.
    """
    powers = range(1, degree + 1, 2)
    points = range(1, int(Fraction(interval) * STEP) + 1)  # odd on both sides: half of them tells all
    # in whole numbers: x = k/100
    moments = {p: sum(k**p for k in points) for p in {a + b for a in powers for b in powers}}
    right = {p: sum(k**p * max(k - STEP, 0) for k in points) for p in powers}
    rows = [[Fraction(moments[a + b]) for b in powers] + [Fraction(right[a])] for a in powers]
    n = len(rows)
    for i in range(n):
        pivot = rows[i][i]
        rows[i] = [v / pivot for v in rows[i]]
        for j in range(n):
            if j != i:
                factor = rows[j][i]
                rows[j] = [v - factor * u for v, u in zip(rows[j], rows[i], strict=True)]
    return tuple(float(row[n] * Fraction(STEP) ** (p - 1)) for row, p in zip(rows, powers, strict=True))
