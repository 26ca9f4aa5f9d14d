"""Matrices of a model at one point, dense or sparse: the same operations on arrays of numpy and on CSC arrays of scipy.

A sparse operation costs the same some twenty microseconds for seven states as for seven hundred, and the first one a third
of a second for scipy: a small train is looked at with dense matrices, which bring in numpy alone. Rounding may differ.
Knows nothing of what the matrices mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Matrix: TypeAlias = Any
"""What an algebra makes. Both kinds know +, -, @, abs, .T, .shape and rows and columns by index."""

SMALL = 100
"""States up to which dense matrices are the quicker ones."""


class Algebra(Protocol):
    """How matrices are made, put together and solved."""

    @property
    def dense(self) -> bool:
        """Whether its matrices are arrays of numpy."""

    def entries(self, values: Array, rows: Indices, columns: Indices, shape: tuple[int, int]) -> Matrix:
        """Entries by row and column; those that are given twice add up."""

    def of(self, matrix: Array) -> Matrix:
        """A matrix of these numbers."""

    def zeros(self, shape: tuple[int, int]) -> Matrix:
        """Nothing but zeros."""

    def diagonal(self, values: Array) -> Matrix:
        """A square matrix with this diagonal."""

    def stacked(self, blocks: Sequence[Sequence[Matrix | None]]) -> Matrix:
        """Blocks by row and column; None: zeros. Each row and column has a block."""

    def array(self, matrix: Matrix) -> Array:
        """All entries."""

    def largest(self, matrix: Matrix, axis: int) -> Array:
        """The largest entry without its sign along an axis."""

    def solved(self, square: Matrix, right: Array) -> Array:
        """The inverse times dense columns. RuntimeError where there is none."""


@final
class Dense:
    """Arrays of numpy."""

    dense = True

    def __repr__(self) -> str:
        return "DENSE"

    def entries(self, values: Array, rows: Indices, columns: Indices, shape: tuple[int, int]) -> Matrix:
        made = np.zeros(shape)
        np.add.at(made, (rows, columns), values)
        return made

    def of(self, matrix: Array) -> Matrix:
        return np.asarray(matrix)

    def zeros(self, shape: tuple[int, int]) -> Matrix:
        return np.zeros(shape)

    def diagonal(self, values: Array) -> Matrix:
        return np.diag(values)

    def stacked(self, blocks: Sequence[Sequence[Matrix | None]]) -> Matrix:
        heights = [next(block.shape[0] for block in row if block is not None) for row in blocks]
        widths = [next(block.shape[1] for block in column if block is not None) for column in zip(*blocks, strict=True)]
        made, top = np.zeros((sum(heights), sum(widths))), 0
        for row, height in zip(blocks, heights, strict=True):
            left = 0
            for block, width in zip(row, widths, strict=True):
                if block is not None:
                    made[top : top + height, left : left + width] = block
                left += width
            top += height
        return made

    def array(self, matrix: Matrix) -> Array:
        return np.asarray(matrix)

    def largest(self, matrix: Matrix, axis: int) -> Array:
        return np.asarray(np.abs(matrix).max(axis=axis, initial=0.0))

    def solved(self, square: Matrix, right: Array) -> Array:
        try:
            return np.asarray(np.linalg.solve(square, right), dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise RuntimeError(str(error)) from error


@final
class Sparse:
    """CSC arrays of scipy, factored by SuperLU."""

    dense = False

    def __repr__(self) -> str:
        return "SPARSE"

    def entries(self, values: Array, rows: Indices, columns: Indices, shape: tuple[int, int]) -> Matrix:
        from scipy.sparse import csc_array

        return csc_array((values, (rows, columns)), shape=shape)

    def of(self, matrix: Array) -> Matrix:
        from scipy.sparse import csc_array

        return csc_array(matrix)

    def zeros(self, shape: tuple[int, int]) -> Matrix:
        from scipy.sparse import csc_array

        return csc_array(shape)

    def diagonal(self, values: Array) -> Matrix:
        from scipy.sparse import csc_array, diags_array

        return csc_array(diags_array(values))

    def stacked(self, blocks: Sequence[Sequence[Matrix | None]]) -> Matrix:
        from scipy.sparse import block_array, csc_array

        return csc_array(block_array([list(row) for row in blocks]))

    def array(self, matrix: Matrix) -> Array:
        return np.asarray(matrix.toarray())

    def largest(self, matrix: Matrix, axis: int) -> Array:
        if 0 in matrix.shape:
            return np.zeros(matrix.shape[1 - axis])
        return np.asarray(abs(matrix).max(axis=axis).todense()).ravel()

    def solved(self, square: Matrix, right: Array) -> Array:
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        return np.asarray(splu(csc_array(square)).solve(np.ascontiguousarray(right)))


DENSE, SPARSE = Dense(), Sparse()


def algebra_of(states: int) -> Algebra:
    """The quicker one for so many states."""
    return DENSE if states <= SMALL else SPARSE
