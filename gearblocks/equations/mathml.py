"""Notation as presentation MathML, which browsers show without help and without a network."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

from markupsafe import escape

from gearblocks.equations.latex import is_tall, width
from gearblocks.equations.line_breaking import Style, lines
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import (
    Call,
    Cases,
    Fence,
    Fraction,
    Matrix,
    Node,
    Num,
    Op,
    Power,
    Root,
    Row,
    Sum,
    Sym,
    Times,
    Words,
)

_DOTS = {1: "\N{DOT ABOVE}", 2: "\N{DIAERESIS}", 3: "\N{COMBINING THREE DOTS ABOVE}"}
_SIGNS = {"-": "\N{MINUS SIGN}", "<=": "≤", ">=": "≥"}
_WORDS = ("and", "or")
_ABOVE = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_THIN = '<mspace width="0.17em"></mspace>'


def unit(text: str) -> str:
    """A unit such as kg m2, with what stands above and the Greek letter: kg m², µm."""
    micro = re.sub(r"\bu(?=[^\W\d])", "µ", "" if text == "1" else text)
    return re.sub(r"(?<=[^\W\d_])-?\d+", lambda found: found[0].translate(_ABOVE), micro)


def name_mathml(name: Name, exponent: str = "") -> str:
    """A name: letter, dots above, number and part of the train at its foot, above that an exponent."""
    whole = name.letter
    change, plain = (whole[0], whole[1:]) if whole[0] in "Δ∂" and len(whole) > 1 else ("", whole)
    letter = f'<mi mathvariant="normal">{escape(plain)}</mi>' if name.is_word else f"<mi>{escape(plain)}</mi>"
    if name.dots:
        above = _DOTS.get(name.dots) or f"({name.dots})"
        letter = f"<mover>{letter}<mo>{above}</mo></mover>"
    foot = ",".join(x for x in (name.number, name.owner.replace("_", " ")) if x)
    tag = "mn" if foot.isdigit() else "mtext"
    if foot:
        both, above = ("msubsup", exponent) if exponent else ("msub", "")
        letter = f"<{both}>{letter}<{tag}>{escape(foot)}</{tag}>{above}</{both}>"
    elif exponent:
        letter = f"<msup>{letter}{exponent}</msup>"
    return f'<mrow><mi mathvariant="normal">{change}</mi>{letter}</mrow>' if change else letter


def mathml(node: Node) -> str:
    """A node as MathML elements."""
    return str(_SHOWN[type(node)](node))


def _row(*parts: str) -> str:
    return f"<mrow>{''.join(parts)}</mrow>"


def _op(node: Op) -> str:
    sign = node.sign
    if sign.startswith(("left ", "right ")):
        return _fence(sign.split()[1])
    if sign == "neg":
        return '<mo form="prefix">\N{MINUS SIGN}</mo>'
    if sign in _WORDS:
        return f"<mtext>\N{NO-BREAK SPACE}{sign}\N{NO-BREAK SPACE}</mtext>"
    return f'<mo form="infix">{escape(_SIGNS.get(sign, sign))}</mo>'  # a line may begin with it


def _fence(sign: str) -> str:
    return f'<mo stretchy="false">{sign}</mo>'


def _fenced(left: str, inner: str, right: str, *nodes: Any) -> str:
    """Brackets, as tall as what stands in them where that is more than a line; browsers stretch them for a foot too."""
    if any(map(is_tall, nodes)):
        return _row(f"<mo>{left}</mo>", inner, f"<mo>{right}</mo>")
    return _row(_fence(left), inner, _fence(right))


def _call(node: Call) -> str:
    arguments = "<mo>,</mo>".join(map(mathml, node.arguments))
    return _row(_called(node), _fenced("(", arguments, ")", *node.arguments))


def _called(node: Call) -> str:
    function = node.function
    name = f"<mi>{escape(function.text)}</mi>" if isinstance(function, Words) else mathml(function)
    return name + (f"<mo>{'′' * node.primes}</mo>" if node.primes else "")


def _power(node: Power) -> str:
    exponent = _row(mathml(node.exponent))
    if isinstance(node.base, Sym) and node.base.name.letter[0] not in "Δ∂":
        return name_mathml(node.base.name, exponent)
    return f"<msup>{_row(mathml(node.base))}{exponent}</msup>"


def _cell(inner: str) -> str:
    return f'<mtd style="text-align: left; padding: 0.1em 0.8em 0.1em 0">{_row(inner)}</mtd>'


def _cases(node: Cases) -> str:
    rows = [f"<mtr>{_cell(_stacked(value))}{_cell(_when(condition))}</mtr>" for value, condition in node.rows]
    return _row("<mo>{</mo>", f"<mtable>{''.join(rows)}</mtable>")


def _matrix(node: Matrix) -> str:
    rows = "".join(f"<mtr>{''.join(f'<mtd>{mathml(x)}</mtd>' for x in row)}</mtr>" for row in node.rows)
    return _row("<mo>[</mo>", f"<mtable>{rows}</mtable>", "<mo>]</mo>")


def _stacked(node: Node) -> str:
    """A cell of cases, in lines where it is wide."""
    first, *others = lines([node], STYLE, CELL, CELL - 2)
    if not others:
        return mathml(node)
    more = "".join(f'<mtr><mtd style="text-align: left; padding-left: 1em">{_row(x)}</mtd></mtr>' for x in others)
    return f'<mtable><mtr><mtd style="text-align: left">{_row(first)}</mtd></mtr>{more}</mtable>'


def _when(condition: Any) -> str:
    return "<mtext>otherwise</mtext>" if condition is None else _stacked(condition)


_SHOWN: dict[Any, Any] = {
    Sym: lambda node: name_mathml(node.name),
    Num: lambda node: f"<mn>{node.digits.replace('-', _SIGNS['-'])}</mn>",
    Words: lambda node: f"<mtext>{escape(node.text).replace(' ', chr(160))}</mtext>" if node.text else "",
    Op: _op,
    Row: lambda node: _row(*map(mathml, node.items)),
    Times: lambda node: _row(_THIN.join(map(mathml, node.factors))),
    Fraction: lambda node: f"<mfrac>{_row(mathml(node.top))}{_row(mathml(node.bottom))}</mfrac>",
    Power: _power,
    Root: lambda node: f"<msqrt>{mathml(node.inner)}</msqrt>",
    Fence: lambda node: _fenced(node.left, mathml(node.inner), node.right, node.inner),
    Call: _call,
    Cases: _cases,
    Sum: lambda node: _row(
        f"<munderover><mo>∑</mo><mrow><mi>{node.index}</mi><mo>=</mo><mn>{node.first}</mn></mrow><mn>{node.last}</mn>"
        f"</munderover>{mathml(node.inner)}"
    ),
    Matrix: _matrix,
}

STYLE = Style(mathml, width, _THIN, _called)
LINE = 84.0
"""Letters of a line."""
PIECE = 24.0
"""Letters of a piece that a page keeps together: a telephone shows about 36 in a line."""
CELL = 50.0
"""Letters of a line in a cell of cases."""


def math(inner: str) -> str:
    """A <math> element."""
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" displaystyle="true">{inner}</math>'


def equation_mathml(left: Node | None, right: Node) -> list[str]:
    """left = right as <math> elements, one for each line."""
    return _pieces(left, right, STYLE, LINE)


def flowing_mathml(left: Node | None, right: Node) -> list[str]:
    """left = right as <math> elements that follow each other, in as many lines as a page needs."""
    return _pieces(left, right, replace(STYLE, whole=LINE / 2), PIECE)


def _pieces(left: Node | None, right: Node, style: Style, width: float) -> list[str]:
    nodes = [right] if left is None else [left, Op("="), right]
    return [math(piece) for piece in lines(nodes, style, width, width)]
