"""Solution of a run between its samples: smooth segments from step to step, with values at the nodes of Gauss and Lobatto.

    f on [t0, t1]:  f(t0 + h x_k), x_k the five nodes of Gauss and Lobatto on [0, 1], the ends being the sides of events

Integrals by these nodes have order 8; a polynomial through them shows where an extremum lies. The nodes are read from the
dense output of the same steps, for which a run is done twice: its steps do not depend on where they are sampled.
Knows nothing of what is asked of the values.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
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
from gearblocks.solver.structures import Array, Code

NODES: Array = np.array([0.0, 0.5 - np.sqrt(3 / 28), 0.5, 0.5 + np.sqrt(3 / 28), 1.0])
WEIGHTS: Array = np.array([1 / 20, 49 / 180, 16 / 45, 49 / 180, 1 / 20])
"""Nodes and weights of Gauss and Lobatto on [0, 1]: exact for polynomials of degree 7."""
_SHORT = 1e-13  # relative to t: a segment so short has no room for nodes
_NO_PICK: NDArray[np.intc] = np.zeros(0, dtype=np.intc)


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

    times: those that were asked for [s]; rows: [t | y] of the states there, the right limit at an event. start, begin: state
    and time at which it began; last: the state at the end. t0, t1: ends of the segments [s], shape (S,).
    """

    sim: Simulation
    program: Program
    case: Case
    needs: Needs
    stop: Callable[[], bool] | None = None
    seconds: float = 0.0
    _first: bool = True
    t0: Array = field(init=False)
    t1: Array = field(init=False)
    start: Array = field(init=False)
    turnover: float = field(init=False)
    energies: tuple[Array, Array] = field(init=False)
    events: Events = field(init=False)
    _values: Array = field(init=False)  # at the times, shape (T, outputs)
    _states: Array = field(init=False)  # rows of the times
    _times: Array = field(init=False)
    _nodes: Array = field(init=False)  # shape (S + parts of segments, 5, outputs)
    _pick: NDArray[np.intc] = field(init=False)
    _cut: dict[tuple[float, float], tuple[tuple[float, float], ...]] = field(init=False)
    _parts: dict[tuple[float, ...], int] = field(init=False)

    def __post_init__(self) -> None:
        numbers = self.program.output_numbers
        self._pick = np.array([numbers[name] for name in self.needs.outputs], dtype=np.intc)
        self._times = np.unique([*self.needs.times, self.case.end])
        if self.needs.windows:
            self._dense()
        else:
            events: list[NDArray[np.void]] = []
            self._sampled(self._times, self._times, events)
            self.events = events_of(self.program.event_table, events)
            self.t0 = self.t1 = np.empty(0)

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
        """The output at any times [s] that increase, none at an event; the run is done once more up to the last one."""
        column = self.needs.outputs.index(output)
        found = [values[:, column] for _, values in self._run(times, float(times[-1]), [])]
        return np.concatenate(found) if found else np.empty(0)

    # -- running ------------------------------------------------------------------------------------------------------

    def _run(
        self, samples: Array | None, end: float, events: list[NDArray[np.void]]
    ) -> Iterator[tuple[Array, Array]]:  # fmt: skip
        """Rows [t | y | ...] and the outputs there, piece by piece, of a run from the start; raises StoppedError."""
        code = self.sim.start(self.case.options, self.case.begin, self.case.y0)
        if code < 0:
            raise StoppedError(code)
        try:
            self.start = self.sim.state()
            begin = self.sim.energies()
        except RuntimeError:
            raise StoppedError(Code(self.sim.report.code)) from None
        record = self.sim.record(None if samples is None else len(samples))
        code, room = Code.PAUSE, memory_limit(samples is not None) / (os.cpu_count() or 1)
        while code != Code.DONE:
            before = thread_time()
            code = self.sim.run(samples, end, record)
            self.seconds += thread_time() - before
            rows, found = record.take()
            room -= rows.shape[0] * 8 * (1 + len(self._pick)) + found.nbytes
            if code < 0 or room < 0:
                raise StoppedError(code if code < 0 else Code.ERR_MEMORY)
            if len(found):
                events.append(found)
            if len(rows):
                if self._first:  # the whole run; what follows looks closer at parts of it
                    _, _, energy = self.sim.evaluate(rows[-1:], _NO_PICK, energies=True)
                    self.energies, self.turnover = (begin, energy[0]), float(self.sim.counters.turnover)
                yield rows, self.sim.evaluate(rows, self._pick)[1]
            if self.stop is not None and self.stop():
                raise StoppedError(None)
        self._first = False

    def _sampled(self, samples: Array, kept: Array, events: list[NDArray[np.void]]) -> Array:
        """Outputs at all samples, shape (len(samples), outputs); those of the times `kept` and the states there are kept."""
        n_total = self.program.n_total
        values = np.empty((len(samples), len(self._pick)))
        self._states, row = np.empty((len(kept), n_total)), 0
        at = np.searchsorted(samples, kept)
        for rows, outputs in self._run(samples, self.case.end, events):
            values[row : row + len(rows)] = outputs
            here = (at >= row) & (at < row + len(rows))
            self._states[here] = rows[at[here] - row, 1 : 1 + n_total]
            row += len(rows)
        self._values = values[at]
        return values

    def _dense(self) -> None:
        """Steps first, then the nodes between them and those of segments that a window cuts."""
        events: list[NDArray[np.void]] = []
        pieces = [(rows[:, 0].copy(), values) for rows, values in self._run(None, self.case.end, events)]
        self.events = events_of(self.program.event_table, events)
        t, at_rows = np.concatenate([t for t, _ in pieces]), np.concatenate([values for _, values in pieces])
        left = np.flatnonzero(t[1:] > t[:-1])
        self.t0, self.t1 = t[left], t[left + 1]
        self._cut = cut = {window: self._partial(*window) for window in self.needs.windows}
        parts = np.array(sorted({part for parts in cut.values() for part in parts}), dtype=np.float64).reshape(-1, 2)
        lower, upper = np.concatenate([self.t0, parts[:, 0]]), np.concatenate([self.t1, parts[:, 1]])
        inner = lower[:, None] + (upper - lower)[:, None] * NODES[1:-1]
        roomy = upper - lower > _SHORT * np.abs(upper)
        samples = np.unique(np.concatenate([inner[roomy].ravel(), parts.ravel(), self._times]))
        values = self._sampled(samples, self._times, [])
        nodes = np.empty((len(lower), 5, len(self._pick)))
        ends = values[np.searchsorted(samples, parts)]
        nodes[:, 0] = np.concatenate([at_rows[left], ends[:, 0]])
        nodes[:, 4] = np.concatenate([at_rows[left + 1], ends[:, 1]])
        for row, (a, b) in enumerate(
            parts.tolist(), start=len(self.t0)
        ):  # an end of a segment is its side of the event
            i = int(np.searchsorted(self.t1, a, side="right"))
            nodes[row, 0] = nodes[i, 0] if a == self.t0[i] else nodes[row, 0]
            nodes[row, 4] = nodes[i, 4] if b == self.t1[i] else nodes[row, 4]
        nodes[:, 1:4] = nodes[:, :1] + (nodes[:, 4:] - nodes[:, :1]) * NODES[None, 1:-1, None]
        nodes[roomy, 1:4] = values[np.searchsorted(samples, inner[roomy])]
        self._nodes, self._parts = nodes, {tuple(p): len(self.t0) + i for i, p in enumerate(parts.tolist())}

    def _partial(self, after: float, before: float) -> tuple[tuple[float, float], ...]:
        """Parts of segments that the window [after, before] cuts."""
        i, j = np.searchsorted(self.t1, after, side="right"), np.searchsorted(self.t0, before) - 1
        first = i < len(self.t0) and self.t0[i] < after
        last = j >= 0 and before < self.t1[j]
        if first and last and i == j:
            return ((after, before),)
        found = [(after, float(self.t1[i]))] if first else []
        return (*found, *([(float(self.t0[j]), before)] if last else []))


def outputs_of(program: Program, names: Sequence[str]) -> tuple[str, ...]:
    """The names without repetition, in the order of the program."""
    numbers = program.output_numbers
    return tuple(sorted(dict.fromkeys(names), key=numbers.__getitem__))
