"""What sticks as a constraint on the speeds: W v = 0, solved for as many speeds as there are independent rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np

from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array

if TYPE_CHECKING:
    from scipy.sparse import csc_array

_NOTHING = 1e-9  # of the largest number of a row: what is left of it says nothing new (as in gb_constraint_rows.h)


@final
@dataclass(frozen=True, eq=False)
class Rows:
    """Independent linear conditions W x = 0 in reduced form: each row has a 1 at its pivot and 0 at all other pivots.

    W: shape (k, n); pivots: shape (k,); which: the rows of those given that are independent; steps: W = steps @ given rows.
    """

    W: Array
    pivots: Indices
    which: Indices
    steps: Array

    @property
    def kept(self) -> Indices:
        """The entries that the others follow."""
        return np.setdiff1d(np.arange(self.W.shape[1]), self.pivots)

    def basis(self) -> csc_array:
        """All entries from the kept ones, shape (n, n - k)."""
        from scipy.sparse import csc_array

        kept, n = self.kept, self.W.shape[1]
        place = np.zeros(n, dtype=np.intp)
        place[kept] = np.arange(len(kept))
        r, c = np.nonzero(self.W)
        beside = ~np.isin(c, self.pivots)
        r, c = r[beside], c[beside]
        values = np.concatenate([np.ones(len(kept)), -self.W[r, c]])
        rows, columns = np.concatenate([kept, self.pivots[r]]), np.concatenate([np.arange(len(kept)), place[c]])
        return csc_array((values, (rows, columns)), shape=(n, len(kept)))

    def projected(self, M: csc_array, rates: Any) -> Any:
        """Rates of the speeds (columns of a matrix) with the forces that keep W times them at 0; M: inertia matrix."""
        from scipy.sparse import csc_array
        from scipy.sparse.linalg import splu

        X = splu(csc_array(M)).solve(self.W.T.copy())
        forces = np.linalg.solve(self.W @ X, csc_array(rates).T.dot(self.W.T).T)
        return csc_array(rates - csc_array(X) @ csc_array(forces))


def reduced(rows: Array, largest: Array | None = None) -> Rows:
    """Independent ones of some rows, reduced. largest: size of each row's terms, where what is left may be rounding."""
    n = rows.shape[1]
    W, pivots, which, steps = np.zeros((0, n)), np.zeros(0, dtype=np.intp), [], np.zeros((0, len(rows)))
    for i, given in enumerate(rows):
        own, step = given - given[pivots] @ W, np.eye(len(rows))[i] - given[pivots] @ steps
        size = np.abs(given).max(initial=0.0) if largest is None else largest[i]
        if not np.abs(own).max(initial=0.0) > _NOTHING * size:
            continue
        pivot = int(np.argmax(np.abs(own)))
        step, own = step / own[pivot], own / own[pivot]
        steps, W = (
            np.vstack([steps - np.outer(W[:, pivot], step), step]),
            np.vstack([W - np.outer(W[:, pivot], own), own]),
        )
        pivots = np.append(pivots, pivot)
        which.append(i)
    return Rows(W, pivots, np.array(which, dtype=np.intp), steps)


def null_space(matrix: Array, largest: Array | None = None) -> Array:
    """Vectors that a small matrix takes to 0, as columns."""
    return np.asarray(reduced(matrix, largest).basis().toarray())
