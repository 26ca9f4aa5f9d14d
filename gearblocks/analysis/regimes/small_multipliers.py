"""Small multipliers of an orbit of several periods, from tangents that are made orthonormal in each of them.

    abs(mu_j) = product over the periods of r_jj,   Q_k R_k = M_k Q_{k-1},   Q_0: Schur vectors of M_m ... M_1, largest first

An eigenvalue of the whole map is told to the rounding of its largest entries, the product to its own (periodic Schur form:
Bojanczyk, Golub and Van Dooren 1992). Multipliers of nearly the same size, as of a pair, have their product told. Knows nothing
of labels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SMALL = 1e-3  # of the size of the map, whose derivatives are told to 1e-10 of it: those below lose digits that matter
_LOST = 1e-10  # of it: below, the order of the directions is rounding
_ALIKE = 0.8  # of the one before: nearer ones are told together


def told_by_period(
    seen: Strobe, y: Array, periods: int, neutral: Neutral, whole: Array, multipliers: Complex
) -> Complex:
    """The multipliers of the orbit through y, the largest first, the small ones among them told period by period. whole: its
    map, in units of the sizes."""
    size, moduli = float(np.abs(whole).max(initial=0.0)), np.abs(multipliers)
    known = int((moduli > _LOST * size).sum())
    if periods < 2 or not (moduli[:known] < _SMALL * size).any():
        return multipliers
    directions = (neutral.rest @ _flag(neutral.rest.T @ whole @ neutral.rest))[:, :known]
    columns, fixed = (x * seen.scale[:, None] for x in (directions, neutral.basis))
    try:
        logs = seen.follow(y, periods, columns, fixed=fixed).logs.sum(axis=0)
    except SimulationError:
        return multipliers
    found = multipliers.copy()
    starts = [j for j in range(known) if j == 0 or moduli[j] < _ALIKE * moduli[j - 1]]
    for first, end in zip(starts, [*starts[1:], known], strict=True):
        change = float(np.mean(logs[first:end] - np.log(moduli[first:end])))
        if moduli[first] < _SMALL * size and np.isfinite(change):
            found[first:end] *= np.exp(change)
    return found


def _flag(matrix: Array) -> Array:
    """Orthonormal columns of which the first j span the invariant subspace of the j largest eigenvalues, pairs together."""
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-np.abs(values), kind="stable")
    parts = [x for j in order if values[j].imag >= 0 for x in _real(vectors[:, j], pair=bool(values[j].imag > 0))]
    found: Array = np.linalg.qr(np.column_stack(parts))[0]
    return found


def _real(vector: Complex, *, pair: bool) -> tuple[Array, ...]:
    return (vector.real, vector.imag) if pair else (vector.real,)
