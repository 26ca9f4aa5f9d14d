"""Captions: the name of an element above its symbol, its values below it where they are wanted, and the words on hover."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from gearblocks.blocks import Fixed
from gearblocks.drawing.scheme import Element
from gearblocks.drawing.shapes import Shape, Words, text_width
from gearblocks.language.block import Effect
from gearblocks.train.summary import field_texts, short_texts

NAME, VALUE = 11.0, 9.0
_WIDEST, _LINE = 92.0, 13.0
_SHAPE = ("module", "pressure_angle", "helix_angle", "profile_shift", "face_width", "addendum", "r_base")


@final
@dataclass(frozen=True, slots=True)
class Caption:
    """Lines above and below a symbol, and all that is said on hover."""

    names: tuple[str, ...]
    values: tuple[str, ...]
    title: str

    @property
    def width(self) -> float:
        """Room for the widest line."""
        return max(
            (text_width(t, s) for lines, s in ((self.names, NAME), (self.values, VALUE)) for t in lines), default=0.0
        )

    @property
    def above(self) -> float:
        """Height of the names."""
        return _LINE * len(self.names) + 2.0

    @property
    def below(self) -> float:
        """Height of the values."""
        return 11.0 * len(self.values) + (2.0 if self.values else 0.0)

    def shapes(self, up: float, down: float) -> Iterator[Shape]:
        """Names whose last line ends above -up, values whose first begins below down."""
        for i, text in enumerate(reversed(self.names)):
            yield Words(0.0, -up - 4.0 - _LINE * i, text, NAME)
        for i, text in enumerate(self.values):
            yield Words(0.0, down + 10.0 + 11.0 * i, text, VALUE, grey=True)


def caption(e: Element, values: bool) -> Caption:
    """The caption of an element; values: whether its values are printed too."""
    single = sum(not isinstance(block, Fixed) for _, block in e.blocks) <= 1
    shown = _foremost(e)[:3] if values and single and not e.parallel else []
    return Caption(tuple(wrapped(e.name)), tuple(line for text in shown for line in _lines(text)), title(e))


def _foremost(e: Element) -> list[str]:
    """Values of an element in few letters: stiffness and gap before the shape of the teeth."""
    texts, gap = short_texts(e.block, e.slides), getattr(e.block, "backlash", None)
    gaps = short_texts(gap, e.slides, type(e.block).fields["backlash"]) if isinstance(gap, Effect) else []
    own = [text for text in texts if text.partition(" ")[0] not in _SHAPE]
    stiffness = [text for text in own if text.startswith("k =")]
    first = [*own[:1], *(x for x in stiffness if x not in own[:1]), *gaps]
    return [*dict.fromkeys([*first, *own, *texts])]


def _lines(text: str) -> list[str]:
    """A value in a line, or in two behind its name where that is too long."""
    if text_width(text, VALUE) <= 1.4 * _WIDEST:
        return [text]
    name, _, value = text.partition(" = ")
    return [f"{_cut(name, VALUE)} =", _cut(value, VALUE)]


def title(e: Element) -> str:
    """Name, class and values of every block."""
    lines = []
    for path, block in e.blocks:
        told = field_texts(block, e.slides)
        lines.append(f"{path}: {type(block).__name__}" + (f" ({', '.join(told)})" if told else ""))
    return "\n".join(lines)


def wrapped(name: str) -> list[str]:
    """A name in at most two lines, broken after a dot, a comma or an underscore, or between words written together."""
    if text_width(name, NAME) <= _WIDEST:
        return [name]
    pieces = re.findall(r"[^._, ]*?[._, ]+|[^._, ]+?(?=[A-Z][a-z])|[^._, ]+", name)
    lines = [""]
    for piece in pieces:
        if lines[-1] and text_width(lines[-1] + piece, NAME) > _WIDEST:
            lines.append("")
        lines[-1] += piece
    lines = [line.strip() for line in lines]
    if len(lines) > 2:
        lines = [lines[0], f"… {lines[-1]}"]
    return [_cut(line) for line in lines]


def _cut(text: str, size: float = NAME) -> str:
    while text_width(text, size) > 1.4 * _WIDEST:
        text = text.removesuffix("…")[:-1] + "…"
    return text
