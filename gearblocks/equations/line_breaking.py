"""Long mathematics in lines: as few as there can be, broken before outer signs rather than between factors or inside brackets.

Each way of showing (text, LaTeX, MathML) says how a node is shown alone and how wide it is. Knows nothing of the characters.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, final

from gearblocks.equations.nodes import Call, Fence, Fraction, Node, Num, Op, Power, Row, Sum, Times, Words


@final
@dataclass(frozen=True, slots=True)
class Style:
    """shown: a node as text; width: of a node; joined: what stands between the factors of a product; called: the name of
    the function of a call, with its primes; whole: how wide fractions are that stay whole in a shorter line; stacked: whether
    fractions have a bar; times: what a line begins with that goes on with a factor."""

    shown: Callable[[Node], str]
    width: Callable[[Node], float]
    joined: str
    called: Callable[[Call], str]
    whole: float = 0.0
    stacked: bool = True
    times: str = ""


@final
@dataclass(frozen=True, slots=True)
class _Piece:
    """Text that stays together, its width, whether a line may begin with it, how deep inside a term that would be, and what
    stands before it there."""

    text: str
    width: float
    begins: bool
    depth: int = 0
    before: str = ""


LINE, TOO_WIDE, _DOT = 3.0, 1e6, 1.0
"""What a line costs, and what a letter does that stands beyond its end; a break costs its depth. How wide a dot is."""


def lines(nodes: list[Node], style: Style, first: float, rest: float) -> list[str]:
    """Nodes in a row as lines: the first `first` wide at most, the others `rest`; what cannot be broken may be wider."""
    return _broken_up(nodes, style, first, rest)[0]


def cost(nodes: list[Node], style: Style, first: float, rest: float) -> float:
    """What `lines` of these cost; over TOO_WIDE / 10 where one of them is too wide."""
    return _broken_up(nodes, style, first, rest)[1]


def _broken_up(nodes: list[Node], style: Style, first: float, rest: float) -> tuple[list[str], float]:
    """The lines that cost least, and what they cost."""
    pieces = [p for node in nodes for p in _pieces(node, style, min(first, rest), 0)]
    groups = [replace(g[0], text="".join(p.text for p in g), width=sum(p.width for p in g)) for g in _groups(pieces)]
    best: list[tuple[float, int]] = [(0.0, 0)]  # the least cost up to a piece, and minus where the last line begins
    for end in range(1, len(groups) + 1):
        found, used = (float("inf"), 0), 0.0
        for begin in range(end - 1, -1, -1):
            used += groups[begin].width
            beyond = used + (begin and _DOT * bool(groups[begin].before)) - (rest if begin else first)
            if beyond > 0 and begin < end - 1 and found[0] < float("inf"):
                break
            total = best[begin][0] + LINE + (groups[begin].depth if begin else 0) + max(beyond, 0.0) * TOO_WIDE
            found = min(found, (total, -begin))
        best.append(found)
    broken: list[str] = []
    end = len(groups)
    while end:
        begin = -best[end][1]
        broken.append((groups[begin].before if begin else "") + "".join(g.text for g in groups[begin:end]))
        end = begin
    return broken[::-1] or [""], best[-1][0]


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


def _pieces(node: Node, style: Style, limit: float, depth: int) -> Iterator[_Piece]:
    """A node as pieces: one, where it fits or cannot be broken."""
    if isinstance(node, Row):
        for item in node.items:
            yield from _pieces(item, style, limit, depth + isinstance(item, Row))
    elif isinstance(node, Words):
        for part in re.findall(r"^\s+|\S+\s*", node.text):
            words = Words(part)
            yield _Piece(style.shown(words), style.width(words), part[0].isalpha(), depth)
    elif isinstance(node, Op):
        yield _Piece(style.shown(node), style.width(node), node.sign != "neg", depth)
    elif style.width(node) <= limit:
        yield _Piece(style.shown(node), style.width(node), begins=False)
    else:
        broken = list(_broken(node, style, limit, depth))
        whole = _Piece(style.shown(node), style.width(node), begins=False)
        yield from broken if any(p.begins for p in broken) else [whole]


def _broken(node: Node, style: Style, limit: float, depth: int) -> Iterator[_Piece]:
    """A node that is wider than a line."""
    if isinstance(node, Times):
        for i, factor in enumerate(node.factors):
            if i and style.joined:
                yield _Piece(style.joined, 0.3, begins=False)
            apart = i > 0 and not _is_short(node.factors[i - 1])
            yield from _begun(_pieces(factor, style, limit, depth + 1), apart, depth + 1, style.times)
    elif isinstance(node, Sum):
        yield _Piece(style.shown(replace(node, inner=Words(""))), 2.5, begins=False)
        yield from _pieces(node.inner, style, limit, depth)
    elif isinstance(node, Fence):
        yield _sign(style, "left " + node.left)
        yield from _pieces(node.inner, style, limit, depth + 2)
        yield _sign(style, "right " + node.right)
    elif isinstance(node, Fraction) and (parted := _parted(node, style, limit)) is not None:
        yield from _pieces(parted, style, limit, depth)
    elif isinstance(node, Fraction) and style.width(node) > style.whole:
        yield from _pieces(_bracketed(node.top), style, limit, depth)
        yield replace(_sign(style, "/"), begins=not isinstance(node.top, Num), depth=depth + 1)
        yield from _pieces(_bracketed(node.bottom), style, limit, depth)
    elif isinstance(node, Call):
        yield _Piece(style.called(node), style.width(node.function), begins=False)
        yield _sign(style, "left (")
        for i, argument in enumerate(node.arguments):
            if i:
                yield _sign(style, ",")
            yield from _begun(_pieces(argument, style, limit, depth + 2), i > 0, depth + 2)
        yield _sign(style, "right )")
    elif isinstance(node, Power) and isinstance(node.base, Fence):
        yield from _pieces(node.base, style, limit, depth)
        yield _Piece(style.shown(Power(Words(""), node.exponent)), style.width(node.exponent), begins=False)
    else:
        yield _Piece(style.shown(node), style.width(node), begins=False)


def _is_short(node: Node) -> bool:
    """Whether it is a number that no line ends with."""
    return isinstance(node, Num) and len(node.digits) <= 2


def _begun(pieces: Iterator[_Piece], begins: bool, depth: int, before: str = "") -> Iterator[_Piece]:
    """Pieces of which the first may begin a line, behind what stands before it there."""
    for number, piece in enumerate(pieces):
        yield replace(piece, begins=True, depth=depth, before=before) if begins and number == 0 else piece


def _parted(node: Fraction, style: Style, limit: float) -> Node | None:
    """A fraction whose functions and brackets stand behind it as factors, where it is short without them."""
    factors = node.top.factors if isinstance(node.top, Times) else (node.top,)
    behind = tuple(x for x in factors if isinstance(x, (Call, Fence)))
    before = tuple(x for x in factors if not isinstance(x, (Call, Fence)))
    if not style.stacked or not behind or isinstance(node.bottom, Row):
        return None
    top = before[0] if len(before) == 1 else Times(before) if before else Num("1")
    short = Fraction(top, node.bottom)
    return Times((short, *behind)) if style.width(short) <= limit else None


def _sign(style: Style, sign: str) -> _Piece:
    return _Piece(style.shown(Op(sign)), 1.0, begins=False)


def _bracketed(node: Any) -> Any:
    return Fence("(", ")", node) if isinstance(node, (Row, Times)) else node
