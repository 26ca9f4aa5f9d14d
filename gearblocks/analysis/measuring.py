"""Quantities of many runs of one model: a chunk of points goes in, a plain array comes out.

The runs share one simulation and make no trajectory, unless a quantity is a function of one. A point that fails is NaN and
leaves a message. Knows nothing of grids, executors and stores.
"""

from __future__ import annotations

import functools
import pickle
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.lane_measuring import measure_in_lanes
from gearblocks.analysis.quantities import SectionPoints
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.run_measuring import RunMeasuring
from gearblocks.analysis.span import Span
from gearblocks.analysis.study_point import Interrupted, Measure, Measured, Task, options_until, point_vector, span_of
from gearblocks.errors import GearblocksError
from gearblocks.language.starts import with_values
from gearblocks.simulation.run import run_model, silent
from gearblocks.simulation.solution import solution_of
from gearblocks.simulation.trajectory import Trajectory

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
    began = time.perf_counter()
    if any(not isinstance(one, Quantity) for one in task.measures):
        return _measure_trajectories(task, points, stop)
    runs = RunMeasuring(task, points, stop)
    runs.run()
    return Measured(runs.values, runs.messages, runs.seconds, time.perf_counter() - began)


def _measure_trajectories(task: Task, points: Array, stop: Callable[[], bool] | None) -> Measured:
    """Where some of them are functions of a trajectory."""
    values = np.full((len(points), sum(task.widths)), np.nan)
    messages: dict[int, str] = {}
    seconds, began, cause = 0.0, time.perf_counter(), None
    bounds = np.cumsum([0, *task.widths])
    for i, point in enumerate(points):
        if stop is not None and stop():
            raise Interrupted
        try:
            found, took = _of_a_trajectory(task, point)
        except Failed as failure:
            messages[i], cause = str(failure), cause or failure.cause
            continue
        seconds += took
        for j, value in enumerate(found):
            values[i, bounds[j] : bounds[j] + np.size(value)] = value
    return Measured(values, messages, seconds, time.perf_counter() - began, cause)


class Failed(Exception):  # noqa: N818  it is what happened to a point, not to the caller
    """A point that could not be measured; cause: the exception of a function of the user's."""

    def __init__(self, message: str, cause: Exception | None = None) -> None:
        super().__init__(message)
        self.cause = cause


def _of_a_trajectory(task: Task, point: Array) -> tuple[list[float | Array], float]:
    """The quantities of a point, and the CPU time in the solver [s]. Raises Failed."""
    program = task.model.program
    values = {axis.path: float(x) for axis, x in zip(task.axes, point, strict=True)}
    by_kind = {
        kind: {a.path: values[a.path] for a in task.axes if a.kind == kind} for kind in ("parameter", "start", "input")
    }
    base = dict(zip((p.path for p in program.parameters), task.base.tolist(), strict=True))
    base = {path: x for path, x in base.items() if path not in program.structural_paths}
    initial = with_values(task.initial, by_kind["start"])
    try:
        span = span_of(task, point_vector(task, point))
        arguments = dict(task.arguments)
        if "t" not in arguments:
            arguments["t_end"] = span.end
        if task.steps_per_period:
            arguments["step"] = options_until(task, span.end).step
        run = run_model(
            task.model, parameters={**base, **by_kind["parameter"]}, inputs={**task.inputs, **by_kind["input"]},
            initial=initial, progress=silent, **arguments,
        )  # fmt: skip
        if not run.complete:
            raise KeyboardInterrupt
        return [_of(one, run, span) for one in task.measures], run.stats.cpu_seconds
    except (GearblocksError, OverflowError) as error:
        raise Failed(str(error)) from error


def _of(measure: Measure, run: Trajectory, span: Span) -> float | Array:
    if isinstance(measure, Quantity):
        with solution_of(run, run.case, measure.needs(span)) as solution:
            return measure.measure(solution, span)
    try:
        answer = measure(run)
        if isinstance(answer, str) or not hasattr(answer, "__float__"):
            raise TypeError(f"its answer is {_answered(answer)}, where a quantity is one number")
        return float(answer)
    except Exception as error:
        raise Failed(f"{function_name(measure)}: {type(error).__name__}: {error}", error) from error


_NUMBER = ("float", "int", "float | None", float, int)
"""How declarations of numbers are written."""


def _answered(answer: Any) -> str:
    """An answer in words: None, or a kind of thing and the numbers that it has."""
    if answer is None:
        return "None"
    kind = type(answer)
    found = {
        n: p.fget.__annotations__.get("return") for n, p in vars(kind).items() if isinstance(p, property) and p.fget
    }
    told = {**getattr(kind, "__annotations__", {}), **found}
    numbers = [n for n, words in told.items() if getattr(words, "__forward_arg__", words) in _NUMBER]
    return f"of kind {type(answer).__name__}" + (f" (of which {', '.join(numbers)} are numbers)" if numbers else "")


def function_name(function: Any, unnamed: str = "lambda") -> str:
    """What a function of a trajectory is called; unnamed: what a lambda is."""
    while isinstance(function, functools.partial):
        function = function.func
    name = str(getattr(function, "__name__", type(function).__name__))
    return unnamed if name == "<lambda>" else name


def widths_of(task: Task, points: Array) -> tuple[int, ...]:
    """How many columns each quantity has: one, or as many as the longest of the points has in a section."""
    if not any(isinstance(measure, SectionPoints) for measure in task.measures):
        return (1,) * len(task.measures)
    spans = [span_of(task, point_vector(task, point)) for point in points]
    return tuple(
        max(m.length(span) for span in spans) if isinstance(m, SectionPoints) else 1 for m in task.measures
    )  # fmt: skip
