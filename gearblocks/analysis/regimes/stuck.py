"""What friction and stops hold from the begin of a run on: states beside that slip there stick after a time as short as their
slip, and those that lie off a stop that is pressed come back to it after one as short as the root of their gap.

    y <- y - dy'/dv B x          over all states:  B = M^-1 F',  x = (G B)^+ g
    v <- v + dB/dt x             over the speeds
    v <- v - B (G B)^+ s

G, F: rows of the active set, M: inertias, g: gaps, s: slips. The last line is the impulse of friction and stops that takes what
slips. In the flight back to a stop its force is missing, whose double integral over time is x: B x is what the train is
displaced by, dy'/dv B x what damps that takes meanwhile, and the impulse at the end finds other inertias than the missing force
would have. Sticking and closing on the way are events, and mapped as such. Knows nothing of orbits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.switched_constraints import ConstraintKind, ConstraintsAtPoint, ModelConstraints

Array = NDArray[np.float64]

_REACH = 1e-6
"""Of a difference, in units of states."""

_HELD = 1e-6
"""Of a gap: more than this is left of it where friction holds what lies off the stop."""


def as_held(sim: Simulation, program: Program, columns: Array) -> Array:
    """Columns of differences of the n states, shape (n, m), beside a run that has just started, after what slips there has
    stuck, and what lies off a stop that is pressed has come back to it."""
    known, modes = sim.constraints(), sim.modes()
    active = [i for i, one in enumerate(known.constraints) if modes[one.active] > 0.5]
    kept = (ConstraintKind.FRICTION, ConstraintKind.STOP)
    if not columns.shape[1] or not any(known.constraints[i].kind in kept for i in active):
        return columns
    start = _Start(sim, program, known, modes, active)
    return start.without_slip(start.without_gap(columns))


@dataclass(frozen=True, slots=True)
class _Start:
    """Where a run starts, and what is active there."""

    sim: Simulation
    program: Program
    known: ModelConstraints
    modes: Array
    active: list[int]

    @property
    def first(self) -> int:
        """The first speed among the states."""
        return self.program.n - self.known.n_speeds

    def at(self, y: Array, modes: Array | None = None) -> ConstraintsAtPoint:
        """The switched constraints."""
        return self.sim.constraints_at(self.sim.time, y, self.modes if modes is None else modes)

    def without_slip(self, columns: Array) -> Array:
        """After an impulse along all that is active."""
        y = self.sim.state()
        rows = self.at(y).rows[self.active]
        slips = rows @ columns[self.first :] if self.known.steady else _along(self._slips, y, columns)
        if not slips.any():
            return columns
        moved = self._by_forces(y, self.active)
        found = columns.copy()
        found[self.first :] -= moved @ np.linalg.lstsq(rows @ moved, slips, rcond=None)[0]
        return found

    def _slips(self, y: Array) -> Array:
        found: Array = self.at(y).rows[self.active] @ y[self.first : self.program.n]
        return found

    def without_gap(self, columns: Array) -> Array:
        """After flights back to all stops that are pressed."""
        y = self.sim.state()
        pressed = np.array([self._is_pressed(i) for i in self.active])
        if not pressed.any():
            return columns
        places = np.vstack([columns[: self.first], np.zeros_like(columns[self.first :])])
        gaps = pressed[:, None] * _along(lambda there: self.at(there).slip[self.active], y, places)
        if not gaps.any():
            return columns
        loose = self._loose(y, [i for i, gap in zip(self.active, gaps, strict=True) if gap.any()])
        kept = [k for k, i in enumerate(self.active) if i not in loose]
        closing = [self.active[k] for k in kept]
        moved, rows = self._by_forces(y, closing), self.at(y).rows[closing]
        late = np.linalg.lstsq(rows @ moved, gaps[kept], rcond=None)[0]
        held = np.abs(rows @ moved @ late - gaps[kept]).max(axis=0) > _HELD * np.abs(gaps).max(axis=0)
        late[:, held] = 0.0
        shifts = np.vstack([np.zeros((self.first, columns.shape[1])), moved @ late])
        flying = self.modes.copy()
        flying[[self.known.constraints[i].active for i in loose]] = 0.0
        found: Array = columns - _along(lambda there: self._rates(there, flying), y, shifts)
        turning = self._rates(y, self.modes)[:, None]
        turning[self.first :] = 0.0  # inertias and rows go by the places
        found[self.first :] += _along(lambda there: self._by_forces(there, closing), y, turning)[..., 0] @ late
        return found

    def _is_pressed(self, i: int) -> bool:
        stop = self.known.constraints[i]
        return (
            stop.is_stop
            and not (stop.free >= 0 and self.modes[stop.free] > 0.5)
            and self.at(self.sim.state()).forces[i] > 0.0
        )

    def _loose(self, y: Array, stops: list[int]) -> list[int]:
        """What friction does not hold where these stops are open."""
        opened = self.modes.copy()
        opened[[self.known.constraints[i].active for i in stops]] = 0.0
        alone = self.at(y, opened)
        frictions = (i for i in self.active if self.known.constraints[i].kind is ConstraintKind.FRICTION)
        return [i for i in frictions if alone.violation[i] > 0.0]

    def _rates(self, y: Array, modes: Array) -> Array:
        return self.sim.probe(self.sim.time, y, modes, "rates")[: self.program.n]

    def _by_forces(self, y: Array, constraints: list[int]) -> Array:
        """M^-1 F'. Where laws have no derivatives inertias are not told, and taken as equal: multipliers do not ask, since
        they are those of motions that stick."""
        forces = self.at(y).force_rows[constraints].T
        if not self.sim.has_jacobian:
            return forces
        inertia = self.sim.inertia(self.sim.time, y, dense=True)
        unknowns = np.arange(self.first, self.program.n) - self.sim.step_matrix_sizes()[0]
        found: Array = np.linalg.solve(inertia[np.ix_(unknowns, unknowns)], forces)
        return found


def _along(function: Callable[[Array], Array], y: Array, columns: Array) -> Array:
    """Derivatives of a function of all states along columns of the n first of them, the columns last."""
    found = []
    for v in columns.T:
        reach = _REACH / np.abs(v).max() if v.any() else 1.0
        step = np.concatenate([reach * v, np.zeros(len(y) - len(v))])
        found.append((function(y + step) - function(y - step)) / (2.0 * reach))
    return np.stack(found, axis=-1)
