"""Derivatives of compiled laws: patterns found by moving, and a probe that leaves no trace."""

import numpy as np
import pytest
import scipy.sparse

import gearblocks as gb
from benchmarks.cases import P4
from benchmarks.problems import p1, train
from gearblocks.solver.point import dependents, derivative, differenced_state_matrix, opened, state_matrix
from gearblocks.solver.sparse_maps import disjoint, recovered, solved
from gearblocks.solver.structures import Code, Method, Options


@pytest.mark.parametrize("shape", [(1, 1), (7, 1), (1, 9), (40, 40), (30, 57)])
def test_the_pattern_and_the_values_of_any_sparse_matrix_are_found(shape):
    matrix = scipy.sparse.random_array(shape, density=0.1, rng=np.random.default_rng(3), format="csc")
    y = np.random.default_rng(4).normal(size=shape[1])
    columns, steps = np.arange(shape[1]), np.full(shape[1], 1e-3)
    found = dependents(lambda x: matrix @ x, y, columns, steps)
    for j in columns:
        assert np.array_equal(found[j], np.flatnonzero(matrix[:, [j]].toarray()))
    slope = derivative(lambda x: matrix @ x, y, columns, steps)
    assert np.abs((slope - matrix).toarray()).max() < 1e-11  # rounding of numbers near 1 over steps of 1e-3


def test_columns_with_a_row_in_common_are_kept_apart():
    rows = [np.array(r) for r in ([0, 1], [1, 2], [3], [2], [], [0])]
    groups = disjoint(rows)
    assert sorted(j for group in groups for j in group) == list(range(6))
    for group in groups:
        taken = np.concatenate([rows[j] for j in group])
        assert len(set(taken)) == len(taken)


def test_a_long_chain_needs_few_evaluations():
    calls = 0

    def second_differences(x):
        nonlocal calls
        calls += 1
        return np.diff(x, 2)

    n = 4096
    derivative(second_differences, np.zeros(n), np.arange(n), np.ones(n))
    assert calls < 120  # 2 x 3 groups in each of 12 rounds, and the values


def test_a_look_at_a_point_changes_nothing_of_a_run():
    model = gb.build(p1())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        assert sim.start(Options(Method.DP8, 1, 1e-9, 0.0, np.inf, np.inf), 0.0) == Code.DONE
        sim.advance(1e-3)
        before, y = sim.save(), sim.state()
        for what in ("rates", "outputs", "energies", "modes"):
            sim.probe(0.3, 1.1 * y, np.array([-1.0]), what, means=True)
        assert sim.save() == before
        sim.advance(2e-3)
        looked_at = sim.state()
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.start(Options(Method.DP8, 1, 1e-9, 0.0, np.inf, np.inf), 0.0)
        sim.advance(1e-3)
        sim.advance(2e-3)
        assert np.array_equal(looked_at, sim.state())


def test_at_their_means_time_no_longer_matters():
    model = gb.build(p1())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.0) as point:
            later = point.at(t=1e-5)
            assert not np.array_equal(point.rates(), later.rates())
            assert np.array_equal(point.at(means=True).rates(), later.at(means=True).rates())
            assert (state_matrix(point.at(means=True)) != state_matrix(later.at(means=True))).nnz == 0


@pytest.mark.parametrize("groups", ["one", "right", "wrong"])
def test_a_linear_map_gives_its_matrix_whatever_groups_are_supposed(groups):
    matrix = scipy.sparse.random_array((60, 40), density=0.05, rng=np.random.default_rng(5), format="csc")
    rows = [matrix[:, [j]].nonzero()[0] for j in range(40)]
    supposed = {"one": [range(40)], "right": disjoint(rows), "wrong": [range(0, 40, 2), range(1, 40, 2)]}[groups]
    found, served = recovered(lambda x: matrix @ x[:40], (60, 40), [list(g) for g in supposed], 43)
    assert np.abs((found - matrix).toarray()).max() < 1e-15  # one product and one quotient of numbers below 1
    assert sorted(int(j) for g in served for j in g) == list(range(40))
    for group in served:
        taken = np.concatenate([rows[j] for j in group])
        assert len(set(taken)) == len(taken)


def test_columns_that_cancel_each_other_are_told_apart():
    matrix = scipy.sparse.csc_array(np.array([[1.0, -1.0, 0.0], [2.0, 2.0, 5.0]]))
    found, _ = recovered(lambda x: matrix @ x, (2, 3), [[0, 1, 2]], 3)
    assert np.array_equal(found.toarray(), matrix.toarray())


def test_a_map_without_bounds_is_refused():
    with pytest.raises(ArithmeticError, match="NaN or infinite"):
        recovered(lambda x: np.full(2, np.inf), (2, 2), [[0, 1]], 2)


@pytest.mark.parametrize("sizes", [(1, 1, 1), (3, 1, 4, 2, 3), (90,)])
def test_systems_of_blocks_are_solved_block_by_block(sizes):
    random = np.random.default_rng(6)
    blocks = scipy.sparse.block_diag([random.normal(size=(n, n)) + 9 * np.eye(n) for n in sizes], format="csc")
    mixed = random.permutation(sum(sizes))
    square = scipy.sparse.csc_array(blocks)[mixed][:, mixed]
    right = scipy.sparse.random_array((sum(sizes), 7), density=0.4, rng=random, format="csc")
    assert np.abs((square @ solved(square, right) - right).toarray()).max() < 1e-12  # condition below 100


def test_a_block_without_an_inverse_is_refused():
    square = scipy.sparse.csc_array(np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    with pytest.raises(ArithmeticError):
        solved(square, scipy.sparse.csc_array(np.eye(3)))


@pytest.mark.parametrize("means", [False, True])
@pytest.mark.parametrize("problem", [P4(n=40), P4(n=41)], ids=["even", "odd"])
def test_the_derivatives_of_the_laws_are_those_that_differences_find(problem, means):
    model = gb.build(train(problem))
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.01) as point:
            held = point.at(means=means, modes=np.where(np.arange(len(point.modes)) % 3 == 0, 0.0, point.modes))
            exact, found = state_matrix(held), differenced_state_matrix(held)
            largest = abs(exact).max(axis=1).toarray()
            assert (np.abs((exact - found).toarray()) <= 1e-8 * largest.reshape(-1, 1)).all()
