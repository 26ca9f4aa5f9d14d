"""Contact damping chi of Hunt and Crossley (1975) from the coefficient of restitution e. Knows nothing of blocks."""

from __future__ import annotations

from math import isnan, log1p, nan


def restitution_damping(e: float) -> float:
    """a = chi v0 of a force k x^n (1 + chi x') that throws a body back with e times its approach speed v0.

    The exact condition a (1 + e) = ln((1 + a)/(1 - e a)), whatever n: the integrals of v/(1 + chi v) from v0 to 0 and from
    0 to -e v0 are opposite (Hunt and Crossley 1975, J. Appl. Mech. 42, 440-445, give a = 3 (1 - e)/2 for e near 1).
    0 < e <= 1; NaN elsewhere. Solved to about 1e-8 next to e = 1, else to rounding.
    """
    if isnan(e) or not 0.0 < e <= 1.0:
        return nan
    if 1.0 - e < 1e-4:
        return 1.5 * (1.0 - e * e) / (1.0 + e * e * e)
    low, high = 0.0, 1.0  # of u = e a; the condition's left side less its right one falls through zero once
    for _ in range(200):
        u = 0.5 * (low + high)
        if u in (low, high):
            break
        if u * (1.0 + e) / e - log1p(u / e) + log1p(-u) > 0.0:
            low = u
        else:
            high = u
    return low / e
