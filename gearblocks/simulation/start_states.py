"""The state vector that a run begins with, where `initial` brings one: the end of an earlier run, or a run of no length.

Knows nothing of start values by name, nor of equilibria.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError
from gearblocks.simulation.records import FinalState
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.structures import Array


def start_state(program: Program, initial: Any) -> Array | None:
    """The state vector of an earlier run, the ledger at zero."""
    if not isinstance(initial, Trajectory):
        return None
    final = initial.final_state
    if final is None or final.key != program.key:
        raise ParameterError("initial: the earlier run is of another train; continue a run with the same model")
    y = np.array(final.y)
    for entry in program.integrals:
        if entry.part != "angle":
            y[entry.offset] = 0.0
    return y


def standing_run(state: FinalState, train: str, parameters: Mapping[str, float]) -> Trajectory:
    """A run of no length, which stands in a state with these parameters: what `initial` takes as an earlier run."""
    return Trajectory(
        [state.t], {}, meta={"train": train, "parameters": parameters, "complete": True}, final_state=state
    )
