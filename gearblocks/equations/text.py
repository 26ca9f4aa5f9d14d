"""Notation as text: Greek letters, fractions in a line, cases as a block with a brace."""

from __future__ import annotations

from typing import Any

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

_SUPERSCRIPTS = {"2": "²", "3": "³", "4": "⁴"}
_SIGNS = {"neg": "-", "×": "×", "/": "/", ",": ", "}
_BRACKETS = {1: ("[", "]"), 2: ("⎡⎣", "⎤⎦")}
_BRACES = {2: "⎧⎩", 3: "⎧⎨⎩", 4: "⎧⎨⎪⎩"}


def name_text(name: Name) -> str:
    """A name such as φ_motor''."""
    owner = f"_{name.owner.replace(' ', '_')}" if name.owner else ""
    number = name.number if name.number.isdigit() and not name.is_word else f"_{name.number}" if name.number else ""
    return f"{name.letter}{number}{owner}" + "'" * name.dots


def text(node: Node) -> str:
    """A node in one line."""
    return str(_SHOWN[type(node)](node))


def _op(node: Op) -> str:
    if node.sign.startswith(("left ", "right ")):
        return node.sign.split()[1]
    return _SIGNS.get(node.sign) or f" {node.sign} "


def _call(node: Call) -> str:
    return f"{_called(node)}({', '.join(map(text, node.arguments))})"


def _called(node: Call) -> str:
    return text(node.function) + "'" * node.primes


def _power(node: Power) -> str:
    exponent = text(node.exponent)
    if exponent in _SUPERSCRIPTS:
        return text(node.base) + _SUPERSCRIPTS[exponent]
    plain = isinstance(node.exponent, (Sym, Num))
    return f"{text(node.base)}^{exponent}" if plain else f"{text(node.base)}^({exponent})"


def _fraction(node: Fraction) -> str:
    top, bottom = text(node.top), text(node.bottom)
    top = f"({top})" if isinstance(node.top, Row) else top
    return f"{top}/({bottom})" if isinstance(node.bottom, (Row, Times, Fraction)) else f"{top}/{bottom}"


def _times(node: Times) -> str:
    shown = [f"({text(f)})" if isinstance(f, Fraction) and i else text(f) for i, f in enumerate(node.factors)]
    return " ".join(x.strip() for x in shown)


def _cases(node: Cases) -> str:
    rows = [f"{text(v)}, {_when(c)}" for v, c in node.rows]
    return "{" + "; ".join(rows) + "}"


def _matrix(node: Matrix) -> str:
    return "[" + "; ".join(", ".join(map(text, row)) for row in node.rows) + "]"


def _when(condition: Any) -> str:
    return "otherwise" if condition is None else text(condition)


_SHOWN: dict[Any, Any] = {
    Sym: lambda node: name_text(node.name),
    Num: lambda node: node.digits,
    Words: lambda node: node.text,
    Op: _op,
    Row: lambda node: "".join(map(text, node.items)),
    Times: _times,
    Fraction: _fraction,
    Power: _power,
    Root: lambda node: f"√{text(node.inner)}" if isinstance(node.inner, (Sym, Num)) else f"√({text(node.inner)})",
    Fence: lambda node: f"{node.left}{text(node.inner)}{node.right}",
    Call: _call,
    Cases: _cases,
    Sum: lambda node: f"Σ_{node.index} {text(node.inner)}",
    Matrix: _matrix,
}

STYLE = Style(text, lambda node: float(len(text(node))), " ", _called, stacked=False, times="· ")


def equation_lines(left: Node | None, right: Node, width: int) -> list[str]:
    """left = right in lines of at most `width` characters where it can be broken; cases as a block."""
    head = "" if left is None else f"{text(left)} = "
    if isinstance(right, Cases) and len(right.rows) > 1:
        return _block(head, right, width)
    if isinstance(right, Matrix):
        return _in_brackets(head, right)
    if len(head) > width // 2:
        broken = lines([left, Op("="), right], STYLE, width, width - 8)  # type: ignore[list-item]
        return [broken[0], *("        " + x.strip() for x in broken[1:])]
    indent = min(len(head), 24)
    broken = lines([right], STYLE, width - len(head), width - indent)
    return [head + broken[0].strip(), *(" " * indent + x.strip() for x in broken[1:])]


def _block(head: str, cases: Cases, width: int) -> list[str]:
    values = [text(value) + "," for value, _ in cases.rows]
    wide = max(map(len, values))
    braces = _BRACES.get(len(values)) or "⎧" + "⎪" * (len(values) - 2) + "⎩"
    middle = (len(values) - 1) // 2
    found = []
    left = len(head) + wide + 4
    for i, (value, (_, condition)) in enumerate(zip(values, cases.rows, strict=True)):
        room = max(width - left, 30)
        when = ["otherwise"] if condition is None else lines([condition], STYLE, room, room)
        found.append(f"{head if i == middle else ' ' * len(head)}{braces[i]} {value:<{wide}}  {when[0].strip()}")
        going_on = " " if i == len(values) - 1 else "⎪"
        found += [f"{' ' * len(head)}{going_on} {' ' * wide}  {more.strip()}" for more in when[1:]]
    return found


def _in_brackets(head: str, matrix: Matrix) -> list[str]:
    cells = [[text(entry) for entry in row] for row in matrix.rows]
    wide = [max(map(len, column)) for column in zip(*cells, strict=True)]
    n = len(cells)
    left, right = _BRACKETS.get(n) or (f"⎡{'⎢' * (n - 2)}⎣", f"⎤{'⎥' * (n - 2)}⎦")
    found = []
    for i, row in enumerate(cells):
        inner = "  ".join(cell.center(room) for cell, room in zip(row, wide, strict=True))
        found.append(f"{head if i == (n - 1) // 2 else ' ' * len(head)}{left[i]} {inner} {right[i]}")
    return found
