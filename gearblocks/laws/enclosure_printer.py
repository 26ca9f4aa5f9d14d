"""C text of sympy expressions in interval arithmetic: calls of gb_enclosure.h over a piece of a step.

    value and rate of f(x, p): gb_enclosed_f(x), where x moves along the step and p does not

What does not move is printed as a number, by printer.py; what several expressions of one function have in common is enclosed
once (hash consing). Knows nothing of what a symbol stands for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import sympy as sp

from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import EllipseLead, Table2At, TableAt, Where
from gearblocks.laws.printer import c_text

_FUNCTIONS = {
    sp.sin: "sin", sp.cos: "cos", sp.tan: "tan", sp.asin: "asin", sp.atan: "atan", sp.exp: "exp", sp.log: "log",
    sp.sinh: "sinh", sp.cosh: "cosh", sp.tanh: "tanh", sp.atan2: "atan2", sp.Heaviside: "heaviside", sp.floor: "floor",
    sp.frac: "fraction",
}  # fmt: skip
"""Functions with an enclosure of their own."""

Moving = Mapping[Any, "str | tuple[str, str]"]

_IN_A_ROW = 50
"""Enclosures that are added or multiplied one after the other."""


class EnclosureError(Exception):
    """An expression with a function that has no enclosure."""


class SharedEnclosure(NamedTuple):
    """A local of the function: its C type, name and text."""

    kind: str
    name: str
    text: str


@dataclass(slots=True, eq=False)
class _Call:
    """A call in C, or with no arguments a name; one object for all calls that are equal. uses: where it stands."""

    head: str
    args: tuple[_Call | str, ...]
    kind: str = "gb_enclosure"
    uses: int = 0


class _Printer:
    """moving: C of the symbols that are enclosures, or of an enclosure and its factor; names: C of all others, numbers
    and tables."""

    def __init__(self, moving: Moving, names: Mapping[Any, str]) -> None:
        self.moving, self.names = moving, names
        self._known: dict[tuple[Any, ...], _Call] = {}
        self._made: dict[Any, _Call] = {}

    def number(self, e: Any) -> str:
        """C of an expression that does not move."""
        return c_text(e, self.names)

    def moves(self, e: Any) -> bool:
        return any(x in self.moving for x in symbols_in(e))

    def enclosed(self, e: Any) -> _Call:
        """The enclosure of an expression."""
        if e not in self._made:
            self._made[e] = self._enclosed(e)
        return self._made[e]

    def _enclosed(self, e: Any) -> _Call:
        if not self.moves(e):
            return self._call("gb_enclosed_number", self.number(e))
        if e.is_Symbol:
            at = self.moving[e]
            return self._call(at) if isinstance(at, str) else self._call("gb_enclosed_scale", self._call(at[0]), at[1])
        if e.is_Add or e.is_Mul:
            return self._chain(e)
        if e.is_Pow:
            return self._power(e)
        if isinstance(e, (sp.sin, sp.cos)):
            return self._wave(e)
        if isinstance(e, TableAt):
            return self._table(e)
        if isinstance(e, Table2At):
            return self._table2(e)
        if isinstance(e, Where) and not self.moves(e.args[0]):
            return self._call("gb_enclosed_where", self.number(e.args[0]), self.enclosed(e.args[1]))
        if isinstance(e, EllipseLead):
            return self.enclosed(e.written_out())
        if isinstance(e, sp.acos):
            return self.enclosed(sp.pi / 2 - sp.asin(e.args[0]))
        if type(e) in _FUNCTIONS:
            n = 2 if isinstance(e, sp.atan2) else 1
            return self._call(f"gb_enclosed_{_FUNCTIONS[type(e)]}", *(self.enclosed(a) for a in e.args[:n]))
        raise EnclosureError(str(type(e).__name__))

    def _call(self, head: str, *args: _Call | str, kind: str = "gb_enclosure") -> _Call:
        key = (head, *(a if isinstance(a, str) else id(a) for a in args))
        if key not in self._known:
            self._known[key] = _Call(head, args, kind)
            for a in args:
                if isinstance(a, _Call):
                    a.uses += 1
        return self._known[key]

    def _chain(self, e: Any) -> _Call:
        """A sum or product: what moves by twos, then what does not."""
        still = e.func(*(a for a in e.args if not self.moves(a)))
        moving = list(map(self.enclosed, filter(self.moves, e.args)))
        found = self._joined("gb_enclosed_add" if e.is_Add else "gb_enclosed_mul", moving)
        if still == (0 if e.is_Add else 1):
            return found
        return self._call(f"gb_enclosed_{'shift' if e.is_Add else 'scale'}", found, self.number(still))

    def _joined(self, head: str, parts: list[_Call]) -> _Call:
        """One after the other; of many each half by itself, as calls that are nested deeper are no longer printed."""
        if len(parts) > _IN_A_ROW:
            half = len(parts) // 2
            parts = [self._joined(head, parts[:half]), self._joined(head, parts[half:])]
        found = parts[0]
        for other in parts[1:]:
            found = self._call(head, found, other)
        return found

    def _power(self, e: Any) -> _Call:
        base, exponent = e.as_base_exp()
        if exponent.is_Integer:
            return self._call("gb_enclosed_power", self.enclosed(base), str(int(exponent)))
        if not self.moves(exponent):
            return self._call("gb_enclosed_root", self.enclosed(base), self.number(exponent))
        return self.enclosed(sp.exp(exponent * sp.log(base)))

    def _wave(self, e: Any) -> _Call:
        """Sine and cosine of one phase are enclosed together: each is the other's derivative."""
        phase = self.enclosed(e.args[0])
        waves = self._call("gb_enclosed_waves", phase, kind="gb_waves")
        return self._call(f"gb_enclosed_{_FUNCTIONS[type(e)]}", phase, waves)

    def _table(self, e: Any) -> _Call:
        table, x, order, *mode = e.args
        name, at, number = f"&{self.names[table]}", self.enclosed(x), str(int(order))
        if mode:
            return self._call("gb_enclosed_table", name, self.number(mode[0]), at, number)
        return self._call("gb_enclosed_table_at", name, at, number)

    def _table2(self, e: Any) -> _Call:
        table, x, y, by_x, by_y, *modes = e.args
        if not modes:
            raise EnclosureError("Table2At across cells")
        cell, orders = [self.number(m) for m in modes], (str(int(by_x)), str(int(by_y)))
        at = self.enclosed(x), self.enclosed(y)
        return self._call("gb_enclosed_table2", f"&{self.names[table]}", *cell, *at, *orders)


class _Text:
    """C of calls; those that stand in several places are locals, in the order in which they are needed."""

    def __init__(self, *, shares: bool) -> None:
        self.shares = shares
        self.locals: list[SharedEnclosure] = []
        self._names: dict[int, str] = {}

    def of(self, call: _Call | str) -> str:
        if isinstance(call, str):
            return call
        if not call.args:
            return call.head
        if id(call) not in self._names:
            text = f"{call.head}({', '.join(self.of(a) for a in call.args)})"
            if not self.shares or call.uses < 2:
                return text
            word = "waves" if call.kind == "gb_waves" else "part"
            name = f"{word}{sum(x.kind == call.kind for x in self.locals)}"
            self.locals.append(SharedEnclosure(call.kind, name, text))
            self._names[id(call)] = name
        return self._names[id(call)]


def enclosure_texts(
    exprs: Sequence[Any], moving: Moving, names: Mapping[Any, str]
) -> tuple[list[SharedEnclosure], list[str]]:  # fmt: skip
    """C of the enclosures of expressions, and what they share; EnclosureError where a function in them has none."""
    printer, text = _Printer(moving, names), _Text(shares=True)
    calls = [printer.enclosed(sp.sympify(e)) for e in exprs]
    for call in calls:
        call.uses += 1
    texts = [text.of(call) for call in calls]
    return text.locals, texts


def enclosure_text(expr: Any, moving: Moving, names: Mapping[Any, str]) -> str:
    """C of the enclosure of one expression; EnclosureError where a function in it has none."""
    return _Text(shares=False).of(_Printer(moving, names).enclosed(sp.sympify(expr)))


__all__ = ["EnclosureError", "SharedEnclosure", "enclosure_text", "enclosure_texts"]
