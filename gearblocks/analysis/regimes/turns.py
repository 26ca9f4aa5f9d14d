"""States of a motion that goes on by whole turns, and their differences beside these. Knows nothing of trains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def without_turns(off: Array, turns: Array) -> Array:
    """Differences of states, shape (..., n), without whole turns."""
    if not turns.any():
        return off
    each = np.where(turns > 0.0, turns, 1.0)
    found: Array = off - np.where(turns > 0.0, each * np.round(off / each), 0.0)
    return found


def around(columns: Array, states: Array, turns: Array) -> Array:
    """Columns over points with those of the states that go round, as points of a circle beside them."""
    at = 2 * np.pi * states[:, turns > 0.0] / turns[turns > 0.0]
    return np.column_stack([columns, np.cos(at), np.sin(at)])
