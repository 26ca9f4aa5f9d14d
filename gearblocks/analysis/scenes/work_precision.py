"""Work and precision of a scene: what an accuracy of its quantities costs, by method, tolerance and located corners.

Lines of runs, each line one method with events located or not, from a loose tolerance to tighter ones. A line ends where
it is as accurate as the reference, where it pays no more, or where its next run would take too much of the budget.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from time import thread_time
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Bench, Effort, Outcome, bench_of
from gearblocks.analysis.scenes.reference import Reference, growth, mean_of, reference_of
from gearblocks.analysis.scenes.scene import Scene, check_scene
from gearblocks.analysis.scenes.work_precision_points import Point, Verified
from gearblocks.analysis.scenes.work_precision_result import WorkPrecision
from gearblocks.errors import GearblocksWarning, ParameterError, SimulationError, by_name_only
from gearblocks.language.expression import finite_number
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]

METHODS = ("auto", "dp8", "dp5", "rodas")
TOLERANCES = tuple(10.0**-k for k in range(2, 11))
STEPS = tuple(2.0**-k for k in range(7))
_FOR_REFERENCE, _FOR_ONE = 1 / 8, 1 / 6  # of the budget: a run of the reference; a point of a line
_UNANSWERED = 2.0  # budgets, while no point is as accurate as it is asked for
_TOO_DEAR = 20.0  # times what as much accuracy costs elsewhere: such a line is not followed
_STOPS = 3  # runs in a row that do not come to their end, after which a line is given up
_FOR_TURNS, _TURNS = 1 / 20, 5  # of the budget: times of what is chosen, once more; how often
_SHORT, _REPEATS = 0.1, 3  # CPU seconds of a run that is timed so many times


@by_name_only
def work_precision(
    scene: Scene, *, budget: float = 60.0, progress: Callable[[str], None] | None = None
) -> WorkPrecision:  # fmt: skip
    """Error of each quantity of a scene against right-hand sides and CPU time, for methods, tolerances from 1e-2 to 1e-10,
    fixed steps, and events located or not (where there are any).

        print(gb.work_precision(scene).sentence)

    Errors are relative, against a reference at a tight tolerance, which runs of another method verify. Times are those of
    runs without their outputs. budget: CPU seconds for all runs together, about; what cannot pay is left out.
    progress: told in words what is being run.
    """
    check_scene("work_precision", scene)
    if finite_number("budget", budget) <= 0:
        raise ParameterError(f"budget = {budget!r} s must be > 0")
    return work_precision_of(bench_of(scene), budget, progress)


def work_precision_of(bench: Bench, budget: float, progress: Callable[[str], None] | None = None) -> WorkPrecision:
    """Work and precision of a train of a scene, which starts as the bench says."""
    runs = _Runs(bench, budget, progress or _silent)
    runs.tell("reference")
    reference = reference_of(runs.bench, runs.attempt, budget * _FOR_REFERENCE)
    patience = max(budget * _FOR_ONE / reference.enough, 2 * runs.attempt(Effort()).stats.cpu_seconds)
    runs.bench = replace(bench, patience=patience)
    _adaptive(runs, reference)
    _fixed(runs, reference)
    points = tuple(point for line in runs.lines for point in line.points)
    found = WorkPrecision(bench.scene, reference, _verified(reference, points), points)
    found = replace(found, points=runs.again(points, found.chosen()))
    while new := [point for point in found.offered() if point.line not in found.after]:
        found = replace(found, after={**found.after, **{point.line: runs.after(point) for point in new}})
    best = found.cheapest_or_none()
    return found if best is None else replace(found, quantities_cost=runs.extra(best))


def _silent(words: str) -> None:
    """Nobody is told."""


# -- runs -------------------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Line:
    """Points of one method with events located or not, as far as it goes."""

    method: str
    locate: bool
    points: list[Point] = field(default_factory=list)
    ended: bool = False
    took: list[float] = field(default_factory=list)  # CPU seconds of each point, all its runs and their quantities

    @property
    def last(self) -> Point | None:
        """The last point whose run came to its end."""
        return next((point for point in reversed(self.points) if not point.failure), None)


@final
@dataclass(slots=True)
class _Runs:
    """Runs of a scene within a budget [CPU s]; those of the same effort are made once."""

    bench: Bench
    budget: float
    tell: Callable[[str], None]
    began: float = field(default_factory=lambda: thread_time())
    lines: list[_Line] = field(default_factory=list)
    _made: dict[Effort, Outcome] = field(default_factory=dict)

    def attempt(self, effort: Effort) -> Outcome:
        """A run with its quantities. Raises SimulationError."""
        if effort not in self._made:
            self._made[effort] = self.bench.outcome(effort)
        return self._made[effort]

    def point(self, effort: Effort, reference: Reference) -> Point:
        """A run, or a mean over as many as the accuracy takes, with its error and the time of a run without outputs."""
        noise, members, scatter = reference.noise, reference.enough, None
        try:
            if reference.scattered:
                mean = mean_of(self.bench, effort, members)
                values, stats = mean.values, mean.stats
                scatter = mean.errors / reference.scale * np.sqrt(members)
                noise = np.hypot(noise, mean.errors / reference.scale)
            else:
                values, stats, *_ = self.attempt(effort)
        except SimulationError as error:
            nothing = np.full(len(noise), np.nan)
            return Point(effort, nothing, nothing, nothing, failure=str(error))
        stats = self.timed(effort, _REPEATS if stats.cpu_seconds < _SHORT else 1)
        return Point(effort, values, reference.errors(values), noise, members, scatter, stats)

    def timed(self, effort: Effort, repeats: int, bench: Bench | None = None) -> Stats:
        """The counters and the least CPU time of runs without outputs. They may be as bad as they like."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GearblocksWarning)
            return (bench or self.bench).timed(effort, repeats)

    def again(self, points: Sequence[Point], chosen: Sequence[Point]) -> tuple[Point, ...]:
        """Points, of which those chosen are timed again in turns, where that takes no twentieth of the budget: the least time
        counts, since what else the machine does at a time makes runs slower, never faster."""
        total = sum(point.stats.cpu_seconds for point in chosen)
        least = {point: point.stats for point in chosen}
        for _ in range(min(_TURNS, int(self.budget * _FOR_TURNS / max(total, 1e-9)))):
            for point in chosen:
                least[point] = min(least[point], self.timed(point.effort, 1), key=lambda stats: stats.cpu_seconds)
        return tuple(replace(point, stats=least.get(point, point.stats)) for point in points)

    def affords(self, predicted: float) -> bool:
        """Whether a point that takes so long [CPU s] is made. Until one is as accurate as it is asked for, there is twice the
        budget: on a machine that does other work the same runs take more CPU time."""
        budget = self.budget if self.answered else _UNANSWERED * self.budget
        return predicted <= min(budget * _FOR_ONE, budget - (thread_time() - self.began))

    @property
    def answered(self) -> bool:
        """Whether some point is as accurate as it is asked for."""
        within = self.bench.scene.within
        return any(point.within(within, slice(None)) for line in self.lines for point in line.points)

    def after(self, point: Point) -> float:
        """Right-hand sides of a window as long that follows, relative to those of the window; NaN where the run does not go
        on to its end."""
        try:
            longer = self.timed(point.effort, 1, self.bench.lengthened(2))
        except SimulationError:
            return float("nan")
        return longer.rhs_calls / point.stats.rhs_calls - 1.0

    def extra(self, point: Point) -> float:
        """CPU seconds that the quantities cost besides the run."""
        return max(self.attempt(point.effort).stats.cpu_seconds - point.stats.cpu_seconds, 0.0)


def _adaptive(runs: _Runs, reference: Reference) -> None:
    """Lines over tolerances, all of them at a tolerance before any at the next."""
    located = [True, False] if runs.attempt(Effort()).stats.events else [True]
    runs.lines = [_Line(method, locate) for locate in located for method in METHODS]
    for rtol in TOLERANCES:
        for line in runs.lines:
            effort = Effort(line.method, rtol, None, line.locate)
            if not line.ended:
                _extend(line, runs, reference, effort, growth(line.last.stats.method) if line.last else 1.0)


def _fixed(runs: _Runs, reference: Reference) -> None:
    """Lines of the classical Runge-Kutta method, from the mean step that dp5 takes."""
    scene = runs.bench.scene
    located = dict.fromkeys(line.locate for line in runs.lines)
    steps = [p.stats.steps for line in runs.lines if line.method == "dp5" for p in line.points if not p.failure]
    if not steps:
        return
    mean = (scene.end - scene.begin) / steps[0]
    lines = [_Line("rk4", locate) for locate in located]
    runs.lines += lines
    for part in STEPS:
        for line in lines:
            if not line.ended:
                _extend(line, runs, reference, Effort("rk4", 1e-6, float(f"{mean * part:.3g}"), line.locate), 2.0)


def _extend(line: _Line, runs: _Runs, reference: Reference, effort: Effort, factor: float) -> None:
    """The next point of a line, where it can be afforded; a first one as those of other lines, in the mean."""
    firsts = [other.took[0] for other in runs.lines if other.took]
    predicted = factor * line.took[-1] if line.took else sum(firsts) / max(len(firsts), 1)
    if not runs.affords(predicted):
        line.ended = True
        return
    runs.tell(str(effort))
    began = thread_time()
    line.points.append(runs.point(effort, reference))
    line.took.append(thread_time() - began)
    line.ended = _ends(line, runs)


def _ends(line: _Line, runs: _Runs) -> bool:
    """Whether smaller tolerances of a line tell no more: it is as good as the reference, or cannot pay."""
    last = line.points[-1]
    if len(line.points) >= _STOPS and all(point.failure for point in line.points[-_STOPS:]):
        return True
    if last.failure or not np.isfinite(last.errors).all():
        return False
    if (last.errors <= 2.0 * last.noise).all():
        return True
    others = [p for other in runs.lines for p in other.points if not p.failure and (p.errors <= last.errors).all()]
    least = min(p.stats.cpu_seconds for p in others)
    return last.stats.cpu_seconds > _TOO_DEAR * least


def _verified(reference: Reference, points: tuple[Point, ...]) -> Verified | None:
    """The tightest run of another method beside the reference."""
    taken = next((p.stats.method for p in points if p.effort == reference.effort), "dp8").split("+")
    others = [p for p in points if p.effort.locate and p.effort.method in ("dp5", "rodas", "dp8")]
    others = [p for p in others if not p.failure and p.effort.method not in taken[:1]]
    best = min(others, key=lambda p: (p.effort.rtol, float(p.errors.max())), default=None)
    return None if best is None else Verified(best.effort, best.errors)
