"""What a run writes (gb_record): rows and events, handed over piece by piece without being copied twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.solver.structures import EVENT, Array, RecordStructure, address

_NONE = np.empty(0, dtype=EVENT)
_PIECE = 8_000_000  # numbers in one piece of a record


class Record:
    """Room for the rows and events of a run, which grows with what is recorded. A row is [t | y | modes | inputs].

    most_rows: how many there can be at most, where that is known.
    """

    def __init__(self, width: int, most_rows: int | None = None) -> None:
        self._width, self._most_rows, self._most_events = width, max(64, min(8192, 2_000_000 // width)), 16384
        if most_rows is not None:
            self._most_rows = max(1, min(most_rows, max(64, _PIECE // width)))
        self.raw = RecordStructure()
        self._first = min(64, self._most_rows) if most_rows is None else self._most_rows
        self._new_rows(self._first)
        self._new_events(64)

    @property
    def is_new(self) -> bool:
        """Whether it is as it was made: empty, and not grown."""
        return len(self._rows) == self._first and self.raw.n_rows == self.raw.n_events == 0 and len(self._events) == 64

    def take(self) -> tuple[Array, NDArray[np.void]]:
        """The rows and events recorded since the last call, the caller's own; the record is empty afterwards."""
        raw = self.raw
        rows, events = self._rows[: raw.n_rows], self._events[:n_events] if (n_events := raw.n_events) else _NONE
        if 2 * len(rows) < len(self._rows):
            rows = rows.copy()
            raw.n_rows = 0
        else:
            self._new_rows(min(4 * len(self._rows), self._most_rows))
        if events is _NONE:
            return rows, events
        if 2 * len(events) < len(self._events):
            events = events.copy()
            self.raw.n_events = 0
        else:
            self._new_events(min(4 * len(self._events), self._most_events))
        return rows, events

    def _new_rows(self, capacity: int) -> None:
        self._rows = np.empty((capacity, self._width))
        self.raw.rows, self.raw.n_rows, self.raw.row_capacity = address(self._rows), 0, capacity

    def _new_events(self, capacity: int) -> None:
        self._events = np.empty(capacity, dtype=EVENT)
        self.raw.events, self.raw.n_events, self.raw.event_capacity = address(self._events), 0, capacity
