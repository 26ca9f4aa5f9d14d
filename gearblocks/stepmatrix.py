"""The matrix of implicit methods as Python sees it: the linear calls of c/gb_core.h."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int, c_void_p
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.pattern import Pattern

Array = NDArray[np.float64]


class _Pattern(ctypes.Structure):
    """gb_pattern."""

    _fields_ = [
        ("n", c_int),
        ("n_places", c_int),
        ("tree", c_int),
        ("order", POINTER(c_int)),
        ("start", POINTER(c_int)),
        ("row", POINTER(c_int)),
        ("pair", POINTER(c_int)),
    ]


PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "gb_pattern_of": (POINTER(_Pattern), (c_void_p,)),
    "gb_linear_sizes": (None, (c_void_p, POINTER(c_int), POINTER(c_int), POINTER(c_int))),
    "gb_linear_matrix": (c_int, (c_void_p, c_double, c_void_p, c_double, *[c_void_p] * 4)),
    "gb_linear_side": (c_int, (c_void_p, c_void_p, c_double, c_void_p, c_void_p)),
    "gb_linear_rates": (c_int, (c_void_p, c_void_p, c_void_p, c_void_p)),
}


class StepMatrix(NamedTuple):
    """S = E - g dG/dx - g^2 dG/ds B of c/gb_model.h: by unknown, by place below and above the diagonal, and the numbers
    that right_side and simple_rates need."""

    g: float
    diag: Array
    lower: Array
    upper: Array
    kept: Array


def pattern_of(shared: ctypes.CDLL, sim: int | None) -> Pattern | None:
    """The pattern of the matrix; None where the model has none."""
    raw = shared.gb_pattern_of(sim)
    if not raw:
        return None
    p = raw.contents
    start, order = tuple(p.start[: p.n + 1]), tuple(p.order[: p.n])
    n_pairs = sum((b - a) * (b - a - 1) // 2 for a, b in pairwise(start))
    steps = [0] * p.n
    for step, unknown in enumerate(order):
        steps[unknown] = step
    return Pattern(order, tuple(steps), start, tuple(p.row[: p.n_places]), tuple(p.pair[:n_pairs]))


def sizes_of(shared: ctypes.CDLL, sim: int | None) -> tuple[int, int, int]:
    """Numbers of simple states, of hidden speeds, and of what the Jacobian keeps (zeros without a pattern)."""
    sizes = (c_int(), c_int(), c_int())
    shared.gb_linear_sizes(sim, *(ctypes.byref(x) for x in sizes))
    return sizes[0].value, sizes[1].value, sizes[2].value


def matrix_at(shared: ctypes.CDLL, sim: int | None, t: float, y: Array, g: float) -> tuple[int, StepMatrix]:
    """The answer of the call and the matrix at (t, y) with the present modes."""
    pattern = shared.gb_pattern_of(sim)
    n, places = (pattern.contents.n, pattern.contents.n_places) if pattern else (0, 0)
    made = StepMatrix(g, *(np.zeros(k) for k in (n, places, places, sizes_of(shared, sim)[2])))
    code = shared.gb_linear_matrix(sim, t, y.ctypes.data, g, *(part.ctypes.data for part in made[1:]))
    return code, made
