"""Jacobian of the states and inertia of a small model as dense matrices, from the step matrix at several g:

    S = E - g dG/dx - g^2 dG/ds B,        d(dy)/dy as in step_matrix.py

What the sparse form recovers from groups of columns is taken column by column here. Knows nothing of the laws.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import NamedTuple, final

import numpy as np

from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.solver.step_matrix import FAR, decades_of, unknowns_of
from gearblocks.solver.structures import Array, PointStructure, address

_WIDTH = np.dtype(np.float64).itemsize


class _Matrices(NamedTuple):
    """Step matrices for several g, one a row: entries by unknown, below and above the diagonal; kinematic terms."""

    g: Array
    entries: Array
    terms: Array


@final
class DenseJacobian:
    """The dense matrices of one simulation. sizes: as `Simulation.step_matrix_sizes`."""

    def __init__(self, shared: ctypes.CDLL, sim: int | None, pattern: Pattern, sizes: tuple[int, int, int]) -> None:
        self._shared, self._sim = shared, sim
        self._n, (self._n_kinematic, self._n_massless, self._n_terms) = len(pattern.order), sizes
        _, self._row, self._column = unknowns_of(pattern)
        entries = np.cumsum([0, self._n, len(self._row), len(self._row), self._n_terms])
        self._ends: list[int] = entries.tolist()

    def __repr__(self) -> str:
        return f"<DenseJacobian: {self._n} unknowns, {self._n_kinematic} kinematic states>"

    def inertia(self, point: PointStructure, y: Array) -> Array:
        """E by the states that are not kinematic."""
        k = self._n - self._n_massless
        return self._full(self._matrices(point, y, [0.0]).entries[0])[:k, :k]

    def at(self, point: PointStructure, y: Array) -> Array:
        """d(dy)/dy of the states at a point. Raises ArithmeticError where a derivative is not finite or the massless speeds
        are not determined, RuntimeError where an input fails."""
        n, n_q, k = self._n, self._n_kinematic, self._n - self._n_massless
        ends = self._matrices(point, y, [0.0, FAR, -FAR])
        first, last = decades_of(*ends.entries[:, :n])
        sizes = [10.0 ** (first - 6), *(10.0**e for e in range(first, last + 1)), 10.0 ** (last + 6)]
        m = self._matrices(point, y, [*sizes, *(-g for g in sizes)])
        by_x = self._full(_odd_part(m.entries, m.g[: len(sizes)]))
        slope = (self._right_side(m, len(sizes) - 1, n_q + k) - self._right_side(ends, 0, n_q + k)) / sizes[-1]
        speeds = self._kinematic_rates(ends.terms[0])
        slope[:, n_q:] += by_x[:, :k]
        full = np.zeros((n_q + k, n_q + k))
        full[:n_q, n_q:] = speeds[:, :k]
        try:
            if self._n_massless:
                massless = np.linalg.solve(by_x[k:, k:], slope[k:])
                slope = slope[:k] - by_x[:k, k:] @ massless
                full[:n_q] -= speeds[:, k:] @ massless
            full[n_q:] = np.linalg.solve(self._full(ends.entries[0])[:k, :k], slope)
        except np.linalg.LinAlgError as error:
            raise ArithmeticError(str(error)) from error
        if not np.isfinite(full).all():
            raise ArithmeticError("a derivative is NaN or infinite")
        return full

    def _matrices(self, point: PointStructure, y: Array, sizes: Sequence[float]) -> _Matrices:
        """The step matrices at a point for these g."""
        table = np.zeros((len(sizes), self._ends[-1]))
        row, state, where = address(table) or 0, address(y), ctypes.byref(point)
        _, lower, upper, terms, width = (_WIDTH * end for end in self._ends)
        sim, call = self._sim, self._shared.gb_step_matrix_at
        for g in sizes:
            code = call(sim, where, state, g, row, row + lower, row + upper, row + terms)
            if code < 0:
                raise RuntimeError(f"gb_step_matrix_at answered {code}")
            row += width
        return _Matrices(np.array(sizes), table[:, : self._ends[3]], table[:, self._ends[3] :])

    def _full(self, entries: Array) -> Array:
        """The matrix by unknown."""
        _, n, above, end, _ = self._ends
        made = np.zeros((n, n))
        made[self._row, self._column], made[self._column, self._row] = entries[n:above], entries[above:end]
        np.fill_diagonal(made, entries[:n])
        return made

    def _right_side(self, m: _Matrices, i: int, columns: int) -> Array:
        """E r_x + g dG/ds r_s of the i-th matrix for each unit vector over the states, as columns."""
        terms, g, call = np.ascontiguousarray(m.terms[i]), float(m.g[i]), self._shared.gb_step_matrix_right_side
        at = address(terms)
        return _columns(lambda r, out: int(call(self._sim, at, g, r, out)), columns, self._n)

    def _kinematic_rates(self, terms: Array) -> Array:
        """B by column."""
        terms, call = np.ascontiguousarray(terms), self._shared.gb_kinematic_rates
        at = address(terms)
        return _columns(lambda x, out: int(call(self._sim, at, x, out)), self._n, self._n_kinematic)


def _columns(call: Callable[[int, int], int], n: int, rows: int) -> Array:
    """The matrix of a linear map of the core, which takes the addresses of a vector of length n and of `rows` results."""
    units, found = np.eye(n), np.zeros((n, rows))
    if rows == 0:
        return found.T
    unit, out = address(units) or 0, address(found) or 0
    for _ in range(n):
        if call(unit, out) < 0:
            raise RuntimeError("the linear parts of the model cannot be had here")
        unit, out = unit + n * _WIDTH, out + rows * _WIDTH
    return found.T.copy()


def _odd_part(matrices: Array, g: Array) -> Array:
    """(S(-g) - S(g)) / 2 g of each entry from the g that leaves the least rounding; rows: S(g), then S(-g)."""
    plus, minus = matrices[: len(g)], matrices[len(g) :]
    noise = np.maximum(abs(plus), abs(minus)) / g[:, None]
    noise[noise != noise] = np.inf  # NaN
    best, each = noise.argmin(axis=0), np.arange(matrices.shape[1])
    odd = (minus[best, each] - plus[best, each]) / (2 * g[best])
    odd[noise[best, each] == np.inf] = 0.0
    return np.asarray(odd)
