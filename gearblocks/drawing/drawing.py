"""The drawing of a train: from its composition to a scheme, a layout and SVG."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, final

from gearblocks.drawing import states
from gearblocks.drawing.layout import Layout, layout
from gearblocks.drawing.scheme import Scheme, scheme_of
from gearblocks.drawing.writing import svg
from gearblocks.errors import ParameterError, arguments_told
from gearblocks.files import as_path, write_text
from gearblocks.train.graph import Tree, flatten

SHOWN = 500
"""Blocks of the largest train that is drawn unasked."""


@final
@arguments_told
@dataclass(frozen=True, slots=True, repr=False)
class Drawing:
    """A kinematic scheme as SVG: str() is the text, save() writes a file, a notebook shows it."""

    name: str
    text: str
    scheme: Scheme
    layout: Layout

    def icon(self) -> bytes:
        """The picture without words as a small PNG file."""
        from gearblocks.drawing.icon import png

        return png(self.layout)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Drawing of '{self.name}': {self.layout.width:.0f} x {self.layout.height:.0f} px>"

    def _repr_svg_(self) -> str:
        return self.text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture to a file. Raises ParameterError where the name does not end in .svg."""
        check_ending(path)
        write_text(path, self.text)


def check_ending(path: str | os.PathLike[str]) -> None:
    """Refuses a file that would not be read as SVG."""
    if not isinstance(path, (str, os.PathLike)):
        raise ParameterError(f"drawing: {path!r:.80} is no name of a file; give one that ends in .svg")
    if as_path(path).suffix.lower() != ".svg":
        raise ParameterError(f"drawing: '{path}' must end in .svg, the only form that a drawing has")


def shown_drawing(tree: Tree) -> Drawing | None:
    """The drawing for places where nobody asked for it, notebooks and documents: none of an empty or very large train."""
    return drawing_of(tree) if 0 < _blocks(tree) <= SHOWN else None


def _blocks(tree: Tree) -> int:
    return sum(_blocks(part) if isinstance(part, Tree) else 1 for _, part in tree.parts)


def drawing_of(
    tree: Tree, path: str | os.PathLike[str] | None = None, *, values: bool = False, run: Any = None, at: float | None = None
) -> Drawing:  # fmt: skip
    """The drawing of a train, open ends and all, also written to `path`. run, at: colours show its state at a time."""
    if path is not None:
        check_ending(path)
    if run is None and at is not None:
        raise ParameterError("draw: at = ... is a time of a run: give run= too")
    scheme = scheme_of(flatten(tree, complete=False, whole=True))
    placed = layout(scheme, values)
    found = states.colours(scheme, run, at) if run is not None else {}
    legend = {colour: words for colour, words in states.LEGEND.items() if colour in {c for c, _ in found.values()}}
    drawing = Drawing(tree.name, svg(tree.name, placed, scheme.shafts, found, legend), scheme, placed)
    if path is not None:
        drawing.save(path)
    return drawing
