"""Small multipliers of an orbit, from derivatives over parts of its periods in each of which little fades.

    M = M_k ... M_1,   Q_j R_j = M_j Q_{j-1},   Q_k = Q_0 W:    multipliers of W R_k ... R_1, block by block of equal sizes

An eigenvalue of the whole map is told to the rounding of its largest entries, a product to its own (periodic Schur form:
Bojanczyk, Golub and Van Dooren 1992; here by simultaneous iteration). Knows nothing of labels.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SMALL = 1e-3  # of the size of the map, whose derivatives are told to 1e-10 of it: those below lose digits that matter
_ALIKE = 0.8  # of the one before: nearer ones may be a pair
_LEAST, _MOST = 3, 60  # times that columns go around: what is alike to 0.7 is apart by then
_TURNS = 1e-8  # of a column, into the ones before it
_LEAK = 1e-6  # of columns, out of the directions that the train has
_NOTHING = 1e-9  # of a part: an event lets nothing through


def with_small_ones(
    seen: Strobe, y: Array, periods: int, neutral: Neutral, whole: Array, multipliers: Complex
) -> tuple[Complex, Array]:
    """The multipliers of the orbit through y, the largest first, and the logarithms of their moduli (-inf: nothing is left);
    the small ones are told by parts of the orbit. whole: its map, in units of the sizes."""
    size, moduli = float(np.abs(whole).max(initial=0.0)), np.abs(multipliers)
    with np.errstate(divide="ignore"):
        logs = np.log(moduli)
    large = int((moduli >= _SMALL * size).sum())
    while 0 < large < len(moduli) and moduli[large] > _ALIKE * moduli[large - 1]:
        large -= 1
    if large == len(moduli):
        return multipliers, logs
    try:
        pieces = seen.pieces(y, periods)
    except SimulationError:
        return multipliers, logs
    told = _of_product(pieces, neutral, neutral.rest @ _flag(neutral.rest.T @ whole @ neutral.rest))
    if told is None:
        return multipliers, logs
    return np.concatenate([multipliers[:large], told[0][large:]]), np.concatenate([logs[:large], told[1][large:]])


def _of_product(pieces: Array, neutral: Neutral, columns: Array) -> tuple[Complex, Array] | None:
    """The multipliers of the product, without those of the neutral directions, and their logarithms; None where the columns
    leave the directions that the train has."""
    p = neutral.basis.shape[1]
    for turns in range(1, _MOST + 1):
        turned, factors = np.column_stack([neutral.basis, columns]), []
        for piece in pieces:
            turned, factor = np.linalg.qr(piece @ turned)
            factors.append(_without_nothing(factor[p:, p:]))
        inside = neutral.rest.T @ turned[:, p:]
        if np.abs(np.linalg.norm(inside, axis=0) - 1.0).max(initial=0.0) > _LEAK:
            return None
        back, factor = np.linalg.qr(inside)
        factors.append(factor)
        turn, columns = (neutral.rest.T @ columns).T @ back, neutral.rest @ back
        blocks = _blocks(turn)
        if turns >= _LEAST and max(b - a for a, b in blocks) <= 2:
            break
    parts = [_block(factors, turn[a:b, a:b], slice(a, b)) for a, b in blocks]
    values, logs = np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])
    order = np.argsort(-logs, kind="stable")
    return values[order], logs[order]


def _without_nothing(factor: Array) -> Array:
    """A factor, in which what is rounding of its own size is nothing."""
    diagonal = np.abs(np.diag(factor))
    lost = diagonal < _NOTHING * np.abs(factor).max(axis=0, initial=0.0)
    found: Array = np.where(lost[:, None], 0.0, factor)
    return found


def _blocks(turn: Array) -> list[tuple[int, int]]:
    """Begin and end of the columns that turn into each other: of pairs, and of multipliers of nearly the same size."""
    n = len(turn)
    starts = [j for j in range(n) if j == 0 or np.abs(turn[j:, :j]).max() <= _TURNS]
    return list(zip(starts, [*starts[1:], n], strict=True))


def _block(factors: Iterable[Array], turn: Array, at: slice) -> tuple[Complex, Array]:
    """The multipliers of a block, and the logarithms of their moduli, which have no least one."""
    product, grown = np.eye(at.stop - at.start), 0.0
    for factor in factors:
        product = factor[at, at] @ product
        size = float(np.abs(product).max())
        if size == 0.0:
            return np.zeros(len(product), dtype=np.complex128), np.full(len(product), -np.inf)
        product, grown = product / size, grown + np.log(size)
    values = np.linalg.eigvals(turn @ product).astype(np.complex128)
    values = values[np.argsort(-np.abs(values), kind="stable")]
    with np.errstate(divide="ignore"):
        return values * np.exp(grown), np.log(np.abs(values)) + grown


def _flag(matrix: Array) -> Array:
    """Orthonormal columns of which the first j span the invariant subspace of the j largest eigenvalues, pairs together."""
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-np.abs(values), kind="stable")
    parts = [x for j in order if values[j].imag >= 0 for x in _real(vectors[:, j], pair=bool(values[j].imag > 0))]
    found: Array = np.linalg.qr(np.column_stack(parts))[0]
    return found


def _real(vector: Complex, *, pair: bool) -> tuple[Array, ...]:
    return (vector.real, vector.imag) if pair else (vector.real,)
