"""Static equilibrium: the state in which a train under its loads neither deforms further nor changes any state of a block.

Speeds and absolute angles stay as they are; relative angles and states of blocks are solved for. Where a train can turn
freely, its steady acceleration under loads that do not balance is allowed: the static state is the one that the
deflections settle in. With the mass matrix M, accelerations a and the free rotations N (B N = 0):

    L M (a(q, z) - N w) = 0,    z' = 0        in the unknowns q, z and the accelerations w of the free rotations

The active set confines the unknowns, q = q0 + D p with G v = 0, and takes the balances that its constraint forces can
answer: L F = 0 for their force rows F. Where nothing is active, D and L are 1. Whether the constraint forces lie within
their bounds is judged afterwards (friction_at_rest.py).

Newton's method in frozen modes, from no deflection where something is under load and from the start values elsewhere (of
several equilibria it finds one near the undeformed train); after each step the modes follow the state. A weak spring on
every coordinate keeps the matrix regular where no stiffness acts at the moment: a load inside a gap moves its coordinate far to
that side, where the contact takes over. A gap without load stays where it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError, SimulationError
from gearblocks.simulation.friction_at_rest import by_slips, judged, overlaps
from gearblocks.simulation.rolling import turning_along
from gearblocks.solver.active_set import ReducedRows, null_space, reduced
from gearblocks.solver.binding import Simulation
from gearblocks.solver.kinematics import Kinematics, kinematics, knows_derivatives
from gearblocks.solver.matrix_algebra import Matrix, algebra_of
from gearblocks.solver.point import Point, dependents, derivative, opened, restarted, state_matrix, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array

_ROUNDS = 200
_WEAK, _WEAKEST = 1e-2, 1e-6  # spring on a coordinate relative to its stiffness, after a change of modes and at the end
_FADES = 10.0  # of it, from step to step in the same modes
_FIRM, _FADES_SLOWLY = 1.0, 1.5  # both where full steps come round to the same modes
_NOTHING = 1e-14  # the same where the torques that are left do not shrink
_AHEAD = 1e-9  # rad, of how far the train has turned: by so much it turns on
_ROUNDING = 1e-13  # of the state
_NEAR, _STALLED = 1e-13, 1e-11  # of the largest torque: what rounding leaves, and at most where it does not shrink


@final
class _WindingUpError(ParameterError):
    """Start speeds that are no steady rotation."""


# -- equilibrium ------------------------------------------------------------------------------------------------------


def static_state(sim: Simulation, program: Program, t: float, *, means: bool, y0: Array | None = None) -> Array:
    """The state vector of the equilibrium from the start values (or y0); see `static_point`."""
    return static_point(sim, program, t, means=means, y0=y0).y


def static_point(sim: Simulation, program: Program, t: float, *, means: bool, y0: Array | None = None) -> Point:
    """The equilibrium from the start values (or y0), with excitations at their means or as at t. Where start speeds that nobody
    gave would wind something up, bodies turn along as in a rolling start.

    Raises ParameterError where speeds contradict each other, SimulationError where there is no equilibrium.
    """
    try:
        with opened(sim, program, t, y0) as point:
            return equilibrium(point.at(means=means))
    except _WindingUpError as wound:
        if y0 is not None:
            raise
        try:
            along = turning_along(sim, program, t, means=means)
        except ParameterError as error:
            raise ParameterError(f"{wound}; {str(error).removeprefix('initial: ')}") from None
        with opened(sim, program, t, along) as point:
            return equilibrium(point.at(means=means))


def static_outputs(sim: Simulation, program: Program, t: float, names: Sequence[str]) -> Array:
    """Outputs in the equilibrium from the start values, with excitations at their means. Errors as `static_state`."""
    found: Array = static_point(sim, program, t, means=True).outputs()
    return found[[program.output_numbers[name] for name in names]]


def equilibrium(point: Point) -> Point:
    """The equilibrium from a point, in the modes that fit it. Errors as `static_state`.

    Switched constraints without slip at the start are active, with the constraint force that balance asks for; those with
    one bound (a stop, a freewheel) become inactive where it would have the other sign. SimulationError where a constraint
    force exceeds its bounds.
    """
    given, point = point, by_slips(point.at(algebra=algebra_of(point.program.n)))
    for _ in range(4 * len(point.sim.constraints().constraints) + 1):
        found = _balanced(point)
        changed = judged(found)
        if changed is None:
            return found.at(algebra=given.algebra)
        point = changed
    raise SimulationError(
        point.t, "", "there is no static equilibrium: stops open and close without end",
        "give start values in place of initial='static'",
    )  # fmt: skip


def _balanced(point: Point) -> Point:
    """The equilibrium for the present active set."""
    kin = kinematics(point)
    if len(kin.coordinates) + len(kin.states) == 0 or len(kin.speeds) + len(kin.states) == 0:
        return point if point.sim.constraints().constraints else point.at(y=restarted(point))
    _check_speeds(point, kin)
    found = _Search(point, kin).run()
    return found if kin.active is None else found.at(y=_angles_following(kin, kin.active, point.y, found.y))


def _angles_following(kin: Kinematics, active: ReducedRows, before: Array, y: Array) -> Array:
    """The state with angles changed along with the coordinates so that G dphi = 0: no active constraint to the ground has
    slipped."""
    S = kin.algebra.stacked([[kin.B], [kin.E]])
    if len(kin.angles) == 0 or kin.massless:
        return y
    turned = np.concatenate([y[kin.coordinates] - before[kin.coordinates], np.zeros(len(kin.angles))])
    rows = kin.algebra.solved(S.T, active.W.T).T  # slips by coordinates and angles
    n_q, following = len(kin.coordinates), y.copy()
    following[kin.angles] -= np.linalg.lstsq(rows[:, n_q:], rows @ turned, rcond=1e-9)[0]
    return following


def fixed_combinations(kin: Kinematics, active: ReducedRows, angles: int) -> Array:
    """Combinations of the coordinates, and of the first so many of the angles, that the active set keeps constant, as rows."""
    S, n = kin.algebra.stacked([[kin.B], [kin.E]]).T, len(kin.coordinates) + angles
    if S.shape[0] == S.shape[1]:
        combined = kin.algebra.solved(S, active.W.T)
        rest, combined = combined[n:], combined[:n]
    else:  # massless groups: more coordinates than speeds
        dense = kin.algebra.array(S[:, :n])
        combined = np.asarray(np.linalg.lstsq(dense, active.W.T, rcond=None)[0], dtype=np.float64)
        rest = active.W.T - dense @ combined
    return np.asarray((combined @ null_space(rest, np.full(len(rest), np.abs(active.W).max(initial=0.0)))).T)


def _check_speeds(point: Point, kin: Kinematics) -> None:
    v = point.y[kin.speeds]
    if len(kin.coordinates) == 0 or kin.massless:
        return
    winding = point.rates()[kin.coordinates]  # prescribed speeds among them
    worst = int(np.argmax(np.abs(winding)))
    largest = float(np.abs(v).max(initial=0.0)) * float(kin.algebra.largest(kin.B, 1).max(initial=0.0))
    largest = max(largest, float(np.abs(winding - kin.B @ v).max()))
    if abs(winding[worst]) > 1e-9 * largest:
        name = point.program.states[kin.coordinates[worst]].name.rsplit(".", 1)[0]
        raise _WindingUpError(
            f"initial: the start speeds are no steady rotation: '{name}' would wind up at {winding[worst]:.6g} rad/s"
        )


@cache
def _roundings(n: int) -> Array:
    """Signs of changes in the last bits of a state, one a row."""
    generator = np.random.default_rng(1)
    return np.array([generator.choice([-1.0, 1.0], n) for _ in range(8)])


class _Search:
    """Newton's method; after each step the modes are those of the state.

    D: changes of the coordinates that the active set allows; L: the balances of torque that its constraint forces do not
    enter (both None where nothing is active: all).
    """

    def __init__(self, point: Point, kin: Kinematics) -> None:
        self.point, self.kin, self.algebra = point, kin, point.algebra
        self.unknown = np.concatenate([kin.coordinates, kin.states])
        still = kin.coordinates if kin.massless else kin.coordinates[:0]  # balance of massless groups: q' = 0
        self.rows = np.concatenate([kin.speeds, kin.states, still])
        self.n_v, self.n_q, self.n_z = len(kin.speeds), len(kin.coordinates), len(kin.states)
        self.D: Matrix | None = None
        self.L: Matrix | None = None
        self.n_t = self.n_v
        if kin.active is not None:
            self.D = reduced(fixed_combinations(kin, kin.active, 0)).basis(self.algebra)
            force_rows = point.active_force_rows()
            assert force_rows is not None
            self.L = force_rows.basis(self.algebra).T
            self.n_t = self.L.shape[0]
        self.weak = 0.0
        self.patterns: dict[bytes, list[Indices]] = {}
        self.turn = self._turned_on()
        self.springs = self._stiffness()

    def run(self) -> Point:
        """The equilibrium. Where full steps lead back to modes that were left, short ones follow an overdamped motion."""
        start, carried = self.point, np.zeros(0)
        for spring, fades in ((_WEAK, _FADES), (_FIRM, _FADES_SLOWLY)):
            self.point, self.weak = start, spring
            found, carried = self._followed(spring, fades)
            if found is not None:
                return found
        raise self._failure(carried)

    def _followed(self, spring: float, fades: float) -> tuple[Point | None, Array]:
        """The equilibrium, or None, and what the weak springs carried at last."""
        last, carried = np.inf, np.zeros(0)
        for _ in range(_ROUNDS):
            matrix = self._matrix()
            idle = np.asarray(abs(matrix[self.n_t :]).sum(axis=1)).ravel() == 0
            rest, error = self._residual(matrix, idle)
            step, carried = self._step(matrix, idle, rest)
            y = self.point.y.copy()
            y[self.unknown] += step
            fit = self._fitting(y)
            same = np.array_equal(fit.modes, self.point.modes)
            if same and (error <= _NEAR or (error <= _STALLED and error > 0.3 * last)):
                return (fit.at(y=restarted(fit)) if self.kin.massless else fit), carried
            lowest = _WEAKEST if error < 0.3 * last else _NOTHING  # a small load crosses a wide gap
            self.weak = max(self.weak / fades, lowest) if same else spring
            last = error if same else np.inf
            self.point = fit
            if overlaps(fit):  # beyond a gap that a stop closes, nothing else may carry the load
                return fit, carried
        return None, carried

    def _fitting(self, y: Array) -> Point:
        """The point at y in the modes of the instant just after, in which the train has turned on.

        A mode that another rounding of the state would keep stays: what lies on a corner, as an angle of 0 that loads do
        not change, would go back and forth for ever.
        """
        old, fit = self.point.modes, self.point.at(y=y + self.turn).settled().modes.copy()
        for signs in _roundings(len(y)) if not np.array_equal(fit, old) else ():
            other = self.point.at(y=(y + self.turn) * (1 + _ROUNDING * signs)).settled().modes
            fit = np.where(other == old, old, fit)
        return self.point.at(y=y, modes=fit)

    def _turned_on(self) -> Array:
        """A change of the state that its steady rotation makes at once: small beside any angle, large beside rounding."""
        rates, turned = self.point.rates(), np.zeros_like(self.point.y)
        turned[self.kin.angles] = rates[self.kin.angles]
        fastest = np.abs(turned).max(initial=0.0)
        far = max(1.0, float(np.abs(self.point.y[self.kin.angles]).max(initial=0.0)))
        return np.asarray(turned * _AHEAD * far / (fastest or 1.0))

    def _stiffness(self) -> Array:
        """Stiffness of each coordinate, the largest of what it has now and with its contacts on either side.

        Takes every coordinate that is under load back to no deflection.
        """
        start = self.point
        of_state = np.array([s.kind == "state" for s in start.program.switches], dtype=bool)
        found = []
        for side in (None, 1.0, -1.0):
            modes = start.modes if side is None else np.where(of_state, side, start.modes)
            self.point = start.at(modes=modes)
            torques = self.kin.M @ self._derivatives()[: self.n_v]
            found.append(self.algebra.largest(torques[:, : self.n_q], 0))
        y = start.y.copy()
        if self.D is None or self.D.shape[0] == self.D.shape[1]:
            y[self.kin.coordinates[found[0] > 0]] = 0.0
        elif (loaded := found[0] > 0).any():
            back = -y[self.kin.coordinates] * loaded
            D = self.algebra.array(self.D)
            y[self.kin.coordinates] += self.D @ np.linalg.lstsq(D[loaded], back[loaded], rcond=None)[0]
        self.point = start
        self.point = self._fitting(y)
        springs = np.nan_to_num(np.max(found, axis=0), posinf=0.0) if self.n_q else np.zeros(0)
        return np.asarray(np.where(springs > 0, springs, springs.max(initial=0.0) or 1.0))

    def _residual(self, matrix: Matrix, idle: NDArray[np.bool_]) -> tuple[Array, float]:
        """Torques and rates of states of blocks that are left, and the largest of them relative to what acts.

        idle: rates that no unknown changes: phases, which run on, and massless groups, which are in balance anyway.
        """
        kin, rates = self.kin, self._rates(self.point.y)
        torque = kin.M @ rates[kin.speeds]
        rest = torque.copy()
        if kin.N.shape[1]:
            weights = self.algebra.array(kin.N.T @ kin.M @ kin.N)
            rest -= kin.M @ (kin.N @ np.linalg.solve(weights, kin.N.T @ torque))
        parts = abs(matrix) @ np.abs(self.point.y[self.unknown])
        largest = max(float(np.abs(torque).max(initial=0.0)), float(parts[: self.n_t].max(initial=0.0)))
        sizes = np.concatenate([np.full(self.n_t, largest), parts[self.n_t :]])
        left = np.concatenate([self._balances(rest), np.where(idle, 0.0, rates[self.rows[self.n_v :]])])
        relative = np.divide(np.abs(left), sizes, out=np.where(left == 0, 0.0, np.inf), where=sizes > 0)
        return left, float(relative.max(initial=0.0))

    def _rates(self, y: Array) -> Array:
        """Rates at a state, the angles of massless groups put into balance."""
        if self.kin.massless:
            y = restarted(self.point.at(y=y))
        return self.point.rates(y)

    def _matrix(self) -> Matrix:
        """Derivatives of the residual by the unknowns."""
        A = self._derivatives()
        return self.algebra.stacked([[self._balances(self.kin.M @ A[: self.n_v])], [A[self.n_v :]]])

    def _balances(self, torques: Any) -> Any:
        """L times torques on the speeds, a vector or columns."""
        return torques if self.L is None else self.L @ torques

    def _derivatives(self) -> Matrix:
        """Of the rates of speeds and states by the unknowns."""
        point = self.point
        if knows_derivatives(point):
            return state_matrix(point)[self.rows][:, self.unknown]
        steps, key = steps_of(point.program, point.y), point.modes.tobytes()

        def rates(y: Array) -> Array:
            return np.asarray(self._rates(y)[self.rows])

        if not all(map(len, self.patterns.get(key, [np.empty(0)]))):  # where nothing answers yet, look again
            self.patterns[key] = dependents(rates, point.y, self.unknown, steps)
        return derivative(rates, point.y, self.unknown, steps, self.patterns.get(key), self.algebra)

    def _step(self, matrix: Matrix, idle: NDArray[np.bool_], rest: Array) -> tuple[Array, Array]:
        """Change of the unknowns, and the torque that the weak springs carry."""
        kin, algebra, springs = self.kin, self.algebra, self.weak * self.springs
        weak = self._balances(kin.B.T @ algebra.diagonal(-springs))
        rest_rows, z = len(self.rows) - self.n_v, np.arange(self.n_z)
        still = algebra.entries(-idle[: self.n_z].astype(float), z, z, (rest_rows, self.n_z))
        below = algebra.zeros((rest_rows, self.n_q))
        added = algebra.stacked([[weak, algebra.zeros((self.n_t, self.n_z))], [below, still]])
        border = algebra.stacked([[-self._balances(kin.M @ kin.N)], [algebra.zeros((rest_rows, kin.N.shape[1]))]])
        inner = matrix + added
        if self.D is not None:
            inner = inner @ (along := algebra.stacked([[self.D, None], [None, algebra.diagonal(np.ones(self.n_z))]]))
        full = algebra.stacked([[inner, border]])
        if full.shape[0] == 0:  # everything is stuck where it stands
            return np.zeros(len(self.unknown)), np.zeros(self.n_q)
        scale = algebra.largest(full, 1)
        scale[scale == 0] = 1.0
        scaled = algebra.diagonal(1 / scale) @ full
        try:
            if kin.massless:
                found = np.asarray(np.linalg.lstsq(algebra.array(scaled), -rest / scale, rcond=1e-13)[0])
            else:
                found = algebra.solved(scaled, -rest / scale)
        except RuntimeError as error:  # exactly singular: states of blocks that nothing ties down
            raise self._failure(np.zeros(0)) from error
        step = np.asarray(found[: inner.shape[1]] if self.D is None else along @ found[: inner.shape[1]])
        return step, springs * step[: self.n_q]

    def _failure(self, carried: Array) -> SimulationError:
        """The error for the coordinate whose weak spring carries most."""
        names = [self.point.program.states[i].name.rsplit(".", 1)[0] for i in self.kin.coordinates]
        return SimulationError(
            self.point.t, names[int(np.argmax(np.abs(carried)))] if len(carried) else "",
            "there is no static equilibrium: nothing carries the load here",
            "change the loads or the contact, or give start values in place of initial='static'",
        )  # fmt: skip
