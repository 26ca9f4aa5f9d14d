"""The events of a run: one structured array, from which objects are made when they are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple, final, overload

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import EventTable
from gearblocks.errors import ParameterError
from gearblocks.pages import small_table
from gearblocks.plurals import singular

KINDS = ("state", "time", "impact")
"""What an event can be, by its number in `Events.array`."""
ROW = np.dtype([("t", "f8"), ("component", "i4"), ("kind", "i4"), ("before", "f8"), ("after", "f8")])
"""A row of `Events.array`."""
_LINES = 20  # of the events that print shows
_IMPACT = 2  # in rows of the solver and in KINDS


class Event(NamedTuple):
    """One change of mode at time `t` [s]; kind: "state", "time" or "impact"; before, after: the modes.

    A mode half way between two is that of a condition whose both sides drive the motion back to it: it slides along.
    """

    t: float
    component: str
    kind: str
    before: float
    after: float


@final
class Events(Sequence[Event]):
    """The events of a run in the order of time, a sequence of `Event`.

    array: one row each with the fields t [s], component (a number in `components`), kind (a number in "state", "time",
    "impact"), before and after; it cannot be written to.
    """

    __slots__ = ("array", "components")

    def __init__(self, array: NDArray[np.void], components: Sequence[str]) -> None:
        self.array = array.view()
        self.array.flags.writeable = False
        self.components = tuple(components)

    @staticmethod
    def of(events: Iterable[Event]) -> Events:
        """Events that are objects already."""
        if isinstance(events, Events):
            return events
        listed = [Event(*event) for event in events]
        number = {name: i for i, name in enumerate(dict.fromkeys(e.component for e in listed))}
        rows = [(e.t, number[e.component], KINDS.index(e.kind), e.before, e.after) for e in listed]
        return Events(np.array(rows, dtype=ROW), tuple(number))

    @overload
    def __getitem__(self, at: int) -> Event: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[Event, ...]: ...
    def __getitem__(self, at: int | slice) -> Event | tuple[Event, ...]:
        if isinstance(at, str):
            raise ParameterError(
                f"events[{at!r}]: events are numbered; those of one part are [e for e in run.events if e.component == {at!r}]"
            )
        if isinstance(at, slice):
            return tuple(self._objects(self.array[at]))
        return next(self._objects(self.array[[at]]))

    def __len__(self) -> int:
        return len(self.array)

    def counts(self) -> dict[str, int]:
        """How many events each component has, most first."""
        found = np.bincount(self.array["component"], minlength=len(self.components))
        order = np.argsort(-found, kind="stable")
        return {self.components[i]: int(found[i]) for i in order if found[i]}

    def __iter__(self) -> Iterator[Event]:
        for start in range(0, len(self.array), 4096):
            yield from self._objects(self.array[start : start + 4096])

    def __eq__(self, other: object) -> bool:
        if isinstance(other, (Events, tuple, list)):
            return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if len(self) <= 4:
            return repr(tuple(self))
        return singular(f"<{len(self)} events of {len(self.components)} components: {self[0]}, ..., {self[-1]}>")

    def __str__(self) -> str:
        """A line each, of many the first ones."""
        rows = self._rows(_LINES)
        wide = max((len(component) for _, component, *_ in rows), default=0)
        shown = [
            f"  {t:<14}  {component:<{wide}}  {kind:<6}  {before} -> {after}"
            for t, component, kind, before, after in rows
        ]
        more = [f"  ... and {len(self) - len(rows)} more; run.events.counts() says of what"] * (len(self) > len(rows))
        counted = f"{len(self)} event{'s' * (len(self) != 1)}" if len(self) else "no events"
        return "\n".join([counted, *shown, *more])

    def _repr_html_(self) -> str:
        head = ("t in s", "component", "kind", "before", "after")
        return small_table(singular(f"{len(self)} events"), self._rows(len(self)), head=head, numbers=(0, 3, 4))

    def _rows(self, most: int) -> list[tuple[str, str, str, str, str]]:
        found = self._objects(self.array[:most])
        return [(f"{e.t:.9g}", e.component, e.kind, f"{e.before:g}", f"{e.after:g}") for e in found]

    def __reduce__(self) -> tuple[Any, ...]:
        return Events, (np.array(self.array), self.components)

    def _objects(self, rows: NDArray[np.void]) -> Iterator[Event]:
        names, columns = self.components, [rows[name].tolist() for name in ROW.names or ()]
        for t, component, kind, before, after in zip(*columns, strict=True):
            yield Event(t, names[component], KINDS[kind], before, after)


_NONE = Events(np.empty(0, dtype=ROW), ())


def events_of(table: EventTable, recorded: Sequence[NDArray[np.void]]) -> Events:
    """The events of rows that the solver recorded, with what stands for modes 0 and 1; changes of one component that follow
    on each other at one instant are one, or none where it ends as it began."""
    if not recorded:
        return _NONE
    return net_events(table, shown(table, recorded[0] if len(recorded) == 1 else np.concatenate(recorded)))


def shown(table: EventTable, raw: NDArray[np.void]) -> NDArray[np.void]:
    """Rows that the solver recorded, with what stands for modes 0 and 1."""
    index, impact = raw["index"], raw["kind"] == _IMPACT
    found = np.empty(len(raw), dtype=ROW)
    found["t"], found["component"] = raw["t"], table.component[index]
    found["kind"] = np.where(impact, _IMPACT, table.timed[index])
    for side in ("before", "after"):
        mode = raw[side]
        stands = np.where(mode == 0.0, table.low[index], np.where(mode == 1.0, table.high[index], mode))
        found[side] = np.where(impact, mode, stands)
    return found


def net_events(table: EventTable, rows: NDArray[np.void]) -> Events:
    """The events of one run from `shown` rows of it."""
    return Events(_net(rows), table.components)


def _net(rows: NDArray[np.void]) -> NDArray[np.void]:
    """Each crowd of events at one instant with its net changes."""
    together = np.flatnonzero(rows["t"][1:] == rows["t"][:-1])
    if not len(together):
        return rows
    keep = np.ones(len(rows), dtype=bool)
    for crowd in np.split(together, np.flatnonzero(np.diff(together) > 1) + 1):
        _merge(rows, keep, range(int(crowd[0]), int(crowd[-1]) + 2))
    return rows[keep]


def _merge(rows: NDArray[np.void], keep: NDArray[np.bool_], crowd: range) -> None:
    """Changes of state of one component that follow on each other, in place."""
    kept: list[int] = []
    for i in crowd:
        last = rows[kept[-1]] if kept else None
        follows = (
            last is not None and rows["kind"][i] == last["kind"] == 0 and rows["component"][i] == last["component"]
        )
        if last is None or not follows or rows["before"][i] != last["after"]:
            kept.append(i)
            continue
        keep[kept[-1]] = False
        if last["before"] == rows["after"][i]:
            keep[i] = False
            kept.pop()
        else:
            rows["before"][i] = last["before"]
            kept[-1] = i
