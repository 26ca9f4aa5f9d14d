"""Quantities of many points by located runs, one after the other in the core, of which no trajectory is made.

A point that fails is NaN and leaves a message. Knows nothing of grids, executors and stores.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.span import Span
from gearblocks.analysis.study_point import Interrupted, Task, moves_starts, options_until, point_vector, span_of
from gearblocks.codegen.program import Program
from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.language.starts import is_rolling, with_values
from gearblocks.simulation.arguments import is_static, set_inputs
from gearblocks.simulation.case import Case
from gearblocks.simulation.failures import reason
from gearblocks.simulation.measured_runs import MeasuredRun, Measuring, Runs, StoppedError, merged
from gearblocks.simulation.needs import Needs
from gearblocks.simulation.run import RESIDUAL, STILL
from gearblocks.simulation.start_states import start_state
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import Code

Array = NDArray[np.float64]


@final
@dataclass(slots=True, eq=False)
class RunMeasuring:
    """A chunk of points, shape (points, axes), being measured. values: shape (points, columns); messages: by number of the
    point; seconds: CPU time in the solver."""

    task: Task
    points: Array
    stop: Callable[[], bool] | None
    values: Array = field(init=False)
    messages: dict[int, str] = field(default_factory=dict)
    seconds: float = 0.0
    _which: list[int] = field(default_factory=list)  # the points that can be run,
    _vectors: list[Array] = field(default_factory=list)  # their parameters,
    _spans: list[Span] = field(default_factory=list)  # what the runs are, one for all where they are alike,
    _needs: list[Needs] = field(default_factory=list)  # what is asked of them, likewise,
    _starts: list[Array] = field(default_factory=list)  # and start states, where these are sought

    def __post_init__(self) -> None:
        self.values = np.full((len(self.points), sum(self.task.widths)), np.nan)

    def run(self) -> None:
        """Measures all points. Raises Interrupted."""
        task, program = self.task, self.task.model.program
        quantities = [q for q in task.measures if isinstance(q, Quantity)]
        with task.model.library.open() as sim:
            set_inputs(sim, program, task.inputs)
            self._prepare(sim, quantities)
            if not self._which:
                return

            def failed(number: int, code: Code) -> None:
                self.messages[self._which[number]] = why(sim, program, code)

            measuring = Measuring(sim, program, failed, self.stop)
            try:
                for number, run in measuring.measured(self._runs(sim)):
                    self._take(self._which[number], run, self._span(number), quantities)
            except StoppedError:
                raise Interrupted from None
            self.seconds = measuring.seconds

    def _prepare(self, sim: Simulation, quantities: list[Quantity]) -> None:
        """Parameters, span, needs and start of every point; one without them is left out with a message."""
        task, program = self.task, self.task.model.program
        static = is_static(task.initial)
        alike = task.window.section is None
        plain = not moves_starts(task)
        for i, vector in enumerate(self._plain_vectors() if plain else self.points):
            if self.stop is not None and self.stop():
                raise Interrupted
            try:
                parameters = vector if plain else point_vector(task, vector)
                known = alike and bool(self._spans)
                span = self._spans[0] if known else span_of(task, parameters)
                needs = None if known else merged(program, [q.needs(span) for q in quantities])
                if is_rolling(task.initial):
                    parameters = self._rolled(sim, parameters, i, span)
                start = self._balanced(sim, parameters, self._inputs(i, sim), span) if static else None
            except (GearblocksError, OverflowError) as error:
                sim.raise_end()
                self.messages[i] = str(error)
                continue
            except StoppedError as stopped:
                self.messages[i] = why(sim, program, stopped.code or Code.ERR_STATE)
                continue
            self._which.append(i)
            self._vectors.append(parameters)
            if needs is not None:
                self._spans.append(span)
                self._needs.append(needs)
            if start is not None:
                self._starts.append(start)

    def _span(self, number: int) -> Span:
        return self._spans[number if len(self._spans) > 1 else 0]

    def _plain_vectors(self) -> Array:
        """Parameter vectors where no start value varies."""
        vectors = np.tile(self.task.base, (len(self.points), 1))
        for j, axis in enumerate(self.task.axes):
            if axis.kind == "parameter":
                vectors[:, axis.offset] = self.points[:, j]
        return vectors

    def _inputs(self, i: int, sim: Simulation) -> Array:
        """Constant inputs at a point."""
        inputs = sim.inputs.copy()
        for axis, value in zip(self.task.axes, self.points[i], strict=True):
            if axis.kind == "input":
                inputs[axis.offset] = value
        return inputs

    def _balanced(self, sim: Simulation, vector: Array, inputs: Array, span: Span) -> Array:
        """The static equilibrium of a point."""
        from gearblocks.simulation.equilibrium import static_state

        sim.parameters[:], kept = vector, sim.inputs.copy()
        sim.inputs[:] = inputs
        try:
            return static_state(sim, self.task.model.program, span.begin, means=self.task.initial == "static")
        except RuntimeError:
            raise StoppedError(Code(sim.report.code)) from None
        finally:
            sim.inputs[:] = kept

    def _rolled(self, sim: Simulation, vector: Array, i: int, span: Span) -> Array:
        """The parameters of a point that starts rolling."""
        from gearblocks.simulation.rolling import rolled

        axes = zip(self.task.axes, self.points[i], strict=True)
        asked = with_values(self.task.initial, {axis.path: float(x) for axis, x in axes if axis.kind == "start"})
        sim.parameters[:], kept = vector, sim.inputs.copy()
        sim.inputs[:] = self._inputs(i, sim)
        try:
            return rolled(self.task.model, sim, span.begin, asked)
        finally:
            sim.inputs[:] = kept

    def _runs(self, sim: Simulation) -> Runs:
        task, program, first = self.task, self.task.model.program, self._spans[0]
        ends = np.array([span.end for span in self._spans])
        ends = np.full(len(self._which), first.end) if len(ends) == 1 else ends
        steps = np.array([options_until(task, end).step for end in ends.tolist()]) if task.steps_per_period else None
        varied = any(axis.kind == "input" for axis in task.axes)
        inputs = np.array([self._inputs(i, sim) for i in self._which]) if varied else None
        start = np.array(self._starts) if self._starts else start_state(program, task.initial)
        case = Case(
            task.model.library, self._vectors[0], task.inputs, options_until(task, first.end), first.begin, first.end, None
        )  # fmt: skip
        return Runs(case, np.array(self._vectors), ends, self._needs, inputs, steps, start)

    def _take(self, i: int, run: MeasuredRun, span: Span, quantities: list[Quantity]) -> None:
        """Its values; those of a section may be fewer than there is room for."""
        try:
            found = [q.measure(run, span) for q in quantities]
        except (GearblocksError, OverflowError) as error:
            self.messages[i] = str(error)
            return
        at = 0
        for width, value in zip(self.task.widths, found, strict=True):
            self.values[i, at : at + np.size(value)] = value
            at += width
        if run.turnover > STILL and run.missing > RESIDUAL * run.turnover:
            self.messages[i] = (
                f"its energy is balanced to {run.missing / run.turnover:.2g} of the turnover only: a smaller rtol makes it "
                f"better"
            )


def why(sim: Simulation, program: Program, code: Code) -> str:
    """Words for a run that could not go on."""
    if code == Code.ERR_MEMORY:
        return f"t = {sim.counters.t:.9g} s: the record of this run fills the memory that it may take"
    return str(SimulationError(sim.report.t, *reason(program, code, sim)))
