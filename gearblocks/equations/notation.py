"""From sympy to mathematics as it is set:

    read(expression, names) -> a tree of nodes (nodes.py)

Knows nothing of trains, nor of characters.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction as Exact
from typing import Any, final

import sympy as sp

from gearblocks.equations.names import Name, plain
from gearblocks.equations.nodes import Call, Cases, Fence, Fraction, Node, Num, Op, Power, Root, Row, Sym, Times, Words
from gearblocks.laws.functions import (
    ContactSide,
    DeadZone,
    EllipseLead,
    InverseInvolute,
    RestitutionDamping,
    SignedPower,
    Table2At,
    TableAt,
)

_FUNCTIONS = {
    "sin": "sin", "cos": "cos", "tan": "tan", "atan": "arctan", "asin": "arcsin", "acos": "arccos", "exp": "exp",
    "log": "ln", "tanh": "tanh", "sinh": "sinh", "cosh": "cosh", "asinh": "arsinh", "sign": "sgn", "Max": "max",
    "Min": "min", "atan2": "atan2", "frac": "frac", "Heaviside": "H", "re": "Re", "Mod": "mod",
}  # fmt: skip
_RELATIONS = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


@final
@dataclass(frozen=True, slots=True)
class Reader:
    """From sympy to notation; names: of its symbols; order: of those that move, by which terms and factors are put in a row,
    behind what does not move in a product, before it in a sum."""

    names: Mapping[Any, Name]
    order: Mapping[Any, int] = dataclasses.field(default_factory=dict)

    def name(self, symbol: Any) -> Name:
        """The name of a symbol, its rate or the rate of that."""
        if symbol in self.names:
            return self.names[symbol]
        base = sp.Symbol(symbol.name.rstrip("'"), real=True)
        dots = len(symbol.name) - len(base.name)
        return self.names[base].rate(dots) if dots and base in self.names else plain(symbol.name)

    def read(self, expr: Any) -> Node:
        """The notation of an expression or a relation."""
        expr = _by_pi(sp.sympify(expr))
        if expr.is_Symbol:
            return Sym(self.name(expr))
        if expr.is_Relational or expr.func in (sp.And, sp.Or, sp.Not):
            return self._condition(expr)
        if expr.is_number and not expr.has(sp.Function, sp.pi) and expr.is_real and (expr.is_Rational or expr.is_Float):
            return _number(expr)
        kind = next((k for k in type(expr).__mro__ if k in _READERS), None)
        return self._function(expr) if kind is None else _READERS[kind](self, expr)

    def terms(self, terms: Iterable[Any]) -> Node:
        """A sum in the order that is given."""
        items: list[Any] = []
        for term in terms:
            minus, size = _sign(term)
            if items:
                items.append(Op("-" if minus else "+"))
            elif minus:
                items.append(Op("neg"))
            inner = self.read(size)
            items.append(Fence("(", ")", inner) if minus and size.is_Add else inner)
        if not items:
            return Num("0")
        return items[0] if len(items) == 1 else Row(tuple(items))

    def products(self, pairs: Iterable[tuple[Any, Any]]) -> Node:
        """The sum of one times another, (J1 + J2) φ'', where a sum stands first."""
        items: list[Any] = []
        for one, other in pairs:
            minus, size = _sign(one)
            items += [Op("-" if minus else "+")] if items else [Op("neg")] * minus
            items.append(Times((self.factor(size), self.read(other))) if size.is_Add else self.read(size * other))
        return items[0] if len(items) == 1 else Row(tuple(items))

    def sorted_terms(self, expr: Any) -> list[Any]:
        """The terms of a sum: numbers, what moves, in its order, what does not."""
        return sorted(sp.Add.make_args(expr) if not expr.is_Add else expr.as_ordered_terms(), key=self._place)

    def _place(self, term: Any) -> tuple[int, int]:
        if term.is_number:
            return 0, 0
        places = [self.order[x] for x in term.free_symbols if x in self.order]
        return (1, max(places)) if places else (2, 0)

    # -- kinds of expressions -----------------------------------------------------------------------------------------

    def _sum(self, expr: Any) -> Node:
        factors = (x for term in expr.args for x in sp.Mul.make_args(term))
        leads = {x: x.written_out() for x in factors if isinstance(x, EllipseLead)}  # which bring a sign of their own
        if leads:
            return self.read(expr.xreplace(leads))
        ordered = self.sorted_terms(expr)
        first = next((i for i, term in enumerate(ordered) if not _sign(term)[0]), 0)
        return self.terms([ordered[first], *ordered[:first], *ordered[first + 1 :]])

    def _product(self, expr: Any) -> Node:
        leads = {
            x: x.written_out() for x in expr.args if isinstance(x, EllipseLead)
        }  # which bring a number of their own
        if leads:
            return self.read(expr.xreplace(leads))
        minus, size = _sign(expr)
        if minus:
            return Row((Op("neg"), self.factor(size)))
        number, rest = size.as_coeff_Mul()
        top: list[Any] = []
        bottom: list[Any] = []
        for factor in sp.Mul.make_args(rest):
            exponent = factor.as_base_exp()[1]
            below = exponent.is_number and exponent.is_negative and factor.func is not sp.exp
            (bottom if below else top).append(1 / factor if below else factor)
        exact = exactly(number)
        if not exact:
            top = [number, *top] if float(number) != 1 else top
        elif bottom or (exact.numerator == 1 and len(top) == 1):
            top = [sp.Integer(exact.numerator), *top] if exact.numerator != 1 else top
            bottom = [sp.Integer(exact.denominator), *bottom] if exact.denominator != 1 else bottom
        elif exact != 1:
            return Times((_ratio(exact), *self._factors(top)))
        if not bottom:
            return self._times(top)
        return Fraction(self._times(top), self._times(bottom))

    def _times(self, factors: list[Any]) -> Node:
        if not factors:
            return Num("1")
        return self.read(factors[0]) if len(factors) == 1 else Times(tuple(self._factors(factors)))

    def _factors(self, factors: list[Any]) -> list[Node]:
        return [self.factor(x) for x in sorted(factors, key=self._rank)]

    def _rank(self, factor: Any) -> tuple[int, int]:
        base = factor.as_base_exp()[0]
        if factor.is_number:
            return 0, 0
        if base.is_Symbol:
            return (2, self.order[base]) if base in self.order else (1, 0)
        return (4 if base.is_Add else 3), 0

    def factor(self, expr: Any) -> Node:
        """An expression as a factor of a product."""
        node = self.read(expr)
        if isinstance(node, (Row, Cases)):
            return Fence("(", ")", node)
        return node

    def _power(self, expr: Any) -> Node:
        base, exponent = expr.as_base_exp()
        if exponent.is_number and float(exponent) == 0.5:
            return Root(self.read(base))
        if exponent.is_number and exponent.is_negative:
            return Fraction(Num("1"), self.read(1 / expr))
        inner = self.read(base)
        if not isinstance(inner, (Sym, Num)):
            inner = Fence("(", ")", inner)
        return Power(inner, self.read(exponent))

    def _function(self, expr: Any) -> Node:
        name = _FUNCTIONS.get(type(expr).__name__, type(expr).__name__)
        arguments = expr.args[:1] if name == "H" else expr.args
        return self._call(Words(name), arguments)

    def _call(self, function: Node, arguments: Iterable[Any], primes: int = 0) -> Node:
        return Call(function, tuple(self.read(x) for x in arguments), primes)

    def _table(self, expr: Any) -> Node:
        return self._call(Sym(self.name(expr.args[0])), expr.args[1:2], int(expr.args[2]))

    def _table2(self, expr: Any) -> Node:
        name, by = self.name(expr.args[0]), "x" * int(expr.args[3]) + "y" * int(expr.args[4])
        return self._call(Sym(Name(name.letter, f"{name.number}{by}", name.owner)), expr.args[1:3])

    def _piecewise(self, expr: Any) -> Node:
        rows = [(value, condition) for value, condition in expr.args]
        if len(rows) == 2 and rows[0][0] == -rows[1][0] and rows[0][1] in (rows[0][0] >= 0, rows[0][0] > 0):
            return Fence("|", "|", self.read(rows[0][0]))
        return Cases(tuple((self.read(v), None if c == True else self.read(c)) for v, c in rows))  # noqa: E712

    def _condition(self, expr: Any) -> Node:
        if expr.func is sp.Not:
            return Row((Words("not"), self._condition(expr.args[0])))
        if expr.func in (sp.And, sp.Or):
            word = "and" if expr.func is sp.And else "or"
            items: list[Any] = []
            for part in expr.args:
                inner = [Fence("(", ")", self._condition(part))] if part.func is sp.And else self._relation(part)
                items += [*([Op(word)] if items else []), *inner]
            return Row(tuple(items))
        return Row(tuple(self._relation(expr)))

    def _relation(self, expr: Any) -> list[Any]:
        if not expr.is_Relational:
            return [self._condition(expr)]
        left, sign, right = expr.lhs, {"==": "=", "!=": "≠"}.get(expr.rel_op, expr.rel_op), expr.rhs
        if sign in _RELATIONS and not self._moves(left) and self._moves(right):
            left, sign, right = right, _RELATIONS[sign], left
        if sign in _RELATIONS and self._moves(left) and not left.is_Add and left.could_extract_minus_sign():
            left, sign, right = -left, _RELATIONS[sign], -right
        return [self.read(left), Op(sign), self.read(right)]

    def _moves(self, expr: Any) -> bool:
        return any(x in self.order for x in expr.free_symbols)


def _fenced(left: str, right: str) -> Callable[[Reader, Any], Node]:
    return lambda reader, expr: Fence(left, right, reader.read(expr.args[0]))


_READERS: dict[Any, Callable[[Reader, Any], Node]] = {
    sp.Add: Reader._sum,
    sp.Mul: Reader._product,
    sp.Pow: Reader._power,
    sp.Abs: _fenced("|", "|"),
    sp.floor: _fenced("⌊", "⌋"),
    sp.Piecewise: Reader._piecewise,
    sp.Derivative: lambda reader, expr: Fraction(
        *(Sym(reader.name(x).change()) for x in (expr.expr, expr.variables[0]))
    ),
    TableAt: Reader._table,
    Table2At: Reader._table2,
    DeadZone: lambda reader, expr: reader.read(expr.spelled_out()),
    ContactSide: lambda reader, expr: reader.read(
        sp.Piecewise((1, expr.args[0] > expr.args[1]), (-1, expr.args[0] < -expr.args[1]), (0, True))
    ),
    SignedPower: lambda reader, expr: reader.read(expr.spelled_out()),
    EllipseLead: lambda reader, expr: reader.read(expr.written_out()),
    InverseInvolute: lambda reader, expr: reader._call(Words("arcinv"), expr.args),
    RestitutionDamping: lambda reader, expr: reader._call(Words("a"), expr.args),
    type(sp.pi): lambda _reader, _expr: Sym(Name("π")),
    type(sp.oo): lambda _reader, _expr: Sym(Name("∞")),
    type(sp.E): lambda _reader, _expr: Sym(Name("e")),
}


def _by_pi(expr: Any) -> Any:
    """The expression, a factor of many digits written as a fraction of pi, or over pi, where it is one: w t/(2 π)."""
    if not (expr.is_Mul or expr.is_Float):
        return expr
    factor, rest = expr.as_coeff_Mul()
    if not factor.is_Float or len(f"{float(factor):.17g}") < _MANY_DIGITS:
        return expr
    value = float(factor)
    for power in (1, -1):
        turns = value / math.pi**power
        ratio = Exact(turns).limit_denominator(_DENOMINATOR)
        if ratio and abs(float(ratio) - turns) <= 4e-16 * abs(turns):
            return sp.Rational(ratio.numerator, ratio.denominator) * sp.pi**power * rest
    return expr


_MANY_DIGITS, _DENOMINATOR = 14, 360
"""Of a number that may be a fraction of pi; the largest denominator of one."""


def _sign(expr: Any) -> tuple[bool, Any]:
    """Whether a minus sign stands before a term, and the term without it."""
    number, rest = sp.sympify(expr).as_coeff_Mul()
    minus = bool(number.is_real and number < 0)
    for factor in rest.args if rest.is_Mul else ():
        if factor.is_Add and all(_below(term) for term in factor.args):
            minus, rest = not minus, sp.Mul(*(-f if f is factor else f for f in rest.args))
    return minus, sp.Mul(abs(number) if number.is_real else number, rest)


def _below(term: Any) -> bool:
    number, _ = term.as_coeff_Mul()
    return bool(number.is_real and number < 0)


def exactly(number: Any) -> Exact | None:
    """A rational number in short terms, where it has some: ratios given as decimals are long fractions."""
    if not number.is_Rational:
        return None
    value = Exact(int(number.p), int(number.q))
    if value.denominator <= 10**6:
        return value
    near = value.limit_denominator(10**4)
    return near if abs(near - value) <= Exact(1, 10**15) * abs(value) else None


def _number(number: Any) -> Node:
    exact = exactly(number)
    if number.is_Rational and exact is not None:
        if exact < 0:
            return Row((Op("neg"), _ratio(-exact)))
        return _ratio(exact)
    value = float(number)
    if (of_pi := _of_pi(value)) is not None:
        return of_pi
    digits, _, power = _digits(abs(value)).partition("e")
    node: Node = Num(digits.removesuffix(".0"))
    if power:
        ten = Power(Num("10"), Num(str(int(power))))
        node = ten if digits == "1" else Times((node, Op("×"), ten))
    return Row((Op("neg"), node)) if value < 0 else node


def _digits(value: float) -> str:
    """A number with 15 digits where these end sooner: what follows is rounding (0.1 + 0.2)."""
    short = repr(float(f"{value:.15g}"))
    return short if len(short) < len(repr(value)) - 2 else repr(value)


def _of_pi(value: float) -> Node | None:
    """A number that is a short fraction of pi, such as the 2 pi f of a frequency, as that."""
    exact = Exact(value / math.pi).limit_denominator(12)
    if exact == 0 or abs(exact) > 10**6 or abs(float(exact) * math.pi - value) > 4e-16 * abs(value):
        return None
    node = Reader({}).read(sp.Rational(abs(exact.numerator), exact.denominator) * sp.pi)
    return Row((Op("neg"), node)) if value < 0 else node


def _ratio(exact: Exact) -> Node:
    if exact.denominator == 1:
        return Num(str(exact.numerator))
    return Fraction(Num(str(exact.numerator)), Num(str(exact.denominator)))
