"""The state that an FMU starts from, where it is not the one that the parameters give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.core import Code, Method, Options
from gearblocks.errors import ParameterError, UnknownNameError, did_you_mean
from gearblocks.library import Model
from gearblocks.program import Program

Array = NDArray[np.float64]


def start_places(program: Program) -> list[tuple[str, str, int]]:
    """Name, unit and index in the state vector of everything that a start state sets: states and riding angles."""
    places = [(state.name, state.unit, index) for index, state in enumerate(program.states[: program.n])]
    return places + [(f"{r.component}.angle", "rad", r.index) for r in program.integrals if r.part == "angle"]


def start_vector(model: Model, values: Array, initial: Any) -> Array | None:
    """The state vector (length n_total) to start from, or None for the one that the parameters give.

    initial: None; a state vector of n or n_total entries; states by name, the others as the parameters give them; or an
    earlier run, whose end it is. Raises ParameterError or UnknownNameError.
    """
    if initial is None:
        return None
    program = model.program
    y = _given_by_parameters(model, values)
    places = start_places(program)
    initial = getattr(initial, "final_state", initial)
    if isinstance(initial, Mapping):
        index = {name: i for name, _, i in places}
        for name, value in initial.items():
            if name not in index:
                raise UnknownNameError(f"no state of '{program.name}' is called '{name}'{did_you_mean(name, index)}")
            y[index[name]] = float(value)
    else:
        given = np.asarray(getattr(initial, "y", initial), dtype=np.float64)
        if given.shape not in ((program.n,), (program.n_total,)):
            raise ParameterError(
                f"initial has shape {given.shape}; a state vector has {program.n} or {program.n_total} entries"
            )
        for _, _, i in places:
            if i < len(given):
                y[i] = given[i]
    bad = [name for name, _, i in places if not math.isfinite(y[i])]
    if bad:
        raise ParameterError(f"initial values of {', '.join(bad)} are not finite")
    return y


def _given_by_parameters(model: Model, values: Array) -> Array:
    with model.library.open() as simulation:
        simulation.parameters[:] = values
        simulation.inputs[:] = [u.start for u in model.program.inputs]
        simulation.changed()
        code = simulation.start(Options(int(Method.DP8), 1, 1e-6, 0.0, math.inf, math.inf), 0.0)
        if code < 0:
            raise ParameterError(f"'{model.program.name}' cannot start from its parameters: {Code(code).name}")
        return simulation.state()
