"""Stick schemes of planetary sets, upper half: suns on the axis, planets on pins of the carrier above them, rings on top.

A planet that meshes with wheels side by side has a stick for each. Ports leave to the left or to the right at the height of
the axis where the way is free, else below it; rings at the top.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias, final

from gearblocks.drawing.planet_sets import CARRIER, Gearing
from gearblocks.drawing.shapes import FILLED, PAPER, THIN, Circle, Shape, Stroke, Words, arc, box, hatch, line
from gearblocks.drawing.symbols import Symbol

_SLOT, _RISE, _RADIUS, _ROW, _TEETH = 22.0, 26.0, 13.0, 12.0, 2.5
"""Width of a mesh, height of a row of planets, radius of a planet, height of a row of ports, gap between two rims."""

Mesh: TypeAlias = "tuple[int, str | int]"


def stick_scheme(gearing: Gearing, ports: Sequence[str], sides: Sequence[int], grounded: Sequence[str]) -> Symbol:
    """The symbol of a set; sides: -1 left or 1 right for each port; grounded: wheels or carrier that are held fast."""
    sticks = _Sticks(gearing, dict(zip(ports, sides, strict=True)), frozenset(grounded))
    sticks.planets()
    for name in gearing.suns:
        sticks.sun(name)
    sticks.carrier()
    for name in gearing.rings:
        sticks.ring(name)
    sticks.counts()
    heights = sticks.heights
    up = 3 - min(*heights.values(), sticks.top) + (8 if any(name in grounded for name in gearing.rings) else 0)
    down = max(*heights.values(), 0.0) + (10 if grounded else 4)
    return Symbol(tuple(sticks.shapes), sticks.half, sticks.half, up, down, tuple(heights[p] for p in ports))


@final
class _Sticks:
    """Columns of the meshes, heights of the pins and of the ports (the axis is y = 0), and what is drawn so far."""

    def __init__(self, gearing: Gearing, side: dict[str, int], grounded: frozenset[str]) -> None:
        self.gearing, self.side, self.grounded = gearing, side, grounded
        self.pins = [-_RISE * (1 + i) for i in range(len(gearing.counts))]
        self.slots = _slots(gearing)
        n = len(self.slots)
        self.x = [_SLOT * (i - (n - 1) / 2) for i in range(n)]
        self.half = _SLOT * n / 2 + 16
        self.top = self.pins[-1] - _RADIUS
        self.heights: dict[str, float] = {}
        self.used: list[tuple[float, float, float]] = []
        self.shapes: list[Shape] = []

    def columns(self, name: str) -> list[float]:
        """Where a sun or ring has a wheel."""
        return [x for x, slot in zip(self.x, self.slots, strict=True) if any(mate == name for _, mate in slot)]

    def on_pin(self, planet: int) -> list[float]:
        """Where a planet has a wheel."""
        return [x for x, s in zip(self.x, self.slots, strict=True) if any(planet in mesh for mesh in s)]

    def planets(self) -> None:
        """Sticks of the planets up to their rims, and their pins."""
        for x, slot in zip(self.x, self.slots, strict=True):
            for planet, mate in slot:
                y = self.pins[planet]
                if isinstance(mate, int):
                    middle = (y + self.pins[mate]) / 2
                    self._stick(x, y, middle, 5)
                    self._stick(x, self.pins[mate], middle - _TEETH if self.pins[mate] < y else middle + _TEETH, 5)
                else:
                    self._stick(x, y, y + _RADIUS if mate in self.gearing.suns else y - _RADIUS, 5)
                if (planet, mate) in self.gearing.noncircular:
                    self.shapes.append(arc(x, y, 7, 0, 360, look=THIN, squeeze=0.55))
        for planet, y in enumerate(self.pins):
            at = self.on_pin(planet)
            self.shapes.append(line((min(at) - 5, y), (max(at) + 5, y)))

    def counts(self) -> None:
        """How many there are of each planet, beside its pin where no line is in the way."""
        strokes = [shape for shape in self.shapes if isinstance(shape, Stroke)]
        for planet, y in enumerate(self.pins):
            if self.gearing.counts[planet] < 2:
                continue
            at, text = self.on_pin(planet), f"{self.gearing.counts[planet]}×"
            half = 3.0 * len(text)
            places = [(x, y + dy) for dy in (3.0, -4.0, 10.0) for x in (min(at) - 7 - half, max(at) + 7 + half)]
            free = (
                p for p in places if not any(_crosses(s, p[0] - half, p[1] - 7, p[0] + half, p[1] + 1) for s in strokes)
            )
            x, base = next(free, places[0])
            self.shapes.append(Words(x, base, text, 8, grey=True))

    def sun(self, name: str) -> None:
        """A wheel on the axis below its planets."""
        at = self.columns(name)
        y = self._row(min(at), max(at), self.side.get(name, -1))
        for x in at:
            self._stick(x, y, self._pin_of(name) + _RADIUS + _TEETH, 5)
        self._leave(name, min(at), max(at), y, "down")

    def ring(self, name: str) -> None:
        """A wheel with inner teeth above its planets."""
        at = self.columns(name)
        y = self.top - 10
        self.top = y
        for x in at:
            self._stick(x, y, self._pin_of(name) - _RADIUS - _TEETH, 7)
        self._leave(name, min(at), max(at), y, "up")

    def carrier(self) -> None:
        """An arm beside the wheels that holds the pins."""
        side = self.side.get(CARRIER, 1)
        edge = side * (_SLOT * len(self.slots) / 2 + 3)
        y = self._row(edge, edge, side)
        self.shapes.append(line((edge, self.pins[-1]), (edge, y)))
        for planet, pin in enumerate(self.pins):
            outermost = max(self.on_pin(planet), key=lambda x: side * x)
            self.shapes += [line((outermost, pin), (edge, pin)), Circle(outermost, pin, 1.8, FILLED)]
        self._leave(CARRIER, edge, edge, y, "down")

    def _stick(self, x: float, hub: float, rim: float, half: float) -> None:
        self.shapes += [line((x, hub), (x, rim)), line((x - half, rim), (x + half, rim))]

    def _pin_of(self, name: str) -> float:
        return min(self.pins[planet] for planet, mate in self.gearing.meshes if mate == name)

    def _row(self, low: float, high: float, side: int) -> float:
        """The highest row at or below the axis that is free from a wheel to the side of its port."""
        low, high = (-self.half, high) if side < 0 else (low, self.half)
        y = 0.0
        while any(y == row and low < b + 3 and a < high + 3 for row, a, b in self.used):
            y += _ROW
        self.used.append((y, low, high))
        return y

    def _leave(self, name: str, low: float, high: float, y: float, outward: str) -> None:
        """The line from a wheel to its port, or ground at the wheel."""
        self.heights[name] = y
        if name in self.grounded:
            self.shapes += [line((low, y), (high, y)), *hatch((low + high) / 2, y, 9, outward)]
            return
        left = self.side[name] < 0
        self.shapes.append(line((-self.half if left else low, y), (high if left else self.half, y)))


def _crosses(stroke: Stroke, left: float, top: float, right: float, bottom: float) -> bool:
    """Whether a stroke of level and upright lines touches a rectangle."""
    for (x0, y0), (x1, y1) in pairwise(stroke.points):
        if min(x0, x1) <= right and max(x0, x1) >= left and min(y0, y1) <= bottom and max(y0, y1) >= top:
            return True
    return False


def _slots(gearing: Gearing) -> list[list[Mesh]]:
    """Meshes column by column: a ring goes above the stick of a planet that meshes with a sun alone."""
    slots: list[list[Mesh]] = []
    for planet, mate in sorted(gearing.meshes, key=lambda m: (m[1] in gearing.rings, m[0])):
        alone = (s for s in slots if len(s) == 1 and s[0][0] == planet and s[0][1] in gearing.suns)
        below = next(alone, None) if mate in gearing.rings else None
        if below is None:
            slots.append([(planet, mate)])
        else:
            below.append((planet, mate))
    return slots


def differential(sides: Sequence[int], ports: Sequence[str], grounded: Sequence[str]) -> Symbol:
    """Bevel gears in a cage: the cage is the carrier, the outputs leave above and below the middle."""
    heights = {"carrier": 0.0, "left": -11.0, "right": 11.0}
    shapes: list[Shape] = [box(-17, -17, 34, 34, PAPER)]
    bevels = (((-11, -11), (11, -11), (6, -6), (-6, -6)), ((-11, 11), (11, 11), (6, 6), (-6, 6)))
    shapes += [line(*b, b[0]) for b in bevels]
    shapes += [line((s * 11, -9), (s * 11, 9), (s * 6, 5), (s * 6, -5), (s * 11, -9)) for s in (-1, 1)]
    for port, side in zip(ports, sides, strict=True):
        shapes.append(line((side * 17, heights[port]), (side * 24, heights[port])))
    if grounded:
        shapes += hatch(0, 17, 9)
    return Symbol(tuple(shapes), 24, 24, 18, 25 if grounded else 18, tuple(heights[p] for p in ports))
