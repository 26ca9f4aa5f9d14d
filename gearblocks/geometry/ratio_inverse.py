"""The ratio law of a pair seen from gear 2: G = F^-1, dG/dy = 1/m(G(y)).

Ellipses exactly: tan(n G/2) = (1 - e)/(1 + e) tan(n y/2); all others by Chebyshev interpolation of dG/dy between the joints of
the law, on segments that are halved until it is exact. Knows nothing of the law itself, nor of gears.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from gearblocks.errors import ParameterError
from gearblocks.geometry.ratio_curves import Array, Curve, Ellipse, Pieces
from gearblocks.geometry.ratio_fit import FIT_DEGREE, FIT_WANTED, Fit, closed, integrated, power_series

_HALVINGS = 9


def inverse_fit(fit: Fit, slope: Callable[[Array], Array], period: float, joints: Array) -> Fit:
    """The law of the pair from gear 2. slope: dG/dy over the angle y of gear 2; period: of y; joints: angles in [0, period]
    between which the slope is smooth."""
    recipe = ("inverted", (fit.recipe,))
    if isinstance(fit.curve, Ellipse):
        return Fit(recipe, fit.n2, fit.n1, Ellipse(-fit.curve.e, fit.curve.n))
    x, rows, worst = [0.0], list[Array](), 0.0
    for low, high in pairwise(joints.tolist()):
        edges, found, error = _segment(slope, low, high)
        x += edges[1:].tolist()
        rows += list(found)
        worst = max(worst, error)
    slopes, width = np.array(rows), np.diff(x)
    powers = 1 / np.arange(1, slopes.shape[1] + 1)
    mean = float(((slopes[:, ::2] @ powers[::2]) * width).sum() / period)
    slopes[:, 0] -= mean
    curve = integrated(np.array(x), slopes, joints=isinstance(fit.curve, Pieces) and fit.curve.joints)
    return closed(recipe, fit.n2, mean, curve, True, worst)


def joints_of(curve: Curve, period: float, F: Callable[[Array], Array]) -> Array:
    """Angles of gear 2 between which the inverse is smooth."""
    ends = curve.x if isinstance(curve, Pieces) and curve.joints else np.array([0.0, period])
    return np.asarray(F(ends))


def _segment(slope: Callable[[Array], Array], low: float, high: float) -> tuple[Array, Array, float]:
    """(edges, polynomials over v, error) between two joints."""
    nodes, between = chebyshev.chebpts1(FIT_DEGREE + 1), np.linspace(-1, 1, 4 * FIT_DEGREE + 1)
    for halvings in range(_HALVINGS + 1):
        x = np.linspace(low, high, 2**halvings + 1)
        middle, half = (x[1:] + x[:-1])[:, None] / 2, (x[1:] - x[:-1])[:, None] / 2
        rows = chebyshev.chebfit(nodes, slope(middle + half * nodes).T, FIT_DEGREE).T
        true = slope(middle + half * between)
        wrong = float(np.abs(chebyshev.chebval(between, rows.T) - true).max() / np.abs(true).max())
        if wrong <= 10 * FIT_WANTED:  # F^-1 itself is as good as 1e-13
            return x, np.array([power_series(row) for row in rows]), wrong
    raise ParameterError(
        f"this ratio law changes too fast between {np.degrees(low):.4g} and {np.degrees(high):.4g} degrees of gear 2 to be "
        f"inverted (by {wrong:.2g}); connect the pair so that gear 1 moves gear 2, or give it compliance"
    )
