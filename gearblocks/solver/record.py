"""What a run writes (gb_record): rows and events, handed over piece by piece without being copied twice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.solver.structures import EVENT, Array, RecordStructure, address

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
        self._new_rows(min(64, self._most_rows) if most_rows is None else self._most_rows)
        self._new_events(64)

    def take(self) -> tuple[Array, NDArray[np.void]]:
        """The rows and events recorded since the last call, the caller's own; the record is empty afterwards."""
        rows, events = self._rows[: self.raw.n_rows], self._events[: self.raw.n_events]
        if 2 * len(rows) < len(self._rows):
            rows = rows.copy()
            self.raw.n_rows = 0
        else:
            self._new_rows(min(4 * len(self._rows), self._most_rows))
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
