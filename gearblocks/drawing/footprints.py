"""Footprint of an element: its symbol with words, the lanes that it covers and how wide, and the channels of its ports.

A boxed element stands on its home lane. A port whose shaft is elsewhere leaves the box at its height and is led in a channel
beside the box, one for each port, up or down to the lane of its shaft. All x are about the middle of the element. Two
footprints are kept apart on every lane that both cover: so no box overlaps another, and no line crosses one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from gearblocks.blocks import Differential, Gearbox, GearMesh, IdealGear, LossyGear, NonCircularGear, Rack, Worm
from gearblocks.drawing import pairs
from gearblocks.drawing.captions import Caption
from gearblocks.drawing.lanes import Lanes
from gearblocks.drawing.riders import rider
from gearblocks.drawing.scheme import Element
from gearblocks.drawing.sets import differential, stick_scheme
from gearblocks.drawing.symbols import Symbol, framed_pair, framed_rack, named_box, series, side_by_side

FRAMED = (IdealGear, LossyGear, Gearbox, GearMesh, NonCircularGear, Worm)
"""Pairs that are drawn in a frame where their housing or carrier turns."""
CHANNEL, MARGIN = 8.0, 4.0
"""Distance of channels from each other and from the box; free room beside what a lane carries."""


@final
@dataclass(frozen=True, slots=True)
class Channel:
    """The way of one port: from height y at a side of the box along x to a lane; straight: on the home lane itself."""

    shaft: int
    side: int
    y: float
    x: float
    lane: int
    straight: bool


@final
@dataclass(frozen=True, slots=True)
class Footprint:
    """Room of an element about its middle. spans: (from, to) by lane; up, down: about its lane (of a pair about both)."""

    element: Element
    symbol: Symbol | None
    caption: Caption
    home: int
    lower: int
    together: bool
    left: float
    right: float
    up: float
    down: float
    spans: dict[int, tuple[float, float]]
    channels: tuple[Channel, ...]


def footprint(i: int, e: Element, lanes: Lanes, caption: Caption, alive: Sequence[int]) -> Footprint:
    """The footprint of element i of the order; alive: shafts that have elements before and after, or at it."""
    if e.is_pair:
        return _of_pair(e, lanes, caption, alive)
    goes = {s: (lanes.first[s] < i, lanes.last[s] > i) for s in e.shafts}
    home = lanes.home[i]
    if e.is_rider:
        symbol = rider(e, *goes[e.shafts[0]])
        return _whole(e, symbol, caption, home, ())
    sides = _sides(e, lanes, goes, home)
    symbol = boxed_symbol(e, sides)
    straight = [y for s, y in zip(e.shafts, symbol.ports, strict=True) if lanes.of_shaft[s] == home]
    if straight and 0.0 not in straight:
        symbol = symbol.lifted(straight[0])
    return _whole(e, symbol, caption, home, tuple(zip(e.shafts, sides, strict=True)), lanes)


def _sides(e: Element, lanes: Lanes, goes: dict[int, tuple[bool, bool]], home: int) -> list[int]:
    """Side of each port: left where its shaft comes from there alone, right where it begins; what passes balances."""
    sides = list[int]()
    for s in e.shafts:
        before, after = goes[s]
        sides.append(0 if before == after else -1 if before else 1)
    for k, side in enumerate(sides):
        if side == 0:
            sides[k] = 1 if sides.count(-1) > sides.count(1) or -1 in sides[:k] else -1
    if len(sides) == 2 and sides[0] == sides[1]:
        free = [k for k in (1, 0) if lanes.of_shaft[e.shafts[k]] != home]
        sides[free[0] if free else 1] *= -1
    return sides


def boxed_symbol(e: Element, sides: Sequence[int]) -> Symbol:
    """The symbol of an element with a place of its own."""
    names = [flange for flange, _ in e.ports]
    if e.gearing is not None:
        return stick_scheme(e.gearing, names, sides, e.grounded)
    if isinstance(e.block, Differential):
        return differential(sides, names, e.grounded)
    if len(e.ports) == 2 and not e.grounded:
        if e.parallel:
            first = e.shafts[0] if sides[0] < 0 else e.shafts[1]
            symbols = [_oriented(one, one.shafts[0] == first) for one in e.parallel]
            return side_by_side(tuple(symbols))
        return _oriented(e, sides[0] < 0)
    if len(e.ports) == 3 and not e.grounded and isinstance(e.block, FRAMED):
        return framed_pair((sides[0], sides[1], sides[2]))
    if len(e.ports) > 2 and not e.grounded and isinstance(e.block, Rack) and names[:2] == ["flange", "slider"]:
        return framed_rack(tuple(sides), names)
    rows = {-1: 0, 1: 0}
    heights = list[float]()
    for side in sides:
        heights.append(14.0 * rows[side])
        rows[side] += 1
    high = 14.0 * (max(rows.values()) - 1)
    ports = tuple((side, y - high / 2, name) for side, y, name in zip(sides, heights, names, strict=True))
    return named_box(e.block, ports, high / 2)


def _oriented(e: Element, first_is_left: bool) -> Symbol:
    """A block in line; the first flange of its class at the left or at the right."""
    names = list(type(e.block).flanges)
    in_order = names.index(e.ports[0][0]) < names.index(e.ports[1][0])
    symbol = series(e.block)
    return symbol if in_order == first_is_left else symbol.mirrored()


def _whole(
    e: Element,
    symbol: Symbol,
    caption: Caption,
    home: int,
    ports: Sequence[tuple[int, int]],
    lanes: Lanes | None = None,
) -> Footprint:
    """An element on its home lane, with channels to the lanes of its ports (shaft, side)."""
    left, right = max(symbol.left, caption.width / 2), max(symbol.right, caption.width / 2)
    channels = tuple(_channels(symbol, home, ports, lanes, left, right)) if lanes is not None else ()
    low, high = -left, right
    spans: dict[int, tuple[float, float]] = {}
    for c in channels:
        if c.straight:
            continue
        for lane in range(min(home, c.lane), max(home, c.lane) + 1):
            a, b = spans.get(lane, (c.x, c.x))
            spans[lane] = (min(a, c.x), max(b, c.x))
    a, b = spans.get(home, (low, high))
    spans[home] = (min(a, low), max(b, high))
    spans = {lane: (a - MARGIN, b + MARGIN) for lane, (a, b) in spans.items()}
    up, down = symbol.up + caption.above, symbol.down + caption.below
    return Footprint(e, symbol, caption, home, home, True, left, right, up, down, spans, channels)


def _channels(
    symbol: Symbol, home: int, ports: Sequence[tuple[int, int]], lanes: Lanes, left: float, right: float
) -> list[Channel]:
    found = list[Channel]()
    for side, edge in ((-1, left), (1, right)):
        here = [(s, y) for (s, at), y in zip(ports, symbol.ports, strict=True) if at == side]
        led = [(s, y) for s, y in here if lanes.of_shaft[s] != home or y != 0]
        found += [Channel(s, side, y, side * edge, home, True) for s, y in here if (s, y) not in led]
        upward = sorted((y, s) for s, y in led if _rises(lanes.of_shaft[s], home, y))
        downward = sorted(((y, s) for s, y in led if not _rises(lanes.of_shaft[s], home, y)), reverse=True)
        for k, (y, s) in enumerate((*upward, *downward)):
            found.append(Channel(s, side, y, side * (edge + CHANNEL * (k + 1)), lanes.of_shaft[s], False))
    return found


def _rises(lane: int, home: int, y: float) -> bool:
    return lane < home or (lane == home and y > 0)


def _of_pair(e: Element, lanes: Lanes, caption: Caption, alive: Sequence[int]) -> Footprint:
    a, b = (lanes.of_shaft[s] for s in e.shafts)
    upper, lower = min(a, b), max(a, b)
    together = not any(upper < lanes.of_shaft[s] < lower for s in alive if s not in e.shafts)
    half = max(pairs.HALF, caption.width / 2)
    spans = dict.fromkeys(range(upper, lower + 1), (-half - MARGIN, half + MARGIN))
    if not together:
        spans |= dict.fromkeys(range(upper + 1, lower), (-2 * MARGIN, 2 * MARGIN))
    up, down = pairs.OUTWARD + 2 + caption.above, pairs.OUTWARD + 2 + caption.below
    return Footprint(e, None, caption, upper, lower, together, half, half, up, down, spans, ())
