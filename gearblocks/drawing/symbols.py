"""Symbols of blocks: shapes about an anchor on the lane, the room they take, and where their ports are.

ISO 3952-1 to -4 (1981-1997) where it has one, else as gearbox textbooks draw it; a block of a class that is not of the
catalogue is a box with the name of the class. Knows nothing of lanes and of places on the paper.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, final

from gearblocks.blocks import (
    Acceleration,
    Angle,
    BearingFriction,
    Brake,
    Chassis,
    Clutch,
    Damper,
    DCMotor,
    DogClutch,
    Force,
    Freewheel,
    HardStop,
    Lash,
    OneWayClutch,
    Shaft,
    Speed,
    SplineCoupling,
    Synchronizer,
    Torque,
    TorqueConverter,
    Tyre,
    UniversalJoint,
)
from gearblocks.drawing.shapes import (
    FILLED,
    PAPER,
    THICK,
    THIN,
    Circle,
    Shape,
    Words,
    arc,
    arrow,
    box,
    line,
    mirrored,
    moved,
    text_width,
    turned,
)
from gearblocks.language.block import Block

HALF = 22.0
"""Half the width of a usual symbol in line."""
_ROW = 18.0


@final
@dataclass(frozen=True, slots=True)
class Symbol:
    """Shapes about (0, 0), the room to each side of it, and the height of each port (y downward).

    parts: the shapes of each element of a bundle, which are not among `shapes`.
    """

    shapes: tuple[Shape, ...]
    left: float
    right: float
    up: float
    down: float
    ports: tuple[float, ...] = (0.0,)
    parts: tuple[tuple[Shape, ...], ...] = ()

    def mirrored(self) -> Symbol:
        """Left and right exchanged."""
        return Symbol(mirrored(self.shapes), self.right, self.left, self.up, self.down, self.ports)

    def lifted(self, dy: float) -> Symbol:
        """The same about an anchor that lies dy lower."""
        ports = tuple(y - dy for y in self.ports)
        return Symbol(
            moved(self.shapes, 0, -dy), self.left, self.right, self.up + dy, self.down - dy, ports, self.parts
        )

    def turned(self) -> Symbol:
        """A quarter turn: the left end on top."""
        return Symbol(turned(self.shapes), self.down, self.up, self.left, self.right)


def series(block: Block) -> Symbol:
    """A block between two shafts in line, its first flange at the left."""
    if isinstance(block, Shaft):
        return _shaft(block)
    made = _SERIES.get(type(block))
    return made() if made is not None else named_box(block, ((-1, 0.0, ""), (1, 0.0, "")))


def side_by_side(symbols: tuple[Symbol, ...]) -> Symbol:
    """Symbols in line between the same two shafts, one above the other."""
    half = max(max(s.left, s.right) for s in symbols)
    height = sum(s.up + s.down for s in symbols) + 4.0 * (len(symbols) - 1)
    y, shapes, parts, rows = -height / 2, list[Shape](), list[tuple[Shape, ...]](), list[float]()
    for s in symbols:
        y += s.up
        rows.append(y)
        parts.append((*moved(s.shapes, 0, y), line((-half, y), (-s.left, y)), line((s.right, y), (half, y))))
        y += s.down + 4.0
    for x, out in ((-half, -half - 6), (half, half + 6)):
        shapes += [line((x, rows[0]), (x, rows[-1])), line((x, 0), (out, 0))]
    return Symbol(tuple(shapes), half + 6, half + 6, height / 2, height / 2, (0.0, 0.0), tuple(parts))


def named_box(block: Block, ports: tuple[tuple[int, float, str], ...], rows: float = 0.0) -> Symbol:
    """A box with the name of the class. ports: side (-1 left, 1 right), height and name of each."""
    name = type(block).__name__
    names = max((text_width(words, 8) + 4 for _, _, words in ports if words), default=0.0)
    half, high = text_width(name, 10) / 2 + 6 + names, 11.0 + rows
    shapes: list[Shape] = [box(-half, -high, 2 * half, 2 * high, PAPER), Words(0, 3.5, name, 10)]
    for side, y, words in ports:
        shapes.append(line((side * half, y), (side * (half + 8), y)))
        if words:
            shapes.append(Words(side * (half - 2 - text_width(words, 8) / 2), y + 3, words, 8, grey=True))
    return Symbol(tuple(shapes), half + 8, half + 8, high, high, tuple(y for _, y, _ in ports))


def _made(shapes: tuple[Shape, ...], high: float, half: float = HALF) -> Symbol:
    return Symbol(shapes, half, half, high, high, (0.0, 0.0))


def _shaft(block: Any) -> Symbol:
    """A spring, beside it a damper and inner friction where there are any; a thick line where it is rigid."""
    if block.rigid:
        return _made((line((-HALF, 0), (HALF, 0), look=THICK),), 6)
    rows = [_spring()]
    if block.torque is not None:
        s = rows[0]
        rows[0] = Symbol((*s.shapes, *arrow((-11, 10), (11, -10), 4)), s.left, s.right, 11, 11, s.ports)
    if block.c is not None or block.damping_ratio is not None:
        rows.append(_dashpot())
    if block.hysteresis is not None:
        rows.append(_plates(7.0))
    if len(rows) == 1:
        return rows[0]
    s = side_by_side(tuple(rows))
    return Symbol((*s.shapes, *(shape for part in s.parts for shape in part)), s.left, s.right, s.up, s.down, s.ports)


def _spring() -> Symbol:
    zigzag = [(-12.5 + 5 * i, 6.0 if i % 2 else -6.0) for i in range(6)]
    return _made((line((-HALF, 0), (-15, 0), *zigzag, (15, 0), (HALF, 0)),), 7)


def _dashpot() -> Symbol:
    cup = line((-10, -6), (7, -6), (7, 6), (-10, 6))
    return _made((line((-HALF, 0), (-2, 0)), line((-2, -4), (-2, 4)), cup, line((7, 0), (HALF, 0))), 7)


def _play(x: float) -> tuple[Shape, ...]:
    """A plate with play in a cage about x; 18 wide, its left end open for the shaft."""
    cage = line((x - 8, -3), (x - 8, -8), (x + 9, -8), (x + 9, 8), (x - 8, 8), (x - 8, 3))
    return (cage, line((x, -5), (x, 5)))


def _lash() -> Symbol:
    s = moved(_spring().shapes, 14, 0)
    return _made((line((-36, 0), (-18, 0)), *_play(-18), line((-9, 0), (-8, 0)), *s), 9, 36)


def _stop() -> Symbol:
    """A plate between two pairs of blocks."""
    blocks = tuple(box(x, y, 4, 6, FILLED) for x in (-10, 7) for y in (-10, 4))
    cage = line((-8, -10), (9, -10), (9, 10), (-8, 10))
    return _made((line((-HALF, 0), (0, 0)), line((0, -7), (0, 7)), *blocks, cage, line((9, 0), (HALF, 0))), 11)


def _plates(high: float = 12.0) -> Symbol:
    left, right = line((-HALF, 0), (-3, 0)), line((3, 0), (HALF, 0))
    return _made((left, line((-3, -high), (-3, high)), line((3, -high), (3, high)), right), high + 1)


def _claws() -> tuple[Shape, ...]:
    edge = [(-4, -12), (-4, -6), (0, -6), (0, 0), (-4, 0), (-4, 6), (0, 6), (0, 12)]
    return (line(*((float(x), float(y)) for x, y in edge)), line(*((x + 4.0, float(y)) for x, y in edge)))


def _dog() -> Symbol:
    return _made((line((-HALF, 0), (-4, 0)), *_claws(), line((4, 0), (HALF, 0))), 13)


def _synchronizer() -> Symbol:
    cones = [line((-15, s * 5), (-8, s * 12)) for s in (-1, 1)] + [line((-11, s * 4), (-4, s * 11)) for s in (-1, 1)]
    shapes = (
        line((-28, 0), (-15, 0)),
        line((-15, -5), (-15, 5)),
        *cones,
        line((-11, -4), (-11, 4)),
        line((-11, 0), (2, 0)),
    )
    return _made((*shapes, *moved(_claws(), 6, 0), line((10, 0), (28, 0))), 13, 28)


def _freewheel(friction: bool) -> Symbol:
    wedge = tuple(arrow((0, 9), (0, -9), 4.5))
    left, right = line((-HALF, 0), (-6, 0)), line((6, 0), (HALF, 0))
    plates = (line((-6, -12), (-6, 12)), line((6, -12), (6, 12)))
    more = (line((-10, -12), (-10, 12)),) if friction else ()
    return _made((left, *plates, *more, *wedge, right), 13)


def _spline() -> Symbol:
    teeth = [line((x, s * 4.5), (x, s * 9), look=THIN) for x in (-3, 0, 3, 6) for s in (-1, 1)]
    sleeve = line((-6, -9), (13, -9), (13, 9), (-6, 9))
    return _made((line((-HALF, 0), (-12, 0)), box(-12, -4.5, 21, 9), sleeve, *teeth, line((13, 0), (HALF, 0))), 10)


def _joint() -> Symbol:
    forks = (arc(0, 0, 10, 100, 260), arc(0, 0, 10, -50, 50))
    return _made((line((-HALF, 0), (-10, 0)), *forks, Circle(0, 0, 3.5, FILLED), line((10, 0), (HALF, 0))), 11)


def _converter() -> Symbol:
    halves = (arc(-2, 0, 15, 90, 270, squeeze=0.6), arc(2, 0, 15, -90, 90, squeeze=0.6))
    walls = (line((-2, -15), (-2, 15)), line((2, -15), (2, 15)))
    return _made((line((-HALF, 0), (-11, 0)), *halves, *walls, line((11, 0), (HALF, 0))), 16)


def _tyre() -> Symbol:
    """A wheel with its tyre on the road; the road is the way to the right."""
    wheel = (Circle(0, 0, 12, PAPER), Circle(0, 0, 7), Circle(0, 0, 1.6, FILLED))
    return _made((line((-HALF, 0), (0, 0)), *wheel, line((12, 0), (HALF, 0)), line((-16, 12), (16, 12), look=THIN)), 14)


def _chassis() -> Symbol:
    """The body of a car over the road, and its hitch at the right."""
    body = line((-22, 8), (-22, -4), (-11, -6), (-5, -15), (12, -15), (17, -6), (22, -4), (22, 8), (-22, 8))
    wheels = tuple(Circle(x, 8, 5, PAPER) for x in (-12, 12))
    ends = (line((-28, 0), (-22, 0)), line((22, 0), (28, 0)))
    return _made((*ends, body, *wheels, line((-26, 13), (26, 13), look=THIN)), 16, 28)


def framed_pair(sides: tuple[int, int, int]) -> Symbol:
    """A gear pair whose bearings stand in a frame that turns itself: the first axis above, the second below, then the frame."""
    shapes: list[Shape] = [box(-20, -27, 40, 54, THIN)]
    for side, y, out in ((sides[0], -13.0, -1), (sides[1], 13.0, 1)):
        rim = y - out * 11.5
        shapes += [line((side * 28, y), (0, y)), line((0, y + out * 9), (0, rim)), line((-5, rim), (5, rim))]
        shapes += [line((-5, y + out * 9), (5, y + out * 9)), line((side * 16, y - 3), (side * 24, y - 3), look=THIN)]
        shapes.append(line((side * 16, y + 3), (side * 24, y + 3), look=THIN))
    shapes.append(line((sides[2] * 20, 0), (sides[2] * 28, 0)))
    return Symbol(tuple(shapes), 28, 28, 28, 28, (-13.0, 13.0, 0.0))


def framed_rack(sides: tuple[int, ...], names: Sequence[str]) -> Symbol:
    """A pinion on its rack, each in what leads it where that moves: the bearing of the pinion in its housing, the bar of the
    rack in its frame. The axis above, the slider below, then the housing on top and the frame at the bottom."""
    teeth = tuple(line((x, 1.0), (x + 2, -2.0), (x + 4, 1.0), look=THIN) for x in (-10, -6, -2, 2, 6))
    shapes: list[Shape] = [line((0, -24), (0, -3)), line((-6, -24), (6, -24)), line((-6, -3), (6, -3))]
    shapes += [*teeth, line((-14, 1), (14, 1)), line((0, 1), (0, 13))]
    heights = {"flange": -13.0, "slider": 13.0, "housing": -30.0, "frame": 24.0}
    ends = {"flange": 0.0, "slider": 0.0, "housing": 15.0 * sides[0], "frame": -9.0 * sides[1]}
    if "housing" in names:
        x = ends["housing"]
        shapes += [line((x - 5, y), (x + 5, y)) for y in (-17, -9)]
        shapes.append(line((x, -17), (x, -30)))
    if "frame" in names:
        x = ends["frame"]
        shapes += [line((x - 5, 5), (x + 5, 5)), line((x, 5), (x, 24))]
    shapes += [
        line((ends[name], heights[name]), (side * 28, heights[name])) for name, side in zip(names, sides, strict=True)
    ]
    up, down = 34.0 if "housing" in names else 27.0, 28.0 if "frame" in names else 17.0
    return Symbol(tuple(shapes), 28, 28, up, down, tuple(heights[name] for name in names))


def _lettered(letter: str) -> Symbol:
    """A source between two shafts."""
    return _made(
        (line((-HALF, 0), (-12, 0)), Circle(0, 0, 12), Words(0, 4.5, letter, 13), line((12, 0), (HALF, 0))), 13
    )


_SERIES: dict[type[Block], Callable[[], Symbol]] = {
    Damper: _dashpot,
    Lash: _lash,
    HardStop: _stop,
    Clutch: _plates,
    Brake: _plates,
    BearingFriction: _plates,
    DogClutch: _dog,
    Synchronizer: _synchronizer,
    OneWayClutch: lambda: _freewheel(True),
    Freewheel: lambda: _freewheel(False),
    SplineCoupling: _spline,
    UniversalJoint: _joint,
    TorqueConverter: _converter,
    Tyre: _tyre,
    Chassis: _chassis,
    Torque: lambda: _lettered("τ"),
    Force: lambda: _lettered("F"),
    Speed: lambda: _lettered("ω"),
    Acceleration: lambda: _lettered("α"),
    Angle: lambda: _lettered("φ"),
    DCMotor: lambda: _lettered("M"),
}
