"""Equations for small deviations from an operating point: M Δq'' = -C Δq' - K Δq, in the words of the printed equations.

The chain rule stops at a definition whose slope is cases: ∂N/∂x is a symbol in K and C, and is defined once behind them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, final

import sympy as sp

from gearblocks.equations.document import Line, Section
from gearblocks.equations.latex import COLUMN, width
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Fence, Matrix, Node, Num, Op, Row, Sym, Times, Words
from gearblocks.equations.notation import Reader
from gearblocks.equations.sections import Written, reader

_SHORT = 6
"""Operations of a slope that stands where it is used."""


@final
@dataclass(frozen=True, slots=True)
class Linearized:
    """stiffness, damping: minus the slopes of the forcing over the angles and over the speeds; rates: of each state of a block
    its slopes over angles, speeds and states; by_states: slopes of the forcing over the states; partials: the slopes that are
    symbols there (Derivative of one definition over another)."""

    stiffness: Any
    damping: Any
    by_states: Any
    rates: Any
    partials: dict[Any, Any]


def linearized(eq: Written) -> Linearized:
    """The slopes of the forcing and of the states' rates; the torques of friction and stops are as they are."""
    chain = _Chain(dict(eq.definitions))
    states = [*eq.states]
    rates = sp.Matrix([[chain.slope(rate, x) for x in (*eq.q, *eq.v, *states)] for rate in eq.states.values()])
    found = [sp.Matrix([[chain.slope(f, x) for x in xs] for f in eq.forcing]) for xs in (eq.q, eq.v, states)]
    partials: dict[Any, Any] = {}
    used = [*found, rates]
    while new := ({d for e in used for d in e.atoms(sp.Derivative)} & chain.partials.keys()) - partials.keys():
        partials |= {d: slope for d, slope in chain.partials.items() if d in new}
        used = [chain.partials[d] for d in new]
    return Linearized(-found[0], -found[1], found[2], rates, partials)


class _Chain:
    """Slopes of expressions over definitions."""

    def __init__(self, definitions: dict[Any, Any]) -> None:
        self.definitions = definitions
        self.partials: dict[Any, Any] = {}
        self._known: dict[tuple[Any, Any], Any] = {}

    def slope(self, expr: Any, x: Any) -> Any:
        """The total slope of an expression over a coordinate."""
        inner = sorted(sp.sympify(expr).free_symbols & set(self.definitions), key=str)
        total = _diff(expr, x) + sum((_diff(expr, d) * self._of(d, x) for d in inner), sp.Integer(0))
        return sp.factor_terms(total)

    def _of(self, symbol: Any, x: Any) -> Any:
        """The slope of a definition over a coordinate."""
        if (symbol, x) not in self._known:
            expr = self.definitions[symbol]
            inner = [d for d in sorted(expr.free_symbols & set(self.definitions), key=str) if self._of(d, x) != 0]
            found = self._partial(symbol, expr, x) if expr.has(x) else sp.Integer(0)
            found += sum((self._partial(symbol, expr, d) * self._of(d, x) for d in inner), sp.Integer(0))
            self._known[symbol, x] = found
        return self._known[symbol, x]

    def _partial(self, symbol: Any, expr: Any, by: Any) -> Any:
        slope = _diff(expr, by)
        if slope.is_number or (not slope.atoms(sp.Function) and sp.count_ops(slope) <= _SHORT):
            return slope
        short = sp.Derivative(symbol, by, evaluate=False)
        self.partials[short] = slope
        return short


def _diff(expr: Any, x: Any) -> Any:
    """The slope where the expression has one: between their jumps whole parts stay."""
    expr = sp.sympify(expr).replace(sp.frac, lambda e: e - sp.floor(e))
    whole = {e: sp.Dummy(real=True) for e in expr.atoms(sp.floor, sp.ceiling)}
    return sp.diff(expr.xreplace(whole), x).xreplace({held: e for e, held in whole.items()})


# -- as people read them ----------------------------------------------------------------------------------------------


def sections(eq: Written) -> Iterator[Section]:
    """The linearised equations, their matrices, and the slopes in them."""
    read, found = reader(eq), linearized(eq)
    M, C, K = (_letter(x) for x in "MCK")
    q, v, a = (_letter("Δq", dots) for dots in (0, 1, 2))
    right: list[Any] = [Op("neg"), Times((C, v)), Op("-"), Times((K, q))]
    if eq.states:
        right += [Op("+"), Times((_letter("S"), _letter("Δs")))]
    said = "Small deviations Δ from an operating point; contacts keep their side, what sticks or slides its mode:"
    lines = [
        Line(None, Words(said)),
        Line(Times((M, a)), Row(tuple(right))),
        _list(read, "q", eq.q),
    ]  # fmt: skip
    for letter, matrix in (("M", eq.mass_matrix), ("C", found.damping), ("K", found.stiffness)):
        lines += matrix_lines(Name(letter), _read(read, matrix))
    yield Section("Linearised", tuple(lines))
    if eq.states:
        yield Section("Linearised states of blocks", tuple(_of_states(eq, read, found)))
    if found.partials:
        yield Section("Slopes", tuple(Line(read.read(d), read.read(e)) for d, e in found.partials.items()))


def _of_states(eq: Written, read: Reader, found: Linearized) -> Iterator[Line]:
    """Torques by the states, and the rates of these."""
    yield _list(read, "s", eq.states)
    yield from matrix_lines(Name("S"), _read(read, found.by_states))
    moving = [*eq.q, *eq.v, *eq.states]
    for symbol, row in zip(eq.states, found.rates.tolist(), strict=True):
        items: list[Any] = []
        for x, slope in zip(moving, row, strict=True):
            if slope != 0:
                items += [Op("+")] if items else []
                items.append(Times((read.factor(slope), Sym(read.name(x).difference()))))
        left = Sym(read.name(symbol).rate().difference())
        yield Line(left, Row(tuple(items)) if items else Num("0"))


def matrix_lines(name: Name, rows: list[list[Node]]) -> Iterator[Line]:
    """A matrix in brackets where it fits a column, else its entries that are not zero."""
    zero = Num("0")
    whole = Matrix(tuple(tuple(row) for row in rows))
    if all(entry == zero for row in rows for entry in row):
        yield Line(Sym(name), zero)
    elif width(Sym(name)) + 2.6 + width(whole) <= COLUMN:
        yield Line(Sym(name), whole)
    else:
        for i, row in enumerate(rows, 1):
            for j, entry in enumerate(row, 1):
                if entry != zero:
                    yield Line(Sym(Name(name.letter, f"{i},{j}")), entry)
        if any(entry == zero for row in rows for entry in row):
            yield Line(None, Words("(all other entries are 0)"))


def _read(read: Reader, matrix: Any) -> list[list[Node]]:
    return [[read.read(entry) for entry in row] for row in matrix.tolist()]


def _letter(text: str, dots: int = 0) -> Sym:
    return Sym(Name(text, "", "", dots))


def _list(read: Reader, letter: str, symbols: Iterable[Any]) -> Line:
    """What stands in a vector."""
    items: list[Any] = []
    for x in symbols:
        items += [Op(","), read.read(x)] if items else [read.read(x)]
    return Line(None, Row((Row((_letter(letter), Op("="), Fence("(", ")", Row(tuple(items))))),)))
