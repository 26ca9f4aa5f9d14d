"""Solution of a run between its samples: smooth segments from step to step, with values at the nodes of Gauss and Lobatto.

    f on [t0, t1]:  f(t0 + h x_k), x_k the five nodes of Gauss and Lobatto on [0, 1], the ends being the sides of events

Integrals by these nodes have order 8; a polynomial through them shows where an extremum lies. The nodes are read from the
dense output as the run goes. For a closer look at a part of it the run goes on once more from a saved state before: its
steps do not depend on where they are sampled.
Knows nothing of what is asked of the values.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from time import thread_time
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.simulation.case import Case
from gearblocks.simulation.events import Events, events_of
from gearblocks.simulation.run import memory_limit
from gearblocks.solver.binding import Simulation
from gearblocks.solver.record import Record
from gearblocks.solver.structures import Array, Code

NODES: Array = np.array([0.0, 0.5 - np.sqrt(3 / 28), 0.5, 0.5 + np.sqrt(3 / 28), 1.0])
WEIGHTS: Array = np.array([1 / 20, 49 / 180, 16 / 45, 49 / 180, 1 / 20])
"""Nodes and weights of Gauss and Lobatto on [0, 1]: exact for polynomials of degree 7."""
_INNER: Array = np.ascontiguousarray(NODES[1:-1])
_CORES = os.cpu_count() or 1
_SLICE = 0.01  # seconds of the solver between saved states of a run
_MARKS = 32 << 20  # bytes that these may take


class StoppedError(Exception):
    """The solver could not go on: its code; or None where the caller asked to stop."""

    def __init__(self, code: Code | None) -> None:
        super().__init__(code)
        self.code = code


@final
@dataclass(frozen=True, slots=True)
class Needs:
    """What is asked of a run: outputs by name; windows [after, before] of time [s] that count between the samples too, if
    any; times [s] at which states and outputs are wanted."""

    outputs: tuple[str, ...] = ()
    windows: tuple[tuple[float, float], ...] = ()
    times: tuple[float, ...] = ()


@final
@dataclass(slots=True, eq=False)
class Segments:
    """One run of a simulation whose parameters and inputs are set: values at times, at the end, and on smooth segments.

    start: state at which it began; t0, t1: ends of the segments [s], shape (S,); energies: at the begin and the end;
    turnover [J]; seconds: CPU time in the solver.
    """

    sim: Simulation
    program: Program
    case: Case
    needs: Needs
    stop: Callable[[], bool] | None = None
    seconds: float = 0.0
    t0: Array = field(init=False)
    t1: Array = field(init=False)
    start: Array = field(init=False)
    turnover: float = field(init=False)
    energies: tuple[Array, Array] = field(init=False)
    _values: Array = field(init=False)  # at the times, shape (T, outputs)
    _states: Array = field(init=False)  # there, shape (T, n_total)
    _times: Array = field(init=False)
    _nodes: Array = field(init=False)  # shape (S + parts of segments, 5, outputs)
    _pick: NDArray[np.intc] = field(init=False)
    _cut: dict[tuple[float, float], tuple[tuple[float, float], ...]] = field(init=False)
    _parts: dict[tuple[float, ...], int] = field(init=False)
    _recorded: list[NDArray[np.void]] = field(init=False)  # events as the solver recorded them
    _marks: list[tuple[float, bytes]] = field(init=False)  # saved states of the simulation with their times

    def __post_init__(self) -> None:
        numbers = self.program.output_numbers
        self._pick = np.array([numbers[name] for name in self.needs.outputs], dtype=np.intc)
        self._times = np.array(sorted({*self.needs.times, self.case.end}))
        self._marks = []
        self._recorded = []
        if self.needs.windows:
            self._dense()
        else:
            self.t0 = self.t1 = np.empty(0)
            self._keep(self._begin(self._times, None, slice_=0.05))

    @property
    def events(self) -> Events:
        """The events of the run."""
        return events_of(self.program.event_table, self._recorded)

    # -- reading ------------------------------------------------------------------------------------------------------

    @property
    def rtol(self) -> float:
        """Relative tolerance of the run."""
        return float(self.case.options.rtol)

    @property
    def loss_integrals(self) -> Mapping[str, int]:
        """Places in the state vector of the energy that each component has lost."""
        names, place = self.program.integral_components["loss"]
        return dict(zip(names, place.tolist(), strict=True))

    def value(self, output: str, time: float) -> float:
        """The output at one of the times that were asked for, or at the end."""
        return float(self._values[np.searchsorted(self._times, time), self.needs.outputs.index(output)])

    def state(self, time: float) -> Array:
        """The state vector with its quadratures at the begin, the end, or one of the times that were asked for."""
        if time <= self.case.begin:
            return self.start
        state: Array = self._states[np.searchsorted(self._times, time)]
        return state

    def within(self, output: str, after: float, before: float) -> tuple[Array, Array, Array]:
        """Segments within one of the windows that were asked for: t0, t1, shape (S,), and the output at their nodes, (S, 5)."""
        column = self.needs.outputs.index(output)
        whole = slice(int(np.searchsorted(self.t0, after)), int(np.searchsorted(self.t1, before, side="right")))
        t0, t1, nodes = self.t0[whole], self.t1[whole], self._nodes[: len(self.t0), :, column][whole]
        parts = self._cut[after, before]
        if not parts:
            return t0, t1, nodes
        cut = self._nodes[[self._parts[part] for part in parts], :, column]
        order = np.argsort(np.concatenate([t0, [a for a, _ in parts]]), kind="stable")
        t0, t1 = np.concatenate([t0, [a for a, _ in parts]])[order], np.concatenate([t1, [b for _, b in parts]])[order]
        return t0, t1, np.concatenate([nodes, cut])[order]

    def sample(self, output: str, times: Array) -> Array:
        """The output at any times [s] that increase."""
        column = self.needs.outputs.index(output)
        return np.concatenate([values[:, column] for _, values in self._look(times)])

    # -- running ------------------------------------------------------------------------------------------------------

    def _begin(self, samples: Array | None, inner: Array | None, slice_: float) -> Iterator[Array]:
        """Rows [t | y | ...] of the run from its start to its end, piece by piece; raises StoppedError."""
        code = self.sim.start(self.case.options, self.case.begin, self.case.y0)
        if code < 0:
            raise StoppedError(code)
        try:
            self.start, begin = self.sim.state(), self.sim.energies()
        except RuntimeError:
            raise StoppedError(Code(self.sim.report.code)) from None
        if inner is not None:
            self._mark()
        record = self.sim.record(None if samples is None else len(samples), inner)
        code, room = Code.PAUSE, memory_limit(samples is not None) / _CORES
        while code != Code.DONE:
            code = self._on(samples, record, slice_)
            rows, found = record.take()
            room -= rows.shape[0] * 8 * (1 + len(self._pick)) + found.nbytes
            if room < 0:
                raise StoppedError(Code.ERR_MEMORY)
            if len(found):
                self._recorded.append(found)
            if code != Code.DONE and inner is not None:
                self._mark()
            if len(rows):
                yield rows
        self.turnover = float(self.sim.counters.turnover)
        self.energies = begin, self.sim.energies()

    def _on(self, samples: Array | None, record: Record, slice_: float) -> Code:
        before = thread_time()
        code = self.sim.run(samples, self.case.end, record, slice_)
        self.seconds += thread_time() - before
        if code < 0:
            raise StoppedError(code)
        if self.stop is not None and self.stop():
            raise StoppedError(None)
        return code

    def _mark(self) -> None:
        """Saves the state of the simulation; of too many every second one stays."""
        self._marks.append((float(self.sim.counters.t), self.sim.save()))
        if len(self._marks) * len(self._marks[0][1]) > _MARKS:
            del self._marks[1::2]

    def _look(self, times: Array) -> Iterator[tuple[Array, Array]]:
        """Rows and outputs at times [s] that increase, by the steps of the run, again from the last saved state before."""
        fronts = np.array([front for front, _ in self._marks])
        of = np.maximum(np.searchsorted(fronts, times, side="right") - 1, 0)
        for mark in np.unique(of).tolist():
            wanted = np.ascontiguousarray(times[of == mark])
            self.sim.restore(self._marks[mark][1])
            record, code = self.sim.record(len(wanted)), Code.PAUSE
            while code != Code.DONE:
                code = self._on(wanted, record, 0.05)
                rows, _ = record.take()
                yield rows, self.sim.evaluate(rows, self._pick)[1]

    def _keep(self, pieces: Iterable[Array]) -> None:
        """States and outputs at the times that were asked for."""
        rows = [*pieces]
        self._states = np.concatenate([piece[:, 1 : 1 + self.program.n_total] for piece in rows])
        self._values = np.concatenate([self.sim.evaluate(piece, self._pick)[1] for piece in rows])

    def _dense(self) -> None:
        """Every step with its nodes; what lies at a time or in a part of a segment from a closer look."""
        low, high = min(a for a, _ in self.needs.windows), max(b for _, b in self.needs.windows)
        times, tables = [], []
        for rows in self._begin(None, _INNER, _SLICE):
            t = rows[:, 0].copy()
            first, last = np.searchsorted(t, low) - 1, np.searchsorted(t, high, side="right") + 4
            part = slice(max(int(first) - 4, 0), int(last))  # and the nodes of the segments that it cuts
            table = np.full((len(rows), len(self._pick)), np.nan)
            table[part] = self.sim.evaluate(rows[part], self._pick)[1]
            times.append(t)
            tables.append(table)
        between = self._times[self._times < self.case.end]
        self._keep([*(rows for rows, _ in self._look(between)), rows[-1:]])
        t, values = np.concatenate(times), np.concatenate(tables)
        at = _groups(t)
        self.t0, self.t1 = t[at[:, 0]], t[at[:, 4]]
        self._cut = {window: self._partial(*window) for window in self.needs.windows}
        parts = sorted({part for cut in self._cut.values() for part in cut})
        self._parts = {part: len(at) + i for i, part in enumerate(parts)}
        self._nodes = np.concatenate([values[at], *(self._of_part(*part, values[at])[None] for part in parts)])

    def _of_part(self, a: float, b: float, nodes: Array) -> Array:
        """Outputs at the nodes of a part of a segment, shape (5, outputs); an end of the segment is its side of an event."""
        times, where = np.unique(a + (b - a) * NODES, return_inverse=True)
        found = np.concatenate([values for _, values in self._look(times)])[where]
        i = int(np.searchsorted(self.t1, a, side="right"))
        if a == self.t0[i]:
            found[0] = nodes[i, 0]
        if b == self.t1[i]:
            found[4] = nodes[i, 4]
        return found

    def _partial(self, after: float, before: float) -> tuple[tuple[float, float], ...]:
        """Parts of segments that the window [after, before] cuts."""
        i, j = np.searchsorted(self.t1, after, side="right"), np.searchsorted(self.t0, before) - 1
        first = i < len(self.t0) and self.t0[i] < after
        last = j >= 0 and before < self.t1[j]
        if first and last and i == j:
            return ((after, before),)
        found = [(after, float(self.t1[i]))] if first else []
        return (*found, *([(float(self.t0[j]), before)] if last else []))


def _groups(t: Array) -> NDArray[np.intp]:
    """Numbers of the rows of each segment, shape (S, 5): its begin, three nodes, its end. A row at the time of the one before
    is the other side of an event."""
    new = 1 + np.flatnonzero(t[1:] != t[:-1])
    if len(new) % 4 == 0:
        first = new.reshape(-1, 4)[:, :1]
        found = first + np.arange(-1, 4)
        t0, t1 = t[found[:, :1]], t[np.minimum(found[:, 4:], len(t) - 1)]
        if found.max(initial=0) < len(t) and (t[found[:, 1:4]] == t0 + (t1 - t0) * _INNER).all():
            return found
    begins, row = [], 1  # a segment without room for nodes has them at its end
    while row < len(t):
        if t[row] != t[row - 1]:
            begins.append(row - 1)
            row += 4
        else:
            row += 1
    return np.array(begins, dtype=np.intp)[:, None] + np.arange(5)


def outputs_of(program: Program, names: Sequence[str]) -> tuple[str, ...]:
    """The names without repetition, in the order of the program."""
    numbers = program.output_numbers
    return tuple(sorted(dict.fromkeys(names), key=numbers.__getitem__))
