"""SVG of a layout: each shape as an element of the template, words escaped, colours of states. Knows nothing of trains."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

from gearblocks.drawing.layout import Layout
from gearblocks.drawing.shapes import DASHED, FILLED, LINE, PAPER, THICK, THIN, Circle, Point, Shape, Stroke, text_width
from gearblocks.pages import page

_LOOKS = {
    LINE: "",
    THIN: ' stroke-width="0.9"',
    THICK: ' stroke-width="4"',
    DASHED: ' stroke-dasharray="5 3"',
    FILLED: ' fill="currentColor" stroke="none"',
    PAPER: ' fill="#fff"',
}
GREY = "#666"


def svg(
    name: str,
    layout: Layout,
    shafts: tuple[str, ...],
    colours: Mapping[str, tuple[str, str]],
    legend: Mapping[str, str],
) -> str:
    """The text of the picture. colours: (colour, words) of elements by name; legend: words by colour."""
    from markupsafe import Markup

    rooms: dict[int, Any] = {box.element: box for box in reversed(layout.boxes)}
    figures = []
    for figure in layout.figures:
        colour, words = colours.get(figure.element.name, ("", ""))
        figures.append({
            "title": figure.title + (f"\n{words}" if words else ""), "colour": colour,
            "room": None if figure.part else [_n(x) for x in astuple(rooms[figure.number])[:4]],
            "shapes": [{**s, "look": Markup(s.get("look", ""))} for s in map(_written, figure.shapes)],
        })  # fmt: skip
    lines = defaultdict[int, list[tuple[Point, ...]]](list)
    for wire in layout.wires:
        lines[wire.shaft].append(wire.points)
    drawn = [
        {"title": f"shaft of {shafts[s]}" if s >= 0 and shafts[s] else "", "d": " ".join(map(_path, wires)),
         "look": Markup(_LOOKS[DASHED] if s < 0 else "")}
        for s, wires in sorted(lines.items())
    ]  # fmt: skip
    items, below = _legend(layout, legend)
    title = "".join(c for c in name if c.isprintable())  # XML has no other control characters than ends of lines
    return page(
        "gearblocks.drawing", "drawing.svg.jinja", title=title, width=_n(layout.width), height=_n(layout.height + below),
        shafts=drawn, joints=[(_n(x), _n(y)) for x, y in layout.joints], figures=figures, legend=items,
    )  # fmt: skip


def _legend(layout: Layout, legend: Mapping[str, str]) -> tuple[list[dict[str, Any]], float]:
    x, y, items = 14.0, layout.height, []
    for colour, words in legend.items():
        wide = text_width(words) + 36
        if x > 14 and x + wide > layout.width:
            x, y = 14.0, y + 18
        items.append({"x": x, "y": y, "colour": colour, "words": words})
        x += wide
    return items, (y - layout.height + 22) if items else 0.0


def _n(x: float) -> str:
    """A number with at most one digit behind the point."""
    return f"{x:.1f}".removesuffix(".0")


def _path(points: tuple[Point, ...]) -> str:
    return "M" + "L".join(f"{_n(x)} {_n(y)}" for x, y in points)


def _written(shape: Shape) -> dict[str, Any]:
    if isinstance(shape, Stroke):
        return {"d": _path(shape.points) + ("Z" if shape.closed else ""), "look": _LOOKS[shape.look]}
    if isinstance(shape, Circle):
        return {"x": _n(shape.x), "y": _n(shape.y), "r": _n(shape.r), "look": _LOOKS[shape.look]}
    return {
        "x": _n(shape.x), "y": _n(shape.y), "size": _n(shape.size), "text": shape.text,
        "fill": GREY if shape.grey else "currentColor",
    }  # fmt: skip
