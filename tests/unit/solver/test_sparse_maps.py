"""Sparse matrices found by moving: patterns, groups of columns, systems of blocks."""

import numpy as np
import pytest
import scipy.sparse

from gearblocks.solver.point import dependents, derivative
from gearblocks.solver.sparse_maps import disjoint, recovered, solved


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
