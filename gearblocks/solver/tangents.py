"""Tangents beside a run (gb_tangents of c/gb_core.h): derivatives of the state by the start state, through steps and events.

Knows nothing of what they mean.
"""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int, c_long, c_longlong, c_void_p
from typing import NamedTuple, final

import numpy as np

from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import Array, Code, address


class TangentsStructure(ctypes.Structure):
    """gb_tangents."""

    _fields_ = [
        *((name, c_int) for name in ("count", "n_fixed", "index")),
        ("n_times", c_long),
        ("done", c_long),
        ("undefined", c_longlong),
        ("t", c_double),
        *(
            (name, c_void_p)
            for name in ("times", "scale", "fixed", "change", "columns", "states", "maps", "logs", "room")
        ),
        ("doubt", c_int),
        ("surface", c_int),
    ]


class Undefined(NamedTuple):
    """Events at which no derivative exists: how many, switch (-1: none by itself) and time [s] of the first."""

    events: int
    switch: int
    t: float


@final
class Tangents:
    """Columns beside a run that has just started. columns: shape (n, m); scale: sizes of the n states, in units of which they
    are made orthonormal, to fixed directions (orthonormal, shape (n, p)) too; change: of the parameters, that the last column
    goes along."""

    def __init__(
        self, sim: Simulation, n_total: int, columns: Array, scale: Array, fixed: Array, change: Array | None = None
    ) -> None:  # fmt: skip
        self._shared, self._sim = sim.handle
        self.n, self.m = columns.shape
        self._columns, self._fixed = (np.zeros((x.shape[1], n_total)) for x in (columns, fixed))
        self._columns[:, : self.n], self._fixed[:, : self.n] = columns.T, fixed.T
        self._scale = np.ascontiguousarray(scale, dtype=np.float64)
        self._change = None if change is None else np.ascontiguousarray(change, dtype=np.float64)
        self._room = np.empty(self._shared.gb_tangent_size(self._sim, self.m))
        self._raw = TangentsStructure(
            count=self.m, n_fixed=len(self._fixed), index=-1, scale=address(self._scale), fixed=address(self._fixed),
            columns=address(self._columns), room=address(self._room),
            change=None if self._change is None else address(self._change),
        )  # fmt: skip

    def begin(self, times: Array, *, maps: bool = False, logs: bool = False) -> None:
        """Times to reach, rising, from where the run stands. maps: the columns are kept at each; logs: they are made
        orthonormal at each, and the logarithms of their lengths kept."""
        width = self._columns.shape[1]
        self._times = np.ascontiguousarray(times, dtype=np.float64)
        self.states = np.empty((len(times), width))
        self._maps = np.empty((len(times) if maps else 0, self.m, width))
        self.logs = np.empty((len(times) if logs else 0, self.m))
        raw = self._raw
        raw.n_times, raw.done, raw.times = len(times), 0, address(self._times)
        raw.states, raw.maps, raw.logs = address(self.states), address(self._maps), address(self.logs)

    def run(self, seconds: float = 0.05) -> Code:
        """Goes on for about so many seconds of CPU time; DONE: all times are reached."""
        return Code(self._shared.gb_tangents_run(self._sim, ctypes.byref(self._raw), seconds))

    @property
    def done(self) -> int:
        """Times that are reached."""
        return int(self._raw.done)

    @property
    def maps(self) -> Array:
        """The columns at each time, shape (times, n, m)."""
        return np.ascontiguousarray(self._maps[:, :, : self.n].transpose(0, 2, 1))

    @property
    def columns(self) -> Array:
        """The columns where the run stands, shape (n, m)."""
        return np.ascontiguousarray(self._columns[:, : self.n].T)

    @property
    def undefined(self) -> Undefined:
        """Where no derivative exists."""
        return Undefined(int(self._raw.undefined), int(self._raw.index), float(self._raw.t))
