"""Studies: quantities of one train over many values of its parameters, on threads or any executor, kept on disk as they go.

The model is built once; a chunk of points goes to a worker, an array comes back. Which worker, how many and in what chunks
changes no bit of the values.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.analysis.designs import Design, grid, paths_of, rows_of, with_numbers
from gearblocks.analysis.designs import cases as listed_cases
from gearblocks.analysis.measuring import measure, measure_packed, packed
from gearblocks.analysis.sections import Section
from gearblocks.analysis.study_point import Interrupted, Measured, Task, points_in_si
from gearblocks.analysis.study_progress import progress as shown_progress
from gearblocks.analysis.study_result import Study, listed
from gearblocks.analysis.study_store import StudyStore, needs_zarr
from gearblocks.analysis.study_task import Settings, check_varies, identity, names_of, number_given, task_of
from gearblocks.analysis.workers import as_done, executor_of
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, by_name_only, warn
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters, warn_of_rows
from gearblocks.solver.lanes import POINTS as LANES
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import os

Array = NDArray[np.float64]
Row = ArrayLike | Sequence[float | str]
"""Values of a path: numbers, or texts with their unit."""

_CHUNK_SECONDS = 0.5  # what a chunk should take: long against sending it, short against the patience of whoever waits
_MOST = 4096  # points in a chunk


@by_name_only
def sweep(
    train: Drivetrain | Model, values: Mapping[str, Row], *, quantity: Any, t_end: float | str | None = None,
    t: ArrayLike | None = None, t_start: float | str | None = None, section: Section | None = None, transient: int = 300,
    keep: int = 100, method: str = "auto", rtol: float = 1e-6, step: float | str | None = None,
    max_step: float | str | None = None, locate: bool = True, steps_per_period: int | None = None,
    inputs: Mapping[str, Any] | None = None,
    parameters: Mapping[str, float | str] | None = None, initial: Any = None, executor: Any = None, threads: int | None = None,
    chunk: int | None = None, store: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], Any] | None = None,
) -> Study:  # fmt: skip
    """Quantities over every combination of values by path: a grid with one dimension per path.

    values: by path of a parameter ("mesh.k"), start value ("motor.w") or input a row of numbers, or of texts with their unit
    ("200 MN/m"). quantity: one or several of
    gb.peak, trough, rms, mean, at, last, count, event_time, energy_lost, points, or functions of a trajectory that answer a
    number (slower). The runs are those of `gb.simulate` with t_end, t, t_start, method, rtol, step, max_step, locate,
    inputs, parameters and initial; or, with a section and no end, transient + keep periods of it, of which windows begin
    after the transient. steps_per_period: with a section, so many fixed steps of "rk4" in each period. Where nothing can
    stick in the train (gb.build(train).program.lanes) many points are then stepped side by side in vectors, nothing is
    located and quantities are those of the steps: five to a hundred times as fast, and coarse: to find where to look closely.
    executor: any of concurrent.futures, or a Dask client; else `threads` (default: every core).
    chunk: points that go to a worker at once (default: about half a second of them). store: a folder (Zarr, needs
    gearblocks[zarr]) that is written as it goes; the same call goes on after a kill and runs what is missing.
    progress: called with the points done and their number; without it a terminal shows points per second and time left,
    a notebook or a log a line.

    A point whose run fails is NaN and stands in `failures`, and so is one where a function of yours raises, unless it does so
    at the first point and at the last. Ctrl-C answers what is done; `complete` is then False. Raises
    ParameterError and UnknownNameError for bad arguments before anything is run, StorageError for a store of another study.
    """
    settings = Settings(
        t_end=t_end, t=t, t_start=t_start, section=section, transient=transient, keep=keep, method=method, rtol=rtol,
        step=step, max_step=max_step, locate=locate, steps_per_period=steps_per_period, inputs=inputs,
        parameters=parameters, initial=initial,
    )  # fmt: skip
    return _studied(train, grid, values, quantity, settings, executor, threads, chunk, store, progress)


@by_name_only
def study(
    train: Drivetrain | Model, cases: Sequence[Mapping[str, float | str]] | Mapping[str, Row], *, quantity: Any,
    t_end: float | str | None = None, t: ArrayLike | None = None, t_start: float | str | None = None,
    section: Section | None = None,
    transient: int = 300, keep: int = 100, method: str = "auto", rtol: float = 1e-6, step: float | str | None = None,
    max_step: float | str | None = None, locate: bool = True, steps_per_period: int | None = None,
    inputs: Mapping[str, Any] | None = None, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
    executor: Any = None, threads: int | None = None, chunk: int | None = None, store: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], Any] | None = None,
) -> Study:  # fmt: skip
    """Quantities over a list of cases: dicts of values by path, or columns of equal length by path, such as
    gb.latin_hypercube and gb.random_cases make. Everything else as in `gb.sweep`."""
    settings = Settings(
        t_end=t_end, t=t, t_start=t_start, section=section, transient=transient, keep=keep, method=method, rtol=rtol,
        step=step, max_step=max_step, locate=locate, steps_per_period=steps_per_period, inputs=inputs,
        parameters=parameters, initial=initial,
    )  # fmt: skip
    return _studied(train, listed_cases, cases, quantity, settings, executor, threads, chunk, store, progress)


def _studied(
    train: Drivetrain | Model, make: Callable[[Any], Design], given: Any, quantity: Any, settings: Settings, executor: Any,
    threads: int | None, chunk: int | None, store: str | os.PathLike[str] | None, tell: Callable[[int, int], Any] | None,
) -> Study:  # fmt: skip
    for name, number in (("threads", threads), ("chunk", chunk)):
        if number is not None and (isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number < 1):
            raise ParameterError(f"{name} = {number!r} must be a whole number, >= 1")
    if tell is not None and not callable(tell):
        raise ParameterError(f"progress = {tell!r:.80} must be a function of the points done and their number")
    if store is not None:
        needs_zarr(store)
    fields = train.field_paths() if isinstance(train, Drivetrain) else frozenset[str]()
    model = cache(lambda: build(train))  # built once, after a design that needs none of it has been looked at
    try:
        design = make(with_numbers(given, lambda path, x: number_given(model(), path, x, settings.initial, fields)))
    except ParameterError:
        for path in paths_of(given) & fields:  # rows of what is structural need be none of numbers
            check_varies(model(), path, settings.initial, fields)
        raise
    task, name_units = task_of(model(), design, quantity, settings, fields)
    warn_of_parameters(task.model, settings.parameters)
    warn_of_rows(task.model, rows_of(given))
    run = _Run(task, design, name_units)
    with executor_of(executor, threads) as (pool, workers):
        if store is not None:
            run.open_store(store, chunk, workers)
        run.size = run.store.chunk if run.store is not None else chunk or run.chunk_size(workers, keep=True)
        run.go(pool, workers, own=executor is None, tell=tell)
    return run.result()


class _Run:
    """A study in progress."""

    def __init__(self, task: Task, design: Design, name_units: Sequence[str]) -> None:
        self.task, self.design, self.name_units = task, design, tuple(name_units)
        self.points = points_in_si(task.axes, design.points)
        self.values = np.full((len(design.points), sum(task.widths)), np.nan)
        self.done = np.zeros(len(design.points), dtype=np.bool_)
        self.messages: dict[int, str] = {}
        self.store: StudyStore | None = None
        self.size = 1
        self.solver_seconds, self.began = 0.0, time.perf_counter()

    def chunk_size(self, workers: int, *, keep: bool = False) -> int:
        """Points that take about half a second, by a trial of the first one, which is kept where chunks may begin behind it;
        no fewer chunks than four for each worker. Raises ParameterError where a function of the user's has no value there,
        and none at the last point."""
        trial = measure(self.task, self.points[:1])
        if trial.cause is not None and (
            len(self.points) == 1 or measure(self.task, self.points[-1:]).cause is not None
        ):
            both = "at the first point and at the last one" if len(self.points) > 1 else "at the only point"
            raise ParameterError(
                f"quantity = {trial.messages[0]}: it fails {both}; mend the function, or let it answer float('nan') where a "
                "run has no such value"
            ) from trial.cause
        if keep:
            self._take(slice(0, 1), trial)
        share = -(-len(self.points) // (4 * workers))
        at_once = LANES if self.task.in_lanes else 1  # what the trial could have measured in that time
        return int(np.clip(at_once * _CHUNK_SECONDS / max(trial.took, 1e-9), 1, min(share, _MOST)))

    def open_store(self, path: str | os.PathLike[str], chunk: int | None, workers: int) -> None:
        """The store at `path` with what it has, or a new one."""
        whole = identity(self.task, self.design)
        self.store = StudyStore.found(path, whole)
        if self.store is None:
            words = {
                "train": self.task.model.program.name,
                "paths": self.design.paths,
                "quantities": names_of(self.task.measures),
            }
            size = chunk or self.chunk_size(workers)
            self.store = StudyStore.made(path, whole, len(self.values), self.values.shape[1], size, words)
        self.done[:] = self.store.done
        if self.done.any():
            self.values[self.done] = self.store.values()[self.done]
            self.messages.update({i: words for i, words in self.store.messages().items() if self.done[i]})

    def go(self, pool: Executor, workers: int, *, own: bool, tell: Callable[[int, int], Any] | None) -> None:
        """Measures what is missing, until the end or Ctrl-C."""
        begin = int(self.store is None and self.done[0])  # behind the trial
        starts = range(begin, len(self.done), self.size)
        chunks = [
            slice(a, min(a + self.size, len(self.done))) for a in starts if not self.done[a : a + self.size].all()
        ]
        stopped = threading.Event()
        submit = self._threads(pool, stopped) if own else self._processes(pool)
        try:
            with shown_progress(len(self.done), int(self.done.sum()), tell) as show:
                for chunk, measured in as_done(workers, chunks, submit):
                    self._take(chunk, measured)
                    show(int(self.done.sum()))
        except (KeyboardInterrupt, Interrupted):
            pass
        finally:
            stopped.set()

    def _threads(self, pool: Executor, stopped: threading.Event) -> Callable[[slice], Future[Measured]]:
        return lambda chunk: pool.submit(measure, self.task, self.points[chunk], stopped.is_set)

    def _processes(self, pool: Executor) -> Callable[[slice], Future[Measured]]:
        try:
            data = packed(self.task)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise ParameterError(
                f"this study cannot be sent to other processes ({error}): functions must be defined at the top of a module, "
                "and inputs be numbers or tables; threads need no sending"
            ) from error
        return lambda chunk: pool.submit(measure_packed, data, self.points[chunk])

    def _take(self, chunk: slice, measured: Measured) -> None:
        if self.store is not None:
            self.store.write(chunk.start, measured)
        self.values[chunk], self.done[chunk] = measured.values, True
        self.messages.update({chunk.start + i: words for i, words in measured.messages.items()})
        self.solver_seconds += measured.seconds

    def result(self) -> Study:
        """What was found; points in doubt are warned about."""
        task, design, window = self.task, self.design, self.task.window
        meta = {
            "train": task.model.program.name, "method": task.arguments["method"], "rtol": task.options.rtol,
            "steps_per_period": task.steps_per_period, "in_lanes": task.in_lanes,
            "begin": window.begin, "end": None if window.periodic else window.end,
            "seconds": time.perf_counter() - self.began, "solver_seconds": self.solver_seconds,
        }  # fmt: skip
        found = Study(
            tuple(axis.path for axis in task.axes), tuple(axis.given_in or axis.unit for axis in task.axes), design.points,
            design.shape if design.levels else (),
            names_of(task.measures), self.name_units, task.widths, self.values, self.done, self.messages, meta,
        )  # fmt: skip
        for array in (found.points, found.values, found.done):
            array.flags.writeable = False
        if found.doubts:
            warn(
                f"study of '{task.model.program.name}': {len(found.doubts)} of {len(found)} points are in doubt "
                f"(study.doubts):\n  {listed(found.doubts)}",
            )
        return found
