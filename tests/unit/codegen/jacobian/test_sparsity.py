"""Symbolic elimination: order, fill-in and entries."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gearblocks.codegen.jacobian.sparsity import eliminate, read_by_none


def test_a_chain_is_eliminated_from_both_ends_without_fill():
    pattern = eliminate(6, [(i, i + 1) for i in range(5)])
    assert pattern.order == (0, 5, 1, 4, 2, 3)
    assert pattern.row == (2, 3, 4, 5, 5)
    assert pattern.start == (0, 1, 2, 3, 4, 5, 5)
    assert pattern.is_tree
    assert pattern.pair == ()


def test_a_star_loses_its_leaves_first():
    assert eliminate(5, [(2, i) for i in (0, 1, 3, 4)]).order == (0, 1, 3, 4, 2)


def test_unknowns_without_neighbours_have_empty_columns():
    pattern = eliminate(3, [(2, 2)])
    assert pattern.start == (0, 0, 0, 0)
    assert eliminate(0, []).order == ()


def test_a_ring_is_filled_by_less_than_one_entry_per_unknown():
    pattern = eliminate(40, [(i, (i + 1) % 40) for i in range(40)])
    assert len(pattern.row) == 2 * 40 - 3  # two entries per column but for the last two
    assert not pattern.is_tree


def test_a_pair_that_is_not_coupled_has_no_place():
    pattern = eliminate(4, [(0, 1), (1, 2), (2, 3)])
    assert pattern.place(1, 0) == pattern.place(0, 1) == 0
    assert pattern.is_lower(1, 0) != pattern.is_lower(0, 1)
    with pytest.raises(KeyError):
        pattern.place(0, 3)


@given(st.data())
def test_every_product_of_the_elimination_finds_its_place(data):
    """The filled pattern holds L and U of a random matrix, and the pairs are the places of all products, in turn."""
    n = data.draw(st.integers(1, 12))
    index = st.integers(0, n - 1)
    coupled = data.draw(st.lists(st.tuples(index, index), max_size=30))
    pattern = eliminate(n, coupled)
    assert sorted(pattern.order) == list(range(n))
    assert all(pattern.order[step] == i for i, step in enumerate(pattern.steps))
    full = np.eye(n, dtype=bool)
    for i, j in coupled:
        full[pattern.steps[i], pattern.steps[j]] = full[pattern.steps[j], pattern.steps[i]] = True
    pairs = []
    for k in range(n):
        rows = [i for i in range(k + 1, n) if full[i, k]]
        assert list(pattern.row[pattern.start[k] : pattern.start[k + 1]]) == rows
        for a, one in enumerate(rows):
            for other in rows[a + 1 :]:
                full[one, other] = full[other, one] = True
                pairs.append((one, other))
    assert list(pattern.pair) == [pattern.place(pattern.order[a], pattern.order[b]) for a, b in pairs]


def test_what_no_equation_reads_goes_ahead_and_couples_nothing():
    """0 reads 3 and 4, 1 reads 0 and 4, 2 is read by 3: one after the other 1 and 0 go, and the rest is a chain."""
    coupled = [(0, 3), (0, 4), (1, 0), (1, 4), (3, 2), (2, 3), (3, 4), (4, 3), (1, 1)]
    ahead = read_by_none(coupled, range(3))
    assert ahead == [1, 0]
    pattern = eliminate(5, coupled, ahead=ahead)
    assert pattern.ahead == 2 and pattern.order[:2] == (1, 0) and pattern.is_tree
    assert [len(range(*pattern.start[k : k + 2])) for k in range(2)] == [2, 2]
    assert not eliminate(5, coupled).is_tree


def test_what_reads_each_other_is_read():
    assert read_by_none([(0, 1), (1, 0), (2, 1)], range(3)) == [2]
