"""Extremum of a piecewise smooth function between its samples.

    f(t) on segments [t0, t1], known at the five nodes of Gauss and Lobatto; sought is max f over all of them

A polynomial of degree 4 through the nodes says where the maximum can lie and, by its highest Chebyshev coefficients, how
wrong it may be. Where that exceeds what the run promises, the function is sampled anew in the segments in question, at
Chebyshev points, whose polynomial of degree 15 is as good as the function itself. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODES: Array = np.array([0.0, 0.5 - np.sqrt(3 / 28), 0.5, 0.5 + np.sqrt(3 / 28), 1.0])
WEIGHTS: Array = np.array([1 / 20, 49 / 180, 16 / 45, 49 / 180, 1 / 20])
"""Nodes and weights of Gauss and Lobatto on [0, 1]: exact for polynomials of degree 7."""

_MOST = 24  # segments that are looked at closely: the best ones by their polynomials
_PART = 1e-2  # of the tolerance of the run: an error that is no concern
_BY_NODE = np.linalg.inv(chebyshev.chebvander(2 * NODES - 1, 4)).T  # values at nodes -> coefficients
_FINE = np.linspace(-1.0, 1.0, 33)
_ON_FINE = _BY_NODE @ chebyshev.chebvander(_FINE, 4).T
_INNER = -np.cos((np.arange(14) + 1) * np.pi / 15)  # inner points; with the ends they are those of degree 15
_BY_POINT = np.linalg.inv(chebyshev.chebvander(np.concatenate([[-1.0], _INNER, [1.0]]), 15)).T
_SERIES_ON_FINE = chebyshev.chebvander(_FINE, 15).T


def extremum(t0: Array, t1: Array, nodes: Array, sample: Callable[[Array], Array], rtol: float) -> float:
    """The maximum over all segments; nodes: shape (S, 5); sample(t): the function at times that increase."""
    if not len(nodes) or not np.isfinite(nodes).all():
        return float("nan")
    coefficients = nodes @ _BY_NODE
    unsure = np.maximum(np.abs(coefficients[:, 4]), np.abs(coefficients[:, 3]) / 16)  # of an odd one c_4 says nothing
    shown = np.maximum((nodes @ _ON_FINE).max(axis=1), nodes.max(axis=1))
    known, scale = float(nodes.max()), float(np.abs(nodes).max())
    candidates = np.flatnonzero(shown + unsure >= max(known + 1e-14 * scale, float((shown - unsure).max())))
    candidates = candidates[np.argsort(-(shown + unsure)[candidates], kind="stable")][:_MOST]
    if (unsure[candidates] <= _PART * rtol * scale).all():
        return max([known, *(_maximum(coefficients[i]) for i in candidates)])
    chosen = np.sort(candidates)
    chosen = chosen[(t1 - t0)[chosen] > 1e-12 * np.abs(t1[chosen])]
    if not len(chosen):
        return known
    times = (t0[chosen] + t1[chosen])[:, None] / 2 + (t1 - t0)[chosen][:, None] / 2 * _INNER
    inner = sample(times.ravel()).reshape(times.shape)
    table = np.column_stack([nodes[chosen, 0], inner, nodes[chosen, 4]])
    closer = table @ _BY_POINT
    tops = (closer @ _SERIES_ON_FINE).max(
        axis=1
    )  # between points of the grid a top is missed by a hundredth of the range at most
    near = tops + 0.01 * np.ptp(table, axis=1) >= tops.max()
    return max([known, *(_maximum(row) for row in closer[near])])


def _maximum(coefficients: Array) -> float:
    """Largest value of a Chebyshev series on [-1, 1]: Newton's method on its slope from the tops of a grid."""
    shown = coefficients @ _SERIES_ON_FINE[: len(coefficients)]
    slope = chebyshev.chebder(coefficients)
    first, second = slope.tolist(), chebyshev.chebder(slope).tolist()
    best, high = float(shown.max()), shown.tolist()
    near = best - 0.02 * float(np.ptp(shown))
    for i in np.flatnonzero(shown >= near).tolist():
        if high[i] < max(high[max(i - 1, 0)], high[min(i + 1, len(high) - 1)]):
            continue
        low, x, top = _FINE[max(i - 1, 0)], float(_FINE[i]), _FINE[min(i + 1, len(high) - 1)]
        for _ in range(8):
            bend = _clenshaw(second, x)
            step = _clenshaw(first, x) / bend if bend < 0 else 0.0
            x = min(max(x - step, low), top)
            if abs(step) < 1e-9:
                break
        best = max(best, _clenshaw(coefficients.tolist(), x))
    return best


def _clenshaw(coefficients: list[float], x: float) -> float:
    """Value of a Chebyshev series."""
    one = two = 0.0
    for c in coefficients[:0:-1]:
        one, two = c + 2 * x * one - two, one
    return coefficients[0] + x * one - two
