"""Sparse matrices of linear maps that can only be applied: their columns in groups, and systems of small blocks.

Two numbers tell which column of a group an entry belongs to: what the map makes of random sizes, and of the same sizes
times the numbers of the columns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_WHOLE = 1e-6  # farther from a whole number: two columns of a group meet in that row
_ROUNDING = 1e-11  # of the number itself
_SAME = 1e-9  # of the sum of the sizes: rounding and what cancels in it
_BLOCK = 64  # unknowns up to which the inverse of a block is made


def disjoint(rows: Sequence[Iterable[int]]) -> list[list[int]]:
    """Groups of numbers whose rows do not overlap, each number in the first group that has room."""
    groups: list[list[int]] = []
    taken: dict[int, int] = {}  # by row: the groups that have it, one bit each
    for number, own in enumerate(rows):
        mine = own.tolist() if isinstance(own, np.ndarray) else list(own)
        used = 0
        for r in mine:
            used |= taken.get(r, 0)
        free = ~used & (used + 1)
        chosen = free.bit_length() - 1
        if chosen == len(groups):
            groups.append([])
        groups[chosen].append(number)
        for r in mine:
            taken[r] = taken.get(r, 0) | free
    return groups


def recovered(
    apply: Callable[[Array], Array], shape: tuple[int, int], groups: Sequence[Sequence[int] | Indices], length: int
) -> tuple[Any, list[Indices]]:
    """The sparse matrix (CSC) of a linear map of vectors of `length` whose first shape[1] entries count, and the groups
    that served.

    groups: columns that are supposed to share no row; those that do are told apart by halves. Raises ArithmeticError
    where the map gives NaN or infinity.
    """
    from scipy.sparse import csc_array

    sizes = np.random.default_rng(1).uniform(1.0, 2.0, shape[1])
    waiting, served = [np.array(g, dtype=np.intp) for g in groups if len(g)], []
    rows: list[Indices] = []
    columns: list[Indices] = []
    values: list[Array] = []
    while waiting:
        group = waiting.pop()
        x = np.zeros(length)
        x[group] = sizes[group]
        one = apply(x).copy()
        if not np.isfinite(one).all():
            raise ArithmeticError("a derivative is NaN or infinite")
        x[group] *= np.arange(1, len(group) + 1)
        found = np.flatnonzero(one)
        number = apply(x)[found] / one[found]
        nearest = np.rint(number)
        if len(group) == 1:
            nearest[:] = 1
        elif (abs(number - nearest) > _WHOLE + _ROUNDING * nearest).any() or not _within(nearest, len(group)):
            waiting += np.array_split(group, 2)
            continue
        served.append(group)
        owner = group[nearest.astype(np.intp) - 1]
        rows.append(found)
        columns.append(owner)
        values.append(one[found] / sizes[owner])
    parts = [np.concatenate(p) if p else np.zeros(0) for p in (values, rows, columns)]
    matrix = csc_array((parts[0], (parts[1].astype(np.intp), parts[2].astype(np.intp))), shape=shape)
    if len(served) < shape[1] and not _agrees(apply, matrix, length):
        return recovered(apply, shape, [[j] for j in range(shape[1])], length)
    return matrix, served


def _within(numbers: Array, count: int) -> bool:
    return bool(((numbers >= 1) & (numbers <= count)).all())


def _agrees(apply: Callable[[Array], Array], matrix: Any, length: int) -> bool:
    """Whether the matrix does the same as the map to a random vector."""
    x = np.zeros(length)
    x[: matrix.shape[1]] = np.random.default_rng(2).normal(size=matrix.shape[1])
    off = np.abs(apply(x) - matrix @ x[: matrix.shape[1]])
    return bool((off <= _SAME * (abs(matrix) @ np.abs(x[: matrix.shape[1]]))).all())


def solved(square: Any, right: Any) -> Any:
    """The inverse of a sparse matrix times another one (CSC). Where the matrix falls into small blocks, nothing of the
    size of the whole is formed. Raises ArithmeticError where there is no inverse."""
    from scipy.sparse import csc_array
    from scipy.sparse.csgraph import connected_components
    from scipy.sparse.linalg import splu

    n = square.shape[0]
    if n == 0:
        return csc_array(right)
    count, label = connected_components(square, directed=False)
    order = np.argsort(label, kind="stable")
    ends = np.cumsum(np.bincount(label, minlength=count))
    sizes = np.diff(ends, prepend=0)
    if sizes.max() > _BLOCK:
        try:
            return csc_array(splu(csc_array(square)).solve(right.toarray()))
        except RuntimeError as error:
            raise ArithmeticError(str(error)) from error
    first = (ends - sizes)[label[order]]  # of the block of each unknown
    try:
        entries, values = _inverses(csc_array(square[order][:, order]).tocoo(), first, sizes[label[order]])
    except np.linalg.LinAlgError as error:
        raise ArithmeticError(str(error)) from error
    inverse = csc_array((values, (order[entries[0]], order[entries[1]])), shape=(n, n))
    return csc_array(inverse @ right)


def _inverses(blocks: Any, first: Indices, sizes: Indices) -> tuple[Indices, Array]:
    """Rows and columns, and values, of the inverse of a matrix of blocks: first row and size of the block by row."""
    entries, values = [], []
    for size in np.unique(sizes):
        of_size = sizes == size
        position = np.cumsum(of_size) - 1
        starts, inside, mine = np.flatnonzero(of_size)[::size], np.arange(size), of_size[blocks.row]
        r, c = blocks.row[mine], blocks.col[mine]
        full = np.zeros((len(starts), size, size))
        np.add.at(full, (position[first[r]] // size, r - first[r], c - first[c]), blocks.data[mine])
        rows = np.broadcast_to(starts[:, None, None] + inside[:, None], full.shape)
        columns = np.broadcast_to(starts[:, None, None] + inside, full.shape)
        entries.append(np.stack([rows.ravel(), columns.ravel()]))
        values.append(np.linalg.inv(full).ravel())
    return np.concatenate(entries, axis=1), np.concatenate(values)
