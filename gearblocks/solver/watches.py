"""Outputs that a run watches step by step (gb_watches of c/gb_core.h): how often they pass a limit, and when first.

Knows nothing of what they mean.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from gearblocks.solver.record import Record
from gearblocks.solver.structures import WatchesStructure, WatchStructure, address


class Seen(NamedTuple):
    """How often an output passed its limit, the time of the first [s] (NaN: never), its least and largest value."""

    times: int
    first: float
    least: float
    largest: float


@final
class Watches:
    """Outputs by number and the limit of each (0: changes of the sign), for one run."""

    def __init__(self, shared: ctypes.CDLL, sim: int | None, outputs: Sequence[int], limits: Sequence[float]) -> None:
        self._of = (WatchStructure * len(outputs))(*(WatchStructure(limit) for limit in limits))
        self._outputs = np.array(outputs, dtype=np.intc)
        self._room = np.empty(shared.gb_watch_room(sim, len(outputs)))
        self.raw = WatchesStructure(self._of, address(self._outputs), len(outputs), 0, address(self._room))
        shared.gb_watches_begin(self.raw)

    def enter(self, record: Record) -> None:
        """Lets what is recorded here be watched."""
        record.raw.watches = ctypes.addressof(self.raw)

    def end(self) -> list[Seen]:
        """What was seen of each up to the end of the run."""
        return [Seen(w.count, w.first, w.least, w.largest) for w in self._of]
