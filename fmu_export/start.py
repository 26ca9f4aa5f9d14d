"""The state that an FMU starts from, where it is not the one that the parameters give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError, SimulationError, warn
from gearblocks.language.starts import is_rolling
from gearblocks.simulation.arguments import check_start, is_static, parameter_vector
from gearblocks.simulation.equilibrium import static_state
from gearblocks.simulation.failures import reason
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array, Code, Options

_OPTIONS = Options(2, 1, 1e-6, 0.0, np.inf, np.inf)
_SAME = 1e-9
"""Relative difference of rates that is rounding."""


def start_offsets(program: Program) -> list[tuple[str, str, int]]:
    """Name, unit and index in the state vector of everything that a start state sets: states and unread angles."""
    offsets = [(state.name, state.unit, index) for index, state in enumerate(program.states[: program.n])]
    return offsets + [(f"{r.component}.angle", "rad", r.offset) for r in program.integrals if r.part == "angle"]


def started(
    model: Model, program: Program, parameters: Mapping[str, float | str], initial: Any
) -> tuple[Array, Array | None]:
    """The parameter vector, and the state vector (length n_total) to start from, or None for the one that the parameters give.

    initial: as in simulate(), or a state vector. An earlier run brings its parameters along, instead of which those given
    here are taken. Inputs are at their start values, time is 0. Raises ParameterError, and SimulationError where there is no
    equilibrium.
    """
    if initial is None or isinstance(initial, Mapping):
        return parameter_vector(model, parameters, initial), None
    if (state := start_state(program, initial)) is not None:
        return parameter_vector(model, parameters, initial), _finite(program, state)
    values = parameter_vector(model, parameters, None)
    if not (is_static(initial) or is_rolling(initial)):
        return values, _finite(program, _vector(program, initial))
    with model.library.open() as sim:
        sim.parameters[:], sim.inputs[:] = values, program.input_starts
        if is_rolling(initial):
            return rolled(model, sim, 0.0, initial), None
        try:
            return values, _finite(program, static_state(sim, program, 0.0, means=initial == "static"))
        except RuntimeError:
            report = sim.report
            raise SimulationError(report.t, *reason(program, Code(report.code), sim)) from sim.error


def say_when(model: Model, values: Array, start: Array | None, initial: Any) -> None:
    """A warning where an earlier run ended at a time that matters: with other rates than at 0, or beside events by time."""
    if start is None or not isinstance(initial, Trajectory) or initial.final_state is None:
        return
    end, program = initial.final_state.t, model.program
    with model.library.open() as sim:
        sim.parameters[:], sim.inputs[:] = values, program.input_starts
        if end == 0.0 or sim.start(_OPTIONS, end, start) < 0:
            return
        here, then = (sim.rhs(t, sim.state())[: program.n] for t in (0.0, end))
    timed = [s.component for s in program.switches if s.kind == "time"]
    if timed or np.abs(here - then).max(initial=0.0) > _SAME * np.abs(then).max(initial=0.0):
        warn(
            f"initial: the run ended at t = {end:.9g} s, and the train follows time; an FMU begins at 0 s unless its importer "
            f"says otherwise: give {end:.9g} s as its start time to go on with the run"
        )


def _vector(program: Program, initial: Any) -> Array:
    """What is given as a state vector. Raises ParameterError."""
    try:
        given = np.asarray(initial, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.array(np.nan)
    if given.ndim == 0:
        check_start("initial", initial)
    if given.shape != (program.n_total,):
        raise ParameterError(
            f"initial has shape {given.shape}; a state vector has {program.n_total} entries: give an earlier run, or start "
            f"values by name such as {{'motor.w': 100.0}}"
        )
    return given


def _finite(program: Program, given: Array) -> Array:
    """The state vector with 0 wherever there is no state. Raises ParameterError."""
    y = np.zeros(program.n_total)
    for name, _, i in start_offsets(program):
        if not np.isfinite(given[i]):
            raise ParameterError(f"the initial value of '{name}' = {given[i]!r} must be finite")
        y[i] = given[i]
    return y
