"""Load sharing of spline teeth with a gap of their own each, in closed form: F(s) = kt sum_j max(s - b_j, 0).

Every tooth has its gap b_j; a tooth pair carries kt (s - b_j) once the deflection s is past it. Gaps in m, forces in N,
stiffness of one pair kt in N/m. The coast side is the same with its own gaps. Knows nothing of blocks.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from itertools import accumulate


def start_forces(gaps: Sequence[float], kt: float) -> list[float]:
    """Force F_i at which tooth i (in the order of the gaps) starts: kt ((i - 1) b_i - sum of the smaller gaps)."""
    b = sorted(gaps)
    return [kt * (i * b[i] - below) for i, below in enumerate(accumulate(b[:-1], initial=0.0))]


def engaged_teeth(force: float, gaps: Sequence[float], kt: float) -> int:
    """Teeth that carry a force >= 0: how many start below it."""
    return bisect_left(start_forces(gaps, kt), force)


def deflection_at(force: float, gaps: Sequence[float], kt: float) -> float:
    """Deflection [m] under a force > 0: (F/kt + sum of the gaps of the engaged teeth) / their number."""
    r = engaged_teeth(force, gaps, kt)
    return (force / kt + sum(sorted(gaps)[:r])) / r if r else min(gaps)


def force_at(deflection: float, gaps: Sequence[float], kt: float) -> float:
    """Force [N] at a deflection: kt times the sum of what it is past each gap; piecewise linear and convex."""
    return kt * sum(max(deflection - b, 0.0) for b in gaps)


FAR = 1e300
"""A deflection beyond all motion [m]: where the outermost segments end."""


def segments(drive: Sequence[float], coast: Sequence[float]) -> tuple[list[float], list[list[float]]]:
    """Joints over the deflection, and on each segment from joint to joint the polynomial of the load.

    Rows: signed number of engaged teeth r, sum S and sum of squares Q of their gaps (signed as the deflection), so that
    the load of teeth with unit stiffness is r' x - S with r' = abs(r), and its integral r' x^2/2 - S x + Q/2. Each row is
    as long as the joints; its last entry repeats.
    """
    corners = sorted({-c for c in coast} | set(drive))
    rows: list[list[float]] = [[], [], []]
    for left, right in zip([-FAR, *corners], [*corners, FAR], strict=True):
        ahead = sorted(b for b in drive if b <= left)
        behind = sorted(-c for c in coast if -c >= right)
        rows[0].append(float(len(ahead) - len(behind)))
        rows[1].append(sum([*ahead, *behind]))
        rows[2].append(sum(b * b for b in [*ahead, *behind]))
    return [-FAR, *corners, FAR], [[*row, row[-1]] for row in rows]
