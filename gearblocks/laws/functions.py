"""sympy functions of laws: tables, dead zones, tooth geometry, with their derivatives and their definitions for readers.

Knows nothing of how they are evaluated in C, nor of modes.
"""

from __future__ import annotations

from typing import Any

import sympy as sp

from gearblocks.geometry.involute import Functions, inverse_involute
from gearblocks.geometry.restitution import restitution_damping


class TableAt(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """A table over a quantity: TableAt(table symbol, quantity, order of the derivative[, mode])."""

    nargs = (3, 4)

    def _sympystr(self, printer: Any) -> str:
        return "{0}{2}({1})".format(*map(printer.doprint, self.args[:2]), "'" * int(self.args[2]))

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """The next derivative."""
        table, x, order, *mode = self.args
        return TableAt(table, x, order + 1, *mode)

    def _latex(self, printer: Any) -> str:
        return _table_latex(printer, self.args[1:2], self.args[2:3])


class Table2At(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """A table over two quantities: Table2At(table symbol, x, y, orders of the derivatives by x, by y[, modes of both])."""

    nargs = (5, 7)

    def _sympystr(self, printer: Any) -> str:
        name, x, y = map(printer.doprint, self.args[:3])
        orders = tuple(int(n) for n in self.args[3:5])
        return f"{name}{f'^{orders}' if any(orders) else ''}({x}, {y})"

    def fdiff(self, argindex: int = 1) -> Any:
        """The next derivative by x (argument 2) or y (argument 3)."""
        table, x, y, by_x, by_y, *modes = self.args
        return Table2At(table, x, y, by_x + (argindex == 2), by_y + (argindex == 3), *modes)

    def _latex(self, printer: Any) -> str:
        return _table_latex(printer, self.args[1:3], self.args[3:5])


def _table_latex(printer: Any, quantities: Any, orders: Any) -> str:
    """T(x, y), with the orders of its derivatives as an index where there are any."""
    index = f"^{{({', '.join(str(n) for n in orders)})}}" if any(orders) else ""
    return rf"T{index}\left({', '.join(printer.doprint(x) for x in quantities)}\right)"


class DeadZone(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """g(x) = x - b (x > b), 0, x + b (x < -b) for order 0; its integral for order -1, its slopes above."""

    nargs = 3

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """The next derivative by x."""
        x, b, order = self.args
        return DeadZone(x, b, order + 1)

    def _latex(self, printer: Any) -> str:
        name = {-1: "G", 0: "g", 1: "g'"}.get(int(self.args[2]), "g''")
        return rf"{name}\left({printer.doprint(self.args[0])}\right)"

    def spelled_out(self) -> Any:
        """The definition, for readers."""
        x, b, order = self.args
        return sp.Piecewise(
            (dead_zone_branch(x - b, order), x > b), (dead_zone_branch(x + b, order), x < -b), (0, True)
        )


def dead_zone_branch(beyond: Any, order: Any) -> Any:
    """One side of the dead zone over the deflection beyond its corner, integrated once for order -1."""
    return {-1: beyond**2 / 2, 0: beyond, 1: sp.Integer(1)}.get(int(order), sp.Integer(0))


class SignedPower(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """x abs(x)^(n - 1), n > 0, for order 0; its integral for order -1, its slopes above. It needs no switch."""

    nargs = 3

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """The next derivative by x."""
        x, n, order = self.args
        return SignedPower(x, n, order + 1)

    def _latex(self, printer: Any) -> str:
        return str(printer.doprint(self.spelled_out()))

    def spelled_out(self) -> Any:
        """The definition, for readers."""
        x, n, order = self.args
        size = sp.Abs(x)
        forms = {-1: size ** (n + 1) / (n + 1), 0: x * size ** (n - 1), 1: n * size ** (n - 1)}
        return forms.get(int(order), n * (n - 1) * x * size ** (n - 3))


class Where(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """x where the indicator m is 1, and 0 where it is 0, even if x has no value there: Where(m, x)."""

    nargs = 2

    @classmethod
    def eval(cls, m: Any, x: Any) -> Any:
        """0 of 0; the one or the other where m is a number."""
        if m.is_number and m > sp.Rational(1, 2):
            return x
        return sp.Integer(0) if x == 0 or m.is_number else None

    def _eval_derivative(self, s: Any) -> Any:
        """That of x, where m is 1."""
        m, x = self.args
        return Where(m, sp.diff(x, s))


class EllipseLead(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """2 atan(e sin x/(1 - e cos x)): by how much the mate of an ellipse that turns about its focus runs ahead."""

    nargs = 2

    @classmethod
    def eval(cls, x: Any, e: Any) -> Any:  # noqa: ARG003  sympy's signature
        """0 at 0."""
        return sp.Integer(0) if x == 0 else None

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """The derivative by x, a rational function of cos x."""
        x, e = self.args
        return 2 * e * (sp.cos(x) - e) / (1 + e**2 - 2 * e * sp.cos(x))

    def written_out(self) -> Any:
        """The definition."""
        x, e = self.args
        return 2 * sp.atan(e * sp.sin(x) / (1 - e * sp.cos(x)))

    def _eval_evalf(self, prec: int) -> Any:
        return self.written_out()._eval_evalf(prec)

    def _sympystr(self, printer: Any) -> str:
        return str(printer.doprint(self.written_out()))

    def _latex(self, printer: Any) -> str:
        return str(printer.doprint(self.written_out()))


class ContactSide(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """-1 where x < -b, +1 where x > b, else 0."""

    nargs = 2

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """0 on each side."""
        return sp.Integer(0)


class InverseInvolute(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """The angle a with tan(a) - a = y, for y >= 0."""

    nargs = 1

    @classmethod
    def eval(cls, y: Any) -> Any:
        """The number, where y is one."""
        return sp.Float(inverse_involute(float(y))) if y.is_number else None


class RestitutionDamping(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """a(e), the contact damping of a restitution; see `gearblocks.geometry.restitution.restitution_damping`."""

    nargs = 1

    @classmethod
    def eval(cls, e: Any) -> Any:
        """The number, where e is one."""
        return sp.Float(restitution_damping(float(e))) if e.is_number else None


SYMBOLS = Functions(sp.sqrt, sp.sin, sp.cos, sp.tan, sp.atan, InverseInvolute, sp.pi)
"""The functions of tooth geometry, of symbols."""
