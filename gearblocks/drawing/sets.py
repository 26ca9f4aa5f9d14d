"""Stick schemes of planetary sets, upper half: suns on the axis, planets on pins of the carrier above them, rings on top.

A planet that meshes with wheels side by side has a stick for each. Ports leave to the left or to the right at the height of
the axis where the way is free, else below it; rings at the top.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from gearblocks.drawing.planet_sets import CARRIER, Gearing
from gearblocks.drawing.shapes import FILLED, PAPER, Circle, Shape, box, hatch, line
from gearblocks.drawing.symbols import Symbol

_SLOT, _RISE, _STEP = 22.0, 26.0, 13.0


@final
class _Sticks:
    """Columns of the meshes, and heights of the planets; the axis is y = 0."""

    def __init__(self, gearing: Gearing) -> None:
        self.gearing = gearing
        self.pins = [-_RISE * (1 + i) for i in range(len(gearing.counts))]
        self.slots: list[list[tuple[int, str | int]]] = []
        order = sorted(gearing.meshes, key=lambda m: (m[1] in gearing.rings, m[0]))
        for planet, mate in order:
            beside = next((s for s in self.slots if self._shares(s, planet, mate)), None)
            if beside is not None:
                beside.append((planet, mate))
            else:
                self.slots.append([(planet, mate)])
        n = len(self.slots)
        self.x = [_SLOT * (i - (n - 1) / 2) for i in range(n)]
        self.top = self.pins[-1] - _STEP

    def _shares(self, slot: list[tuple[int, str | int]], planet: int, mate: str | int) -> bool:
        """A ring goes above the stick that meshes with a sun."""
        return (
            mate in self.gearing.rings and len(slot) == 1 and slot[0][0] == planet and slot[0][1] in self.gearing.suns
        )

    def wheel_x(self, name: str) -> list[float]:
        """Columns of a sun or ring."""
        return [x for x, s in zip(self.x, self.slots, strict=True) if any(mate == name for _, mate in s)]

    def planets(self) -> list[Shape]:
        """Sticks of the planets, with their rims, and their pins."""
        shapes: list[Shape] = []
        for x, slot in zip(self.x, self.slots, strict=True):
            for planet, mate in slot:
                y = self.pins[planet]
                other = (
                    self.pins[mate] if isinstance(mate, int) else 0.0 if mate in self.gearing.suns else self.top - _STEP
                )
                contact = (y + other) / 2 if not isinstance(mate, str) else _contact(y, mate in self.gearing.suns)
                shapes += [line((x, y), (x, contact)), line((x - 5, contact), (x + 5, contact))]
                if isinstance(mate, int):
                    shapes += [line((x, other), (x, contact)), line((x - 5, contact + 2.5), (x + 5, contact + 2.5))]
        for planet, y in enumerate(self.pins):
            at = self.pin_x(planet)
            shapes.append(line((min(at) - 5, y), (max(at) + 5, y)))
        return shapes

    def pin_x(self, planet: int) -> list[float]:
        """Columns at which a planet has a wheel."""
        return [x for x, s in zip(self.x, self.slots, strict=True) for p, mate in s if planet in (p, mate)]


def _contact(pin: float, below: bool) -> float:
    return pin + _STEP if below else pin - _STEP


def stick_scheme(gearing: Gearing, ports: Sequence[str], sides: Sequence[int], grounded: Sequence[str]) -> Symbol:
    """The symbol of a set; sides: -1 left or 1 right for each port; grounded: wheels or carrier that are held fast."""
    sticks = _Sticks(gearing)
    shapes = sticks.planets()
    side_of = dict(zip(ports, sides, strict=True))
    half = _SLOT * len(sticks.slots) / 2 + 16
    heights = dict[str, float]()
    rows = _Rows(half)
    for name in gearing.suns:
        at = sticks.wheel_x(name)
        side = side_of.get(name, -1)
        y = rows.take(min(at), max(at), side)
        heights[name] = y
        for x in at:
            contact = _contact(min(sticks.pins[p] for p, m in gearing.meshes if m == name), True) + 2.5
            shapes += [line((x, y), (x, contact)), line((x - 5, contact), (x + 5, contact))]
        shapes += _exit(min(at), max(at), y, side, half, name in grounded)
    shapes += _carrier(sticks, rows, side_of.get(CARRIER, 1), half, CARRIER in grounded, heights)
    top = sticks.top
    for i, name in enumerate(gearing.rings):
        at = sticks.wheel_x(name)
        y = top - 10 - 10 * i
        heights[name] = y
        for x in at:
            contact = min(sticks.pins[p] for p, m in gearing.meshes if m == name) - _STEP - 2.5
            shapes += [line((x - 7, contact), (x + 7, contact)), line((x, contact), (x, y))]
        shapes += _exit(min(at), max(at), y, side_of.get(name, 1), half, name in grounded, up=True)
        top = y + 10
    up = 3 - min([*heights.values(), sticks.top]) + (8 if any(name in grounded for name in gearing.rings) else 0)
    down = max([*heights.values(), 0.0]) + (10 if grounded else 4)
    return Symbol(tuple(shapes), half, half, up, down, tuple(heights[p] for p in ports))


@final
class _Rows:
    """Heights at and below the axis that are still free along a stretch."""

    def __init__(self, half: float) -> None:
        self.half = half
        self.used: list[tuple[float, float, float]] = []

    def take(self, low: float, high: float, side: int) -> float:
        """The highest row free from a wheel to the side of its port."""
        low, high = (-self.half, high) if side < 0 else (low, self.half)
        y = 0.0
        while any(y == row and low < b + 3 and a < high + 3 for row, a, b in self.used):
            y += 12.0
        self.used.append((y, low, high))
        return y


def _exit(low: float, high: float, y: float, side: int, half: float, grounded: bool, up: bool = False) -> list[Shape]:
    """The line of a wheel to its port, or to the ground."""
    if grounded:
        end = low - 8 if side < 0 else high + 8
        return (
            [line((low, y), (high, y)), *hatch((low + high) / 2, y, 9, "up" if up else "down")]
            if low == high
            else [
                line((low, y), (high, y)),
                *hatch(end, y, 8, "left" if side < 0 else "right"),
                line((low if side < 0 else high, y), (end, y)),
            ]
        )
    return [line((-half if side < 0 else low, y), (half if side > 0 else high, y))]


def _carrier(
    sticks: _Sticks, rows: _Rows, side: int, half: float, grounded: bool, heights: dict[str, float]
) -> list[Shape]:
    """Pins joined by an arm beside the wheels, and the line to the port."""
    edge = side * (_SLOT * len(sticks.slots) / 2 + 3)
    y = rows.take(edge, edge, side)
    heights[CARRIER] = y
    shapes: list[Shape] = [line((edge, sticks.pins[-1]), (edge, y))]
    for planet, pin in enumerate(sticks.pins):
        at = sticks.pin_x(planet)
        shapes.append(line(((max(at) if side > 0 else min(at)), pin), (edge, pin)))
        shapes.append(Circle(max(at) if side > 0 else min(at), pin, 1.8, FILLED))
    if grounded:
        return [*shapes, *hatch(edge, y, 8, "down")]
    return [*shapes, line((edge, y), (side * half, y))]


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
