"""Layout of a scheme: boxes, shafts as lines on lanes, and the shapes of every symbol, in pixels.

On every lane that an element covers it stands to the right of what was placed before (the longest path over footprints
that share a lane), so that no two boxes overlap and no line crosses a box, by construction. A row that would grow too wide
ends, and its shafts go on in the next one. Of several orders the one that draws best is taken.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import final

from gearblocks.drawing import pairs
from gearblocks.drawing.captions import caption, title
from gearblocks.drawing.footprints import Footprint, footprint
from gearblocks.drawing.lanes import Lanes, laid_out
from gearblocks.drawing.ordering import orders
from gearblocks.drawing.scheme import Element, Scheme
from gearblocks.drawing.shapes import Point, Shape, line, moved

WIDTH = 900.0
"""Width in pixels that a drawing does not pass, but for an element that is wider by itself."""
EDGE, GAP, TRACK, ROW_GAP = 14.0, 4.0, 7.0, 12.0
LEAST_PAIR, LEAST_APART = 58.0, 34.0


@final
@dataclass(frozen=True, slots=True)
class Box:
    """The room of a symbol with its words: no other box and no line comes in."""

    x: float
    y: float
    width: float
    height: float
    element: int


@final
@dataclass(frozen=True, slots=True)
class Wire:
    """Part of a shaft outside of all boxes; shaft = -1: what joins the two wheels of a pair, which lie apart."""

    points: tuple[Point, ...]
    shaft: int


@final
@dataclass(frozen=True, slots=True)
class Figure:
    """The shapes of one element, and its words on hover; part: it is one of those drawn as a bundle."""

    element: Element
    number: int
    shapes: tuple[Shape, ...]
    title: str
    part: bool = False


@final
@dataclass(frozen=True, slots=True)
class Layout:
    """All that is drawn, and where."""

    width: float
    height: float
    figures: tuple[Figure, ...]
    boxes: tuple[Box, ...]
    wires: tuple[Wire, ...]
    joints: tuple[Point, ...]

    def __repr__(self) -> str:
        return f"<Layout {self.width:.0f} x {self.height:.0f}: {len(self.boxes)} boxes, {len(self.wires)} lines>"


def layout(scheme: Scheme, values: bool = False) -> Layout:
    """The best layout among the orders of the elements: small, with short lines."""
    made = [_Sheet(scheme, order, values).drawn() for order in orders(scheme)]
    return min(made, key=_badness)


def _badness(one: Layout) -> float:
    """Area, and the length of lines, each over a usual size."""
    length = sum(abs(a[0] - b[0]) + abs(a[1] - b[1]) for w in one.wires for a, b in pairwise(w.points))
    return one.width * one.height / 1e5 + length / 2e3


@final
@dataclass(slots=True)
class _Row:
    """One row of the sheet: footprints with the x of their middle, and the height of each lane."""

    begin: int
    prints: list[tuple[Footprint, float]]
    right: float = 0.0
    y: dict[int, float] | None = None
    top: float = 0.0
    bottom: float = 0.0


def _margin(crossing: Sequence[int]) -> float:
    """Room beside the rows, where shafts are led around that go on from row to row."""
    return EDGE + (TRACK * (max(crossing) + 1) if crossing else 0.0)


@final
class _Sheet:
    """The rows of one order of the elements."""

    def __init__(self, scheme: Scheme, order: Sequence[int], values: bool) -> None:
        self.order = order
        self.elements = [scheme.elements[i] for i in order]
        self.lanes: Lanes = laid_out(self.elements, len(scheme.shafts))
        self.order_of = {id(e): i for i, e in enumerate(self.elements)}
        alive = self._alive()
        self.prints = [footprint(i, e, self.lanes, caption(e, values), alive[i]) for i, e in enumerate(self.elements)]
        self.joints: list[Point] = []
        self.wires: list[Wire] = []
        self.boxes: list[Box] = []
        self.figures: list[Figure] = []

    def drawn(self) -> Layout:
        """Rows filled from left to right, given their heights, then drawn."""
        self.rows = self._rows(WIDTH - 2 * EDGE)
        if len(self.rows) > 1:
            self.rows = self._folded()
        self.breaks = [self._crossing(row.begin) for row in self.rows[1:]]
        margin = _margin([*map(len, self.breaks)])
        right = max(row.right for row in self.rows)
        self.left, self.right = margin, margin + right
        y = EDGE
        for k, row in enumerate(self.rows):
            y = self._heights(k, row, y)
            if k < len(self.breaks):
                y += ROW_GAP + TRACK * (len(self.breaks[k]) + 1)
        for k, row in enumerate(self.rows):
            for n, (p, x) in enumerate(row.prints):
                self._draw(row, p, x + self.left, self.order[row.begin + n])
            self._draw_shafts(k, row)
        for k in range(len(self.breaks)):
            self._draw_break(k)
        return Layout(
            right + 2 * margin, y + EDGE, tuple(self.figures), tuple(self.boxes), tuple(self.wires), tuple(self.joints)
        )

    # -- places -------------------------------------------------------------------------------------------------------

    def _alive(self) -> list[list[int]]:
        """Shafts that are there at each element."""
        found: list[list[int]] = [[] for _ in self.elements]
        for s, (a, b) in enumerate(zip(self.lanes.first, self.lanes.last, strict=True)):
            for i in range(a, b + 1):
                found[i].append(s)
        return found

    def _crossing(self, i: int) -> list[int]:
        """Shafts that go on from before element i, the uppermost first."""
        first, last = self.lanes.first, self.lanes.last
        found = [s for s in range(len(first)) if first[s] < i <= last[s]]
        return sorted(found, key=lambda s: self.lanes.of_shaft[s])

    def _folded(self) -> list[_Row]:
        """As few rows as there must be, with few shafts that go on from row to row, and of much the same width."""
        widest = WIDTH - 2 * (EDGE + 3 * TRACK)
        tried = [self._rows(widest - 25.0 * i) for i in range(12)]

        def worth(rows: list[_Row]) -> tuple[bool, int, int, float]:
            crossing = [len(self._crossing(row.begin)) for row in rows[1:]]
            width = max(row.right for row in rows)
            return width + 2 * _margin(crossing) > WIDTH, len(rows), sum(crossing), width

        return min(tried, key=worth)

    def _rows(self, room: float) -> list[_Row]:
        """Each element right of what lies before it on its lanes; a new row where the width is used up."""
        rows = [_Row(0, [])]
        front = defaultdict[int, float](float)
        for i, p in enumerate(self.prints):
            x = max(front[lane] - a + GAP for lane, (a, _) in p.spans.items())
            if rows[-1].prints and x + max(b for _, b in p.spans.values()) > room:
                rows.append(_Row(i, []))
                front.clear()
                x = max(GAP - a for a, _ in p.spans.values())
            rows[-1].prints.append((p, x))
            for lane, (_, b) in p.spans.items():
                front[lane] = x + b
            rows[-1].right = max(rows[-1].right, *(x + b for _, b in p.spans.values()))
        return rows

    def _heights(self, k: int, row: _Row, top: float) -> float:
        """The y of every lane of a row; answers with its lower end."""
        up, down = defaultdict[int, float](lambda: 6.0), defaultdict[int, float](lambda: 6.0)
        for p, _ in row.prints:
            up[p.home] = max(up[p.home], p.up)
            down[p.lower] = max(down[p.lower], p.down)
            if not p.together:
                down[p.home] = max(down[p.home], pairs.APART + 2)
                up[p.lower] = max(up[p.lower], pairs.APART + 2)
            for c in p.channels:
                up[c.lane], down[c.lane] = max(up[c.lane], 6.0), max(down[c.lane], 6.0)
        for s in self._in_row(k):
            up[self.lanes.of_shaft[s]] = max(up[self.lanes.of_shaft[s]], 6.0)
        row.y, bottom = {}, top - 8.0
        for lane in sorted({*up, *down}):
            y = bottom + 8.0 + up[lane]
            for p, _ in row.prints:
                if p.lower == lane and p.home in row.y and p.symbol is None:
                    y = max(y, row.y[p.home] + (LEAST_PAIR if p.together else LEAST_APART))
            row.y[lane], bottom = y, y + down[lane]
        row.top, row.bottom = top, bottom
        return bottom

    def _in_row(self, k: int) -> list[int]:
        """Shafts with a piece in row k."""
        begin = self.rows[k].begin
        end = self.rows[k + 1].begin if k + 1 < len(self.rows) else len(self.elements)
        return [
            s for s, (a, b) in enumerate(zip(self.lanes.first, self.lanes.last, strict=True)) if a < end and b >= begin
        ]

    # -- drawing ------------------------------------------------------------------------------------------------------

    def _draw(self, row: _Row, p: Footprint, x: float, number: int) -> None:
        """The box, the symbol with its words, and the leads in its channels."""
        assert row.y is not None
        y, low = row.y[p.home], row.y[p.lower]
        if p.symbol is None:
            shapes = self._draw_pair(p, x, y, low, number)
        else:
            self.boxes.append(Box(x - p.left, y - p.up, p.left + p.right, p.up + p.down, number))
            s = p.symbol
            shapes = [*moved(s.shapes, x, y), *moved(p.caption.shapes(s.up, s.down), x, y)]
            shapes += self._stubs(p, x, y)
        for c in p.channels:
            if not c.straight and self.lanes.first[c.shaft] < self.lanes.last[c.shaft]:  # an open flange leads nowhere
                edge = x + (-p.left if c.side < 0 else p.right)
                self.wires.append(Wire(((edge, y + c.y), (x + c.x, y + c.y), (x + c.x, row.y[c.lane])), c.shaft))
        self.figures.append(Figure(p.element, number, tuple(shapes), p.caption.title))
        parts = p.symbol.parts if p.symbol is not None else ()
        for one, drawn in zip(p.element.parallel, parts, strict=True):
            self.figures.append(Figure(one, number, moved(drawn, x, y), title(one), part=True))

    def _stubs(self, p: Footprint, x: float, y: float) -> list[Shape]:
        """Lines from the symbol to the sides of its box, where the words are wider."""
        assert p.symbol is not None
        found: list[Shape] = []
        sides = [(c.side, c.y) for c in p.channels]
        if p.element.is_rider:
            shaft, i = p.element.shafts[0], self.order_of[id(p.element)]
            sides = [
                (s, 0.0) for s, goes in ((-1, self.lanes.first[shaft] < i), (1, self.lanes.last[shaft] > i)) if goes
            ]
        for side, at in sides:
            inner, outer = (-p.symbol.left, -p.left) if side < 0 else (p.symbol.right, p.right)
            if inner != outer:
                found.append(line((x + inner, y + at), (x + outer, y + at)))
        return found

    def _draw_pair(self, p: Footprint, x: float, y: float, low: float, number: int) -> list[Shape]:
        e, lanes = p.element, self.lanes
        i = self.order_of[id(e)]
        first_is_upper = lanes.of_shaft[e.shafts[0]] == p.home
        shapes = [*moved(pairs.pair(e.block, low - y, first_is_upper, p.together), x, y)]
        for shaft in e.shafts:
            at = y if lanes.of_shaft[shaft] == p.home else low
            ends = (-p.left if lanes.first[shaft] < i else 0.0, p.right if lanes.last[shaft] > i else 0.0)
            shapes.append(line((x + ends[0], at), (x + ends[1], at)))
        out = pairs.OUTWARD + 2
        shapes += [*moved(p.caption.shapes(out, out + low - y), x, y)]
        if p.together:
            self.boxes.append(Box(x - p.left, y - p.up, p.left + p.right, low - y + p.up + p.down, number))
        else:
            self.boxes.append(Box(x - p.left, y - p.up, p.left + p.right, p.up + pairs.APART + 2, number))
            self.boxes.append(
                Box(x - p.left, low - pairs.APART - 2, p.left + p.right, pairs.APART + 2 + p.down, number)
            )
            self.wires.append(Wire(((x, y + pairs.APART + 2), (x, low - pairs.APART - 2)), -1))
        return shapes

    def _draw_shafts(self, k: int, row: _Row) -> None:
        """Lines between what each shaft meets on its lane, and dots where leads join a line that goes on."""
        assert row.y is not None
        for s in self._in_row(k):
            y = row.y[self.lanes.of_shaft[s]]
            stops: list[tuple[float, float]] = []
            joined: list[float] = []
            for p, middle in row.prints:
                x = middle + self.left
                if s not in p.element.shafts:
                    continue
                if not p.element.is_boxed:
                    half = p.left
                    stops.append((x - half, x + half))
                for c in p.channels:
                    if c.shaft == s:
                        stops.append((x + c.x, x + c.x))
                        joined += [] if c.straight else [x + c.x]
            stops += [(self.left, self.left)] if k and s in self.breaks[k - 1] else []
            stops += [(self.right, self.right)] if k < len(self.breaks) and s in self.breaks[k] else []
            stops.sort()
            for (_, a), (b, _) in pairwise(stops):
                if b > a:
                    self.wires.append(Wire(((a, y), (b, y)), s))
            self.joints += [(x, y) for x in joined if stops[0][0] < x < stops[-1][1]]

    def _draw_break(self, k: int) -> None:
        """Shafts that go on in the next row: out at the right, back between the rows, in at the left, without a crossing."""
        upper, lower = self.rows[k], self.rows[k + 1]
        assert upper.y is not None and lower.y is not None
        n = len(self.breaks[k])
        for j, s in enumerate(self.breaks[k]):
            lane = self.lanes.of_shaft[s]
            out, into = self.right + TRACK * (n - j), self.left - TRACK * (j + 1)
            between = upper.bottom + ROW_GAP / 2 + TRACK * (n - j)
            points = (
                (self.right, upper.y[lane]), (out, upper.y[lane]), (out, between), (into, between), (into, lower.y[lane]),
                (self.left, lower.y[lane]),
            )  # fmt: skip
            self.wires.append(Wire(points, s))
