"""A model at one point: rates, outputs and energies in frozen modes, and their derivatives as matrices.

Derivatives of the rates are those of the laws where they exist. All others are central differences: which entry depends on
which unknown is found first, by changing blocks of unknowns that are halved from round to round; columns that share no row
are then changed together. A chain of any length takes a few hundred evaluations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import SimulationError
from gearblocks.plurals import singular
from gearblocks.solver.active_set import ReducedRows, reduced
from gearblocks.solver.binding import Simulation
from gearblocks.solver.matrix_algebra import SPARSE, Algebra, Matrix
from gearblocks.solver.sparse_maps import Indices, disjoint
from gearblocks.solver.structures import Array, Code, Options
from gearblocks.solver.switched_constraints import ConstraintsAtPoint

_SHARE = 6e-6  # of the size of an unknown: its step, about the cube root of the rounding unit
_FLOOR = 1e-3  # smallest size of an angle or state taken for its step
_FLOOR_OF_SPEED = 1.0  # rad/s or m/s


@dataclass(frozen=True, eq=False)
class Point:
    """A model at (t, y) in frozen modes. means: excitations of time alone at their means; u: values of inputs; algebra: of
    its derivatives."""

    sim: Simulation
    program: Program
    t: float
    y: Array
    modes: Array
    u: Array | None = None
    means: bool = False
    algebra: Algebra = SPARSE

    def __repr__(self) -> str:
        return singular(
            f"<Point of '{self.program.name}' at t = {self.t:g} s: {len(self.y)} states, {len(self.modes)} modes>"
        )

    def at(self, **changes: Any) -> Point:
        """The same with other values."""
        return Point(**{**self.__dict__, **changes})

    def _look(self, wanted: str, y: Array | None, rates: Array | None = None) -> Array:
        where = self.y if y is None else y
        return self.sim.probe(self.t, where, self.modes, wanted, inputs=self.u, means=self.means, rates=rates)

    def rates(self, y: Array | None = None) -> Array:
        """dy/dt, length n_total."""
        return self._look("rates", y)

    def outputs(self, y: Array | None = None, rates: Array | None = None) -> Array:
        """All outputs; rates: taken as given (length n_total)."""
        return self._look("outputs", y, rates)

    def energies(self, y: Array | None = None) -> Array:
        """All energies."""
        return self._look("energies", y)

    def surfaces(self, y: Array | None = None) -> Array:
        """The event functions by switch, 0 for those of time alone."""
        return self._look("surfaces", y)

    def fitting_modes(self, y: Array | None = None) -> Array:
        """The modes that the state asks for."""
        return self._look("modes", y)

    def constraints(self) -> ConstraintsAtPoint:
        """The switched constraints here: rows, force bounds, constraint forces."""
        return self.sim.constraints_at(self.t, self.y, self.modes, inputs=self.u, means=self.means)

    def active_set(self) -> tuple[int, ...]:
        """The active set: numbers of the switched constraints with G v = 0 (stuck, closed)."""
        return tuple(i for i, x in enumerate(self.sim.constraints().constraints) if self.modes[x.active] > 0.5)

    def active_rows(self) -> ReducedRows | None:
        """G of the active set, reduced: G v = 0. None where nothing is active."""
        active = list(self.active_set())
        return reduced(self.constraints().rows[active]) if active else None

    def active_force_rows(self) -> ReducedRows | None:
        """Torques on the speeds per constraint force of the active set, reduced in the same way."""
        active = list(self.active_set())
        return reduced(self.constraints().force_rows[active]) if active else None

    def settled(self) -> Point:
        """The same with modes that fit state and time."""
        modes = self.modes
        for _ in range(20):  # GB_FLIPS: modes may depend on each other
            fit = self.at(modes=modes).fitting_modes()
            if np.array_equal(fit, modes):
                break
            modes = fit
        return self.at(modes=modes)


_OPTIONS = Options(2, 1, 1e-6, 0.0, np.inf, np.inf)


def restarted(point: Point) -> Array:
    """Lets changed parameters take effect on the derived values; the state, massless groups in balance."""
    point.sim.start(_OPTIONS, point.t, point.y)
    return point.sim.state()


@contextmanager
def opened(
    sim: Simulation, program: Program, t: float, y0: Array | None = None, *, beyond: bool = False
) -> Iterator[Point]:
    """A point at the start values of `sim` (parameters and inputs are set), or at y0, in the modes that fit.

    beyond: start values that lie beyond stops or slip in lossy ties pass too.

    Raises SimulationError where a rate is no number there, RuntimeError where the start itself fails (see sim.report).
    """
    code = sim.start(_OPTIONS, t, y0)
    let_pass = beyond and code is Code.ERR_BEYOND
    if code < 0 and not let_pass:
        raise RuntimeError(f"gb_start answered {code.name}")
    modes = np.zeros(len(program.switches)) if let_pass else sim.modes()  # a start that is refused has no modes yet
    point = Point(sim, program, t, sim.state(stopped=let_pass), modes).settled()
    bad = np.flatnonzero(~np.isfinite(point.rates()[: program.n]))
    if len(bad):
        raise SimulationError(
            t, program.states[int(bad[0])].name.rsplit(".", 1)[0], "a derivative is NaN or infinite",
            "look at the law and the values of this component, and at inertias of 0",
        )  # fmt: skip
    yield point


# -- derivatives ------------------------------------------------------------------------------------------------------


def steps_of(program: Program, y: Array) -> Array:
    """Size of the step of each entry of the state vector for differences."""
    floor = np.full(program.n_total, _FLOOR)
    speeds = [i for i, s in enumerate(program.states) if s.kind == "speed"]
    floor[speeds] = _FLOOR_OF_SPEED
    return np.asarray(_SHARE * np.maximum(np.abs(y), floor))


def derivative(
    function: Callable[[Array], Array], y: Array, columns: Indices, steps: Array,
    pattern: list[Indices] | None = None, algebra: Algebra = SPARSE,
) -> Matrix:  # fmt: skip
    """d function / d y[columns] at y, shape (len(function), len(columns)).

    steps: of all entries of y; pattern: what `dependents` found, where it is known.
    """
    pattern = dependents(function, y, columns, steps) if pattern is None else pattern
    rows, numbers, values = [], [], []
    for group in disjoint(pattern):
        moved = columns[group]
        up, down = y.copy(), y.copy()
        up[moved] += steps[moved]
        down[moved] -= steps[moved]
        change = function(up) - function(down)
        width = up - down
        for j in group:
            rows.append(pattern[j])
            numbers.append(np.full(len(pattern[j]), j))
            values.append(change[pattern[j]] / width[columns[j]])
    shape = (len(function(y)), len(columns))
    if not rows:
        return algebra.zeros(shape)
    return algebra.entries(np.concatenate(values), np.concatenate(rows), np.concatenate(numbers), shape)


def dependents(function: Callable[[Array], Array], y: Array, columns: Indices, steps: Array) -> list[Indices]:
    """Rows of function(y) that depend on each of y[columns]: blocks of columns are changed and halved; blocks without a
    common row go together.

    An entry that does not depend on what changed keeps every bit; changes of random size do not cancel each other.
    """
    base = function(y)
    size = np.random.default_rng(1).uniform(1.0, 2.0, len(columns))

    def changed(blocks: list[tuple[int, int]]) -> NDArray[np.bool_]:
        moved = y.copy()
        for start, end in blocks:
            moved[columns[start:end]] += steps[columns[start:end]] * size[start:end]
        return np.asarray(function(moved) != base)

    found: list[Indices] = [np.empty(0, dtype=np.intp)] * len(columns)
    blocks = [(0, len(columns))] if len(columns) else []
    rows = [np.flatnonzero(changed([block])) for block in blocks]
    while blocks:
        pending = []
        for (a, b), own in zip(blocks, rows, strict=True):
            if b - a == 1:
                found[a] = own
            elif len(own):
                pending.append(((a, b), own))
        blocks, rows = _halved(pending, changed)
    return found


def _halved(
    blocks: list[tuple[tuple[int, int], Indices]], changed: Callable[[list[tuple[int, int]]], NDArray[np.bool_]]
) -> tuple[list[tuple[int, int]], list[Indices]]:
    """The halves of blocks of columns, and the rows that each of them changes."""
    parts: list[tuple[int, int]] = []
    rows: list[Indices] = []
    for group in disjoint([own for _, own in blocks]):
        for half in (0, 1):
            moving = [((a, (a + b) // 2), ((a + b) // 2, b))[half] for a, b in (blocks[i][0] for i in group)]
            hit = changed(moving)
            parts += moving
            rows += [own[hit[own]] for own in (blocks[i][1] for i in group)]
    return parts, rows


def state_matrix(point: Point) -> Matrix:
    """d(dy/dt)/dy of the first n states in frozen modes, shape (n, n): from the derivatives of the laws where they
    exist, else from differences. The active set stays: G v' = 0."""
    active = point.active_rows()
    if point.sim.has_jacobian and (active is None or point.sim.constraints().plain):
        with suppress(ArithmeticError):
            A: Matrix = point.sim.jacobian(
                point.t, point.y, point.modes, inputs=point.u, means=point.means, dense=point.algebra.dense
            )
            return A if active is None else _with_constraint_forces(point, A, active)
    return differenced_state_matrix(point)


def _with_constraint_forces(point: Point, A: Matrix, active: ReducedRows) -> Matrix:
    """The matrix A with the constraint forces of the active set, which the laws do not know:

    A - M^-1 G' (G M^-1 G')^-1 G A    in the rows of the speeds.
    """
    n = A.shape[0]
    first = n - active.W.shape[1]
    M = point.sim.inertia(point.t, point.y, dense=point.algebra.dense)
    unknowns = np.arange(first, n) - point.sim.step_matrix_sizes()[0]
    rates = active.projected(M[unknowns][:, unknowns], A[first:], point.algebra)
    return point.algebra.stacked([[A[:first]], [rates]])


def differenced_state_matrix(point: Point) -> Matrix:
    """The same from differences."""
    n = point.program.n
    steps = steps_of(point.program, point.y)
    return derivative(lambda y: point.rates(y)[:n], point.y, np.arange(n), steps, algebra=point.algebra)
