"""The point that a train is looked at about: static equilibrium, start values, the end of a run, turning as one piece."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import SimulationError
from gearblocks.language.starts import is_rolling
from gearblocks.simulation.arguments import (
    InputSource,
    Start,
    begin_of,
    check_start,
    is_static,
    parameter_vector,
    set_inputs,
)  # fmt: skip
from gearblocks.simulation.equilibrium import static_point
from gearblocks.simulation.failures import reason
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.point import Point, opened
from gearblocks.solver.structures import Code

OperatingPoint: TypeAlias = Start


@contextmanager
def operating_point(
    model: Model, at: OperatingPoint, t: float | None = None, parameters: Mapping[str, float | str] | None = None,
    inputs: Mapping[str, InputSource] | None = None,
) -> Iterator[Point]:  # fmt: skip
    """The model at an operating point, as `linearize` takes it; inputs: their values, else those they start with."""
    check_start("at", at)
    program = model.program
    begin = begin_of(t, at)
    with model.library.open() as sim:
        sim.parameters[:] = parameter_vector(model, parameters or {}, at)
        set_inputs(sim, program, inputs or {})
        if is_rolling(at):
            sim.parameters[:] = rolled(model, sim, begin, at)
        with _named(sim, program, begin):
            if is_static(at):
                point = _static(sim, program, begin, at)
            else:
                with opened(sim, program, begin, start_state(program, at)) as point:
                    if isinstance(at, Trajectory) and at.final_state is not None:
                        point = point.at(modes=np.array(at.final_state.modes))
            yield point.at(u=np.array(sim.inputs))


def _static(sim: Simulation, program: Program, t: float, at: OperatingPoint) -> Point:
    """The static equilibrium. Where there is none the error says which other points there are."""
    try:
        return static_point(sim, program, t, means=at == "static")
    except SimulationError as error:
        others = 'a point that moves: at=run (its end), or at={"motor.w": ...}'
        raise SimulationError(error.time, error.component, error.cause, f"{error.remedy}; or take {others}") from None


@contextmanager
def _named(sim: Simulation, program: Program, t: float) -> Iterator[None]:
    """A failure of the core as a SimulationError."""
    try:
        yield
    except RuntimeError as error:
        if sim.error is not None:
            raise SimulationError(t, *reason(program, Code.ERR_CALLBACK, sim)) from sim.error
        raise SimulationError(
            t, "", f"the point cannot be held ({error})", "look at the values of the train"
        ) from error
