"""Quantities of many runs of one model: a chunk of points goes in, a plain array comes out.

The runs share one simulation and make no trajectory, unless a quantity is a function of one. A point that fails is NaN and
leaves a message. Knows nothing of grids, executors and stores.
"""

from __future__ import annotations

import functools
import pickle
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.lane_measuring import measure_in_lanes
from gearblocks.analysis.quantities import SectionPoints
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.solution import Span, solution_of
from gearblocks.analysis.study_point import Interrupted, Measured, Task, point_vector, span_of
from gearblocks.codegen.program import Program
from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.simulation.arguments import is_static, set_inputs, start_state
from gearblocks.simulation.case import Case
from gearblocks.simulation.failures import reason
from gearblocks.simulation.run import RESIDUAL, STILL, run_model
from gearblocks.simulation.segments import Needs, Segments, StoppedError, outputs_of
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import Code, Options

Array = NDArray[np.float64]


def measure_packed(task: bytes, points: Array) -> Measured:
    """`measure` with a task as `packed` gives it, unpacked once in a process."""
    return replace(measure(_unpacked(task), points), cause=None)


def packed(task: Task) -> bytes:
    """The task as bytes, to be sent to other processes."""
    return pickle.dumps(task)


@functools.lru_cache(maxsize=2)
def _unpacked(task: bytes) -> Task:
    found = pickle.loads(task)  # from `packed`, by way of an executor, which pickles itself
    assert isinstance(found, Task)
    return found


def measure(task: Task, points: Array, stop: Callable[[], bool] | None = None) -> Measured:
    """The quantities of a chunk of points, shape (points, axes). Raises Interrupted where `stop` answers True."""
    if task.in_lanes:
        return measure_in_lanes(task, points, stop)
    values = np.full((len(points), sum(task.widths)), np.nan)
    messages: dict[int, str] = {}
    seconds, began, cause = 0.0, time.perf_counter(), None
    bounds = np.cumsum([0, *task.widths])
    with task.model.library.open() as sim:
        set_inputs(sim, task.model.program, task.inputs)
        for i, point in enumerate(points):
            if stop is not None and stop():
                raise Interrupted
            run = _Point(task, sim, point, stop)
            try:
                for j, found in enumerate(run.measured()):
                    values[i, bounds[j] : bounds[j] + np.size(found)] = found
            except Failed as failure:
                values[i] = np.nan
                messages[i] = str(failure)
                cause = cause or failure.cause
            seconds += run.seconds
            if run.doubt and i not in messages:
                messages[i] = run.doubt
    return Measured(values, messages, seconds, time.perf_counter() - began, cause)


class Failed(Exception):  # noqa: N818  it is what happened to a point, not to the caller
    """A point that could not be measured; cause: the exception of a function of the user's."""

    def __init__(self, message: str, cause: Exception | None = None) -> None:
        super().__init__(message)
        self.cause = cause


@dataclass(slots=True, eq=False)
class _Point:
    """One point being measured."""

    task: Task
    sim: Simulation
    point: Array
    stop: Callable[[], bool] | None
    seconds: float = 0.0
    doubt: str = ""

    def measured(self) -> list[float | Array]:
        """Its quantities. Raises Failed."""
        try:
            if any(not isinstance(measure, Quantity) for measure in self.task.measures):
                return self._of_a_trajectory()
            return self._of_segments()
        except (GearblocksError, OverflowError) as error:
            raise Failed(str(error)) from error
        except StoppedError as stopped:
            if stopped.code is None:
                raise Interrupted from None
            raise Failed(self._why(stopped.code)) from None

    def _why(self, code: Code) -> str:
        report, program = self.sim.report, self.task.model.program
        if code == Code.ERR_MEMORY:
            return f"t = {self.sim.counters.t:.9g} s: the record of this run fills the memory that it may take"
        name, cause, remedy = reason(program, code, report, self.sim.parameters)
        if code == Code.ERR_CALLBACK and self.sim.error is not None:
            remedy = f"{type(self.sim.error).__name__}: {self.sim.error}"
        return str(SimulationError(report.t, name, cause, remedy))

    def _of_segments(self) -> list[float | Array]:
        task, program = self.task, self.task.model.program
        vector = point_vector(task, self.point)
        self.sim.parameters[:] = vector
        for axis, value in zip(task.axes, self.point, strict=True):
            if axis.kind == "input":
                self.sim.inputs[axis.offset] = value
        span = span_of(task, vector)
        case = Case(
            task.model.library,
            vector,
            task.inputs,
            _until(task, span.end),
            span.begin,
            span.end,
            self._start(span),
        )
        quantities = [q for q in task.measures if isinstance(q, Quantity)]
        run = Segments(self.sim, program, case, needs_of(program, quantities, span), self.stop)
        found = [q.measure(run, span) for q in quantities]
        self.seconds = run.seconds
        self.doubt = _doubt(program, run)
        return found

    def _start(self, span: Span) -> Array | None:
        program, initial = self.task.model.program, self.task.initial
        if not is_static(initial):
            return start_state(program, initial)
        from gearblocks.simulation.equilibrium import static_state

        try:
            return static_state(self.sim, program, span.begin, means=initial == "static")
        except RuntimeError:
            raise StoppedError(Code(self.sim.report.code)) from None

    def _of_a_trajectory(self) -> list[float | Array]:
        task = self.task
        program = task.model.program
        values = {axis.path: float(x) for axis, x in zip(task.axes, self.point, strict=True)}
        by_kind = {
            kind: {a.path: values[a.path] for a in task.axes if a.kind == kind}
            for kind in ("parameter", "start", "input")
        }
        base = dict(zip((p.path for p in program.parameters), task.base.tolist(), strict=True))
        base = {path: x for path, x in base.items() if path not in program.structural_paths}
        initial = {**(task.initial or {}), **by_kind["start"]} if by_kind["start"] else task.initial
        span = span_of(task, point_vector(task, self.point))
        arguments = dict(task.arguments)
        if "t" not in arguments:
            arguments["t_end"] = span.end
        if task.steps_per_period:
            arguments["step"] = _until(task, span.end).step
        run = run_model(
            task.model, parameters={**base, **by_kind["parameter"]}, inputs={**task.inputs, **by_kind["input"]},
            initial=initial, **arguments,
        )  # fmt: skip
        if not run.complete:
            raise Interrupted
        self.seconds = run.stats.cpu_seconds
        found: list[float | Array] = []
        for one in task.measures:
            if isinstance(one, Quantity):
                found.append(_of(one, run, span))
                continue
            try:
                found.append(float(one(run)))
            except Exception as error:
                raise Failed(f"{function_name(one)}: {type(error).__name__}: {error}", error) from error
        return found


def _of(quantity: Quantity, run: Trajectory, span: Span) -> float | Array:
    with solution_of(run, quantity.needs(span)) as solution:
        return quantity.measure(solution, span)


def function_name(function: Any) -> str:
    """What a function of a trajectory is called."""
    return str(getattr(function, "__name__", type(function).__name__))


def needs_of(program: Program, quantities: list[Quantity], span: Span) -> Needs:
    """What several quantities need, together."""
    needs = [quantity.needs(span) for quantity in quantities]
    return Needs(
        outputs_of(program, [name for need in needs for name in need.outputs]),
        tuple(sorted({window for need in needs for window in need.windows})),
        tuple(sorted({time for need in needs for time in need.times})),
    )


def _until(task: Task, end: float) -> Options:
    """The options of a run that ends there."""
    o, window = task.options, task.window
    step = end / ((window.transient + (window.keep or 1)) * task.steps_per_period) if task.steps_per_period else o.step
    if o.t_stop == end and o.step == step:
        return o
    return Options(o.method, o.locate, o.rtol, step, o.max_step, end)


def _doubt(program: Program, run: Segments) -> str:
    """Words where the energy of a run does not balance, else "": the imbalance over the turnover, as after every run."""
    (begin, end), (place, sign) = run.energies, program.ledger_integrals
    change = run.state(run.case.end) - run.start
    missing = abs(float(end.sum()) - float(begin.sum()) + float((sign * change[place]).sum()))
    turnover = max(float(begin.sum()), float(end.sum())) + run.turnover
    if turnover <= STILL or missing <= RESIDUAL * turnover:
        return ""
    return f"its energy is balanced to {missing / turnover:.2g} of the turnover only: a smaller rtol makes it better"


def widths_of(task: Task, points: Array) -> tuple[int, ...]:
    """How many columns each quantity has: one, or as many as the longest of the points has in a section."""
    if not any(isinstance(measure, SectionPoints) for measure in task.measures):
        return (1,) * len(task.measures)
    spans = [span_of(task, point_vector(task, point)) for point in points]
    return tuple(
        max(m.length(span) for span in spans) if isinstance(m, SectionPoints) else 1 for m in task.measures
    )  # fmt: skip
