"""Extremum of a piecewise smooth function between its samples.

    f(t) on segments [t0, t1], known at the five nodes of Gauss and Lobatto; sought is max f over all of them

A polynomial of degree 4 through the nodes says where the maximum can lie and, by its highest Chebyshev coefficient, how
wrong it may be. Where that exceeds what the run promises, the function is sampled anew in the segments in question, at
Chebyshev points, whose polynomial of degree 15 is as good as the function itself. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from gearblocks.simulation.segments import NODES

Array = NDArray[np.float64]

_MOST = 24  # segments that are looked at closely: the best ones by their polynomials
_PART = 1e-2  # of the tolerance of the run: an error that is no concern
_BY_NODE = np.linalg.inv(chebyshev.chebvander(2 * NODES - 1, 4)).T  # values at nodes -> coefficients
_FINE = np.linspace(-1.0, 1.0, 33)
_ON_FINE = _BY_NODE @ chebyshev.chebvander(_FINE, 4).T
_INNER = -np.cos((np.arange(14) + 1) * np.pi / 15)  # inner points; with the ends they are those of degree 15
_BY_POINT = np.linalg.inv(chebyshev.chebvander(np.concatenate([[-1.0], _INNER, [1.0]]), 15)).T


def extremum(t0: Array, t1: Array, nodes: Array, sample: Callable[[Array], Array], rtol: float) -> float:
    """The maximum over all segments; nodes: shape (S, 5); sample(t): the function at times that increase."""
    if not len(nodes) or not np.isfinite(nodes).all():
        return float("nan")
    coefficients = nodes @ _BY_NODE
    unsure = np.abs(coefficients[:, 4])
    upper = np.maximum((nodes @ _ON_FINE).max(axis=1), nodes.max(axis=1)) + unsure
    scale = float(np.abs(nodes).max())
    known = nodes.max()
    candidates = np.flatnonzero(upper > known)
    candidates = candidates[np.argsort(-upper[candidates], kind="stable")]
    if (unsure[candidates] <= _PART * rtol * scale).all():
        return max(float(known), *(_maximum(coefficients[i]) for i in candidates[:_MOST]), -np.inf)
    chosen = np.sort(candidates[:_MOST])
    chosen = chosen[(t1 - t0)[chosen] > 1e-12 * np.abs(t1[chosen])]
    if not len(chosen):
        return float(known)
    times = (t0[chosen] + t1[chosen])[:, None] / 2 + (t1 - t0)[chosen][:, None] / 2 * _INNER
    inner = sample(times.ravel()).reshape(times.shape)
    table = np.column_stack([nodes[chosen, 0], inner, nodes[chosen, 4]])
    return max(float(known), *(_maximum(row) for row in table @ _BY_POINT))


def _maximum(coefficients: Array) -> float:
    """Largest value of a Chebyshev series on [-1, 1]."""
    slope = chebyshev.chebder(coefficients)
    size = float(np.abs(slope).max())
    if size <= 1e-14 * float(np.abs(coefficients).max()):
        return float(chebyshev.chebval(np.array([-1.0, 1.0]), coefficients).max())
    roots = chebyshev.chebroots(chebyshev.chebtrim(slope, 1e-15 * size))
    real = roots.real[(np.abs(roots.imag) < 1e-4) & (np.abs(roots.real) < 1.0)]
    return float(chebyshev.chebval(np.concatenate([[-1.0, 1.0], real]), coefficients).max())
