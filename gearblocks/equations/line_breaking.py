"""Long mathematics in lines: what does not fit is broken before a sign, outer ones first, then inside brackets.

Each way of showing (text, LaTeX, MathML) says how a node is shown alone and how wide it is. Knows nothing of the characters.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, final

from gearblocks.equations.nodes import Call, Fence, Fraction, Node, Op, Power, Row, Sum, Times, Words


@final
@dataclass(frozen=True, slots=True)
class Style:
    """shown: a node as text; width: of a node; joined: what stands between the factors of a product; called: the name of
    the function of a call, with its primes; whole: how wide fractions are that stay whole in a shorter line."""

    shown: Callable[[Node], str]
    width: Callable[[Node], float]
    joined: str
    called: Callable[[Call], str]
    whole: float = 0.0


@final
@dataclass(frozen=True, slots=True)
class _Piece:
    """Text that stays together, its width, and whether a line may begin with it."""

    text: str
    width: float
    begins: bool


def lines(nodes: list[Node], style: Style, first: float, rest: float) -> list[str]:
    """Nodes in a row as lines: the first `first` wide at most, the others `rest`; what cannot be broken may be wider."""
    pieces = [p for node in nodes for p in _pieces(node, style, min(first, rest))]
    found: list[str] = []
    text, used, limit = "", 0.0, first
    groups = _groups(pieces)
    for group in groups:
        width = sum(p.width for p in group)
        if text and used + width > limit:
            found.append(text)
            text, used, limit = "", 0.0, rest
        text += "".join(p.text for p in group)
        used += width
    return [*found, text] if text or not found else found


def _groups(pieces: list[_Piece]) -> Iterator[list[_Piece]]:
    """Pieces between two places where a line may break."""
    group: list[_Piece] = []
    for piece in pieces:
        if piece.begins and group:
            yield group
            group = []
        group.append(piece)
    if group:
        yield group


def _pieces(node: Node, style: Style, limit: float) -> Iterator[_Piece]:
    """A node as pieces: one, where it fits or cannot be broken."""
    if isinstance(node, Row):
        for item in node.items:
            yield from _pieces(item, style, limit)
    elif isinstance(node, Words):
        for part in re.findall(r"\s*\S+\s*", node.text):
            words = Words(part)
            yield _Piece(style.shown(words), style.width(words), begins=part[0].isalpha())
    elif isinstance(node, Op):
        yield _Piece(style.shown(node), style.width(node), node.sign != "neg")
    elif style.width(node) <= limit:
        yield _Piece(style.shown(node), style.width(node), begins=False)
    else:
        yield from _broken(node, style, limit)


def _broken(node: Node, style: Style, limit: float) -> Iterator[_Piece]:
    """A node that is wider than a line."""
    if isinstance(node, Times):
        for i, factor in enumerate(node.factors):
            if i and style.joined:
                yield _Piece(style.joined, 0.3, begins=False)
            for number, piece in enumerate(_pieces(factor, style, limit)):
                yield _Piece(piece.text, piece.width, piece.begins or (number == 0 and i > 0))
    elif isinstance(node, Sum):
        yield _Piece(style.shown(replace(node, inner=Words(""))), 2.5, begins=False)
        yield from _pieces(node.inner, style, limit)
    elif isinstance(node, Fence):
        yield _sign(style, "left " + node.left)
        yield from _pieces(node.inner, style, limit)
        yield _sign(style, "right " + node.right)
    elif isinstance(node, Fraction) and style.width(node) > style.whole:
        yield from _pieces(_bracketed(node.top), style, limit)
        yield _sign(style, "/", begins=True)
        yield from _pieces(_bracketed(node.bottom), style, limit)
    elif isinstance(node, Call):
        yield _Piece(style.called(node), style.width(node.function), begins=False)
        yield _sign(style, "left (")
        for i, argument in enumerate(node.arguments):
            if i:
                yield _sign(style, ",")
            for number, piece in enumerate(_pieces(argument, style, limit)):
                yield _Piece(piece.text, piece.width, piece.begins or (number == 0 and i > 0))
        yield _sign(style, "right )")
    elif isinstance(node, Power) and isinstance(node.base, Fence):
        yield from _pieces(node.base, style, limit)
        yield _Piece(style.shown(Power(Words(""), node.exponent)), style.width(node.exponent), begins=False)
    else:
        yield _Piece(style.shown(node), style.width(node), begins=False)


def _sign(style: Style, sign: str, *, begins: bool = False) -> _Piece:
    return _Piece(style.shown(Op(sign)), 1.0, begins)


def _bracketed(node: Any) -> Any:
    return Fence("(", ")", node) if isinstance(node, (Row, Times)) else node
