"""Independent deviations that the active set allows: x = R x[kept], as with rigid constraints in its place.

G dv = 0 for the speeds, and for coordinates and angles the combinations that G keeps constant. Knows nothing of
friction laws or of forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from gearblocks.simulation.equilibrium import fixed_combinations
from gearblocks.solver.active_set import ReducedRows, reduced
from gearblocks.solver.kinematics import Kinematics, kinematics
from gearblocks.solver.point import Point, derivative, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array


@final
@dataclass(frozen=True, eq=False)
class Reduction:
    """All deviations x = R x[kept] of the independent ones, shape (n, m)."""

    kept: Indices
    R: Any

    def __repr__(self) -> str:
        return f"<Reduction: {self.R.shape[1]} of {self.R.shape[0]} deviations are independent>"

    def matrix(self, A: Any) -> Any:
        """A of the independent deviations."""
        return (A[self.kept] @ self.R).tocsc()

    def without_still(self, point: Point, A: Any, B: Array) -> Reduction:
        """Without the states of blocks that nothing changes: a count of impacts, an angle that does not creep."""
        small = self.matrix(A)
        still = (np.asarray(abs(small).sum(axis=1)).ravel() == 0) & ~B[self.kept].any(axis=1)
        first = point.program.n - point.sim.constraints().n_speeds
        still &= np.isin(self.kept, kinematics(point).states) & (self.kept < first)
        return Reduction(self.kept[~still], self.R[:, np.flatnonzero(~still)])


def reduction(point: Point, n: int) -> Reduction | None:
    """Dependent deviations among the states and n - program.n unread angles, by the active set. None in a train without
    switched constraints."""
    if not point.sim.constraints().constraints:
        return None
    active = point.active_rows()
    rows = reduced(np.zeros((0, n))) if active is None else _conditions(point, active, kinematics(point), n)
    return Reduction(rows.kept, rows.basis())


def _conditions(point: Point, active: ReducedRows, kin: Kinematics, n: int) -> ReducedRows:
    """Rows over all deviations: positions that stay constant, speeds without slip."""
    angles = kin.angles[kin.angles < point.program.n]  # the first ones: others are unread
    columns, fixed = np.concatenate([kin.coordinates, angles]), fixed_combinations(kin, active, len(angles))
    still = np.zeros((len(fixed), n))
    still[:, columns] = fixed
    positions = reduced(still)
    speeds = np.zeros((len(active.W), n))
    speeds[:, kin.speeds] = active.W
    if not point.sim.constraints().steady:
        speeds[:, : kin.speeds[0]] = _slips_by_position(point, active, kin)
    speeds -= speeds[:, positions.pivots] @ positions.W
    pivots = np.concatenate([positions.pivots, kin.speeds[active.pivots]])
    return ReducedRows(np.vstack([positions.W, speeds]), pivots, np.arange(len(pivots)), np.eye(len(pivots)))


def _slips_by_position(point: Point, active: ReducedRows, kin: Kinematics) -> Array:
    """Derivatives of the slips by the states other than speeds, where gains change with the position."""
    numbers = list(point.active_set())
    stops = np.array([point.sim.constraints().constraints[i].is_stop for i in numbers])

    def slips(y: Array) -> Array:
        at = point.at(y=y).constraints()
        return np.where(stops, at.rows[numbers] @ y[kin.speeds], at.slip[numbers])

    others = np.arange(kin.speeds[0])
    change = derivative(slips, point.y, others, steps_of(point.program, point.y)).toarray()
    return np.asarray(active.steps @ change)
