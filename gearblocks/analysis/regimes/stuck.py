"""What friction and stops hold from the begin of a run on: states beside that slip there stick after a time as short as
their slip, and those that lie off a stop come back to it after one as short as the root of their gap.

    v <- v - M^-1 F' (G M^-1 F')^+ G v        over the speeds;  G, F: rows of the active set, M: inertias
    y <- y - dy'/dv M^-1 F' (G M^-1 F')^+ g   over all states;  g: gaps of the stops, y': rates with what sticks

The impulse of friction that takes a small slip away; the forces that begin so much later for a gap move the train by what it
had been off, and what damps that takes its part of the speeds. Sticking and closing on the way are events, and mapped as such.
Knows nothing of orbits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.switched_constraints import ConstraintKind

Array = NDArray[np.float64]

_REACH = 1e-6
"""Of a difference, in units of states."""


def without_slip(sim: Simulation, program: Program, columns: Array) -> Array:
    """Columns of differences of the n states, shape (n, m), beside a run that has just started, after what slips there has
    stuck, and what lies off a stop has come back to it."""
    known = sim.constraints()
    modes, kept = sim.modes(), (ConstraintKind.FRICTION, ConstraintKind.STOP)
    if not columns.shape[1] or not any(modes[one.active] > 0.5 and one.kind in kept for one in known.constraints):
        return columns
    active = [i for i, one in enumerate(known.constraints) if modes[one.active] > 0.5]
    t, y, first = sim.time, sim.state(), program.n - known.n_speeds
    here = sim.constraints_at(t, y, modes)
    slips, gaps = here.rows[active] @ columns[first:], np.zeros((len(active), columns.shape[1]))
    stops = np.array([known.constraints[i].is_stop for i in active])
    for j, v in enumerate(columns.T if stops.any() else ()):
        gaps[:, j] = stops * _along(lambda there: sim.constraints_at(t, there, modes).slip[active], y, v)
    if not slips.any() and not gaps.any():
        return columns
    moved = _by_inertias(sim, t, y, first, program.n, here.force_rows[active].T)
    forces = np.linalg.lstsq(here.rows[active] @ moved, np.column_stack([slips, gaps]), rcond=None)[0]
    impulses, shifts = np.hsplit(moved @ forces, 2)
    found = columns.copy()
    found[first:] -= impulses
    for shift, column in zip(shifts.T, found.T, strict=True):
        faster = np.concatenate([np.zeros(first), shift])
        column -= _along(lambda there: sim.probe(t, there, modes, "rates")[: program.n], y, faster)
    return found


def _along(function: Callable[[Array], Array], y: Array, v: Array) -> Array:
    """Derivative of a function of all states along v of the n first of them."""
    step = np.zeros(len(y))
    reach = _REACH / np.abs(v).max() if v.any() else 1.0
    step[: len(v)] = reach * v
    found: Array = (function(y + step) - function(y - step)) / (2.0 * reach)
    return found


def _by_inertias(sim: Simulation, t: float, y: Array, first: int, n: int, forces: Array) -> Array:
    """M^-1 F'. Where laws have no derivatives inertias are not told, and taken as equal: multipliers do not ask, since they
    are those of motions that stick."""
    if not sim.has_jacobian:
        return forces
    inertia = sim.inertia(t, y, dense=True)
    unknowns = np.arange(first, n) - sim.step_matrix_sizes()[0]
    found: Array = np.linalg.solve(inertia[np.ix_(unknowns, unknowns)], forces)
    return found
