"""What friction holds from the begin of a run on: states beside that slip there stick after a time as short as their slip.

    v <- v - M^-1 F' (G M^-1 F')^+ G v        over the speeds;  G, F: rows of the active set, M: inertias

The impulse of friction that takes a small slip away. Sticking on the way is an event, and mapped as one. Knows nothing of
orbits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.switched_constraints import ConstraintKind

Array = NDArray[np.float64]


def without_slip(sim: Simulation, program: Program, columns: Array) -> Array:
    """Columns of differences of the n states, shape (n, m), beside a run that has just started, after what slips there has
    stuck."""
    known = sim.constraints()
    frictions = [i for i, one in enumerate(known.constraints) if one.kind is ConstraintKind.FRICTION]
    if not frictions or not columns.shape[1]:
        return columns
    modes = sim.modes()
    if not any(modes[known.constraints[i].active] > 0.5 for i in frictions):
        return columns
    active = [i for i, one in enumerate(known.constraints) if modes[one.active] > 0.5 and not one.is_stop]
    t, y, first = sim.time, sim.state(), program.n - known.n_speeds
    here = sim.constraints_at(t, y, modes)
    slips = here.rows[active] @ columns[first:]
    if not slips.any():
        return columns
    moved = _by_inertias(sim, t, y, first, program.n, here.force_rows[active].T)
    impulses = np.linalg.lstsq(here.rows[active] @ moved, slips, rcond=None)[0]
    found = columns.copy()
    found[first:] -= moved @ impulses
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
