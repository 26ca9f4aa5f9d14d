"""Events as one array, objects on access, and what the solver records made into them."""

import pickle
from typing import Any

import numpy as np
import pytest

from gearblocks.codegen.program import EventTable
from gearblocks.simulation.events import ROW, Event, Events, events_of
from gearblocks.solver.structures import EVENT

TABLE = EventTable(
    ("x", "y", "tau"),
    np.array([0, 1, 0, 2], dtype=np.int32),
    np.array([False, False, True, True]),
    np.array([0.0, -1.0, 0.0, 0.0]),
    np.array([1.0, 3.0, 1.0, 1.0]),
)
"""Two switches of state, one of time, and an input."""
LISTED = [
    Event(0.5, "x", "state", 0.0, 1.0), Event(0.5, "y", "state", 3.0, -1.0), Event(1.0, "y", "impact", -2.5, 1.25),
    Event(2.0, "tau", "time", 10.0, 20.0),
]  # fmt: skip


def _recorded(*rows: tuple[float, int, int, float, float]) -> list[np.ndarray[Any, Any]]:
    """Rows (t, index, kind, before, after) as the solver writes them, in two pieces."""
    made = np.array([(t, before, after, index, kind) for t, index, kind, before, after in rows], dtype=EVENT)
    return [made[:1], made[1:]]


def test_events_are_those_that_the_solver_recorded():
    found = events_of(
        TABLE, _recorded((0.5, 0, 0, 0, 1), (0.5, 1, 0, 1, 0), (1.0, 1, 2, -2.5, 1.25), (2.0, 3, 1, 10, 20))
    )
    assert found == LISTED and list(found) == LISTED and found == Events.of(LISTED)
    assert [type(value) for value in found[2]] == [float, str, str, float, float]
    assert events_of(TABLE, []) == () and not events_of(TABLE, [])


def test_a_mode_beyond_the_two_named_ones_is_shown_as_it_is():
    assert [e.after for e in events_of(TABLE, _recorded((0.0, 1, 0, 0, 2), (1.0, 1, 0, 2, 0.5)))] == [2.0, 0.5]


def test_events_behave_as_a_sequence_that_cannot_be_written_to():
    found = Events.of(LISTED)
    assert len(found) == 4 and found[0] == LISTED[0] and found[-1] == LISTED[-1]
    assert found[1:3] == tuple(LISTED[1:3]) and LISTED[2] in found and found.index(LISTED[2]) == 2
    assert found != LISTED[:3] and found != "events" and Events.of(found) is found
    with pytest.raises(IndexError):
        found[4]
    with pytest.raises(ValueError, match="read-only"):
        found.array["t"] = 0.0
    assert "x" in repr(found) and "4 events" not in repr(found)
    assert repr(Events.of([*LISTED, *LISTED])).startswith("<8 events of 3 components")


def test_events_travel_by_pickle():
    assert pickle.loads(pickle.dumps(Events.of(LISTED))) == LISTED


def test_many_events_are_iterated_in_their_order():
    array = np.zeros(10_000, dtype=ROW)
    array["t"] = np.arange(10_000)
    assert [e.t for e in Events(array, ["x"])] == list(range(10_000))


def test_changes_of_one_component_at_one_instant_are_one_change_or_none():
    def net(*rows: tuple[float, int, int, float, float]) -> list[tuple[float, ...]]:
        made = np.array([(t, before, after, index, kind) for t, index, kind, before, after in rows], dtype=EVENT)
        table = TABLE._replace(low=np.zeros(4), high=np.ones(4))
        return [(e.t, e.component, e.kind, e.before, e.after) for e in events_of(table, [made])]

    there, back = (1.0, 0, 0, 0.0, 1.0), (1.0, 0, 0, 1.0, 0.0)
    other_there, other_back = (1.0, 1, 0, 0.0, 1.0), (1.0, 1, 0, 1.0, 0.0)
    shown = (1.0, "x", "state", 0.0, 1.0)
    assert net(there, back) == []
    assert net(there, back, there) == [shown]
    assert net(there, other_there, other_back, back) == []
    assert net(there, (1.0, 0, 0, 1.0, -1.0)) == [(1.0, "x", "state", 0.0, -1.0)]
    assert net((0.5, *there[1:]), there, back, (2.0, *back[1:])) == [(0.5, *shown[1:]), (2.0, "x", "state", 1.0, 0.0)]
    for other in ((2.0, *back[1:]), (1.0, 1, 0, 1.0, 0.0), (1.0, 0, 2, 1.0, 0.0), (1.0, 0, 0, 2.0, 0.0)):
        assert len(net(there, other)) == 2


def test_print_shows_a_line_for_each_event_and_of_many_the_first_ones() -> None:
    shown = str(Events.of(LISTED)).splitlines()
    assert shown[0] == f"{len(LISTED)} events" and len(shown) == 1 + len(LISTED)
    assert f"{LISTED[0].before:g} -> {LISTED[0].after:g}" in shown[1] and LISTED[0].component in shown[1]
    many = str(Events.of([LISTED[0]] * 50)).splitlines()
    assert len(many) == 22 and many[-1].strip() == "... and 30 more; run.events.counts() says of what"
    assert str(Events.of([])) == "no events" and str(Events.of(LISTED[:1])).startswith("1 event\n")
    assert Events.of([LISTED[0]] * 50)._repr_html_().count("<tr") > 20
