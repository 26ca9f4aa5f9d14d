"""Small deviations that what sticks allows: fewer states, from which all others follow, as with ties in its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from gearblocks.simulation.equilibrium import fixed_combinations
from gearblocks.solver.active_set import Rows, reduced
from gearblocks.solver.motion import Motion, motion
from gearblocks.solver.point import Point, derivative, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array


@final
@dataclass(frozen=True, eq=False)
class Reduction:
    """All deviations x = R x[kept] of those that stay, shape (n, m)."""

    kept: Indices
    R: Any

    def __repr__(self) -> str:
        return f"<Reduction: {self.R.shape[1]} of {self.R.shape[0]} deviations are independent>"

    def matrix(self, A: Any) -> Any:
        """A of the deviations that stay."""
        return (A[self.kept] @ self.R).tocsc()

    def without_still(self, point: Point, A: Any, B: Array) -> Reduction:
        """Without the states of blocks that nothing changes: a count of impacts, an angle that does not creep."""
        small = self.matrix(A)
        still = (np.asarray(abs(small).sum(axis=1)).ravel() == 0) & ~B[self.kept].any(axis=1)
        first = point.program.n - point.sim.locks().n_speeds
        still &= np.isin(self.kept, motion(point).states) & (self.kept < first)
        return Reduction(self.kept[~still], self.R[:, np.flatnonzero(~still)])


def reduction(point: Point, n: int) -> Reduction | None:
    """What follows from what holds, among the states and n - program.n angles that ride along. None in a train where
    nothing can stick."""
    if not point.sim.locks().places:
        return None
    held = point.held_rows()
    rows = reduced(np.zeros((0, n))) if held is None else _conditions(point, held, motion(point), n)
    return Reduction(rows.kept, rows.basis())


def _conditions(point: Point, held: Rows, whole: Motion, n: int) -> Rows:
    """Speeds and positions that follow from others."""
    angles = whole.angles[whole.angles < point.program.n]  # the first ones: others ride along
    places, fixed = np.concatenate([whole.coordinates, angles]), fixed_combinations(whole, held, len(angles))
    still = np.zeros((len(fixed), n))
    still[:, places] = fixed
    positions = reduced(still)
    speeds = np.zeros((len(held.W), n))
    speeds[:, whole.speeds] = held.W
    if not point.sim.locks().steady:
        speeds[:, : whole.speeds[0]] = _beside(point, held, whole)
    speeds -= speeds[:, positions.pivots] @ positions.W
    pivots = np.concatenate([positions.pivots, whole.speeds[held.pivots]])
    return Rows(np.vstack([positions.W, speeds]), pivots, np.arange(len(pivots)), np.eye(len(pivots)))


def _beside(point: Point, held: Rows, whole: Motion) -> Array:
    """What slips change by with the states other than speeds, where gains change with the position."""
    holding = list(point.holding())
    stops = np.array([point.sim.locks().places[i].is_stop for i in holding])

    def slips(y: Array) -> Array:
        at = point.at(y=y).locks()
        return np.where(stops, at.rows[holding] @ y[whole.speeds], at.slip[holding])

    others = np.arange(whole.speeds[0])
    change = derivative(slips, point.y, others, steps_of(point.program, point.y)).toarray()
    return np.asarray(held.steps @ change)
