"""Lanes: each shaft gets one for the interval of its elements; intervals on one lane do not overlap (interval colouring).

Two shafts may meet on a lane where one ends and the other begins at an element in line. Lanes are then changed one shaft at
a time, and exchanged, as long as lines get shorter and cross less. Knows nothing of widths.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import final

from gearblocks.drawing.scheme import Element

BROKEN, CROSSING, A_LANE, LEANS = 1.5, 2.0, 1.5, 0.4
"""Costs beside one for each lane that an element reaches across: a series element out of line, a crossing, one lane more, a
port whose shaft is not on the side of the symbol on which the port is."""
ROUNDS, WORK = 12, 300_000
"""How often all changes are tried at most, and how many lines are looked at in all; more is not bettered."""


@final
@dataclass(frozen=True, slots=True)
class Lanes:
    """Lane of every shaft; home: the lane on which a boxed element or a rider stands (the upper one of a pair)."""

    of_shaft: tuple[int, ...]
    home: tuple[int, ...]
    first: tuple[int, ...]
    last: tuple[int, ...]
    count: int
    cost: float


def laid_out(elements: Sequence[Element], n_shafts: int) -> Lanes:
    """Lanes for elements in their order from left to right."""
    search = _Search(elements, n_shafts)
    search.start()
    search.improve()
    return search.result()


@final
class _Search:
    """Lines (shafts, then a line of its own for each boxed element at which no shaft ends or begins) and their lanes."""

    def __init__(self, elements: Sequence[Element], n_shafts: int) -> None:
        self.elements = elements
        self.n_shafts = n_shafts
        self.first, self.last = [len(elements)] * n_shafts, [-1] * n_shafts
        for i, e in enumerate(elements):
            for s in e.shafts:
                self.first[s], self.last[s] = min(self.first[s], i), max(self.last[s], i)
        self.own: dict[int, int] = {}
        for i, e in enumerate(elements):
            if e.is_boxed and not any(i in (self.first[s], self.last[s]) for s in e.shafts):
                self.own[i] = len(self.first)
                self.first.append(i)
                self.last.append(i)
        self.alive = [list[int]() for _ in elements]
        for line, (a, b) in enumerate(zip(self.first, self.last, strict=True)):
            for i in range(a, b + 1):
                self.alive[i].append(line)
        self.lane = [-1] * len(self.first)
        self.on_lane = defaultdict[int, set[int]](set)

    def fits(self, line: int, lane: int) -> bool:
        """Whether nothing else is on the lane along the line, but for what it meets at an element in line."""
        return all(other == line or self._beside(line, other) for other in self.on_lane[lane])

    def _beside(self, line: int, other: int) -> bool:
        if self.first[line] > self.first[other]:
            line, other = other, line
        if self.last[line] < self.first[other]:
            return True
        at = self.first[other]
        if self.last[line] != at or self.first[line] == at or self.last[other] == at:
            return False
        return self.elements[at].is_boxed and {line, other} <= set(self.elements[at].shafts)

    def start(self) -> None:
        """From left to right each line takes the free lane nearest to the lines that lead to it."""
        for line in sorted(range(len(self.first)), key=lambda s: (self.first[s], s)):
            beside = [self.lane[s] for s in self.elements[self.first[line]].shafts if self.lane[s] >= 0]
            wanted = sum(beside) / len(beside) if beside else 0.0
            free = [lane for lane in range(len(self.on_lane) + 1) if self.fits(line, lane)]
            self.lane[line] = min(free, key=lambda lane: (abs(lane - wanted), lane))
            self.on_lane[self.lane[line]].add(line)

    def home(self, i: int) -> int:
        """The lane of an element: of a boxed one that of a shaft which ends or begins there."""
        e = self.elements[i]
        if i in self.own:
            return self.lane[self.own[i]]
        if not e.is_boxed:
            return min(self.lane[s] for s in e.shafts)
        lanes = [self.lane[s] for s in e.shafts if i in (self.first[s], self.last[s])]
        everyone = [self.lane[s] for s in e.shafts]
        return min(
            lanes,
            key=lambda lane: (self._leaning(e, lane) - lanes.count(lane), sum(abs(lane - x) for x in everyone), lane),
        )

    def _leaning(self, e: Element, home: int) -> float:
        """What it costs that ports are not where their shafts are."""
        leans = e.leans()
        return LEANS * sum(
            (self.lane[s] > home) - (self.lane[s] < home) != lean
            for s, lean in zip(e.shafts, leans, strict=bool(leans))
        )

    def cost_of(self, i: int) -> float:
        """What one element costs where its lines are."""
        e = self.elements[i]
        if e.is_rider:
            return 0.0
        lanes = [self.lane[s] for s in e.shafts]
        home = self.home(i) if e.is_boxed else lanes[0]
        low, high = min(*lanes, home), max(*lanes, home)
        between = sum(low < self.lane[s] < high and s not in e.shafts for s in self.alive[i])
        broken = e.is_boxed and len(lanes) == 2 and lanes[0] != lanes[1]
        return (high - low) + CROSSING * between + BROKEN * broken + self._leaning(e, home)

    def cost(self) -> float:
        """What the whole costs."""
        used = len({*self.lane})
        return sum(self.cost_of(i) for i in range(len(self.elements))) + A_LANE * used

    def improve(self) -> None:
        """Moves single lines and exchanges lanes while that costs less."""
        best = self.cost()
        left = WORK // sum(map(len, self.alive))
        for _ in range(ROUNDS):
            before = best
            for lanes in islice(self._changes(), left):
                left -= 1
                kept = list(self.lane)
                self._take(lanes)
                now = self.cost()
                if now < best - 1e-9:
                    best = now
                else:
                    self._take(kept)
            if best >= before - 1e-9:
                return

    def _changes(self) -> Iterator[list[int]]:
        """Lanes with one line on another lane or on a new one, with two lanes or two lines exchanged, or upside down."""
        for line in range(len(self.lane)):
            for lane in range(self.count):
                if lane != self.lane[line] and self.fits(line, lane):
                    yield [lane if s == line else x for s, x in enumerate(self.lane)]
            for new in range(self.count + 1):
                yield [new if s == line else x + (x >= new) for s, x in enumerate(self.lane)]
        for a in range(self.count):
            for b in range(a):
                yield [b if x == a else a if x == b else x for x in self.lane]
        yield [-x for x in self.lane]
        for one in range(len(self.lane)):
            for other in range(one):
                if self.lane[one] != self.lane[other] and self._may_exchange(one, other):
                    yield [self.lane[{one: other, other: one}.get(s, s)] for s in range(len(self.lane))]

    def _may_exchange(self, one: int, other: int) -> bool:
        """Whether each of two lines is free to go where the other one is."""
        pairs = ((one, other), (other, one))
        return all(s == b or self._beside(a, s) for a, b in pairs for s in self.on_lane[self.lane[b]])

    def _take(self, lanes: list[int]) -> None:
        """Takes lanes as they are, empty ones closed up."""
        rank = {lane: i for i, lane in enumerate(sorted({*lanes}))}
        self.lane = [rank[lane] for lane in lanes]
        self.on_lane.clear()
        for line, lane in enumerate(self.lane):
            self.on_lane[lane].add(line)

    @property
    def count(self) -> int:
        """How many lanes there are."""
        return len({*self.lane})

    def result(self) -> Lanes:
        """What was found."""
        n, homes = self.n_shafts, tuple(self.home(i) for i in range(len(self.elements)))
        return Lanes(tuple(self.lane[:n]), homes, tuple(self.first[:n]), tuple(self.last[:n]), self.count, self.cost())
