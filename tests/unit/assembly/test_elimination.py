"""Exact elimination against sympy's dense matrices."""

from fractions import Fraction

import pytest
import sympy as sp
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gearblocks.assembly.elimination import Combination, Elimination, dependency_order, row_sum

N = 5
NUMBERS = st.sampled_from((0, 0, 0, 1, -1, 2, -3, Fraction(1, 2), Fraction(-7, 3)))
MATRICES = st.lists(st.lists(NUMBERS, min_size=N, max_size=N), min_size=1, max_size=6)
unhurried = settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow])  # on a busy machine


def row_of(numbers):
    return {x: c for x, c in enumerate(numbers) if c}


def eliminated(matrix, choose=min, *, reduced_first=True):
    """Every row that says something new, solved; row k carries the label k. The numbers of those that do not, too."""
    elimination, spare = Elimination(), []
    for k, numbers in enumerate(matrix):
        row = Combination(row_of(numbers), {k: -1})
        left = elimination.left(row.groups)
        if not left:
            spare.append(k)
            continue
        elimination.solve(elimination.reduced(row) if reduced_first else row, choose(left))
    return elimination, spare


@unhurried
@given(MATRICES, st.sampled_from((min, max, lambda row: next(iter(row)))))
def test_as_many_pivots_as_the_rank_whatever_the_pivot_rule(matrix, choose):
    elimination, spare = eliminated(matrix, choose)
    assert len(elimination.definitions) == sp.Matrix(matrix).rank() == len(matrix) - len(spare)


@unhurried
@given(MATRICES, st.sampled_from((min, max)))
def test_definitions_substituted_into_each_other_are_the_reduced_row_form(matrix, choose):
    elimination, _ = eliminated(matrix, choose)
    pivots = sorted(elimination.definitions)
    columns = pivots + [x for x in range(N) if x not in pivots]  # with these in front, sympy takes the same pivots
    reduced, chosen = sp.Matrix(matrix)[:, columns].rref()
    assert list(chosen) == list(range(len(pivots)))
    for i, pivot in enumerate(pivots):
        gains = elimination.gains(pivot)
        assert not gains.keys() & elimination.definitions.keys()
        assert [-gains.get(x, 0) for x in columns[len(pivots) :]] == list(reduced[i, len(pivots) :])


@unhurried
@given(MATRICES)
def test_what_is_left_spans_the_null_space(matrix):
    elimination, _ = eliminated(matrix, max)
    free = [x for x in range(N) if x not in elimination.definitions]
    basis = [sp.Matrix([elimination.gains(x).get(f, 0) for x in range(N)]) for f in free]
    assert len(basis) == len(sp.Matrix(matrix).nullspace())
    assert all((sp.Matrix(matrix) * vector).is_zero_matrix for vector in basis)


@unhurried
@given(MATRICES, st.sampled_from((min, max)))
def test_labels_tell_which_given_rows_a_solved_one_consists_of(matrix, choose):
    elimination, spare = eliminated(matrix, choose)
    for pivot in elimination.definitions:
        whole = elimination.reduced(Combination({pivot: 1}))
        shares = whole.coordinates
        found = [sum(shares.get(k, 0) * Fraction(row[x]) for k, row in enumerate(matrix)) for x in range(N)]
        assert found == [Fraction(x == pivot) - Fraction(whole.groups.get(x, 0)) for x in range(N)]
    for k in spare:  # and which rows say together what a spare one says
        rest = elimination.reduced(Combination(row_of(matrix[k]), {k: -1}))
        assert not rest.groups
        assert all(sum(rest.coordinates.get(i, 0) * row[x] for i, row in enumerate(matrix)) == 0 for x in range(N))


def test_a_chain_of_raw_rows_stays_as_short_as_it_is():
    elimination = Elimination()
    n = 5000
    for k in range(n):
        elimination.solve(Combination({k: 1, k + 1: -1}, {k: -1}), k + 1)
    assert max(len(d.groups) + len(d.coordinates) for d in elimination.definitions.values()) == 2
    assert elimination.gains(n) == {0: 1}
    assert len(elimination.reduced(Combination({n: 1})).coordinates) == n


def test_whole_numbers_stay_whole_numbers():
    elimination = Elimination()
    elimination.solve(Combination({0: -1, 1: 3}), 0)
    elimination.solve(Combination({1: 2, 2: 4}), 1)
    assert elimination.gains(0) == {2: -6}
    assert elimination.left({0: 1, 2: 6}) == {}


def test_what_floats_leave_where_they_cancel_is_nothing():
    terms = [(Fraction(0.1), {0: 1, 1: 1}), (Fraction(0.2), {0: 1}), (Fraction(0.3), {0: -1})]
    assert set(row_sum(terms)) == {0, 1}
    assert set(row_sum(terms, 1e-14)) == {1}


def test_a_pivot_that_the_row_does_not_have_is_a_bug_of_the_caller():
    with pytest.raises(KeyError):
        Elimination().solve(Combination({0: 1}), 1)


def test_sources_come_before_what_they_define():
    sources = {3: [2, 1], 2: [1, 0], 1: [0], 5: [4]}
    assert dependency_order([3], sources, sources.__getitem__) == [1, 2, 3]
    assert dependency_order([5, 3], sources, sources.__getitem__) == [5, 1, 2, 3]


def test_a_circle_ends_the_search_too():
    sources = {0: [1], 1: [0]}
    assert dependency_order([0], sources, sources.__getitem__) == [1, 0]
