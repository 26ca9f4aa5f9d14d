"""Dense and sparse matrices: the same operations give the same numbers, and a small train needs no scipy for them."""

import subprocess
import sys

import numpy as np
import pytest

from gearblocks.solver.matrix_algebra import DENSE, SMALL, SPARSE, algebra_of

RANDOM = np.random.default_rng(3)
A, B = RANDOM.normal(size=(3, 4)), RANDOM.normal(size=(3, 2))
SQUARE = RANDOM.normal(size=(4, 4)) + 4 * np.eye(4)

STARTS = """
import sys
import gearblocks as gb
from benchmarks import problems
from benchmarks.cases import P4
for train in (problems.p1(), problems.train(P4(n=6))):
    assert gb.simulate(train, t_end=1e-9, initial="static").complete
print(sorted(name for name in sys.modules if name.split(".")[0] == "scipy"))
"""


@pytest.mark.parametrize("algebra", [DENSE, SPARSE], ids=repr)
class TestBoth:
    def test_entries_that_are_given_twice_add_up(self, algebra):
        values, rows, columns = np.array([1.0, 2.0, 4.0]), np.array([0, 1, 1]), np.array([2, 0, 0])
        found = algebra.array(algebra.entries(values, rows, columns, (2, 3)))
        assert found.tolist() == [[0, 0, 1], [6, 0, 0]]

    def test_blocks_stand_where_they_are_put(self, algebra):
        found = algebra.stacked([[algebra.of(A), None], [None, algebra.of(B)], [algebra.zeros((1, 4)), None]])
        expected = np.block([[A, np.zeros((3, 2))], [np.zeros((3, 4)), B], [np.zeros((1, 6))]])
        assert np.array_equal(algebra.array(found), expected)

    @pytest.mark.parametrize("width", [0, 2])
    def test_blocks_may_be_empty(self, algebra, width):
        beside = algebra.stacked([[algebra.of(A), algebra.zeros((3, width))]])
        below = algebra.stacked([[algebra.of(A.T)], [algebra.zeros((width, 3))]])
        assert beside.shape == (3, 4 + width) and below.shape == (4 + width, 3)

    def test_the_largest_entries_are_those_without_their_sign(self, algebra):
        for axis in (0, 1):
            assert np.array_equal(algebra.largest(algebra.of(A), axis), np.abs(A).max(axis=axis))
        assert algebra.largest(algebra.zeros((3, 0)), 1).tolist() == [0, 0, 0]

    def test_what_is_solved_solves(self, algebra):
        for right in (np.ones(4), SQUARE[:, :2]):
            found = algebra.solved(algebra.of(SQUARE), right)
            assert found.shape == right.shape
            assert np.abs(SQUARE @ found - right).max() < 1e-13
        scaled = algebra.diagonal(np.arange(1.0, 5.0)) @ algebra.of(SQUARE)
        assert np.array_equal(algebra.array(scaled), np.arange(1.0, 5.0)[:, None] * SQUARE)

    @pytest.mark.parametrize("singular", [np.zeros((2, 2)), np.array([[1.0, 2.0], [2.0, 4.0]])], ids=["zero", "rank 1"])
    def test_a_matrix_without_inverse_is_refused(self, algebra, singular):
        with pytest.raises(RuntimeError):
            algebra.solved(algebra.of(singular), np.ones(2))


def test_the_size_says_which():
    assert algebra_of(SMALL) is DENSE and algebra_of(SMALL + 1) is SPARSE


def test_small_trains_start_at_rest_without_scipy():
    done = subprocess.run([sys.executable, "-c", STARTS], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
