"""Symbols from one axis to a parallel one: gear pairs, belts, racks. Wheels are drawn about their axis, the mate below.

Radii go as the ratio says where nothing passes between the axes; else the wheels stay small, and a dashed line joins them.
Knows nothing of lanes.
"""

from __future__ import annotations

from typing import Any

from gearblocks.blocks import BeltDrive, Gearbox, LossyGear, NonCircularGear, Rack, Worm
from gearblocks.drawing.shapes import FILLED, THIN, Circle, Shape, arc, hatch, line, moved, turned
from gearblocks.language.block import Block

OUTWARD, APART, HALF = 18.0, 13.0, 11.0
"""How far a wheel reaches beyond its axis at most, its radius where others pass between, half the width."""
_PULLEY = 9.0


def pair(block: Block, distance: float, first_is_upper: bool, together: bool) -> tuple[Shape, ...]:
    """The wheels of a pair; the upper axis is y = 0, the lower one y = distance. together: whether nothing passes between."""
    share = _share(block)
    radii = (share * distance, (1 - share) * distance) if together else (APART, APART)
    if isinstance(block, Rack):
        first = 20.0 if together and distance > 30 else APART
        radii = (first, distance - first)
    upper, lower = (_wheel_of(block, k, radii[k], together) for k in ((0, 1) if first_is_upper else (1, 0)))
    upside_down = turned(turned(lower))
    belt: tuple[Shape, ...] = ()
    if isinstance(block, BeltDrive) and together:
        belt = tuple(line((x, _PULLEY - 4), (x, distance - _PULLEY + 4), look=THIN) for x in (-8, 8))
    return (*upper, *moved(upside_down, 0, distance), *belt)


def _wheel_of(block: Block, k: int, radius: float, together: bool) -> tuple[Shape, ...]:
    """The first (k = 0) or second wheel."""
    if isinstance(block, BeltDrive):
        return (Circle(0, 0, _PULLEY), Circle(0, 0, 1.6, FILLED))
    if isinstance(block, Rack) and k:
        return _rack(radius if together else 4.0)
    if isinstance(block, Worm) and not k:
        return _screw(radius)
    shapes = _wheel(radius)
    if k and is_internal(block):
        shapes = (*shapes, *(line((x, radius - 1.5), (x, radius + 5)) for x in (-6, 6)))
    if isinstance(block, NonCircularGear):
        shapes = (*shapes, arc(0, 0, 9, 0, 360, look=THIN, squeeze=0.55))
    if isinstance(block, (LossyGear, Gearbox)) and not k:
        shapes = (*shapes, line((-7, radius - 8), (7, radius + 5), look=THIN))
    return shapes


def is_internal(block: Any) -> bool:
    """Whether the second wheel is a ring that has the first one inside."""
    return getattr(block, "external", None) is False


def _share(block: Any) -> float:
    """The radius of the first wheel over the distance of the axes, kept within what can be drawn."""
    teeth, ratio = getattr(block, "teeth", None), getattr(block, "ratio", None)
    if isinstance(teeth, tuple):
        share = float(teeth[0]) / float(teeth[0] + teeth[1])
    elif isinstance(ratio, (int, float)) and ratio:
        share = 1 / (1 + abs(float(ratio)))
    else:
        share = 0.5
    return min(max(share, 0.25), 0.75)


def _wheel(radius: float) -> tuple[Shape, ...]:
    """A wheel from the side: its web, and the width of its teeth at the rim."""
    out, rim = min(radius, OUTWARD), radius - 1.5
    return (line((0, -out), (0, rim)), line((-6, rim), (6, rim)), line((-6, -out), (6, -out)))


def _screw(radius: float) -> tuple[Shape, ...]:
    """A worm on its axis, and the line of centres down to its wheel."""
    threads = tuple(line((x - 2, -6), (x + 2, 6), look=THIN) for x in (-6, -2, 2, 6))
    return (line((-9, -6), (9, -6)), line((-9, 6), (9, 6)), *threads, line((0, 6), (0, radius - 1.5), look=THIN))


def _rack(reach: float) -> tuple[Shape, ...]:
    """A toothed bar where the wheel rolls, on a post from its slider, and the fixed frame that the slider is led by."""
    teeth = tuple(line((x, reach), (x + 2, reach - 3), (x + 4, reach), look=THIN) for x in (-10, -6, -2, 2, 6))
    frame = (line((-8, -4), (8, -4)), line((0, -4), (0, -9)), *hatch(0, -9, 9, "up"))
    return (*teeth, line((-10, reach - 3), (10, reach - 3)), line((0, 0), (0, reach - 3)), *frame)
