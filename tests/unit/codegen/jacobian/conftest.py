"""The matrix of implicit methods against differences of the right-hand side, modes frozen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.solver.binding import Simulation
from gearblocks.solver.step_matrix import StepMatrix
from gearblocks.solver.structures import Options

NEAR = 1e-9  # differences of fourth order with steps of 1e-3 of each state: 1e-12, times what terms cancel


def _dense(pattern: Pattern, linear: StepMatrix) -> np.ndarray:
    """The matrix in full."""
    full = np.diag(linear.diag)
    for k, column in enumerate(pattern.order):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            row = pattern.order[pattern.row[place]]
            full[row, column], full[column, row] = linear.lower[place], linear.upper[place]
    return full


def _solved(pattern: Pattern, linear: StepMatrix, b: np.ndarray) -> np.ndarray:
    """The solution by L D U as gb_pattern describes it."""
    n = len(pattern.order)
    d, low, up = (linear.diag[list(pattern.order)], linear.lower.copy(), linear.upper.copy())
    at = 0
    for k in range(n):
        places = range(pattern.start[k], pattern.start[k + 1])
        for a, one in enumerate(places):
            d[pattern.row[one]] -= low[one] * up[one] / d[k]
            for other in places[a + 1 :]:
                low[pattern.pair[at]] -= low[other] * up[one] / d[k]
                up[pattern.pair[at]] -= low[one] * up[other] / d[k]
                at += 1
    assert at == len(pattern.pair)
    x = b[list(pattern.order)].astype(float)
    for k in range(n):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            x[pattern.row[place]] -= low[place] * x[k] / d[k]
    for k in reversed(range(n)):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            x[k] -= up[place] * x[pattern.row[place]]
        x[k] /= d[k]
    out = np.empty(n)
    out[list(pattern.order)] = x
    return out


def _differences(sim: Simulation, t: float, y: np.ndarray, size: np.ndarray) -> np.ndarray:
    """d(dy)/dy by central differences of fourth order."""
    n = len(size)
    result = np.empty((n, n))
    for j in range(n):
        f = []
        for k in (1, -1, 2, -2):
            moved = y.copy()
            moved[j] += k * 1e-3 * size[j]
            f.append(sim.rhs(t, moved)[:n])
        result[:, j] = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12e-3 * size[j])
    return result


def _check(rig: gb.Drivetrain, angle: float = 1.0, speed: float = 1.0, state: float = 1.0) -> Pattern:
    """Compares at random points of that size. g goes from small to large, so that each part of the matrix counts."""
    model = gb.build(rig)
    size = np.array([{"rad": angle, "rad/s": speed}.get(q.unit, state) for q in model.program.states])
    random = np.random.default_rng(7)
    with model.library.open() as sim:
        pattern = sim.pattern()
        assert pattern is not None
        sim.parameters[:] = model.values
        sim.inputs[:] = 1.3
        for t in (0.0, 0.37, 2.9):
            y = np.zeros(model.program.n_total)
            y[: len(size)] = size * random.normal(size=len(size))
            assert sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), t, y) == 0
            J = _differences(sim, t, y, size)
            off, row = np.abs(sim.jacobian(t, y).toarray() - J) * size, (np.abs(J) * size).max(axis=1, keepdims=True)
            assert (off <= NEAR * row).all()
            for g in (1e-3 * angle / speed, angle / speed, 1e3 * angle / speed):
                _check_step(sim, pattern, sim.step_matrix(t, y, g), (J, sim.step_matrix(t, y, 0.0).diag, size), random)
    return pattern


def _check_step(
    sim: Simulation, pattern: Pattern, linear: StepMatrix, known: tuple, random: np.random.Generator
) -> None:
    """One step size: the matrix, the right side, the solution, the rates. known: derivatives, inertias, sizes."""
    (J, E, size), g = known, linear.g
    n_kinematic = len(size) - len(E)
    A, K, B = (
        E[:, None] * J[n_kinematic:, n_kinematic:],
        E[:, None] * J[n_kinematic:, :n_kinematic],
        J[:n_kinematic, n_kinematic:],
    )
    S = _dense(pattern, linear)
    parts = np.diag(E) + g * np.abs(A) + g**2 * np.abs(K) @ np.abs(B)
    off = (np.diag(E) - g * A - g**2 * K @ B - S) * size[n_kinematic:]
    assert (np.abs(off) / (parts * size[n_kinematic:]).max(axis=1, keepdims=True)).max() < NEAR
    r = size * random.normal(size=len(size))
    b = sim.right_side(linear, r)
    weight = E * np.abs(r[n_kinematic:]) + g * np.abs(K) @ np.abs(r[:n_kinematic])
    assert (np.abs(E * r[n_kinematic:] + g * K @ r[:n_kinematic] - b) / weight).max() < NEAR
    x = _solved(pattern, linear, b)
    assert np.abs(S @ x - b).max() <= 1e-12 * (np.abs(S) @ np.abs(x)).max()  # rounding of a few dozen operations
    assert np.allclose(x, np.linalg.solve(S, b), rtol=0, atol=1e-14 * np.linalg.cond(S) * np.abs(x).max())
    rates = sim.kinematic_rates(linear, x)
    assert np.allclose(rates, B @ x, rtol=0, atol=NEAR * (np.abs(B) @ np.abs(x)).max(initial=0.0))


def _check_whole(rig: gb.Drivetrain) -> tuple[int, ...]:
    """Solves (1 - g J) U = g r by way of the matrix: S x = g right_side(r), U = x and, of kinematic states, g (r + B x).

    This holds for every train, massless speeds included, and does not need to know what E is. Answers sizes.
    """
    model = gb.build(rig)
    n = model.program.n
    random = np.random.default_rng(11)
    with model.library.open() as sim:
        pattern = sim.pattern()
        assert pattern is not None
        n_kinematic, n_massless, _ = sim.step_matrix_sizes()
        assert len(pattern.order) == n - n_kinematic + n_massless
        sim.parameters[:] = model.values
        sim.inputs[:] = 1.3
        for t in (0.0, 0.37, 2.9):
            y = np.zeros(model.program.n_total)
            y[:n] = random.normal(size=n)
            assert sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), t, y) == 0
            y = sim.state()
            J, near = sim.jacobian(t, y).toarray(), _differences(sim, t, y, np.ones(n))
            assert (np.abs(J - near) <= NEAR * np.abs(near).max(axis=1, keepdims=True)).all()
            for g in (1e-3, 0.1, 10.0):
                r = random.normal(size=n)
                linear = sim.step_matrix(t, y, g)
                x = _solved(pattern, linear, g * sim.right_side(linear, r))
                ours = np.append(g * (r[:n_kinematic] + sim.kinematic_rates(linear, x)), x[: n - n_kinematic])
                # by the Jacobian, which differences have confirmed: their errors would grow by the condition
                true = np.linalg.solve(np.eye(n) - g * J, g * r)
                assert np.abs(ours - true).max() < NEAR * np.abs(true).max()
    return n_kinematic, n_massless, len(pattern.order)


@pytest.fixture(scope="session")
def check() -> Callable[..., Pattern]:
    """check(rig, angle, speed, state): see _check."""
    return _check


@pytest.fixture(scope="session")
def check_whole() -> Callable[[gb.Drivetrain], tuple[int, ...]]:
    """check_whole(rig): see _check_whole."""
    return _check_whole
