"""Symbols of what sits on one shaft alone: bodies, sources, loads, and what is held fast at its other end.

left, right: whether the shaft goes on to that side; the symbol draws the piece of the shaft within its own room.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from gearblocks.blocks import (
    Acceleration,
    Angle,
    BearingFriction,
    Brake,
    Damper,
    DCMotor,
    EddyCurrentBrake,
    Engine,
    Fixed,
    Force,
    HardStop,
    Inertia,
    Lash,
    Mass,
    Shaft,
    Speed,
    SpeedLoad,
    Torque,
    Vehicle,
)
from gearblocks.drawing.scheme import Element
from gearblocks.drawing.shapes import (
    FILLED,
    PAPER,
    THIN,
    Circle,
    Shape,
    Words,
    arc,
    arrow,
    box,
    hatch,
    head,
    line,
    moved,
)
from gearblocks.drawing.symbols import Symbol, named_box, series
from gearblocks.language.block import Block
from gearblocks.language.signals import value_at

_BESIDE = 11.0


def rider(e: Element, left: bool, right: bool) -> Symbol:
    """The symbol of an element on one shaft."""
    block = e.block
    made = _RIDERS.get(type(block))
    if made is not None:
        return made(block, e.slides, left, right)
    if e.grounded or type(block) in (Brake, HardStop) or len(type(block).flanges) == 2:
        return _held(block, left, right)
    return _other(block, left, right)


def _axis(left: bool, right: bool, inner: float, outer: float) -> tuple[Shape, ...]:
    """The shaft beside a symbol that is 2 inner wide."""
    pieces = ((left, -outer, -inner), (right, inner, outer))
    return tuple(line((a, 0), (b, 0)) for goes, a, b in pieces if goes)


def _disc(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001  same arguments for all
    shapes = (box(-4.5, -18, 9, 36, PAPER), *_axis(left, right, 4.5, _BESIDE))
    return Symbol(shapes, _BESIDE, _BESIDE, 18, 18)


def _mass(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    wheels = tuple(Circle(x, 14, 3) for x in (-9, 9))
    shapes = (box(-16, -11, 32, 22, PAPER), *wheels, line((-20, 17), (20, 17), look=THIN), *_axis(left, right, 16, 22))
    return Symbol(shapes, 22, 22, 12, 18)


def _fixed(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    if left != right:
        outward, x = ("right", 6.0) if left else ("left", -6.0)
        return Symbol((line((-13.0 if left else 13.0, 0), (x, 0)), *hatch(x, 0, 12, outward)), 13, 13, 13, 13)
    return Symbol((*_axis(left, right, 0, 12), line((0, 0), (0, 12)), *hatch(0, 12, 12)), 13, 13, 4, 19)


def _backward(value: Any) -> bool:
    """Whether what is given begins below 0, as its Parameters and Inputs say; forward where others decide."""
    numbers = (value_at(value, t) for t in (0.0, 1e-3, 0.1, 1.0))
    return next((x < 0 for x in numbers if math.isfinite(x) and x != 0), False)


def _torque(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A bent arrow round the shaft: the near side goes down for a torque that drives forward."""
    bow = arc(0, 0, 15, 60, 300, squeeze=0.5)
    tip, tail = (bow.points[0], bow.points[2]) if not _backward(block.tau) else (bow.points[-1], bow.points[-3])
    axis = tuple(line((a, 0), (b, 0)) for goes, a, b in ((left, -14, 2), (right, -2, 14)) if goes)
    return Symbol((bow, head(tail, tip), *axis, Circle(0, 0, 1.6, FILLED)), 14, 14, 17, 17)


def _force(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """An arrow along the slider."""
    ends = ((-16.0, -9.0), (16.0, -9.0))
    a, b = ends if not _backward(block.f) else ends[::-1]
    return Symbol((*arrow(a, b), *_axis(left, right, 0, 18), Circle(0, 0, 1.6, FILLED)), 18, 18, 14, 6)


def _prescribed(block: Any, slides: bool, left: bool, right: bool) -> Symbol:
    letters: dict[Any, tuple[str, str]] = {Speed: ("ω", "v"), Angle: ("φ", "s"), Acceleration: ("α", "a")}
    return _circle(letters[type(block)][slides], left, right)


def _circle(letter: str, left: bool, right: bool) -> Symbol:
    shapes = (Circle(0, 0, 12, PAPER), Words(0, 4.5, letter, 13), *_axis(left, right, 12, 18))
    return Symbol(shapes, 18, 18, 13, 13)


def _motor(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    return _circle("M", left, right)


def _engine(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A piston over its crank."""
    cylinder = (line((-8, -12), (-8, -28), (8, -28), (8, -12)), box(-8, -23, 16, 7))
    crank = (Circle(0, 0, 8), line((0, -16), (5, -4)), line((5, -4), (0, 0)), Circle(0, 0, 1.6, FILLED))
    return Symbol((*cylinder, *crank, *_axis(left, right, 8, 16)), 16, 16, 29, 9)


def _load(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A propeller: a torque that grows with speed; on a slider a sheet in the stream."""
    if slides:
        return Symbol(
            (*_axis(left, right, 0, 14), line((0, -14), (0, 14)), arc(-4, 0, 14, -60, 60, look=THIN)), 14, 14, 15, 15
        )
    blades = tuple(arc(0, s * 9.5, 9, 0, 360, squeeze=0.4) for s in (-1, 1))
    return Symbol((*blades, *_axis(left, right, 0, 14), Circle(0, 0, 1.8, FILLED)), 14, 14, 19, 19)


def _eddy(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A disc between the poles of a magnet that stands on the ground."""
    poles = (line((-9, 8), (-3.5, 8)), line((3.5, 8), (9, 8)), line((-9, 8), (-9, 20), (9, 20), (9, 8)))
    shapes = (box(-2, -14, 4, 28), *_axis(left, right, 2, 16), *poles, *hatch(0, 20, 12))
    return Symbol(shapes, 16, 16, 15, 27)


def _vehicle(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A wheel on the road under the corner of a body."""
    wheel = (Circle(0, 0, 13, PAPER), Circle(0, 0, 4), line((-22, 13), (22, 13)))
    body = (line((-20, -4), (-16, -18), (16, -18), (20, -4), look=THIN),)
    return Symbol((*wheel, *body, *_axis(left, right, 13, 22)), 22, 22, 19, 15)


def _bearing(block: Any, slides: bool, left: bool, right: bool) -> Symbol:  # noqa: ARG001
    """A shaft between two shells."""
    shells = (line((-9, -4), (9, -4)), line((-9, 4), (9, 4)), line((0, 4), (0, 10)), *hatch(0, 10, 10))
    return Symbol((*shells, *_axis(left, right, 0, 14)), 14, 14, 8, 17)


def _held(block: Block, left: bool, right: bool) -> Symbol:
    """A symbol in line whose other end is the ground: at the end of a shaft in line, else and for brakes hanging from it."""
    s = series(block)
    if left != right and isinstance(block, (Shaft, Damper, Lash, HardStop)):
        found = Symbol(
            (*s.shapes, *hatch(s.right, 0, 10, "right")), s.left, s.right + 7, max(s.up, 11), max(s.down, 11)
        )
        return found if left else found.mirrored()
    down = s.turned()
    hanging = (*moved(down.shapes, 0, s.left), *hatch(0, s.left + s.right, 10))
    half = max(down.left, down.right, 12.0)
    shapes = (*hanging, *_axis(left, right, 0, half + 2), Circle(0, 0, 1.8, FILLED))
    return Symbol(shapes, half + 2, half + 2, 4, s.left + s.right + 7)


def _other(block: Block, left: bool, right: bool) -> Symbol:
    """A box with the name of the class, at the end of a shaft or hanging from it."""
    if left != right:
        return named_box(block, ((-1 if left else 1, 0.0, ""),))
    s = named_box(block, ())
    shapes = (
        *moved(s.shapes, 0, s.up + 12),
        line((0, 0), (0, 12)),
        *_axis(left, right, 0, s.left),
        Circle(0, 0, 1.8, FILLED),
    )
    return Symbol(shapes, s.left, s.right, 4, 2 * s.up + 13)


_RIDERS: dict[type[Block], Callable[[Any, bool, bool, bool], Symbol]] = {
    Inertia: _disc,
    Mass: _mass,
    Fixed: _fixed,
    Torque: _torque,
    Force: _force,
    Speed: _prescribed,
    Acceleration: _prescribed,
    Angle: _prescribed,
    DCMotor: _motor,
    Engine: _engine,
    SpeedLoad: _load,
    EddyCurrentBrake: _eddy,
    Vehicle: _vehicle,
    BearingFriction: _bearing,
}
