"""Static starts: the state in which a train under its loads neither deforms further nor changes any state of a block.

Speeds and absolute angles stay as they are; relative angles and states of blocks are solved for. Where a train can turn
freely, its steady acceleration under loads that do not balance is allowed: the static state is the one that the
deflections settle in. With the inertia matrix M, accelerations a and the free rotations N (B N = 0):

    M (a(q, z) - N w) = 0,    z' = 0        in the unknowns q, z and the accelerations w of the free rotations

Newton's method in frozen modes, from no deflection where something is under load and from the start values elsewhere (of
several equilibria it finds one near the undeformed train); after each step the modes follow the state. A weak spring on
every coordinate keeps parts determined that nothing holds at the moment: a load inside a gap moves its coordinate far to
that side, where the contact takes over. A gap without load stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError, SimulationError
from gearblocks.simulation.friction_at_rest import by_slips, judged
from gearblocks.solver.active_set import Rows, null_space, reduced
from gearblocks.solver.binding import Array, Simulation
from gearblocks.solver.point import Point, dependents, derivative, opened, restarted, state_matrix, steps_of
from gearblocks.solver.sparse_maps import Indices, disjoint

if TYPE_CHECKING:
    from scipy.sparse import csc_array

_ROUNDS = 200
_WEAK, _WEAKEST = 1e-2, 1e-6  # spring on a coordinate relative to its stiffness, after a change of modes and at the end
_NOTHING = 1e-14  # the same where the torques that are left do not shrink
_NEAR, _STUCK = 1e-13, 1e-11  # of the largest torque: what rounding leaves, and at most where it does not shrink


@dataclass(frozen=True, eq=False)
class Motion:
    """How coordinates and angles follow from speeds: q' = B v, angles' = E v; N: free rotations, B N = 0, E N = 1.

    held: what sticks, conditions on the speeds (None: nothing does); free rotations are those that it allows.
    """

    coordinates: Indices
    angles: Indices
    states: Indices
    speeds: Indices
    B: csc_array
    E: csc_array
    N: csc_array
    M: csc_array
    held: Rows | None = None

    @property
    def hidden(self) -> bool:
        """Whether there are shafts without inertia, whose speeds are no states."""
        return len(self.coordinates) + len(self.angles) > len(self.speeds)


_KINDS = {"relative angle": "coordinate", "relative position": "coordinate", "position": "angle"}


def kinds(program: Program) -> tuple[Indices, Indices, Indices, Indices]:
    """Places of coordinates, absolute angles, states of blocks and speeds in the state vector."""
    found: dict[str, list[int]] = {"coordinate": [], "angle": [], "state": [], "speed": []}
    for i, quantity in enumerate(program.states):
        found[_KINDS.get(quantity.words, quantity.words)].append(i)
    found["angle"] += [x.place for x in program.integrals if x.part == "angle"]
    groups = (found["coordinate"], sorted(found["angle"]), found["state"], found["speed"])
    return tuple(np.array(g, dtype=np.intp) for g in groups)  # type: ignore[return-value]


def motion(point: Point) -> Motion:
    """The kinematics and the inertia matrix of a train."""
    from scipy.sparse import csc_array, identity, vstack
    from scipy.sparse.linalg import splu

    q, angles, z, v = kinds(point.program)
    still = point.y.copy()
    still[v] = 0.0
    rows = np.concatenate([q, angles])
    S = _rates_by_speed(point, still, rows, v)
    B = csc_array(S[: len(q)])
    turning = np.asarray(abs(S[len(q) :]).sum(axis=1)).ravel() > 0  # angles that are prescribed do not follow speeds
    angles = angles[turning]
    S, rows = csc_array(S[np.concatenate([np.ones(len(q), bool), turning])]), np.concatenate([q, angles])
    M = _inertia(point, still, v)
    right = vstack([csc_array((len(q), len(angles))), identity(len(angles))], format="csc").toarray()
    if len(rows) == 0 or len(angles) == 0:
        N = np.zeros((len(v), 0))
    elif len(rows) == len(v):
        N = splu(S).solve(right)
    else:  # more coordinates than speeds: shafts without inertia
        N = np.linalg.lstsq(S.toarray(), right, rcond=None)[0]
    held = point.held_rows()
    if held is not None and N.shape[1]:
        N = N @ null_space(held.W @ N, np.max(np.abs(held.W) @ np.abs(N), axis=1, initial=0.0))
    return Motion(q, angles, z, v, B, csc_array(S[len(q) :]), csc_array(N), M, held)


def _knows_derivatives(point: Point) -> bool:
    """Whether the laws have derivatives and every speed is a state."""
    return point.sim.has_jacobian and point.sim.linear_sizes()[1] == 0


def _rates_by_speed(point: Point, still: Array, rows: Indices, v: Indices) -> csc_array:
    """Derivatives of the rates of coordinates and angles by the speeds; angles that ride along come last."""
    from scipy.sparse import csc_array, vstack

    ones = np.ones(point.program.n_total)  # the rates are linear in the speeds: any step is exact
    n = point.program.n if _knows_derivatives(point) else 0
    riders = rows[rows >= n]
    beside = derivative(lambda y: point.rates(y)[riders], still, v, ones)
    if n == 0:
        return beside
    return csc_array(vstack([state_matrix(point.at(y=still))[rows[rows < n]][:, v], beside]))


def _inertia(point: Point, still: Array, v: Indices) -> csc_array:
    """The inertia matrix of the speeds: where the laws do not give it, second derivatives of the kinetic energy."""
    from scipy.sparse import csc_array

    if _knows_derivatives(point):
        unknowns = v - point.sim.linear_sizes()[0]
        return csc_array(point.sim.inertia(point.t, still)[unknowns][:, unknowns])
    kinetic = np.array([e.place for e in point.program.energies if e.part == "kinetic"], dtype=np.intp)

    def energy(y: Array) -> Array:
        return point.energies(y)[kinetic]

    def moved(*numbers: int) -> Array:
        y = still.copy()
        y[v[list(numbers)]] = 1.0
        return energy(y)

    own = dependents(energy, still, v, np.ones(len(still)))
    diagonal = np.zeros(len(v))
    for group in disjoint(own):
        found = moved(*group)
        diagonal[group] = [2 * float(found[own[j]].sum()) for j in group]
    owners: dict[int, list[int]] = {}
    for j, entries in enumerate(own):
        for e in entries:
            owners.setdefault(int(e), []).append(j)
    pairs = sorted({(i, j) for js in owners.values() for i in js for j in js if i < j})
    beside = [float(moved(i, j).sum()) - (diagonal[i] + diagonal[j]) / 2 for i, j in pairs]
    left, right = (np.array([pair[side] for pair in pairs], dtype=np.intp) for side in (0, 1))
    rows = np.concatenate([np.arange(len(v)), left, right])
    columns = np.concatenate([np.arange(len(v)), right, left])
    return csc_array((np.concatenate([diagonal, beside, beside]), (rows, columns)), shape=(len(v), len(v)))


# -- equilibrium ------------------------------------------------------------------------------------------------------


def static_state(sim: Simulation, program: Program, t: float, *, means: bool, y0: Array | None = None) -> Array:
    """The state vector of the equilibrium from the start values (or y0), with excitations at their means or as at t.

    Raises ParameterError where the start speeds wind something up, SimulationError where there is no equilibrium.
    """
    with opened(sim, program, t, y0) as point:
        return equilibrium(point.at(means=means)).y


def equilibrium(point: Point) -> Point:
    """The equilibrium of the train held at a point, in the modes that fit it. Errors as `static_state`.

    What does not slip at the start is stuck, and carries what balance asks for; what holds one way only (a stop, a
    freewheel) opens where it would have to pull. SimulationError where the limit of one is less than it must carry.
    """
    point = by_slips(point)
    for _ in range(4 * len(point.sim.locks().places) + 1):
        found = _balanced(point)
        changed = judged(found)
        if changed is None:
            return found
        point = changed
    raise SimulationError(
        point.t, "", "there is no static equilibrium: stops open and close without end",
        "give start values in place of initial='static'",
    )  # fmt: skip


def _balanced(point: Point) -> Point:
    """The equilibrium while locks and stops stay what they are."""
    whole = motion(point)
    if len(whole.coordinates) + len(whole.states) == 0 or len(whole.speeds) + len(whole.states) == 0:
        return point if point.sim.locks().places else point.at(y=restarted(point))
    _check_speeds(point, whole)
    found = _Search(point, whole).run()
    return found if whole.held is None else found.at(y=_turned_along(whole, whole.held, point.y, found.y))


def _turned_along(whole: Motion, held: Rows, before: Array, y: Array) -> Array:
    """Angles after coordinates have changed, so that what is stuck to the housing stays where it was."""
    from scipy.sparse import csc_array, vstack

    S = csc_array(vstack([whole.B, whole.E]))
    if len(whole.angles) == 0 or whole.hidden:
        return y
    turned = np.concatenate([y[whole.coordinates] - before[whole.coordinates], np.zeros(len(whole.angles))])
    rows = _solve(csc_array(S.T), held.W.T).T  # what slips by coordinates and angles
    n_q, moved = len(whole.coordinates), y.copy()
    moved[whole.angles] -= np.linalg.lstsq(rows[:, n_q:], rows @ turned, rcond=1e-9)[0]
    return moved


def _solve(S: csc_array, right: Array) -> Array:
    """S^-1 times a matrix; S as few columns as it has."""
    from scipy.sparse.linalg import splu

    return np.asarray(splu(S).solve(np.ascontiguousarray(right)))


def fixed_combinations(whole: Motion, held: Rows, angles: int) -> Array:
    """Combinations of the coordinates, and of the first so many of the angles, that what holds keeps constant, as rows."""
    from scipy.sparse import csc_array, vstack

    S, n = csc_array(vstack([whole.B, whole.E]).T), len(whole.coordinates) + angles
    if S.shape[0] == S.shape[1]:
        combined = _solve(S, held.W.T)
        rest, combined = combined[n:], combined[:n]
    else:  # shafts without inertia: more coordinates than speeds
        dense = S[:, :n].toarray()
        combined = np.linalg.lstsq(dense, held.W.T, rcond=None)[0]
        rest = held.W.T - dense @ combined
    return np.asarray((combined @ null_space(rest, np.full(len(rest), np.abs(held.W).max()))).T)


def _check_speeds(point: Point, whole: Motion) -> None:
    v = point.y[whole.speeds]
    if len(whole.coordinates) == 0 or whole.hidden:
        return
    winding = point.rates()[whole.coordinates]  # prescribed speeds among them
    worst = int(np.argmax(np.abs(winding)))
    largest = float(np.abs(v).max(initial=0.0)) * float(np.abs(whole.B.data).max(initial=0.0))
    largest = max(largest, float(np.abs(winding - whole.B @ v).max()))
    if abs(winding[worst]) > 1e-9 * largest:
        name = point.program.states[whole.coordinates[worst]].name.rsplit(".", 1)[0]
        raise ParameterError(
            f"initial: the start speeds are no steady rotation: '{name}' would wind up at {winding[worst]:.6g} rad/s; "
            f"give w0 to every body that turns, or to none"
        )


class _Search:
    """Newton's method with modes that follow.

    D: changes of the coordinates that what holds allows; L: the balances of torque that it leaves (both 1 where nothing
    holds).
    """

    def __init__(self, point: Point, whole: Motion) -> None:
        from scipy.sparse import csc_array, eye_array

        self.point, self.whole = point, whole
        self.unknown = np.concatenate([whole.coordinates, whole.states])
        still = (
            whole.coordinates if whole.hidden else whole.coordinates[:0]
        )  # balance of shafts without inertia: q' = 0
        self.rows = np.concatenate([whole.speeds, whole.states, still])
        self.n_v, self.n_q, self.n_z = len(whole.speeds), len(whole.coordinates), len(whole.states)
        self.D, self.L = csc_array(eye_array(self.n_q)), csc_array(eye_array(self.n_v))
        if whole.held is not None:
            self.D = reduced(fixed_combinations(whole, whole.held, 0)).basis()
            pushes = point.held_pushes()
            assert pushes is not None
            self.L = csc_array(pushes.basis().T)
        self.n_t = self.L.shape[0]
        self.weak = _WEAK
        self.patterns: dict[bytes, list[Indices]] = {}
        self.springs = self._stiffness()

    def run(self) -> Point:
        """The equilibrium."""
        last, carried = np.inf, np.zeros(0)
        for _ in range(_ROUNDS):
            matrix = self._matrix()
            idle = np.asarray(abs(matrix[self.n_t :]).sum(axis=1)).ravel() == 0
            rest, error = self._residual(matrix, idle)
            step, carried = self._step(matrix, idle, rest)
            y = self.point.y.copy()
            y[self.unknown] += step
            fit = self.point.at(y=y).settled()
            same = np.array_equal(fit.modes, self.point.modes)
            if same and (error <= _NEAR or (error <= _STUCK and error > 0.3 * last)):
                return fit.at(y=restarted(fit)) if self.whole.hidden else fit
            lowest = _WEAKEST if error < 0.3 * last else _NOTHING  # a small load crosses a wide gap
            self.weak = max(self.weak / 10, lowest) if same else _WEAK
            last = error if same else np.inf
            self.point = fit
        raise self._failure(carried)

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
            torques = self.whole.M @ self._derivatives()[: self.n_v]
            found.append(np.asarray(abs(torques[:, : self.n_q]).max(axis=0).todense()).ravel())
        y = start.y.copy()
        if self.D.shape[0] == self.D.shape[1]:
            y[self.whole.coordinates[found[0] > 0]] = 0.0
        elif (loaded := found[0] > 0).any():
            back = -y[self.whole.coordinates] * loaded
            y[self.whole.coordinates] += self.D @ np.linalg.lstsq(self.D.toarray()[loaded], back[loaded], rcond=None)[0]
        self.point = start.at(y=y).settled()
        springs = np.nan_to_num(np.max(found, axis=0), posinf=0.0) if self.n_q else np.zeros(0)
        return np.asarray(np.where(springs > 0, springs, springs.max(initial=0.0) or 1.0))

    def _residual(self, matrix: csc_array, idle: NDArray[np.bool_]) -> tuple[Array, float]:
        """Torques and rates of states of blocks that are left, and the largest of them relative to what acts.

        idle: rates that no unknown changes: phases, which run on, and shafts that are in balance anyway.
        """
        whole, rates = self.whole, self._rates(self.point.y)
        torque = whole.M @ rates[whole.speeds]
        rest = torque.copy()
        if whole.N.shape[1]:
            weights = (whole.N.T @ whole.M @ whole.N).toarray()
            rest -= whole.M @ (whole.N @ np.linalg.solve(weights, whole.N.T @ torque))
        parts = abs(matrix) @ np.abs(self.point.y[self.unknown])
        largest = max(float(np.abs(torque).max(initial=0.0)), float(parts[: self.n_t].max(initial=0.0)))
        sizes = np.concatenate([np.full(self.n_t, largest), parts[self.n_t :]])
        left = np.concatenate([self.L @ rest, np.where(idle, 0.0, rates[self.rows[self.n_v :]])])
        relative = np.divide(np.abs(left), sizes, out=np.where(left == 0, 0.0, np.inf), where=sizes > 0)
        return left, float(relative.max(initial=0.0))

    def _rates(self, y: Array) -> Array:
        """Rates at a state, the angles of shafts without inertia put into balance."""
        if self.whole.hidden:
            y = restarted(self.point.at(y=y))
        return self.point.rates(y)

    def _matrix(self) -> csc_array:
        """Derivatives of the residual by the unknowns."""
        from scipy.sparse import csc_array, vstack

        A = self._derivatives()
        return csc_array(vstack([self.L @ (self.whole.M @ A[: self.n_v]), A[self.n_v :]]))

    def _derivatives(self) -> csc_array:
        """Of the rates of speeds and states by the unknowns."""
        point = self.point
        if _knows_derivatives(point):
            return state_matrix(point)[self.rows][:, self.unknown]
        steps, key = steps_of(point.program, point.y), point.modes.tobytes()

        def rates(y: Array) -> Array:
            return np.asarray(self._rates(y)[self.rows])

        if not all(map(len, self.patterns.get(key, [np.empty(0)]))):  # where nothing answers yet, look again
            self.patterns[key] = dependents(rates, point.y, self.unknown, steps)
        return derivative(rates, point.y, self.unknown, steps, self.patterns.get(key))

    def _step(self, matrix: csc_array, idle: NDArray[np.bool_], rest: Array) -> tuple[Array, Array]:
        """Change of the unknowns, and the torque that the weak springs carry."""
        from scipy.sparse import block_diag, csc_array, diags_array, eye_array, hstack, vstack
        from scipy.sparse.linalg import splu

        whole = self.whole
        springs = self.weak * self.springs
        weak = hstack([self.L @ (whole.B.T @ diags_array(-springs)), csc_array((self.n_t, self.n_z))])
        still = hstack([csc_array((self.n_z, self.n_q)), diags_array(-idle[: self.n_z].astype(float))])
        rest_rows = len(self.rows) - self.n_v - self.n_z
        added = csc_array(vstack([weak, still, csc_array((rest_rows, self.n_q + self.n_z))]))
        border = vstack([-(self.L @ (whole.M @ whole.N)), csc_array((self.n_z + rest_rows, whole.N.shape[1]))])
        along = csc_array(block_diag([self.D, eye_array(self.n_z)]))
        full = csc_array(hstack([(matrix + added) @ along, border]))
        scale = np.asarray(abs(full).max(axis=1).todense()).ravel()
        scale[scale == 0] = 1.0
        scaled = csc_array(diags_array(1 / scale) @ full)
        try:
            if whole.hidden:
                found = np.linalg.lstsq(scaled.toarray(), -rest / scale, rcond=1e-13)[0]
            else:
                found = splu(scaled).solve(-rest / scale)
        except RuntimeError as error:  # exactly singular: states of blocks that nothing ties down
            raise self._failure(np.zeros(0)) from error
        step = along @ found[: along.shape[1]]
        return step, springs * step[: self.n_q]

    def _failure(self, carried: Array) -> SimulationError:
        """What nothing carries."""
        names = [self.point.program.states[i].name.rsplit(".", 1)[0] for i in self.whole.coordinates]
        return SimulationError(
            self.point.t, names[int(np.argmax(np.abs(carried)))] if len(carried) else "",
            "there is no static equilibrium: nothing carries the load here",
            "change the loads or the contact, or give start values in place of initial='static'",
        )  # fmt: skip
