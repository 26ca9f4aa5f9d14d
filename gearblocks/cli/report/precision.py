"""What accuracy costs: error reached and CPU time spent, method by method, against a tight reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import SimulationError
from gearblocks.running import simulate
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Line:
    """One method with one way to treat corners, over its tolerances or steps (whichever is set)."""

    method: str
    locate: bool
    tolerances: tuple[float, ...] = ()
    steps: tuple[float, ...] = ()

    @property
    def label(self) -> str:
        """Words for a legend."""
        kind = "fixed step" if self.steps else "adaptive"
        return f"{self.method} {kind}, corners {'located' if self.locate else 'by stage'}"


@dataclass(frozen=True, slots=True)
class Point:
    """One run: what was asked for, the error reached, the CPU seconds, steps and right-hand sides spent."""

    asked: float
    error: float
    seconds: float
    steps: int
    rhs_calls: int


@dataclass(frozen=True, slots=True)
class Task:
    """The question: these outputs at these times, with these parameters, from the start values of the model.

    reference: the right answer, one column per output.
    """

    model: Model
    t: Array
    outputs: tuple[str, ...]
    parameters: dict[str, float]
    reference: Array

    def error(self, values: Array) -> float:
        """Largest deviation from the reference, each output relative to its own largest value."""
        scale = np.abs(self.reference).max(axis=0)
        worst = np.max(np.abs(values - self.reference) / scale)
        return max(float(worst), 1e-17) if np.isfinite(worst) else float("inf")


def pose(model: Model, t: Array, outputs: Sequence[str], parameters: dict[str, float]) -> tuple[Task, float]:
    """The task with its reference at rtol 1e-13, and how far another method at 1e-13 is from it."""
    names = tuple(outputs)
    first, second = (
        _columns(_run(model, t, names, parameters, {"method": method, "rtol": 1e-13}), names)
        for method in ("dp8", "dp5")
    )
    task = Task(model, t, names, parameters, first)
    return task, task.error(second)


def measure(task: Task, line: Line, repeats: int = 3) -> list[Point]:
    """Runs of one line; CPU time is the least of `repeats`. Runs that stop early are left out."""
    return [point for asked, options in _settings(line) if (point := _point(task, asked, options, repeats))]


def curves(task: Task, lines: Sequence[Line], tell: Callable[[str], None]) -> list[tuple[Line, list[Point]]]:
    """All lines, telling each as it is begun."""
    found = []
    for line in lines:
        tell(line.label)
        found.append((line, measure(task, line)))
    return found


def at_error(points: Sequence[Point], error: float) -> float | None:
    """CPU seconds at which the points reach `error` (between neighbours by logarithms), or None if never."""
    ordered = sorted(points, key=lambda point: -point.error)
    for worse, better in pairwise(ordered):
        if better.error <= error <= worse.error:
            span = np.log(worse.error / better.error)
            part = np.log(worse.error / error) / span if span > 0 else 1.0
            return float(np.exp(np.log(worse.seconds) * (1 - part) + np.log(better.seconds) * part))
    return ordered[0].seconds if ordered and ordered[0].error <= error else None


def _settings(line: Line) -> Iterator[tuple[float, dict[str, Any]]]:
    common = {"method": line.method, "locate": line.locate}
    for rtol in line.tolerances:
        yield rtol, common | {"rtol": rtol}
    for step in line.steps:
        yield step, common | {"step": step}


def _point(task: Task, asked: float, options: dict[str, Any], repeats: int) -> Point | None:
    seconds = float("inf")
    for _ in range(repeats):
        try:
            run = _run(task.model, task.t, task.outputs, task.parameters, options)
        except SimulationError:
            return None
        seconds = max(min(seconds, run.stats.cpu_seconds), 1e-9)
    return Point(asked, task.error(_columns(run, task.outputs)), seconds, run.stats.steps, run.stats.rhs_calls)


def _run(
    model: Model, t: Array, outputs: tuple[str, ...], parameters: dict[str, float], options: dict[str, Any]
) -> Trajectory:
    return simulate(model, t=t, outputs=outputs, parameters=parameters, **options)


def _columns(run: Trajectory, names: Sequence[str]) -> Array:
    return np.column_stack([run[name] for name in names])
