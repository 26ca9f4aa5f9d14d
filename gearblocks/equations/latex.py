"""Notation as LaTeX (amsmath): aligned equations whose lines fit a column."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Sequence
from typing import Any

from gearblocks.equations.line_breaking import LINE, TOO_WIDE, Style, cost, lines
from gearblocks.equations.names import GREEK, INDEX, Name
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

_GREEK = {letter: f"\\{name}" for name, letter in GREEK.items()} | {
    "φ": r"\varphi", "ε": r"\varepsilon", "π": r"\pi", "∞": r"\infty",
}  # fmt: skip
COLUMN = 40.0
"""Letters in a column of a two-column article, beside a number of the equation."""

_CHANGES = {"Δ": r"\Delta ", "∂": r"\partial "}
_DOTS = {1: r"\dot", 2: r"\ddot", 3: r"\dddot"}
_SIGNS = {
    "neg": "-", "<=": r" \le ", ">=": r" \ge ", "≠": r" \ne ", "and": r"\ \text{and}\ ", "or": r"\ \text{or}\ ",
    "×": r" \times ", ",": r",\, ",
}  # fmt: skip
_SPECIAL = {c: f"\\{c}" for c in "_%&#${}"}
_IN_MATHEMATICS = {
    "~": r"\sim ", "^": r"\wedge ", "\\": r"\backslash ", "≤": r"\le ", "≥": r"\ge ", "≠": r"\ne ", "×": r"\times ",
    "·": r"\cdot ", "±": r"\pm ", "→": r"\to ", "√": r"\surd ", "²": "^2", "³": "^3", "°": r"^\circ ", "µ": r"\mu ",
}  # fmt: skip
_IN_PROSE = {c: f"${x.strip()}$" for c, x in [*_IN_MATHEMATICS.items(), *((c, c) for c in "|<>"), *_GREEK.items()]}
_FENCES = {"⌊": r"\lfloor ", "⌋": r"\rfloor ", "|": "|", "(": "(", ")": ")"}
_MACROS = {"sin", "cos", "tan", "arctan", "arcsin", "arccos", "exp", "ln", "tanh", "sinh", "cosh", "max", "min"}


def word(words: str) -> str:
    """Words upright within mathematics."""
    special = _SPECIAL | _IN_MATHEMATICS | {" ": "\\,"}
    return r"\mathrm{" + "".join(special.get(c, c) for c in words) + "}"


def prose(words: str) -> str:
    """Words as text; ^2 is an exponent."""
    special = _SPECIAL | _IN_PROSE
    return re.sub(r"\^(-?\d+)|.", lambda m: f"$^{{{m[1]}}}$" if m[1] else special.get(m[0], m[0]), words)


def name_latex(name: Name) -> str:
    """A name such as \\ddot{\\varphi}_{\\mathrm{motor}}."""
    differs = name.letter[0] in _CHANGES and len(name.letter) > 1
    change, letter = (_CHANGES[name.letter[0]], name.letter[1:]) if differs else ("", name.letter)
    letter = _GREEK.get(letter) or (letter if len(letter) == 1 else word(letter))
    if name.dots > 3:
        letter = f"{letter}^{{({name.dots})}}"
    elif name.dots:
        letter = f"{_DOTS[name.dots]}{{{letter}}}"
    number = name.number if not name.number or name.number.isdigit() else _GREEK.get(name.number) or word(name.number)
    index = ",".join(x for x in (number, _foot(name.owner)) if x)
    return f"{change}{letter}_{{{index}}}" if index else change + letter


def _foot(owner: str) -> str:
    """The part of the train upright, its index as that of the sums."""
    whole = owner.removesuffix(f" {INDEX}")
    return "" if not owner else word(whole) + (rf"\,{INDEX}" if whole != owner else "")


def latex(node: Node) -> str:
    """A node in one line."""
    return str(_SHOWN[type(node)](node))


def _op(node: Op) -> str:
    if node.sign.startswith(("left ", "right ")):
        return _FENCES[node.sign.split()[1]]
    return _SIGNS.get(node.sign) or f" {node.sign} "


def _call(node: Call) -> str:
    arguments = ",\\, ".join(map(latex, node.arguments))
    return f"{_called(node)}{_fenced('(', arguments, ')', node.arguments)}"


def _called(node: Call) -> str:
    function = node.function
    if isinstance(function, Words):
        name = f"\\{function.text}" if function.text in _MACROS else rf"\operatorname{{{function.text}}}"
    else:
        name = latex(function)
    return f"{{{name}}}" + "'" * node.primes if node.primes else name


def _fenced(left: str, inner: str, right: str, nodes: tuple[Any, ...]) -> str:
    """Brackets, as tall as what stands in them where that is more than a line."""
    if any(map(is_tall, nodes)):
        return f"\\left{_FENCES[left]}{inner}\\right{_FENCES[right]}"
    return f"{_FENCES[left]}{inner}{_FENCES[right]}"


def is_tall(node: Any) -> bool:
    """Whether brackets around a node are more than a line tall."""
    if isinstance(node, (Fraction, Cases, Root, Sum, Matrix)):
        return True
    parts = {Row: "items", Times: "factors", Call: "arguments"}.get(type(node))
    inner = getattr(node, parts) if parts else (node.inner,) if isinstance(node, Fence) else ()
    return any(map(is_tall, inner))


def _fraction(node: Fraction) -> str:
    small = isinstance(node.top, Num) and isinstance(node.bottom, Num)
    return rf"\{'tfrac' if small else 'frac'}{{{latex(node.top)}}}{{{latex(node.bottom)}}}"


def _cases(node: Cases) -> str:
    room = COLUMN - 7.0
    free = room - max(width(value) for value, _ in node.rows)
    beside = min(max(_when_width(c) for _, c in node.rows), max(0.6 * room, free))
    rows = [f"{_stacked(value, room - beside, ',')} & {_when(condition, beside)}" for value, condition in node.rows]
    return r"\begin{cases} " + r" \\ ".join(rows) + r" \end{cases}"


def _matrix(node: Matrix) -> str:
    rows = r" \\ ".join(" & ".join(map(latex, row)) for row in node.rows)
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def _stacked(node: Node, room: float, end: str = "") -> str:
    """A cell of cases, in lines where it is wide; end: what stands behind it."""
    broken = lines([node], STYLE, room, room - 2)
    if len(broken) == 1:
        return broken[0] + end
    return r"\begin{aligned}[t]&" + r"\\ &\quad ".join(broken) + end + r"\end{aligned}"


def _when(condition: Any, room: float = COLUMN) -> str:
    return r"\text{otherwise}" if condition is None else _stacked(condition, room)


def _when_width(condition: Any) -> float:
    return 6.5 if condition is None else width(condition)


_SHOWN: dict[Any, Any] = {
    Sym: lambda node: name_latex(node.name),
    Num: lambda node: node.digits,
    Words: lambda node: rf"\text{{{prose(node.text)}}}" if node.text else "",
    Op: _op,
    Row: lambda node: "".join(map(latex, node.items)),
    Times: lambda node: r"\,".join(map(latex, node.factors)),
    Fraction: _fraction,
    Power: lambda node: f"{latex(node.base)}^{{{latex(node.exponent)}}}",
    Root: lambda node: rf"\sqrt{{{latex(node.inner)}}}",
    Fence: lambda node: _fenced(node.left, latex(node.inner), node.right, (node.inner,)),
    Call: _call,
    Cases: _cases,
    Sum: lambda node: rf"\sum_{{{node.index}={node.first}}}^{{{node.last}}} {latex(node.inner)}",
    Matrix: _matrix,
}


# -- how wide it will be, in letters ----------------------------------------------------------------------------------

_WIDE = {"=": 2.6, "+": 2.4, "-": 2.4, "neg": 1.4, "and": 5.0, "or": 4.0}


def name_width(name: Name) -> float:
    """The width of a name, in letters of the mathematics."""
    index = len(name.number) + len(name.owner)
    return 1.1 * len(name.letter) + 0.69 * index + (0.4 if name.number and name.owner else 0.0)


def width(node: Node) -> float:
    """The width of a node, in letters of the mathematics."""
    kind = type(node)
    if kind in _WIDTHS:
        return float(_WIDTHS[kind](node))
    return len(latex(node))


def _sum(nodes: tuple[Any, ...], between: float = 0.0) -> float:
    return sum(map(width, nodes)) + between * (len(nodes) - 1)


def _matrix_width(node: Matrix) -> float:
    return 2.0 + sum(2.0 + max(map(width, column)) for column in zip(*node.rows, strict=True))


_WIDTHS: dict[Any, Any] = {
    Matrix: _matrix_width,
    Sym: lambda node: name_width(node.name),
    Sum: lambda node: 2.5 + width(node.inner),
    Num: lambda node: len(node.digits),
    Words: lambda node: 0.9 * len(node.text),
    Op: lambda node: _WIDE.get(node.sign, 2.4),
    Row: lambda node: _sum(node.items),
    Times: lambda node: _sum(node.factors, 0.35),
    Fraction: lambda node: max(width(node.top), width(node.bottom)) + 0.5,
    Power: lambda node: width(node.base) + 0.75 * width(node.exponent),
    Root: lambda node: width(node.inner) + 1.8,
    Fence: lambda node: width(node.inner) + 1.8,
    Call: lambda node: width(node.function) + _sum(node.arguments, 1.2) + 2.0,
    Cases: lambda node: min(
        COLUMN, 7.0 + max(map(width, (v for v, _ in node.rows))) + max(_when_width(c) for _, c in node.rows)
    ),
}

STYLE = Style(latex, width, r"\,", _called, times=r"\cdot ")


def is_wide(left: Node, right: Node) -> bool:
    """Whether the left side needs lines of its own: aligned with others it would push them out of the column, or the right side
    is fewer lines below it."""
    head = width(left) + 2.6
    if head > 0.45 * COLUMN or head + _unbroken(right) > COLUMN:
        return True
    below = cost([Op("="), right], STYLE, COLUMN - 2, COLUMN - 2)
    return _beside(head, right) > 2 * LINE + 1 and _beside(head, right) > LINE + below


def fit_together(equations: Sequence[tuple[Node, Node]]) -> bool:
    """Whether equations may be aligned with each other: what none of them can break fits behind the widest left side."""
    head = max(width(left) for left, _ in equations) + 2.6
    return all(head + _unbroken(right) <= COLUMN and _beside(head, right) < TOO_WIDE / 10 for _, right in equations)


def _beside(head: float, right: Node) -> float:
    """What the lines of a right side cost behind a left side."""
    return cost([right], STYLE, COLUMN - head, COLUMN - head - 2)


def _unbroken(node: Any) -> float:
    """The width of the widest cases on a right side; 4 for the indent and the sign before those that are a term of a sum."""
    if isinstance(node, Cases):
        return width(node)
    return max((4.0 + width(x) for x in _cases_in(node)), default=0.0)


def _cases_in(node: Any) -> Iterator[Cases]:
    if isinstance(node, Cases):
        yield node
    parts = node if isinstance(node, tuple) else ()
    if dataclasses.is_dataclass(node):
        parts = tuple(getattr(node, field.name) for field in dataclasses.fields(node))
    for part in parts:
        yield from _cases_in(part)


def align(equations: Sequence[tuple[Node, Node]]) -> str:
    """Equations as the lines of an align environment, all behind the widest left side."""
    head = max((width(left) + 2.6 for left, right in equations if not is_wide(left, right)), default=0.0)
    return " \\\\\n".join(aligned(left, right, head) for left, right in equations)


def aligned(left: Node, right: Node, head: float = 0.0) -> str:
    """One equation as lines of an align environment, on one page; the number stands at the last. head: width of the left side
    that it is aligned behind, where that is wider than its own."""
    head = max(head, width(left) + 2.6)
    if not is_wide(left, right):
        broken = lines([right], STYLE, COLUMN - head, COLUMN - head - 2)
        found = [f"{latex(left)} &= {broken[0]}", *(rf"&\quad {x}" for x in broken[1:])]
    elif isinstance(right, Cases):
        found = [f"&{latex(left)} =", rf"&\quad {latex(right)}"]
    else:
        above = lines([left], STYLE, COLUMN, COLUMN - 2)
        broken = lines([Op("="), right], STYLE, COLUMN - 2, COLUMN - 2)
        found = [f"&{above[0]}", *(rf"&\quad {x}" for x in [*above[1:], *broken])]
    return " \\notag \\\\*\n".join(found)


def sentence(node: Node) -> str:
    """Words and symbols that a paragraph breaks by itself."""
    items = node.items if isinstance(node, Row) else (node,)
    return "".join(prose(x.text) if isinstance(x, Words) else _within(x) for x in items)


def _within(node: Node) -> str:
    """Mathematics within a sentence; what is wide stands in lines of its own."""
    if width(node) <= 0.6 * COLUMN:
        return f"${latex(node)}$"
    return r"\[" + _stacked(node, COLUMN).replace("{aligned}[t]", "{aligned}") + r"\]"


def value(text: str) -> str:
    """A value as it is given, 2e8 as a power of ten."""
    return re.sub(
        r"([\d.]+)e([+-]?\d+)",
        lambda m: rf"${m[1]} \times 10^{{{int(m[2])}}}$".replace(r"$1 \times ", "$"),
        prose(text),
    )


def unit(text: str) -> str:
    """A unit such as N m s/rad."""
    if text in ("", "1"):
        return ""
    micro = re.sub(r"\bu(?=[^\W\d])", r"\\mu ", word(text))
    return "$" + re.sub(r"(?<=[^\W\d_])(-?\d+)", r"^{\1}", micro) + "$"
