"""What sticks in a running model, as its core tells: which switches are whose, and rows, limits and forces at a point."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_int, c_void_p
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "gb_constraints_of": (c_int, (c_void_p, POINTER(c_int), POINTER(c_int), c_void_p)),
    "gb_modes": (c_int, (c_void_p, c_void_p)),
    "gb_constraints_at": (c_int, (c_void_p,) * 9),
}


class LockKind(IntEnum):
    """What a lock is: friction or an unlimited lock; a stop; a tie with losses; its loss."""

    FRICTION = 0
    STOP = 1
    TIE = 2
    LOSS = 3


class LockPlace(NamedTuple):
    """Kind of a lock, and its switches: slip (of a stop its gap, of a tie the sign of its force), hold, free (-1: none)."""

    kind: LockKind
    slip: int
    hold: int
    free: int

    @property
    def is_stop(self) -> bool:
        """Whether it is a unilateral contact."""
        return self.kind is LockKind.STOP

    def shown(self, modes: Array) -> float:
        """The mode as events show it: 0 stuck, 1 forward, -1 backward, 2 free; of a stop 1 closed, 0 open."""
        held, direction = modes[self.hold] > 0.5, float(modes[self.slip])
        if self.is_stop:
            return float(held)
        return 0.0 if held else direction or 2.0

    def words(self, modes: Array) -> str:
        """The same in words."""
        if self.is_stop:
            return "closed" if self.shown(modes) else "open"
        return {0.0: "stuck", 1.0: "slides forward", -1.0: "slides backward"}.get(self.shown(modes), "free")


class Locks(NamedTuple):
    """All locks at a point: rows over the speeds, shape (locks, speeds), and what a force does to these; limits: least and
    largest held force, sizes of the force against forward and backward slip, engagement; held forces, by how much they
    exceed their limits; slips (of stops: gaps)."""

    rows: Array
    pushes: Array
    limits: Array
    held: Array
    excess: Array
    slip: Array


class LocksOf(NamedTuple):
    """The locks of a model; whether their rows never change; number of speeds."""

    places: tuple[LockPlace, ...]
    steady: bool
    n_speeds: int

    @property
    def shown(self) -> tuple[LockPlace, ...]:
        """Those with a mode for people: all but the ties that losses go with."""
        return tuple(place for place in self.places if place.kind is not LockKind.TIE)

    @property
    def plain(self) -> bool:
        """Whether the derivatives of the laws and the rows tell all: no losses that depend on what is held."""
        return self.steady and not any(place.kind is LockKind.TIE for place in self.places)


def locks_of(shared: ctypes.CDLL, sim: int | None) -> LocksOf:
    """The locks of a model."""
    n_speeds, steady = c_int(), c_int()
    count = shared.gb_constraints_of(sim, ctypes.byref(n_speeds), ctypes.byref(steady), None)
    table = np.zeros((count, 4), dtype=np.intc)
    shared.gb_constraints_of(sim, ctypes.byref(n_speeds), ctypes.byref(steady), table.ctypes.data)
    places = tuple(LockPlace(LockKind(p[0]), int(p[1]), int(p[2]), int(p[3])) for p in table)
    return LocksOf(places, bool(steady.value), n_speeds.value)


def locks_at(shared: ctypes.CDLL, sim: int | None, point: Any, y: Array) -> tuple[int, Locks]:
    """The answer of the call and the locks at a point (gb_point)."""
    places, _, n_speeds = locks_of(shared, sim)
    n = len(places)
    made = Locks(np.zeros((n, n_speeds)), np.zeros((n, n_speeds)), np.zeros((n, 5)), *(np.zeros(n) for _ in range(3)))
    code = shared.gb_constraints_at(sim, ctypes.byref(point), y.ctypes.data, *(part.ctypes.data for part in made))
    return code, made
