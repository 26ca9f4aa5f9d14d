"""State matrices as printed equations, in the notation of the equations of motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy as sp

from gearblocks.equations.document import Document, Line, Nomenclature, Section
from gearblocks.equations.linearized import matrix_lines
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Node, Op, Row, Sym, Times, Words
from gearblocks.equations.notation import Reader

DIGITS = 6
"""Digits of a number on paper."""

Linear = Any
"""`Linearization`, which prints itself by these functions and therefore stands above them."""


def document(linear: Linear) -> Document:
    """dx/dt = A x + B u, y = C x + D u, what the vectors hold, and the matrices."""
    x, u, y = _letter("x"), _letter("u"), _letter("y")
    lines = [Line(None, Words(linear.words))]
    lines += [Line(_letter("x", 1), _sum((("A", x), ("B", u)), linear)), Line(y, _sum((("C", x), ("D", u)), linear))]
    for letter, names in (("x", linear.states), ("u", linear.inputs), ("y", linear.outputs)):
        if names:
            lines.append(Line(None, Row((_letter(letter), Words(f": {', '.join(names)}")))))
    for letter in "ABCD":
        matrix = getattr(linear, letter)
        if 0 not in matrix.shape:
            lines += matrix_lines(Name(letter), [*_rows(matrix)])
    return Document("Linearised equations", (Section("State matrices", tuple(lines)),), Nomenclature(()))


def _sum(parts: tuple[tuple[str, Node], ...], linear: Linear) -> Node:
    items: list[Any] = []
    for letter, vector in parts:
        if 0 not in getattr(linear, letter).shape:
            items += [*([Op("+")] if items else []), Times((_letter(letter), vector))]
    return Row(tuple(items))


def _rows(matrix: Any) -> Iterator[list[Node]]:
    read = Reader({})
    full = matrix if not hasattr(matrix, "toarray") else matrix.toarray()
    for row in full:
        yield [read.read(sp.Float(float(f"{value:.{DIGITS}g}")) if value else sp.Integer(0)) for value in row]


def _letter(text: str, dots: int = 0) -> Sym:
    return Sym(Name(text, "", "", dots))
