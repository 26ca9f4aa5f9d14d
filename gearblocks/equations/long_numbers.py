"""Constants of many digits, which nobody prints within an equation: a symbol each, with all digits in the nomenclature.

Knows nothing of sympy, nor of how a symbol is shown.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

from gearblocks.equations.document import Line, Nomenclature, Section
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Num, Op, Power, Sym, Times
from gearblocks.equations.nomenclature import Entry

MOST = 9
"""Digits of a number that stands in an equation."""
LETTERS = ("n", "ν", "ϰ")
"""Of constants: the first that no other symbol has with a number at its foot alone."""


def with_constants(sections: Iterable[Section], nomenclature: Nomenclature) -> tuple[tuple[Section, ...], Nomenclature]:
    """Sections and symbols with one more for each number of more than MOST digits."""
    taken = {name.letter for name, _ in nomenclature.entries if not name.owner}
    letter = next((x for x in LETTERS if x not in taken), LETTERS[-1])
    found: dict[str, Name] = {}

    def symbol(value: str) -> Sym:
        return Sym(found.setdefault(value, Name(letter, str(len(found) + 1))))

    def read(node: Any) -> Any:
        if isinstance(node, Num):
            return symbol(node.digits) if _is_long(node) else node
        if isinstance(node, Times) and Op("×") in node.factors and isinstance(node.factors[0], Num):
            number, _, ten = node.factors[:3]
            if _is_long(number) and isinstance(ten, Power):
                value = symbol(f"{number.digits}e{ten.exponent.digits}")
                rest = tuple(read(x) for x in node.factors[3:])
                return Times((value, *rest)) if rest else value
        if isinstance(node, tuple):
            return tuple(read(x) for x in node)
        if dataclasses.is_dataclass(node) and not isinstance(node, (type, Name)):
            return dataclasses.replace(node, **{f.name: read(getattr(node, f.name)) for f in dataclasses.fields(node)})
        return node

    changed = tuple(Section(s.heading, tuple(Line(read(x.left), read(x.right)) for x in s.lines)) for s in sections)
    entries = tuple((name, Entry("constant", value)) for value, name in found.items())
    return changed, Nomenclature((*nomenclature.entries, *entries))


def _is_long(node: Num) -> bool:
    return len(node.digits.replace(".", "").lstrip("0")) > MOST
