"""Switched constraints of a model, as its core tells them: the switches of each, and at a point

    slip = G v,    forces' = (what G' or the lossy columns make of) lambda,    lower <= lambda <= upper

with the rows G over the speeds, the constraint forces lambda and their force bounds. Knows nothing of how the core finds
the active set.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_int, c_void_p
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from gearblocks.solver.structures import Array, address

PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "gb_constraints_of": (c_int, (c_void_p, POINTER(c_int), POINTER(c_int), c_void_p)),
    "gb_modes": (c_int, (c_void_p, c_void_p)),
    "gb_constraints_at": (c_int, (c_void_p,) * 9),
}


class ConstraintKind(IntEnum):
    """Kind of a switched constraint: friction or an unbounded lock; a stop; a lossy gear; its loss."""

    FRICTION = 0
    STOP = 1
    TIE = 2
    LOSS = 3


class ConstraintSwitches(NamedTuple):
    """A switched constraint: its kind and its switches.

    slip: direction of the slip (of a stop the sign of its gap, of a lossy tie that of its force); active: 1 while active;
    free: 1 while nothing presses it (-1: no such switch).
    """

    kind: ConstraintKind
    slip: int
    active: int
    free: int

    @property
    def is_stop(self) -> bool:
        """Whether it is a unilateral contact."""
        return self.kind is ConstraintKind.STOP

    def shown(self, modes: Array) -> float:
        """The mode as events show it: 0 stuck, 1 forward, -1 backward, 2 free; of a stop 1 closed, 0 open."""
        active, direction = modes[self.active] > 0.5, float(modes[self.slip])
        if self.is_stop:
            return float(active)
        return 0.0 if active else direction or 2.0

    def words(self, modes: Array) -> str:
        """The same in words."""
        if self.is_stop:
            return "closed" if self.shown(modes) else "open"
        return {0.0: "stuck", 1.0: "slides forward", -1.0: "slides backward"}.get(self.shown(modes), "free")


class ConstraintsAtPoint(NamedTuple):
    """All switched constraints at a point.

    rows: G, shape (constraints, speeds); force_rows: torques on the speeds per constraint force, same shape; bounds, shape
    (constraints, 5): lower and upper force bound, sizes of the sliding force against forward and backward slip, engagement;
    forces: constraint forces; violation: by how much they exceed their bounds; slip: G v (of stops the gap).
    """

    rows: Array
    force_rows: Array
    bounds: Array
    forces: Array
    violation: Array
    slip: Array

    def __repr__(self) -> str:
        return f"<{self.rows.shape[0]} switched constraints over {self.rows.shape[1]} speeds at a point>"


class ModelConstraints(NamedTuple):
    """The switched constraints of a model; steady: their rows G are constant; number of speeds."""

    constraints: tuple[ConstraintSwitches, ...]
    steady: bool
    n_speeds: int

    def __repr__(self) -> str:
        return f"<{len(self.constraints)} switched constraints over {self.n_speeds} speeds>"

    @property
    def shown(self) -> tuple[ConstraintSwitches, ...]:
        """Those whose mode is shown: all but lossy ties, whose mode is that of their loss."""
        return tuple(x for x in self.constraints if x.kind is not ConstraintKind.TIE)

    @property
    def plain(self) -> bool:
        """Whether the rates are those of the laws with constraint forces by G' alone: constant rows, no lossy ties."""
        return self.steady and not any(x.kind is ConstraintKind.TIE for x in self.constraints)


def constraints_of(shared: ctypes.CDLL, sim: int | None) -> ModelConstraints:
    """The switched constraints of a model."""
    n_speeds, steady = c_int(), c_int()
    count = shared.gb_constraints_of(sim, ctypes.byref(n_speeds), ctypes.byref(steady), None)
    table = np.zeros((count, 4), dtype=np.intc)
    shared.gb_constraints_of(sim, ctypes.byref(n_speeds), ctypes.byref(steady), address(table))
    constraints = tuple(ConstraintSwitches(ConstraintKind(p[0]), int(p[1]), int(p[2]), int(p[3])) for p in table)
    return ModelConstraints(constraints, bool(steady.value), n_speeds.value)


def constraints_at(shared: ctypes.CDLL, sim: int | None, point: Any, y: Array) -> tuple[int, ConstraintsAtPoint]:
    """The answer of the call and the switched constraints at a point (gb_point)."""
    constraints, _, n_speeds = constraints_of(shared, sim)
    n = len(constraints)
    made = ConstraintsAtPoint(
        np.zeros((n, n_speeds)), np.zeros((n, n_speeds)), np.zeros((n, 5)), *(np.zeros(n) for _ in range(3))
    )
    code = shared.gb_constraints_at(sim, ctypes.byref(point), address(y), *(address(part) for part in made))
    return code, made
