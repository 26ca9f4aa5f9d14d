"""C text of sympy expressions; sympy becomes text here and nowhere else.

Knows nothing of statements, nor of what a symbol stands for.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from functools import cache
from typing import Any

import sympy as sp
from sympy.printing.c import C99CodePrinter

_OWN_FUNCTIONS = {
    "sin": "gb_sin",
    "cos": "gb_cos",
    "atan": "gb_atan",
}  # the same bits on every platform, and vectorisable


class _CPrinter(C99CodePrinter):  # type: ignore[misc]  # sympy carries no types
    """Expressions of a law in C; `names` gives the text of every symbol, and of subexpressions that have a name."""

    math_macros: Mapping[Any, str] = {}  # none; as a setting sympy would make all of its own first

    def __init__(self) -> None:
        super().__init__({"user_functions": _OWN_FUNCTIONS})
        self._names: Mapping[Any, str] = {}

    def knowing(self, names: Mapping[Any, str]) -> _CPrinter:
        """This printer with these names; one from scratch takes longer than most expressions."""
        printer = copy(self)
        printer._names = names
        return printer

    def _handle_UnevaluatedExpr(self, expr: Any) -> Any:
        return expr  # laws have none, and sympy would walk through all of each to find that

    def _format_code(self, lines: list[str]) -> list[str]:
        return lines if len(lines) == 1 else list(super()._format_code(lines))

    def _print(self, expr: Any, **kwargs: Any) -> str:
        name = self._names.get(expr)
        return str(super()._print(expr, **kwargs)) if name is None else name

    def parenthesize(self, item: Any, level: int, strict: bool = False) -> str:
        name = self._names.get(item)
        return str(super().parenthesize(item, level, strict)) if name is None else name

    def _print_Symbol(self, expr: Any) -> str:
        return self._names[expr]

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:  # noqa: ARG002  sympy's signature
        base, exponent = expr.as_base_exp()
        if exponent.is_Integer and 1 < abs(exponent) <= 4:
            text = "*".join(
                [self.parenthesize(base, sp.printing.precedence.PRECEDENCE["Mul"] + 1)] * abs(int(exponent))
            )
            return f"({text})" if exponent > 0 else f"(1.0/({text}))"
        return str(super()._print_Pow(expr))

    def _print_Heaviside(self, expr: Any) -> str:
        return f"gb_unit_step({self._print(expr.args[0])})"

    def _print_frac(self, expr: Any) -> str:
        return f"gb_fraction({self._print(expr.args[0])})"

    def _print_TableAt(self, expr: Any) -> str:
        table, x, order, *mode = expr.args
        where = self._print(mode[0]) if mode else f"gb_table_segment(&{self._print(table)}, {self._print(x)})"
        return f"gb_table_value(&{self._print(table)}, {where}, {self._print(x)}, {int(order)})"

    def _print_Table2At(self, expr: Any) -> str:
        table, x, y, by_x, by_y, *modes = expr.args
        name, at = self._print(table), [self._print(x), self._print(y)]
        where = [self._print(m) for m in modes] or [
            f"gb_table_segment({name}.{axis}, {text})" for axis, text in zip("xy", at, strict=True)
        ]
        return f"gb_table2_value(&{name}, {', '.join([*where, *at])}, {int(by_x)}, {int(by_y)})"

    def _print_Where(self, expr: Any) -> str:
        return f"gb_where({self._print(expr.args[0])}, {self._print(expr.args[1])})"

    def _print_EllipseLead(self, expr: Any) -> str:
        return str(self._print(expr.written_out()))

    def _print_SignedPower(self, expr: Any) -> str:
        x, n, order = expr.args
        return f"gb_signed_power({self._print(x)}, {self._print(n)}, {int(order)})"

    def _print_RestitutionDamping(self, expr: Any) -> str:
        return f"gb_restitution_damping({self._print(expr.args[0])})"

    def _print_InverseInvolute(self, expr: Any) -> str:
        return f"gb_inverse_involute({self._print(expr.args[0])})"

    def _print_Integer(self, expr: Any) -> str:
        return f"{int(expr)}.0"

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_Rational(self, expr: Any) -> str:
        return repr(float(expr))

    def _print_NumberSymbol(self, expr: Any) -> str:
        return repr(float(expr))

    _print_Half = _print_Rational
    _print_One = _print_Integer
    _print_NegativeOne = _print_Integer
    _print_Zero = _print_Integer
    _print_Pi = _print_NumberSymbol
    _print_Exp1 = _print_NumberSymbol


def c_text(expr: Any, names: Mapping[Any, str]) -> str:
    """C for an expression over doubles."""
    return str(_c_printer().knowing(names).doprint(sp.sympify(expr)))


@cache
def _c_printer() -> _CPrinter:
    return _CPrinter()


def plain_text(expr: Any) -> str:
    """One line of plain text for an expression or equation."""
    if isinstance(expr, sp.Equality):
        return f"{sp.sstr(_decimal(expr.lhs))} = {sp.sstr(_decimal(expr.rhs))}"
    return str(sp.sstr(_decimal(expr)))


def _decimal(expr: Any) -> Any:
    """The expression with decimals in place of long fractions: those stand for ratios given as decimal numbers."""
    long = [x for x in sp.sympify(expr).atoms(sp.Rational) if x.q > 10**6]
    return sp.sympify(expr).xreplace({x: sp.Float(float(x)) for x in long}) if long else expr


__all__ = ["c_text", "plain_text"]
