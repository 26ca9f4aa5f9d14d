"""Runs of a scene: its quantities on the solution, what the solver counted, and the CPU time of a run without its outputs.

A bench holds one train of a scene (the whole one, or one that lacks effects) ready to be run with any method, tolerance and
small change of its parameters. Knows nothing of what is compared with what.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from threading import Event
from time import thread_time
from typing import Any, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.linearization import DENSE
from gearblocks.analysis.measuring import function_name
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.analysis.sections import RELATIVE
from gearblocks.analysis.span import Span, program_span
from gearblocks.analysis.study_point import Interrupted, Measure
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError, ParameterError, SimulationError
from gearblocks.language.starts import is_rolling
from gearblocks.running import build
from gearblocks.simulation.arguments import (
    is_static,
    method_options,
    method_words,
    parameter_vector,
    set_inputs,
)
from gearblocks.simulation.carried_start import carried_start, carried_values
from gearblocks.simulation.case import Case
from gearblocks.simulation.equilibrium import static_state
from gearblocks.simulation.failures import reason
from gearblocks.simulation.input_series import with_tables
from gearblocks.simulation.measured_runs import StoppedError, measured_run, merged, run_again
from gearblocks.simulation.needs import Needs
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.simulation.records import Stats
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.run import run_case, stats_of
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model
from gearblocks.solver.point import opened, state_matrix
from gearblocks.solver.structures import Code

Array = NDArray[np.float64]


QUARTERS = 4
"""Parts of the window, each of which has its own trace."""
_MOST = 64  # outputs of a trace


class Effort(NamedTuple):
    """How a run is made: method, tolerance or fixed step [s], and whether events are located."""

    method: str = "auto"
    rtol: float = 1e-6
    step: float | None = None
    locate: bool = True

    def __str__(self) -> str:
        words = f"{self.method}, {f'step {self.step:g} s' if self.step is not None else f'rtol {self.rtol:g}'}"
        return words if self.locate else f"{words}, events not located"


class Outcome(NamedTuple):
    """What came of a run: values of the quantities, in their order, what the solver counted, and a trace of the motion.

    trace: deflections, twists and speeds at 33 times of each quarter of the window, shape (4, 33, outputs); rates: which
    of these are speeds, shape (outputs,).
    """

    values: Array
    stats: Stats
    trace: Array
    rates: NDArray[np.bool_]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """One train of a scene, ready to be run. start: the state that it starts from (None: that of its parameters); patience:
    CPU seconds that a run may take; ended: set where no run is wanted any more."""

    scene: Scene
    drivetrain: Drivetrain
    model: Model
    parameters: Array
    inputs: Mapping[str, Any]
    start: Array | None
    patience: float = math.inf
    ended: Event = field(default_factory=Event)

    def outcome(self, effort: Effort, factors: Array | None = None) -> Outcome:
        """The quantities of a run, its parameters times `factors`, shape (n_parameters,), where given.

        Raises SimulationError, Interrupted."""
        case, why = self._case(effort, factors)
        span, needs = self._asked(case.parameters)
        program = self.model.program
        with self.model.library.open() as sim:
            set_inputs(sim, program, self.inputs)
            before = thread_time()
            try:
                run = measured_run(
                    sim, case, needs, lambda: self.ended.is_set() or thread_time() - before > self.patience
                )
            except StoppedError as stopped:
                if self.ended.is_set():
                    raise Interrupted from None
                if stopped.code is None:
                    words = f"the run takes more than {self.patience:.3g} s of CPU time"
                    raise SimulationError(sim.counters.t, "", words, "give it a larger budget") from None
                code = stopped.code
                raise SimulationError(sim.report.t, *reason(program, code, sim)) from None
            counters, cpu = sim.counters, thread_time() - before
        measures = self.scene.measures
        whole = (
            None if all(isinstance(m, Quantity) for m in measures) else _uninterrupted(run_case(self.model, case, why))
        )
        values = [_value(m, run if isinstance(m, Quantity) else whole, span) for m in measures]
        names = self._traced()
        trace = run.table(names, self._times()).reshape(QUARTERS, -1, len(names))
        rates = np.array([not name.endswith((".deflection", ".twist")) for name in names], dtype=np.bool_)
        return Outcome(np.array(values), stats_of(counters, cpu, *method_words(counters, why)), trace, rates)

    def timed(self, effort: Effort, repeats: int = 3) -> Stats:
        """What a run without any outputs takes: the counters, and the least CPU time of `repeats` runs. Raises
        SimulationError."""
        case, why = self._case(effort, None)
        ends = [self.scene.begin, self.scene.end]
        found = [_uninterrupted(run_case(self.model, case, why, t=ends, outputs=())).stats for _ in range(repeats)]
        return min(found, key=lambda stats: stats.cpu_seconds)

    def fastest(self) -> float:
        """The shortest time constant at the start [s], 1 over the largest eigenvalue in size; NaN where there is none, or the
        train is long."""
        program = self.model.program
        if not 0 < program.n <= DENSE:
            return float("nan")
        with self.model.library.open() as sim:
            sim.parameters[:] = self.parameters
            set_inputs(sim, program, self.inputs)
            with opened(sim, program, self.scene.begin, self.start) as point:
                matrix = state_matrix(point)
        values = np.linalg.eigvals(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
        largest = float(np.abs(values).max())
        return 1 / largest if largest > 0 else float("nan")

    def lengthened(self, times: int) -> Bench:
        """The same train and start, run so many times as long."""
        begin, end = self.scene.begin, self.scene.end
        return replace(self, scene=self.scene.changed(t_end=begin + times * (end - begin)))

    def _case(self, effort: Effort, factors: Array | None) -> tuple[Case, str]:
        options, why = method_options(effort.method, effort.rtol, effort.step, None, effort.locate, self.scene.end)
        vector = self.parameters if factors is None else self.parameters * factors
        return Case(
            self.model.library, vector, self.inputs, options, self.scene.begin, self.scene.end, self.start, run_again
        ), why

    def _asked(self, parameters: Array) -> tuple[Span, Needs]:
        program = self.model.program
        span = program_span(program, self.scene.begin, self.scene.end, parameters, None)
        asked = [m for m in self.scene.measures if isinstance(m, Quantity)]
        for m in asked:
            m.unit(span)
        trace = Needs(self._traced(), tuple(self._times().tolist()))
        return span, merged(program, [trace, *(m.needs(span) for m in asked)])

    def _times(self) -> Array:
        """Times of the trace [s]."""
        return np.linspace(self.scene.begin, self.scene.end, QUARTERS * 33)

    def _traced(self) -> tuple[str, ...]:
        """Outputs of the trace."""
        program = self.model.program
        names = [name for name in program.output_numbers if name.rpartition(".")[2] in RELATIVE]
        names += [state.name for state in program.states if state.name.endswith((".w", ".v"))]
        return tuple(names[:: 1 + len(names) // _MOST])


def _uninterrupted(run: Trajectory) -> Trajectory:
    """A run, unless Ctrl-C ended it."""
    if not run.complete:
        raise KeyboardInterrupt
    return run


def _value(measure: Measure, run: Any, span: Span) -> float:
    if isinstance(measure, Quantity):
        return float(measure.measure(run, span))
    try:
        return float(measure(run))
    except GearblocksError:
        raise
    except Exception as error:
        words = f"{type(error).__name__}: {error}; it must answer a number for the trajectory of every run"
        raise ParameterError(f"the quantity '{function_name(measure)}' raises {words}") from error


def bench_of(
    scene: Scene, drivetrain: Drivetrain | None = None, full: Model | None = None, model: Model | None = None
) -> Bench:
    """The bench of a scene's own train, or of one that lacks some of its effects and starts as it does.

    full, model: of the scene's own train and of this one, where they are built. Parameters and inputs of the scene that went
    with an effect are left out. Raises ModelError, ParameterError, UnknownNameError, and SimulationError where there is no
    start.
    """
    full = full or build(scene.drivetrain)
    tuned, driven, initial = scene.parameters, with_tables(scene.inputs), scene.initial
    if drivetrain is None:
        model = full
        warn_of_parameters(full, tuned)
    else:
        model = model or build(drivetrain)
        initial = carried_start(full, model, initial, t_start=scene.begin, parameters=tuned, inputs=driven)
        tuned, driven = carried_values(model, tuned), carried_values(model, driven, inputs=True)
    vector = parameter_vector(model, tuned, initial)
    if is_rolling(initial):
        vector = _rolled(model, vector, driven, initial, scene.begin)
    start = _start(model, vector, driven, initial, scene.begin)
    return Bench(scene, drivetrain or scene.drivetrain, model, vector, driven, start)


def _rolled(model: Model, vector: Array, inputs: Mapping[str, Any], initial: Any, begin: float) -> Array:
    with model.library.open() as sim:
        sim.parameters[:] = vector
        set_inputs(sim, model.program, inputs)
        return rolled(model, sim, begin, initial)


def _start(model: Model, vector: Array, inputs: Mapping[str, Any], initial: Any, begin: float) -> Array | None:
    if not is_static(initial):
        return start_state(model.program, initial)
    with model.library.open() as sim:
        sim.parameters[:] = vector
        set_inputs(sim, model.program, inputs)
        try:
            return static_state(sim, model.program, begin, means=initial == "static")
        except RuntimeError:
            report = sim.report
            raise SimulationError(report.t, *reason(model.program, Code(report.code), sim)) from sim.error
