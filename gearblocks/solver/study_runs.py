"""Many runs of a model by one call of the core (gb_study of c/gb_core.h), of each of which a few numbers are kept.

Knows nothing of what points and numbers mean.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int, c_long, c_longlong, c_void_p
from dataclasses import dataclass
from enum import IntEnum
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import EVENT, Array, Code, Options, RecordStructure, address

_ROWS = 1 << 21  # bytes of the rows that a run leaves at once
_EVENTS = 1 << 12  # events that are kept before the caller has to take them


class QuantityKind(IntEnum):
    """What is kept of an output along a run."""

    PEAK = 0
    TROUGH = 1
    MEAN = 2
    RMS = 3
    STD = 4


class _Quantity(ctypes.Structure):
    """gb_quantity."""

    _fields_ = [
        ("kind", c_int),
        *((name, c_double) for name in ("after", "before", "value", "sum", "rest", "scale", "length")),
    ]


class _Quantities(ctypes.Structure):
    """gb_quantities."""

    _fields_ = [
        ("of", POINTER(_Quantity)),
        ("output", c_void_p),
        ("factor", c_void_p),
        ("count", c_int),
        ("follows", c_int),
        ("room", c_void_p),
    ]


class StudyStructure(ctypes.Structure):
    """gb_study."""

    _fields_ = [
        ("n_points", c_long),
        ("point", c_long),
        ("begun", c_int),
        ("lone_start", c_int),
        ("options", Options),
        ("t0", c_double),
        *((name, c_void_p) for name in ("parameters", "inputs", "start", "steps", "times", "windows")),
        *((name, c_void_p) for name in ("outputs", "states", "ledger", "sign")),
        ("n_times", c_long),
        ("n_outputs", c_int),
        ("n_states", c_int),
        ("n_ledger", c_int),
        ("record", RecordStructure),
        ("first", c_void_p),
        ("n_done", c_long),
        ("events_taken", c_longlong),
        *((name, c_void_p) for name in ("values", "start_states", "quantities", "balance", "events")),
    ]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """What the runs of P points follow from, by point: parameters (P, n_parameters); times [s], rising, the last one being
    the end, (P, T); windows [after, before] of the quantities, (P, Q, 2); inputs (P, n_inputs), steps [s] (P,) and start
    (P, n_total) or (n_total,), each None where it is that of the model and the options. options, t0 [s]: of all of them."""

    options: Options
    t0: float
    parameters: Array
    times: Array
    windows: Array
    inputs: Array | None = None
    steps: Array | None = None
    start: Array | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """What is kept: outputs and states at the times, by number, and kinds of quantities of outputs, which are multiplied by
    other outputs (factors; -1: by none)."""

    outputs: NDArray[np.intc]
    states: NDArray[np.intc]
    kinds: tuple[QuantityKind, ...]
    of: NDArray[np.intc]
    factors: NDArray[np.intc]


@final
class StudyRuns:
    """Runs in progress; what is found of them, by point: values (P, T, outputs + states), start_states (P, states), quantities
    (P, Q), balance (P, 4): energy at begin and end, what came in, turnover."""

    def __init__(self, sim: Simulation, program: Program, points: Points, wanted: Wanted) -> None:
        self._sim, self._points, self._wanted = sim, points, wanted
        (count, n_times), (place, sign) = points.times.shape, program.ledger_integrals
        n_outputs, n_states, n_kinds = len(wanted.outputs), len(wanted.states), len(wanted.kinds)
        self.values = np.empty((count, n_times, n_outputs + n_states))
        self.start_states, self.quantities = np.empty((count, n_states)), np.empty((count, n_kinds))
        self.balance = np.empty((count, 4))
        self.ends = np.zeros(count, dtype=np.int64)
        """How many events there were up to the end of each point."""
        width = 1 + program.n_total + len(program.switches) + len(program.inputs)
        rows = np.empty((max(1, min(n_times, _ROWS // (8 * width))), width))
        self._events = np.empty(_EVENTS, dtype=EVENT)
        record = RecordStructure(address(rows), 0, len(rows), address(self._events), 0, len(self._events), None, None)
        kinds = (_Quantity * max(n_kinds, 1))(*(_Quantity(kind) for kind in wanted.kinds))
        shared, handle = sim.handle
        room = np.empty(shared.gb_quantity_room(handle, n_kinds) if n_kinds else 0)
        quantities = _Quantities(kinds, address(wanted.of), address(wanted.factors), n_kinds, 0, address(room))
        if n_kinds:
            record.quantities = ctypes.addressof(quantities)
        first, ledger = np.empty(program.n_total), np.ascontiguousarray(place, dtype=np.intc)
        signs = np.ascontiguousarray(sign, dtype=np.float64)
        given = [points.parameters, points.inputs, points.start, points.steps, points.times, points.windows]
        arrays = [None if x is None else np.ascontiguousarray(x, dtype=np.float64) for x in given]
        found = [self.values, self.start_states, self.quantities, self.balance, self.ends]
        self._raw = StudyStructure(
            count, 0, 0, int(points.start is None or points.start.ndim == 1), points.options, points.t0,
            *map(address, arrays), address(wanted.outputs), address(wanted.states), address(ledger), address(signs),
            n_times, n_outputs, n_states, len(ledger), record, address(first), 0, 0, *map(address, found),
        )  # fmt: skip
        self._kept = (rows, kinds, room, quantities, first, ledger, signs, arrays)

    @property
    def point(self) -> int:
        """The point under way."""
        return int(self._raw.point)

    def run(self, seconds: float) -> Code:
        """Goes on for about so many seconds of CPU time. DONE: all points are; FULL: take the events; below zero: the
        point cannot be run."""
        shared, handle = self._sim.handle
        return Code(shared.gb_study_run(handle, ctypes.byref(self._raw), seconds))

    def skip(self) -> None:
        """Goes on with the next point: this one failed."""
        self.ends[self.point] = self._raw.events_taken + self._raw.record.n_events
        self._raw.point, self._raw.begun = self._raw.point + 1, 0

    def take_events(self) -> NDArray[np.void]:
        """The events since the last call, the caller's own; with room for four times as many after many of them."""
        record = self._raw.record
        events = self._events[: record.n_events].copy()
        self._raw.events_taken += len(events)
        record.n_events = 0
        if len(events) == len(self._events):
            self._events = np.empty(min(4 * len(events), 1 << 20), dtype=EVENT)
            record.events, record.event_capacity = address(self._events), len(self._events)
        return events
