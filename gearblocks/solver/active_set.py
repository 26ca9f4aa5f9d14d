"""Active set of switched constraints as velocity constraints, in reduced row form:

    G v = 0    ->    W v = 0,  W = steps G    each row of W is 1 at its pivot and 0 at all other pivots

so that the speeds at the pivots (dependent) follow from the others: v = basis v_kept. Gauss-Jordan elimination with the
largest entry of a row as its pivot; a row that is within rounding a combination of those before is left out. The C core
reduces its rows by the same rule while it steps (docs/decisions/0019). Knows nothing of friction laws, modes or time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from gearblocks.solver.matrix_algebra import DENSE, SPARSE, Algebra, Matrix
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array

_DEPENDENT = 1e-9  # of the largest entry of a row: what is left of it is rounding (as in gb_constraint_rows.h)


@final
@dataclass(frozen=True, eq=False)
class ReducedRows:
    """Reduced row form W x = 0 of given rows.

    W: shape (k, n); pivots: shape (k,); which: the given rows that are independent; steps: W = steps @ given rows.
    """

    W: Array
    pivots: Indices
    which: Indices
    steps: Array

    @property
    def kept(self) -> Indices:
        """The entries that are no pivots: the others depend on them."""
        return np.setdiff1d(np.arange(self.W.shape[1]), self.pivots)

    def basis(self, algebra: Algebra = SPARSE) -> Matrix:
        """Null space of W as columns, shape (n, n - k): x = basis x_kept, 1 at the kept entries."""
        kept, n = self.kept, self.W.shape[1]
        column = np.zeros(n, dtype=np.intp)
        column[kept] = np.arange(len(kept))
        r, c = np.nonzero(self.W)
        off_pivot = ~np.isin(c, self.pivots)
        r, c = r[off_pivot], c[off_pivot]
        values = np.concatenate([np.ones(len(kept)), -self.W[r, c]])
        rows, columns = np.concatenate([kept, self.pivots[r]]), np.concatenate([np.arange(len(kept)), column[c]])
        return algebra.entries(values, rows, columns, (n, len(kept)))

    def projected(self, M: Matrix, rates: Matrix, algebra: Algebra = SPARSE) -> Matrix:
        """Accelerations, columns of `rates`, with constraint forces added: a - M^-1 W' lambda with W (...) = 0.

        M: mass matrix. The least change in the metric of M (Gauss 1829, principle of least constraint).
        """
        X = algebra.solved(M, self.W.T)
        forces = np.linalg.solve(self.W @ X, (rates.T @ self.W.T).T)
        return rates - algebra.of(X) @ algebra.of(forces)


def reduced(rows: Array, largest: Array | None = None) -> ReducedRows:
    """Reduced row form. largest: size of the terms of each row, where the row itself may be what cancellation left of them."""
    n = rows.shape[1]
    W, pivots, which, steps = np.zeros((0, n)), np.zeros(0, dtype=np.intp), [], np.zeros((0, len(rows)))
    for i, given in enumerate(rows):
        row, step = given - given[pivots] @ W, np.eye(len(rows))[i] - given[pivots] @ steps
        size = np.abs(given).max(initial=0.0) if largest is None else largest[i]
        if not np.abs(row).max(initial=0.0) > _DEPENDENT * size:
            continue
        pivot = int(np.argmax(np.abs(row)))
        step, row = step / row[pivot], row / row[pivot]
        steps = np.vstack([steps - np.outer(W[:, pivot], step), step])
        W = np.vstack([W - np.outer(W[:, pivot], row), row])
        pivots = np.append(pivots, pivot)
        which.append(i)
    return ReducedRows(W, pivots, np.array(which, dtype=np.intp), steps)


def null_space(matrix: Array, largest: Array | None = None) -> Array:
    """Null space of a small matrix, as columns."""
    return np.asarray(reduced(matrix, largest).basis(DENSE))
