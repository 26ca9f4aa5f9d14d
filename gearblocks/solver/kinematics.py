"""Kinematics of a model at one point: how coordinates and angles follow from the speeds, mass matrix, free rotations.

    q' = B v,   angles' = E v,   B N = 0,   E N = 1

Columns of N: motions without any deflection, those that the active set allows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.solver.active_set import ReducedRows, null_space
from gearblocks.solver.matrix_algebra import SPARSE, Algebra, Matrix
from gearblocks.solver.point import Point, dependents, derivative, state_matrix
from gearblocks.solver.sparse_maps import Indices, disjoint
from gearblocks.solver.structures import Array

_HELD = 1e-9  # what is left of S N = 1 beyond it is no rounding


@dataclass(frozen=True, eq=False)
class Kinematics:
    """q' = B v, angles' = E v; N: free rotations; M: mass matrix of the speeds.

    coordinates, angles, states, speeds: indices in the state vector; active: reduced rows of the active set (None: it is
    empty).
    """

    coordinates: Indices
    angles: Indices
    states: Indices
    speeds: Indices
    B: Matrix
    E: Matrix
    N: Matrix
    M: Matrix
    active: ReducedRows | None = None
    algebra: Algebra = SPARSE

    def __repr__(self) -> str:
        counts = f"{len(self.coordinates)} coordinates, {len(self.angles)} angles, {len(self.speeds)} speeds"
        return f"<Kinematics: {counts}, {self.N.shape[1]} free rotations>"

    @property
    def massless(self) -> bool:
        """Whether there are massless groups, whose speeds are no states."""
        return len(self.coordinates) + len(self.angles) > len(self.speeds)


def kinds(program: Program) -> tuple[Indices, Indices, Indices, Indices]:
    """Indices of coordinates, absolute angles, states of blocks and speeds in the state vector."""
    found: dict[str, list[int]] = {"coordinate": [], "angle": [], "state": [], "speed": [], "sum": []}
    for i, quantity in enumerate(program.states):
        found[quantity.kind].append(i)
    found["angle"] += [x.offset for x in program.integrals if x.part == "angle"]
    groups = (found["coordinate"], sorted(found["angle"]), found["state"], found["speed"])
    return tuple(np.array(g, dtype=np.intp) for g in groups)  # type: ignore[return-value]


def kinematics(point: Point) -> Kinematics:
    """The kinematics and the mass matrix of a train."""
    algebra = point.algebra
    q, angles, z, v = kinds(point.program)
    still = point.y.copy()
    still[v] = 0.0
    rows = np.concatenate([q, angles])
    S = _rates_by_speed(point, still, rows, v)
    B = S[: len(q)]
    free = np.asarray(abs(S[len(q) :]).sum(axis=1)).ravel() > 0  # angles that are prescribed do not follow speeds
    angles = angles[free]
    S, rows = S[np.concatenate([np.ones(len(q), bool), free])], np.concatenate([q, angles])
    M = _inertia(point, still, v)
    right = np.vstack([np.zeros((len(q), len(angles))), np.eye(len(angles))])
    if len(rows) == 0 or len(angles) == 0:
        N: Array = np.zeros((len(v), 0))
    elif len(rows) == len(v):
        N = algebra.solved(S, right)
    else:  # more coordinates than speeds: massless groups
        N = _free_rotations(algebra.array(S), right)
    active = point.active_rows()
    if active is not None and N.shape[1]:
        N = N @ null_space(active.W @ N, np.max(np.abs(active.W) @ np.abs(N), axis=1, initial=0.0))
    return Kinematics(q, angles, z, v, B, S[len(q) :], algebra.of(N), M, active, algebra)


def _free_rotations(S: Array, right: Array) -> Array:
    """N with S N = right; those of its columns, and their combinations, that there are: what friction without inertia holds
    at its place does not turn."""
    N = np.asarray(np.linalg.lstsq(S, right, rcond=None)[0], dtype=np.float64)
    left = S @ N - right
    return N @ null_space(left, np.full(len(left), np.abs(S).max(initial=1.0))) if np.abs(left).max() > _HELD else N


def knows_derivatives(point: Point) -> bool:
    """Whether the laws have derivatives and no group is massless."""
    return point.sim.has_jacobian and point.sim.step_matrix_sizes()[1] == 0


def _rates_by_speed(point: Point, still: Array, rows: Indices, v: Indices) -> Matrix:
    """Derivatives of the rates of coordinates and angles by the speeds; unread angles come last."""
    ones = np.ones(point.program.n_total)  # the rates are linear in the speeds: any step is exact
    n = point.program.n if knows_derivatives(point) else 0
    unread = rows[rows >= n]
    beside = derivative(lambda y: point.rates(y)[unread], still, v, ones, algebra=point.algebra)
    if n == 0:
        return beside
    return point.algebra.stacked([[state_matrix(point.at(y=still))[rows[rows < n]][:, v]], [beside]])


def _inertia(point: Point, still: Array, v: Indices) -> Matrix:
    """The mass matrix of the speeds: where the laws do not give it, second derivatives of the kinetic energy."""
    if knows_derivatives(point):
        unknowns = v - point.sim.step_matrix_sizes()[0]
        return point.sim.inertia(point.t, still, dense=point.algebra.dense)[unknowns][:, unknowns]
    kinetic = np.array([e.offset for e in point.program.energies if e.part == "kinetic"], dtype=np.intp)

    def energy(y: Array) -> Array:
        return point.energies(y)[kinetic]

    def kinetic_at(*numbers: int) -> Array:
        y = still.copy()
        y[v[list(numbers)]] = 1.0
        return energy(y)

    own = dependents(energy, still, v, np.ones(len(still)))
    diagonal = np.zeros(len(v))
    for group in disjoint(own):
        found = kinetic_at(*group)
        diagonal[group] = [2 * float(found[own[j]].sum()) for j in group]
    owners: dict[int, list[int]] = {}
    for j, entries in enumerate(own):
        for e in entries:
            owners.setdefault(int(e), []).append(j)
    pairs = sorted({(i, j) for js in owners.values() for i in js for j in js if i < j})
    beside = [float(kinetic_at(i, j).sum()) - (diagonal[i] + diagonal[j]) / 2 for i, j in pairs]
    left, right = (np.array([pair[side] for pair in pairs], dtype=np.intp) for side in (0, 1))
    rows = np.concatenate([np.arange(len(v)), left, right])
    columns = np.concatenate([np.arange(len(v)), right, left])
    return point.algebra.entries(np.concatenate([diagonal, beside, beside]), rows, columns, (len(v), len(v)))
