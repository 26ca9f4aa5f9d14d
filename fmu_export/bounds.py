"""Bounds that a model cannot stand on: an inertia of 0 where no other body turns with it, say.

A train may be built without that inertia, but then it has other equations; those at hand divide by it. Found by trying:
at the start of the run, each parameter on its bound alone. Knows nothing of laws.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fmu_export.options import SolverOptions
from gearblocks.codegen.program import ParameterInfo
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Code

_NOT_FINITE = (Code.ERR_NAN_RATE, Code.ERR_NAN_START)


def opened_bounds(
    model: Model, values: NDArray[np.float64], start: NDArray[np.float64] | None, solver: SolverOptions
) -> tuple[ParameterInfo, ...]:
    """The program's parameters, a bound being open where the model has no finite rates on it.

    values: the parameter vector; start: the state vector to start from (length n_total), or None. Where the model does
    not start with these, all bounds stay as they are.
    """
    program = model.program
    with model.library.open() as sim:
        sim.inputs[:] = [u.start for u in program.inputs]
        if not _runs(sim, values, start, solver):
            return program.parameters
        found = []
        for i, info in enumerate(program.parameters):
            refused = []
            for bound, is_open in ((info.lower, info.open_lower), (info.upper, info.open_upper)):
                tried = np.array(values)
                if bound is None or is_open or not math.isfinite(bound):
                    refused.append(is_open)
                    continue
                tried[i] = bound
                refused.append(not _runs(sim, tried, start, solver))
            found.append(info._replace(open_lower=refused[0], open_upper=refused[1]))
    return tuple(found)


def _runs(
    sim: Simulation, values: NDArray[np.float64], start: NDArray[np.float64] | None, solver: SolverOptions
) -> bool:
    """Whether all rates at the start are finite; True too where the start is refused for another reason."""
    sim.parameters[:] = values
    sim.changed()
    code = sim.start(solver.to_core(None), 0.0, start)
    if code in _NOT_FINITE:
        return False
    return code != Code.DONE or bool(np.all(np.isfinite(sim.rhs(0.0, sim.state()))))
