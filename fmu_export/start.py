"""The state that an FMU starts from, where it is not the one that the parameters give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError
from gearblocks.language.starts import is_rolling
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model


def start_offsets(program: Program) -> list[tuple[str, str, int]]:
    """Name, unit and index in the state vector of everything that a start state sets: states and unread angles."""
    offsets = [(state.name, state.unit, index) for index, state in enumerate(program.states[: program.n])]
    return offsets + [(f"{r.component}.angle", "rad", r.offset) for r in program.integrals if r.part == "angle"]


def rolled_values(model: Model, program: Program, values: NDArray[np.float64], initial: Any) -> NDArray[np.float64]:
    """The parameters with the start values of a rolling start, where that is asked for: inputs at their start values."""
    if not is_rolling(initial):
        return values
    with model.library.open() as sim:
        sim.parameters[:], sim.inputs[:] = values, program.input_starts
        return rolled(model, sim, 0.0, initial)


def start_vector(program: Program, initial: Any) -> NDArray[np.float64] | None:
    """The state vector (length n_total) to start from, or None for the one that the parameters give.

    initial: an earlier run, whose end it is, or a state vector; None, start values by name and a rolling start leave it to the
    parameters. Raises ParameterError.
    """
    if initial is None or isinstance(initial, Mapping) or is_rolling(initial):
        return None
    given = np.asarray(start_state(program, initial) if isinstance(initial, Trajectory) else initial, dtype=np.float64)
    if given.shape != (program.n_total,):
        raise ParameterError(f"initial has shape {given.shape}; a state vector has {program.n_total} entries")
    y = np.zeros(program.n_total)
    for name, _, i in start_offsets(program):
        if not np.isfinite(given[i]):
            raise ParameterError(f"the initial value of '{name}' = {given[i]!r} must be finite")
        y[i] = given[i]
    return y
