"""Step matrix of the implicit methods, and the Jacobian of the states that follows from it.

    S = E - g dG/dx - g^2 dG/ds B,        E x' = G(s, x),  s' = B x

s: kinematic states, eliminated before factoring; x: the other states and the speeds of massless groups. The core answers
S at any g, and the products B x and E r_x + g dG/ds r_s (gb_core.h); dG/dx is the part of S that is odd in g. Knows nothing
of the laws.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import POINTER, c_double, c_int, c_void_p
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.solver.sparse_maps import Array, Indices, disjoint, recovered, solved
from gearblocks.solver.structures import address

FAR = 1e30
"""The g [s] at which the stiffness shows alone, and nothing overflows."""


class _Pattern(ctypes.Structure):
    """gb_pattern."""

    _fields_ = [
        ("n", c_int),
        ("n_places", c_int),
        ("tree", c_int),
        ("ahead", c_int),
        ("order", POINTER(c_int)),
        ("start", POINTER(c_int)),
        ("row", POINTER(c_int)),
        ("pair", POINTER(c_int)),
    ]


PROTOTYPES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "gb_pattern_of": (POINTER(_Pattern), (c_void_p,)),
    "gb_step_matrix_sizes": (None, (c_void_p, POINTER(c_int), POINTER(c_int), POINTER(c_int))),
    "gb_step_matrix_at": (c_int, (c_void_p, c_void_p, c_void_p, c_double, *[c_void_p] * 4)),
    "gb_step_matrix_right_side": (c_int, (c_void_p, c_void_p, c_double, c_void_p, c_void_p)),
    "gb_kinematic_rates": (c_int, (c_void_p, c_void_p, c_void_p, c_void_p)),
}


class StepMatrix(NamedTuple):
    """S = E - g dG/dx - g^2 dG/ds B of c/gb_model.h: by unknown, by entry of the pattern below and above the diagonal,
    and the terms that right_side and kinematic_rates need."""

    g: float
    diag: Array
    lower: Array
    upper: Array
    kinematic_terms: Array

    def __repr__(self) -> str:
        return (
            f"<StepMatrix at g = {self.g:g} s: {len(self.diag)} unknowns, {len(self.lower)} entries below the diagonal>"
        )


def pattern_of(shared: ctypes.CDLL, sim: int | None) -> Pattern | None:
    """The pattern of the matrix; None where the model has none."""
    raw = shared.gb_pattern_of(sim)
    if not raw:
        return None
    p = raw.contents
    start, order = tuple(p.start[: p.n + 1]), tuple(p.order[: p.n])
    n_pairs = sum((b - a) * (b - a - 1) // 2 for a, b in pairwise(start[p.ahead :]))
    steps = [0] * p.n
    for step, unknown in enumerate(order):
        steps[unknown] = step
    return Pattern(order, tuple(steps), start, tuple(p.row[: p.n_places]), tuple(p.pair[:n_pairs]), p.ahead)


def sizes_of(shared: ctypes.CDLL, sim: int | None) -> tuple[int, int, int]:
    """Numbers of kinematic states, of massless speeds, and of kinematic terms (zeros without a pattern)."""
    sizes = (c_int(), c_int(), c_int())
    shared.gb_step_matrix_sizes(sim, *(ctypes.byref(x) for x in sizes))
    return sizes[0].value, sizes[1].value, sizes[2].value


def matrix_at(shared: ctypes.CDLL, sim: int | None, point: Any, y: Array, g: float) -> tuple[int, StepMatrix]:
    """The answer of the call and the step matrix at a point (gb_point)."""
    pattern = shared.gb_pattern_of(sim)
    n, entries = (pattern.contents.n, pattern.contents.n_places) if pattern else (0, 0)
    made = StepMatrix(g, *(np.zeros(k) for k in (n, entries, entries, sizes_of(shared, sim)[2])))
    code = shared.gb_step_matrix_at(sim, ctypes.byref(point), address(y), g, *(address(part) for part in made[1:]))
    return code, made


class Linear(Protocol):
    """The linear parts of a model at one instant, as a `Simulation` gives them."""

    def right_side(self, m: StepMatrix, r: Array) -> Array:
        """E r_x + g dG/ds r_s."""

    def kinematic_rates(self, m: StepMatrix, x: Array) -> Array:
        """B x."""


class ColumnGroups(NamedTuple):
    """Columns that share no row: of the right side by the states, and of the rates of kinematic states by the unknowns."""

    right_side: list[Indices]
    rates: list[Indices]

    def __repr__(self) -> str:
        return f"<ColumnGroups: {len(self.right_side)} of states, {len(self.rates)} of unknowns>"


def guessed_groups(
    pattern: Pattern, kinematic_rates: Callable[[Array], Array], n_kinematic: int, n_others: int
) -> ColumnGroups:
    """Groups that the pattern suggests: unknowns in the rate of a kinematic state are coupled to each other and to all
    equations in which that state stands. Few other states stand in a deflection: those of a prescribed angle."""
    colour = _colours(pattern)
    rates: list[list[int]] = [[] for _ in range(max(colour, default=-1) + 1)]
    for unknown, c in enumerate(colour):
        rates[c].append(unknown)
    B, served = recovered(kinematic_rates, (n_kinematic, len(colour)), rates, len(colour))
    around = [[i] for i in range(len(colour))]
    for k, column in enumerate(pattern.order):
        for row in pattern.row[pattern.start[k] : pattern.start[k + 1]]:
            around[column].append(pattern.order[row])
            around[pattern.order[row]].append(column)
    B = B.tocsr()
    first = [int(B.indices[start]) if start < end else -1 for start, end in pairwise(B.indptr)]
    by_state = disjoint([around[u] if u >= 0 else [-1 - i] for i, u in enumerate(first)])
    rest = n_kinematic + np.arange(n_others)
    return ColumnGroups([*(np.array(g, dtype=np.intp) for g in by_state), rest], served)


def _colours(pattern: Pattern) -> list[int]:
    """Colours of the unknowns, coupled ones different: backwards through the elimination, as gb_colours."""
    colour = [0] * len(pattern.order)
    for k in reversed(range(len(pattern.order))):
        used = 0
        for row in pattern.row[pattern.start[k] : pattern.start[k + 1]]:
            used |= 1 << colour[pattern.order[row]]
        colour[pattern.order[k]] = (~used & (used + 1)).bit_length() - 1
    return colour


def state_jacobian(
    sim: Linear,
    pattern: Pattern,
    sizes: tuple[int, int],
    matrix: Callable[[float], StepMatrix],
    groups: ColumnGroups | None,
) -> tuple[Any, ColumnGroups]:
    """d(dy)/dy of the states as a scipy.sparse matrix (CSC), the speeds of massless groups eliminated, and the
    groups of columns that served (for the next time).

    With y = [s | x] and massless speeds w: E x' = G, s' = B [x, w], 0 = the massless rows of G. sizes: numbers of kinematic
    states and of massless speeds; matrix: the step matrix for g. The right side holds the derivatives by kinematic states
    and by prescribed angles among the others, the matrix the rest. Raises ArithmeticError where a derivative is not
    finite or the massless speeds are not determined.
    """
    from scipy import sparse

    (n_kinematic, n_massless), n = sizes, len(pattern.order)
    k = n - n_massless
    first, last = _decades(matrix)
    far, near = matrix(10.0 ** (last + 6)), matrix(0.0)

    def rates(x: Array) -> Array:
        return sim.kinematic_rates(near, x)

    def slopes(r: Array) -> Array:
        return (sim.right_side(far, r) - sim.right_side(near, r)) / far.g

    guess = groups or guessed_groups(pattern, rates, n_kinematic, k)
    by_y, for_right_side = recovered(slopes, (n, n_kinematic + k), guess.right_side, n_kinematic + k)
    speeds, for_rates = recovered(rates, (n_kinematic, n), guess.rates, n)
    by_x = _rate_part(pattern, matrix, first, last)
    rows = by_y + sparse.hstack([sparse.csc_array((n, n_kinematic)), by_x[:, :k]], format="csc")
    kinematic = sparse.hstack([sparse.csc_array((n_kinematic, n_kinematic)), speeds[:, :k]], format="csc")
    if n_massless:
        massless = solved(by_x[k:, k:], rows[k:])
        rows, kinematic = rows[:k] - by_x[:k, k:] @ massless, kinematic - speeds[:, k:] @ massless
    others = solved(full_matrix(pattern, near)[:k, :k], rows)
    full = sparse.csc_array(sparse.vstack([kinematic, others], format="csc"))
    full.eliminate_zeros()
    if not np.isfinite(full.data).all():
        raise ArithmeticError("a derivative is NaN or infinite")
    return full, ColumnGroups(for_right_side, for_rates)


def unknowns_of(pattern: Pattern) -> tuple[Indices, Indices, Indices]:
    """Unknowns in the order of elimination; row and column of each entry below the diagonal."""
    order = np.array(pattern.order, dtype=np.intp)
    column = order[np.repeat(np.arange(len(order)), np.diff(pattern.start))]
    return order, order[np.array(pattern.row, dtype=np.intp)], column


def full_matrix(pattern: Pattern, m: StepMatrix) -> Any:
    """The matrix by unknown, a CSC array."""
    from scipy import sparse

    (order, row, column), n = unknowns_of(pattern), len(pattern.order)
    entries = np.concatenate([order, row, column]), np.concatenate([order, column, row])
    made = sparse.csc_array((np.concatenate([m.diag[order], m.lower, m.upper]), entries), shape=(n, n))
    made.eliminate_zeros()
    return made


def _decades(matrix: Callable[[float], StepMatrix]) -> tuple[int, int]:
    """Powers of ten that enclose, of all unknowns with a stiffness, the g at which it is as large as the inertia."""
    return decades_of(*(matrix(g).diag for g in (0.0, FAR, -FAR)))


def decades_of(still: Array, far: Array, back: Array) -> tuple[int, int]:
    """The same from the diagonals at g = 0, FAR and -FAR."""
    inertia, stiffness = np.abs(still), np.abs(far / 2 + back / 2) / FAR**2
    known = (inertia > 0) & (stiffness > 1e-55 * inertia)
    if not known.any():
        return -9, 0
    found = np.log10(inertia[known] / stiffness[known]) / 2
    return int(np.floor(found.min())), int(np.ceil(found.max()))


def _rate_part(pattern: Pattern, matrix: Callable[[float], StepMatrix], first: int, last: int) -> Any:
    """dG/dx, the part of the matrix that is odd in g: each entry from the g that leaves the least rounding."""
    best = [np.zeros_like(part) for part in matrix(0.0)[1:4]]
    least = [np.full(len(part), np.inf) for part in best]
    for exponent in (first - 6, *range(first, last + 1), last + 6):
        g = 10.0**exponent
        for i, (p, m) in enumerate(zip(matrix(g)[1:4], matrix(-g)[1:4], strict=True)):
            noise = np.maximum(abs(p), abs(m)) / g
            best[i] = np.where(noise < least[i], (m - p) / (2 * g), best[i])
            least[i] = np.minimum(noise, least[i])
    return full_matrix(pattern, StepMatrix(0.0, best[0], best[1], best[2], np.zeros(0)))
