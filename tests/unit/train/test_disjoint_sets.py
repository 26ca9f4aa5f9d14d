"""Union-find with exact gains."""

from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gearblocks.train.disjoint_sets import DisjointSets

N = 12
PAIRS = st.lists(st.tuples(st.integers(0, N - 1), st.integers(0, N - 1)), max_size=30)
NUMBERS = [Fraction(*x) for x in ((1, 1), (-1, 1), (2, 1), (1, 2), (-3, 5), (7, 3))]
GAINS = st.lists(st.sampled_from(NUMBERS), min_size=N, max_size=N)
unhurried = settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow])  # on a busy machine


@unhurried
@given(PAIRS)
def test_sets_are_the_connected_parts_of_a_graph(pairs):
    sets, parts = DisjointSets[int](), {i: {i} for i in range(N)}
    for a, b in pairs:
        sets.join(a, b)
        if parts[a] is not parts[b]:
            parts[a] |= parts[b]
            for i in parts[b]:
                parts[i] = parts[a]
    for a in range(N):
        assert {b for b in range(N) if sets.root(b) == sets.root(a)} == parts[a]


@unhurried
@given(PAIRS)
def test_the_root_of_the_second_stays(pairs):
    sets = DisjointSets[int]()
    for a, b in pairs:
        stays = sets.root(b)
        sets.join(a, b)
        assert sets.root(a) == sets.root(b) == stays


@unhurried
@given(PAIRS, GAINS)
def test_gains_multiply_along_the_way_to_the_root(pairs, values):
    sets = DisjointSets[int]()
    for a, b in pairs:
        sets.join(a, b, values[a] / values[b])
    for i in range(N):
        root, gain = sets.find(i)
        assert gain == values[i] / values[root]


@pytest.mark.long
@unhurried
@given(PAIRS, GAINS, st.sets(st.integers(0, N - 1)))
def test_another_root_leaves_sets_and_ratios_as_they_are(pairs, values, wanted):
    sets = DisjointSets[int]()
    for a, b in pairs:
        sets.join(a, b, values[a] / values[b])
    before = [sets.root(i) for i in range(N)]
    roots = {sets.root(i): i for i in wanted}
    sets.reroot(roots)
    for i in range(N):
        root, gain = sets.find(i)
        assert root == roots.get(before[i], before[i])
        assert gain == values[i] / values[root]


def test_whole_gains_stay_whole_numbers():
    sets = DisjointSets[str]()
    sets.join("ring", "sun", 4)
    sets.join("wheel", "ring", Fraction(1, 2))
    sets.reroot({"sun": "wheel"})
    found = [sets.find(x) for x in ("sun", "ring", "wheel", "alone")]
    assert found == [("wheel", Fraction(1, 2)), ("wheel", 2), ("wheel", 1), ("alone", 1)]
    assert isinstance(sets.find("ring")[1], int)


def test_a_long_chain_needs_no_recursion():
    sets = DisjointSets[int]()
    for i in range(100_000):
        sets.join(i, i + 1, -1)
    assert sets.find(0) == (100_000, 1)
