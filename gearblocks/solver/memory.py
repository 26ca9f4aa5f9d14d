"""The solver's memory of a simulation, which may serve another one: opening it takes longer than a short run.

A start clears all but parameters, inputs and what is tied to inputs. Knows nothing of runs.
"""

from __future__ import annotations

from contextlib import suppress
from ctypes import c_double
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from gearblocks.plurals import singular
from gearblocks.solver.record import Record
from gearblocks.solver.structures import Array

SPARE, SMALL = 4, 30_000
"""How many simulations of a model have their memory kept, up to so many states."""
NOTHING: Array = np.empty(0)


class Memory(NamedTuple):
    """The solver's memory for one simulation, with what looks into it: parameters, inputs; and an empty record."""

    sim: int
    parameters: Array
    inputs: Array
    record: Record | None

    def __repr__(self) -> str:
        return singular(f"<Memory of a simulation: {len(self.parameters)} parameters, {len(self.inputs)} inputs>")


def taken(spare: list[Memory] | None) -> Memory | None:
    """Spare memory, if there is any; other threads may take it at the same time."""
    with suppress(IndexError):
        return spare.pop() if spare else None
    return None


def view(place: int, length: int) -> Array:
    """A numpy view into the solver's memory."""
    return np.frombuffer(_vector(length).from_address(place)) if length else NOTHING


@cache
def _vector(length: int) -> Any:
    """The type of a row of doubles; ctypes would make it anew for every view."""
    return c_double * length
