"""What printed equations say, in order: balances, then what each part of the train introduces, then what holds while
constraints are active, relative coordinates, and functions.

    balances      mass matrix times accelerations = one term of each part, in the order of the train
    parts         deflection, stiffness, force ... by their own symbols; friction and stops as cases; rates of states
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

import sympy as sp

from gearblocks.equations.document import Line, Nomenclature, Section
from gearblocks.equations.names import Name, owners
from gearblocks.equations.nodes import Call, Cases, Fence, Num, Op, Power, Row, Sym, Times, Words
from gearblocks.equations.notation import Reader
from gearblocks.equations.switched_constraints import Sentence, in_order
from gearblocks.laws.functions import InverseInvolute, RestitutionDamping
from gearblocks.laws.symbols import time_symbol

Written: TypeAlias = Any
"""`Equations`, which prints itself by these functions and therefore stands above them."""


def reader(eq: Written) -> Reader:
    """The notation of a train."""
    moving: dict[Any, int] = {}
    for symbol in (*eq.q, *eq.v, *eq.ties, *eq.coordinates, *eq.states, *eq.held, time_symbol(), *eq.inputs):
        moving[symbol] = 0
    for c in eq.switched_constraints:
        moving |= dict.fromkeys((c.torque, c.slip, *c.shown), 0)
    for i, (symbol, expr) in enumerate(eq.definitions.items(), 1):
        if any(x in moving for x in expr.free_symbols):
            moving[symbol] = i
    for symbol in [*moving]:
        moving.setdefault(sp.Symbol(f"{symbol.name}'", real=True), moving[symbol])
    return Reader(dict(eq.names), moving)


def balances(eq: Written) -> Section:
    """Inertia times acceleration = torques, term by term in the order of the train."""
    read = reader(eq)
    accelerations = [sp.Symbol(f"{v.name}'", real=True) for v in eq.v]
    rows: list[Line] = []
    aside: list[Line] = []
    for i, contributions in enumerate(eq.contributions):
        left = [(m, a) for m, a in zip(eq.mass_matrix.row(i), accelerations, strict=True) if m != 0]
        right: list[Any] = []
        for path, term in contributions:
            found, plain = _lifted(eq, read, term, path, "f")
            aside += found
            right += [] if plain == 0 else _parts(read, plain)
        rows.append(Line(read.products(left) if left else Num("0"), read.terms(right)))
    return Section("Angle form", (*rows, *aside))


def _parts(read: Reader, term: Any) -> list[Any]:
    """What one part contributes: one term, or a sum of few symbols term by term."""
    parts = read.sorted_terms(term)
    positive = [x for x in parts if not x.could_extract_minus_sign()]
    return [*positive, *(x for x in parts if x.could_extract_minus_sign())]


def _lifted(eq: Written, read: Reader, expr: Any, path: str, letter: str) -> tuple[list[Line], Any]:
    """Cases within an expression as lines of their own, by names; and the expression over these names."""
    lines: list[Line] = []
    while inner := [p for p in expr.atoms(sp.Piecewise) if p != expr and not _is_size(p)]:
        cases = min(inner, key=lambda p: (sp.count_ops(p), sp.default_sort_key(p)))
        number = 1 + sum(name.letter == letter and name.owner == owners(eq.kinds)[path] for name in read.names.values())
        symbol = sp.Symbol(f"{letter}{number}_{path}_case", real=True)
        read.names[symbol] = Name(letter, str(number), owners(eq.kinds)[path])  # type: ignore[index]
        read.order[symbol] = max((read.order.get(x, -1) for x in cases.free_symbols), default=-1)  # type: ignore[index]
        lines.append(Line(read.read(symbol), read.read(cases)))
        expr = expr.xreplace({cases: symbol})
    return lines, expr


def _is_size(cases: Any) -> bool:
    """Whether cases are the size of something."""
    rows = cases.args
    return len(rows) == 2 and rows[0][0] == -rows[1][0]


def ties(eq: Written) -> Section | None:
    """Angles that follow from others through ratios and planetary sets."""
    read = reader(eq)
    lines = tuple(Line(read.read(symbol), read.read(angle)) for symbol, angle in eq.ties.items())
    return Section("Kinematics", lines) if lines else None


def parts(eq: Written) -> dict[str, Section]:
    """What each part of the train introduces, in the order of the train."""
    found = ((path, kind, tuple(part(eq, path))) for path, kind in eq.kinds.items())
    return {path: Section(f"{path} ({kind})", lines) for path, kind, lines in found if lines}


def part(eq: Written, path: str) -> Iterator[Line]:
    """Lines of one part: definitions, cases of its friction and stops, rates of its states."""
    read = reader(eq)
    for symbol, expr in eq.definitions.items():
        if eq.owners.get(symbol) == path and not (eq.names[symbol].dots and base(symbol) in eq.definitions):
            lines, plain = _lifted(eq, read, expr, path, "p")
            yield from lines
            yield Line(read.read(symbol), read.read(plain))
    for constraint in eq.switched_constraints:
        if eq.owners.get(constraint.torque) == path:
            yield from _lines(read, in_order([constraint], eq.used() - counters(eq)))
    for symbol, rate in eq.states.items():
        if eq.owners.get(symbol) == path and symbol not in counters(eq) and symbol not in eq.held:
            lines, plain = _lifted(eq, read, rate, path, "p")
            yield from lines
            yield Line(Sym(read.name(symbol).rate()), read.read(plain))
    for symbol, value in eq.held.items():
        if eq.owners.get(symbol) == path:
            taken = Row((read.read(symbol), Op("="), read.read(value)))
            yield Line(None, Row((Words("taken as it begins, and held: "), taken)))


def counters(eq: Written) -> set[Any]:
    """States that only count along with friction (a relative angle) and move nothing, and the symbols of their modes."""
    modes = {x: c for c in eq.switched_constraints for x in c.shown}
    read = {x for e in [*eq.forcing, *eq.definitions.values()] for x in e.free_symbols}
    read |= {x for c in eq.switched_constraints for e in c.expressions() for x in e.free_symbols}
    found: set[Any] = set(eq.unread)
    for symbol, rate in eq.states.items():
        others = {x for s, e in eq.states.items() if s != symbol for x in e.free_symbols}
        if symbol not in read | others and rate.free_symbols & set(modes):
            found |= {symbol, *(x for x in rate.free_symbols & set(modes) if x not in read)}
    return found


def base(symbol: Any) -> Any:
    """What a symbol of this name is the rate of, None where it is none."""
    stem = symbol.name.split("'_", 1)
    return sp.Symbol("_".join(stem), real=True) if len(stem) == 2 else None


def _lines(read: Reader, found: Iterable[Any]) -> Iterator[Line]:
    """Equations and sentences as lines."""
    for one in found:
        if isinstance(one, Sentence):
            yield Line(None, Row(tuple(Words(x) if isinstance(x, str) else _said(read, x) for x in one.parts)))
        else:
            yield Line(read.read(one.lhs), read.read(one.rhs))


def _said(read: Reader, expr: Any) -> Any:
    """An expression or equation within a sentence."""
    if isinstance(expr, sp.Equality):
        return Row((read.read(expr.lhs), Op("="), read.read(expr.rhs)))
    return read.read(expr)


def others(eq: Written) -> Section | None:
    """States that belong to no part: angles of which only the speed is prescribed."""
    read = reader(eq)
    lines = tuple(
        Line(Sym(read.name(symbol).rate()), read.read(rate))
        for symbol, rate in eq.states.items()
        if symbol not in eq.owners
    )
    return Section("Prescribed", lines) if lines else None


def active(eq: Written) -> Section | None:
    """The constraints that are active, all together."""
    if not any(c.kind in ("friction", "stop") for c in eq.switched_constraints):
        return None

    def letter(text: str, dots: int = 0) -> Sym:
        return Sym(Name(text, "", "", dots))

    G, M, v, f, force = letter("G"), letter("M"), letter("v"), letter("f"), letter("λ")
    transposed, inverse = Power(G, letter("T")), Power(M, Num("-1"))
    said = [
        Row((
            Words("Rows of "), G, Words(": the slips (rates of the gaps) of all that is stuck (closed), over the speeds "), v,
            Words(". While they are active "), Row((Times((G, v)), Op("="), Num("0"))),
            Words(" holds, and their forces are "),
            Row((
                force, Op("="), Op("neg"),
                Times((
                    Power(_round(Times((G, inverse, transposed))), Num("-1")),
                    _round(Row((Times((G, inverse, f)), Op("+"), Times((letter("G", 1), v))))),
                )),
            )),
            Words(" with "), f, Words(" the right sides above without them, each within its limits."),
        ))
    ]  # fmt: skip
    return Section("Active constraints", tuple(Line(None, row) for row in said))


def _round(inner: Any) -> Any:
    return Fence("(", ")", inner)


def relative(eq: Written) -> Iterator[Section]:
    """Relative coordinates, their equations, and what reads otherwise in them."""
    equations = eq.relative_form()
    if not equations:
        return
    read = reader(eq)
    yield Section("Relative coordinates", tuple(Line(read.read(x), read.read(e)) for x, e in eq.coordinates.items()))
    yield Section("Relative form", tuple(Line(read.read(e.lhs), read.read(e.rhs)) for e in equations))
    absolute = {*eq.q, *eq.v}
    changed = tuple(
        Line(read.read(e.lhs), read.read(e.rhs))
        for e in eq.relative_definitions()
        if eq.definitions[e.lhs].free_symbols & absolute and e.lhs not in eq.coordinates and not _is_rate(eq, e)
    )
    if changed:
        yield Section("In relative coordinates", changed)


def _is_rate(eq: Written, equation: Any) -> bool:
    return bool(eq.names[equation.lhs].dots)


def functions(eq: Written) -> Section | None:
    """Functions that a reader may not know."""
    exprs = [*eq.forcing, *eq.definitions.values(), *eq.states.values()]
    x, lines = Sym(Name("x")), []
    zero, one = Num("0"), Num("1")
    if any(e.has(sp.Heaviside) for e in exprs):
        lines.append(Line(Call(Words("H"), (x,)), Cases(((one, Row((x, Op(">="), zero))), (zero, None)))))
    if any(e.has(sp.frac) for e in exprs):
        lines.append(Line(Call(Words("frac"), (x,)), Row((x, Op("-"), Fence("⌊", "⌋", x)))))
    if any(e.has(InverseInvolute) for e in exprs):
        back = Call(Words("arcinv"), (x,))
        lines.append(Line(Row((Call(Words("tan"), (back,)), Op("-"), back)), x))
    if any(e.has(RestitutionDamping) for e in exprs):
        e = sp.Symbol("e", real=True)
        read, a = Reader({e: Name("e")}), RestitutionDamping(e)
        lines.append(Line(read.read(a * (1 + e)), read.read(sp.log((1 + a) / (1 - a * e)))))
    return Section("Functions", tuple(lines)) if lines else None


def nomenclature(eq: Written, shown: set[Any]) -> Nomenclature:
    """The symbols of these, in the order: coordinates, states, what is defined, parameters, tables."""
    ordered = [*eq.q, *eq.ties, *eq.coordinates, *eq.states, *eq.definitions, *eq.names]
    found, unseen = {}, counters(eq)
    for symbol in dict.fromkeys(ordered):
        if symbol in shown - unseen and symbol in eq.entries and not eq.names[symbol].dots:
            found[symbol] = eq.names[symbol], eq.entries[symbol]
    return Nomenclature(tuple(found.values()))
