"""What symbols are made of: strokes, circles and words, in pixels about the anchor of a symbol, y downward."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import TypeAlias, final

Point: TypeAlias = "tuple[float, float]"

LINE, THIN, DASHED, THICK, FILLED, PAPER = "line", "thin", "dashed", "thick", "filled", "paper"
"""How a shape is drawn: stroked (of three widths, or dashed), filled, or filled white with a border."""


@final
@dataclass(frozen=True, slots=True)
class Stroke:
    """A polyline, or a polygon where it is filled or closed."""

    points: tuple[Point, ...]
    look: str = LINE
    closed: bool = False


@final
@dataclass(frozen=True, slots=True)
class Circle:
    """A circle about a point."""

    x: float
    y: float
    r: float
    look: str = LINE


@final
@dataclass(frozen=True, slots=True)
class Words:
    """One line of text, centred at x, its base line at y."""

    x: float
    y: float
    text: str
    size: float = 11.0
    grey: bool = False


Shape: TypeAlias = "Stroke | Circle | Words"


def line(*points: Point, look: str = LINE) -> Stroke:
    """A polyline."""
    return Stroke(points, look)


def box(x: float, y: float, width: float, height: float, look: str = LINE) -> Stroke:
    """A rectangle from its upper left corner."""
    return Stroke(((x, y), (x + width, y), (x + width, y + height), (x, y + height)), look, closed=True)


def moved(shapes: Iterable[Shape], dx: float, dy: float) -> tuple[Shape, ...]:
    """The shapes elsewhere."""
    return tuple(_mapped(s, 1.0, 0.0, dx, dy) for s in shapes)


def mirrored(shapes: Iterable[Shape]) -> tuple[Shape, ...]:
    """Left and right exchanged; words stay readable."""
    return tuple(_mapped(s, -1.0, 0.0, 0.0, 0.0) for s in shapes)


def turned(shapes: Iterable[Shape]) -> tuple[Shape, ...]:
    """A quarter turn that brings the left end to the top; words stay upright."""
    return tuple(_mapped(s, 0.0, 1.0, 0.0, 0.0) for s in shapes)


def _mapped(shape: Shape, along: float, across: float, dx: float, dy: float) -> Shape:
    """x -> along x - across y + dx, y -> across x + (1 or 0) y + dy: a move, a mirror image or a quarter turn."""

    def at(x: float, y: float) -> Point:
        return (-y + dx, x + dy) if across else (along * x + dx, y + dy)

    if isinstance(shape, Stroke):
        return replace(shape, points=tuple(at(*p) for p in shape.points))
    x, y = at(shape.x, shape.y)
    return replace(shape, x=x, y=y)


def arc(x: float, y: float, r: float, start: float, end: float, look: str = LINE, squeeze: float = 1.0) -> Stroke:
    """Part of a circle or, squeezed in x, of an ellipse; degrees, clockwise on the screen from the right."""
    n = max(2, round(abs(end - start) / 12))
    angles = [pi / 180 * (start + (end - start) * i / n) for i in range(n + 1)]
    return Stroke(tuple((x + squeeze * r * cos(a), y + r * sin(a)) for a in angles), look)


def arrow(tail: Point, tip: Point, size: float = 5.0) -> tuple[Shape, ...]:
    """A line with a filled head."""
    return (line(tail, tip), head(tail, tip, size))


def head(tail: Point, tip: Point, size: float = 5.0) -> Stroke:
    """The head alone of an arrow from tail to tip."""
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    length = (dx * dx + dy * dy) ** 0.5
    ux, uy = dx / length * size, dy / length * size
    bx, by = tip[0] - 1.6 * ux, tip[1] - 1.6 * uy
    return Stroke((tip, (bx - 0.6 * uy, by + 0.6 * ux), (bx + 0.6 * uy, by - 0.6 * ux)), FILLED, closed=True)


def hatch(x: float, y: float, half: float, outward: str = "down") -> tuple[Shape, ...]:
    """The ground: a bar with slanted lines on its far side ("down", "up", "left" or "right")."""
    n = 5
    steps = [-half + 2 * half * (i + 0.5) / n for i in range(n)]
    slants = [line((t - 3.0, 6.0), (t + 3.0, 0.0), look=THIN) for t in steps]
    down: tuple[Shape, ...] = (line((-half, 0.0), (half, 0.0)), *slants)
    turns = {"down": 0, "left": 1, "up": 2, "right": 3}[outward]
    for _ in range(turns):
        down = turned(down)
    return moved(down, x, y)


def text_width(text: str, size: float = 11.0) -> float:
    """An upper bound of the width of a text in the widest of the usual sans-serif fonts (DejaVu Sans)."""
    return sum(map(_letter_width, text)) * size


def _letter_width(c: str) -> float:
    if c in "mwMW@%" or ord(c) > 126:
        return 1.0
    if c in "=+<>#~^&" or c.isupper():
        return 0.84
    return 0.42 if c in "iljI.,:;'|!/()[]tfr " else 0.66
