"""One point of a study: what all points have in common, what a point makes of it, and what comes out of a chunk of them.

Knows nothing of how points are run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.sections import Section, section_period
from gearblocks.analysis.span import Span, program_span
from gearblocks.language.starts import is_rolling
from gearblocks.language.units import parse_unit
from gearblocks.simulation.arguments import parameter_vector, with_followed
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Options

Array = NDArray[np.float64]
Measure: TypeAlias = "Quantity | Callable[[Trajectory], float]"


class Axis(NamedTuple):
    """What varies: path, unit and place. kind: "parameter", "start" (a start value) or "input" (held constant).

    given_in: the unit of its values where that is none of SI.
    """

    path: str
    unit: str
    kind: str
    offset: int
    given_in: str = ""


def points_in_si(axes: Sequence[Axis], points: Array) -> Array:
    """Points, shape (points, axes), in SI."""
    if not any(axis.given_in for axis in axes):
        return points
    found = points.copy()
    for column, axis in zip(found.T, axes, strict=True):
        unit = parse_unit(axis.given_in)
        column[:] = [unit.in_si(value) for value in column.tolist()]
    return found


class Window(NamedTuple):
    """How long the runs are: to t_end [s], or transient + keep periods of a section."""

    begin: float
    end: float
    section: Section | None
    transient: int = 0
    keep: int | None = None
    periodic: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """All that a chunk of points needs besides the points. widths: how many columns each quantity has; steps_per_period: fixed
    steps in each period of the section (0: steps as the method wants them); in_lanes: points are stepped side by side;
    given_starts: offsets of start values that do not follow from Parameters."""

    model: Model
    axes: tuple[Axis, ...]
    base: Array
    measures: tuple[Measure, ...]
    widths: tuple[int, ...]
    window: Window
    options: Options
    inputs: Mapping[str, Any]
    initial: Any
    arguments: Mapping[str, Any]
    steps_per_period: int = 0
    in_lanes: bool = False
    given_starts: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Values of a chunk, shape (points, columns), messages by point, CPU time in the solver and time in all [s].

    cause: the first exception of a function of the user's, which may be a slip in it."""

    values: Array
    messages: Mapping[int, str] = field(default_factory=dict)
    seconds: float = 0.0
    took: float = 0.0
    cause: Exception | None = None


class Interrupted(Exception):  # noqa: N818  no error: the caller asked for it
    """The points of a chunk are not wanted any more."""


def point_vector(task: Task, point: Array) -> Array:
    """The parameter vector of a point."""
    model, vector, starts = task.model, task.base.copy(), {}
    for axis, value in zip(task.axes, point, strict=True):
        if axis.kind == "parameter":
            vector[axis.offset] = value
        elif axis.kind == "start":
            starts[axis.path] = float(value)
    if any(axis.path in model.start_parameters for axis in task.axes):
        vector = with_followed(model, vector, task.given_starts)
    if starts and not is_rolling(task.initial):
        vector = parameter_vector(model, {}, {**(task.initial or {}), **starts}, vector)
    return vector


def moves_starts(task: Task) -> bool:
    """Whether start values differ from point to point."""
    return any(axis.kind == "start" or axis.path in task.model.start_parameters for axis in task.axes)


def span_of(task: Task, vector: Array) -> Span:
    """The run of a point with this parameter vector."""
    program, window = task.model.program, task.window
    span = program_span(program, window.begin, window.end, vector, window.section)
    if not window.periodic or window.section is None:
        return span
    period = section_period(window.section, span.parameters)
    after, most = period * window.transient, window.keep
    end = period * (window.transient + (window.keep or 1))
    return Span(
        window.begin, end, span.units, span.components, span.losses, span.parameters, after, window.section, most
    )  # fmt: skip


def options_until(task: Task, end: float) -> Options:
    """The options of a run that ends there."""
    o, window = task.options, task.window
    step = end / ((window.transient + (window.keep or 1)) * task.steps_per_period) if task.steps_per_period else o.step
    if o.t_stop == end and o.step == step:
        return o
    return Options(o.method, o.locate, o.rtol, step, o.max_step, end)
