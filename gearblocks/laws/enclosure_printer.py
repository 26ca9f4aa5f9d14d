"""C text of sympy expressions in interval arithmetic: calls of gb_enclosure.h over a piece of a step.

    value and rate of f(x, p): gb_enclosed_f(x), where x moves along the step and p does not

What does not move is printed as a number, by printer.py. Knows nothing of what a symbol stands for.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from gearblocks.laws.functions import EllipseLead, Table2At, TableAt
from gearblocks.laws.printer import c_text

_FUNCTIONS = {
    sp.sin: "sin", sp.cos: "cos", sp.tan: "tan", sp.asin: "asin", sp.atan: "atan", sp.exp: "exp", sp.log: "log",
    sp.sinh: "sinh", sp.cosh: "cosh", sp.tanh: "tanh", sp.atan2: "atan2", sp.Heaviside: "heaviside", sp.floor: "floor",
    sp.frac: "fraction",
}  # fmt: skip
"""Functions with an enclosure of their own."""


class EnclosureError(Exception):
    """An expression with a function that has no enclosure."""


class _Printer:
    """moving: C of the symbols that are enclosures; names: C of all others, numbers and tables."""

    def __init__(self, moving: Mapping[Any, str], names: Mapping[Any, str]) -> None:
        self.moving, self.names = moving, names

    def number(self, e: Any) -> str:
        """C of an expression that does not move."""
        return c_text(e, self.names)

    def moves(self, e: Any) -> bool:
        return any(x in self.moving for x in e.free_symbols)

    def text(self, e: Any) -> str:
        """C of an enclosure."""
        if not self.moves(e):
            return f"gb_enclosed_number({self.number(e)})"
        if e.is_Symbol:
            return self.moving[e]
        if e.is_Add or e.is_Mul:
            return self._chain(e)
        if e.is_Pow:
            return self._power(e)
        if isinstance(e, TableAt):
            return self._table(e)
        if isinstance(e, Table2At):
            return self._table2(e)
        if isinstance(e, EllipseLead):
            return self.text(e.written_out())
        if isinstance(e, sp.acos):
            return self.text(sp.pi / 2 - sp.asin(e.args[0]))
        if type(e) in _FUNCTIONS:
            n = 2 if isinstance(e, sp.atan2) else 1
            return f"gb_enclosed_{_FUNCTIONS[type(e)]}({', '.join(self.text(a) for a in e.args[:n])})"
        raise EnclosureError(str(type(e).__name__))

    def _chain(self, e: Any) -> str:
        """A sum or product: what moves by twos, then what does not."""
        still = e.func(*(a for a in e.args if not self.moves(a)))
        moving = [self.text(a) for a in e.args if self.moves(a)]
        text = moving[0]
        for other in moving[1:]:
            text = f"gb_enclosed_{'add' if e.is_Add else 'mul'}({text}, {other})"
        if still == (0 if e.is_Add else 1):
            return text
        return f"gb_enclosed_{'shift' if e.is_Add else 'scale'}({text}, {self.number(still)})"

    def _power(self, e: Any) -> str:
        base, exponent = e.as_base_exp()
        if exponent.is_Integer:
            return f"gb_enclosed_power({self.text(base)}, {int(exponent)})"
        if not self.moves(exponent):
            return f"gb_enclosed_root({self.text(base)}, {self.number(exponent)})"
        return self.text(sp.exp(exponent * sp.log(base)))

    def _table(self, e: Any) -> str:
        table, x, order, *mode = e.args
        if mode:
            return f"gb_enclosed_table(&{self.names[table]}, {self.number(mode[0])}, {self.text(x)}, {int(order)})"
        return f"gb_enclosed_table_at(&{self.names[table]}, {self.text(x)}, {int(order)})"

    def _table2(self, e: Any) -> str:
        table, x, y, by_x, by_y, *modes = e.args
        if not modes:
            raise EnclosureError("Table2At across cells")
        cell = ", ".join(self.number(m) for m in modes)
        orders = f"{int(by_x)}, {int(by_y)}"
        return f"gb_enclosed_table2(&{self.names[table]}, {cell}, {self.text(x)}, {self.text(y)}, {orders})"


def enclosure_text(expr: Any, moving: Mapping[Any, str], names: Mapping[Any, str]) -> str:
    """C of the enclosure of an expression; EnclosureError where a function in it has none."""
    return _Printer(moving, names).text(sp.sympify(expr))


__all__ = ["EnclosureError", "enclosure_text"]
