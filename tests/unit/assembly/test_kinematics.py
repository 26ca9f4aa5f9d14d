"""How dependent groups solve_dependent: rows solved exactly, prescribed motions, and what is refused by name."""

from fractions import Fraction

import pytest

from gearblocks.assembly.kinematics import GroupRow, PrescribedRow, solve_dependent
from gearblocks.errors import ModelError


def row(path, coefficients, offsets=None, *, grounded=False):
    return GroupRow(path, coefficients, offsets or {}, grounded)


def drive(path, group, *sources):
    return PrescribedRow(0, 0, path, group, 1, {f"flange{s}": (s, 1) for s in sources}, by_speed=False)


FREE = dict.fromkeys(range(8), (0, 0))


def test_a_row_is_solved_for_the_group_of_least_reluctance():
    found = solve_dependent([row("set", {0: 1, 1: 2, 2: -3})], [], {**FREE, 0: (1, 0), 2: (0, 1)}, {})
    (follower,) = found.dependent_groups
    assert follower.group == 1
    assert follower.row.groups == {0: Fraction(-1, 2), 2: Fraction(3, 2)}
    assert found.new == [True]


def test_followers_come_after_their_sources():
    rows = [row("one", {0: 1, 1: 1, 2: -2}), row("two", {2: 1, 3: 1, 4: -2}), row("three", {4: 1, 5: 1, 0: 3})]
    found = solve_dependent(rows, [drive("cam", 6, 5)], FREE, {})
    done = set()
    for f in found.dependent_groups:
        assert not (set(f.sources) - done) & found.dependent.keys(), f
        done.add(f.group)
    assert len(found.dependent_groups) == 4


def test_a_row_that_others_imply_says_nothing_new():
    rows = [row("one", {0: 1, 1: 1, 2: -2}), row("two", {0: 3, 1: 3, 2: -6})]
    assert solve_dependent(rows, [], FREE, {}).new == [True, False]


def test_rows_that_leave_nothing_to_move_are_refused():
    rows = [row("one", {0: 1, 1: 1, 2: -2}), row("two", {0: 1, 1: 1, 2: -3})]
    with pytest.raises(ModelError, match="'one', 'two' contradict each other"):
        solve_dependent(rows, [], FREE, {})


def test_angles_that_the_ground_holds_must_fit():
    rows = [row("one", {0: 1}, {"fixed.phi0": 2}, grounded=True), row("two", {0: 1}, {"other.phi0": 1}, grounded=True)]
    assert solve_dependent(rows, [], FREE, {"fixed.phi0": 1.0, "other.phi0": 2.0}).new == [True, False]
    with pytest.raises(ModelError, match="contradicts the angles"):
        solve_dependent(rows, [], FREE, {"fixed.phi0": 1.0, "other.phi0": 2.5})


def test_prescribed_motions_in_a_circle_are_refused_by_name():
    with pytest.raises(ModelError, match="'p', 'q' depend on each other"):
        solve_dependent([], [drive("p", 0, 1), drive("q", 1, 0)], FREE, {})
    with pytest.raises(ModelError, match="'p', 'q', 'r' depend on each other"):
        solve_dependent([], [drive("p", 0, 1), drive("q", 1, 2), drive("r", 2, 0)], FREE, {})
