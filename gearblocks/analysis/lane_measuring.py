"""Quantities of many points by fixed steps in the lanes of vectors: quick and coarse, to find where to look closely.

Each period of the section has the same number of steps of the classical Runge-Kutta method; nothing is located, and
quantities are those of the steps. Knows nothing of how points are handed out.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantities import Extremum, Integral, SectionPoints, Value
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.study_point import Interrupted, Measured, Task, point_vector, span_of
from gearblocks.solver.lanes import LaneResult, Lanes, LaneSteps

Array = NDArray[np.float64]

_AT_ONCE = 256  # points between two looks at whether to go on


def fits_lanes(task: Task) -> bool:
    """Whether the points of a study can be stepped in lanes: by what the train is and by what is asked of it."""
    plain = task.initial is None or isinstance(task.initial, dict)
    constant = all(not callable(x) and np.ndim(x) == 0 and hasattr(x, "__float__") for x in task.inputs.values())
    varied = any(axis.kind == "input" for axis in task.axes)
    asked = all(_is_of_steps(measure) for measure in task.measures)
    return bool(task.model.program.lanes) and plain and constant and not varied and asked and task.window.begin == 0.0


def _is_of_steps(measure: object) -> bool:
    """Whether a quantity follows from the steps that count."""
    if isinstance(measure, Integral) and measure.which == "std":
        return False
    if isinstance(measure, (Extremum, Integral)):
        return measure.after is None and measure.before is None
    return (isinstance(measure, Value) and measure.time is None) or (
        isinstance(measure, SectionPoints) and measure.section is None
    )


def measure_in_lanes(task: Task, points: Array, stop: Callable[[], bool] | None = None) -> Measured:
    """The quantities of a chunk of points, as `measure` answers them. Raises Interrupted where `stop` answers True."""
    began, cpu = time.perf_counter(), time.thread_time()
    quantities = [m for m in task.measures if isinstance(m, Quantity)]
    names = sorted({q.output for q in quantities})  # type: ignore[attr-defined]  # all that follow from steps have one
    numbers = task.model.program.output_numbers
    lanes = Lanes(task.model, [numbers[name] for name in names])
    rows = []
    for first in range(0, len(points), _AT_ONCE):
        if stop is not None and stop():
            raise Interrupted
        found = _stepped(task, lanes, points[first : first + _AT_ONCE])
        columns = [_value(q, found, names.index(q.output), task) for q in quantities]  # type: ignore[attr-defined]
        values = np.column_stack(columns)
        values[~np.isfinite(found.last).all(axis=1)] = np.nan
        rows.append(values)
    values = np.concatenate(rows)
    lost = np.flatnonzero(np.isnan(values).any(axis=1)).tolist()
    words = "its steps diverge: more of them in a period, or a located run"
    return Measured(values, dict.fromkeys(lost, words), time.thread_time() - cpu, time.perf_counter() - began)


def _stepped(task: Task, lanes: Lanes, points: Array) -> LaneResult:
    """The runs of some points."""
    window, count = task.window, task.steps_per_period
    vectors = np.array([point_vector(task, point) for point in points])
    ends = np.array([span_of(task, vector).end for vector in vectors])
    periods = window.transient + (window.keep or 1)
    inputs = task.model.program.input_starts.copy()
    for name, value in task.inputs.items():
        inputs[task.model.program.input_numbers[name]] = float(value)
    kept = (periods - window.transient) * count  # with a stride of as much, samples are the first and the last of these
    in_section = any(isinstance(m, SectionPoints) for m in task.measures)
    how = LaneSteps(
        steps=periods * count, period=count, first=window.transient * count, stride=count if in_section else kept,
        every=any(isinstance(m, (Extremum, Integral)) for m in task.measures),
    )  # fmt: skip
    return lanes.run(vectors, ends / (periods * count), inputs, how)


def _value(quantity: Quantity, found: LaneResult, output: int, task: Task) -> Array:
    """A quantity by point, shape (points,) or (points, its length)."""
    if isinstance(quantity, Extremum):
        return (found.largest if quantity.which == "peak" else found.least)[:, output]
    if isinstance(quantity, Integral):
        return (found.rms if quantity.which == "rms" else found.mean)[:, output]
    if isinstance(quantity, Value):
        return found.samples[:, -1, output]
    assert isinstance(quantity, SectionPoints)
    rows = found.samples[:, : task.window.keep, output]
    return rows if quantity.keep is None else rows[:, -quantity.keep :]
