"""The symbols that a block's physics is written in."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy as sp

from gearblocks.declare import Rate, _Declared
from gearblocks.expression import Expr, to_sympy
from gearblocks.impact import restitution_damping
from gearblocks.signals import Input, Parameter, Table
from gearblocks.tooth_geometry import Functions, inverse_involute


@dataclass(frozen=True, slots=True)
class Slot:
    """What a symbol stands for.

    role: own (a number of the block), exact, shared (a Parameter), mobility, time, input, sense, table (time-driven),
    phi, w, alpha, tau, state, coordinate, mode. of: flange, state, switch number, path, or the leaf itself.
    """

    role: str
    of: Any


LEVEL = {
    "own": 0,
    "exact": 0,
    "shared": 0,
    "mobility": 0,
    "time": 1,
    "input": 1,
}  # everything else moves with the state
CONSTANT, TIMED, MOVING = 0, 1, 2


class TableAt(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """A table over a quantity: TableAt(table symbol, quantity, order of the derivative[, mode])."""

    nargs = (3, 4)

    def fdiff(self, argindex: int = 1) -> Any:  # noqa: ARG002  sympy's signature
        """The next derivative."""
        table, x, order, *mode = self.args
        return TableAt(table, x, order + 1, *mode)


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


class ContactSide(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """-1 where x < -b, +1 where x > b, else 0."""

    nargs = 2


class InverseInvolute(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """The angle a with tan(a) - a = y, for y >= 0."""

    nargs = 1

    @classmethod
    def eval(cls, y: Any) -> Any:
        """The number, where y is one."""
        return sp.Float(inverse_involute(float(y))) if y.is_number else None


class RestitutionDamping(sp.Function):  # type: ignore[misc]  # sympy carries no types
    """What a restitution asks for; see `gearblocks.impact.restitution_damping`."""

    nargs = 1

    @classmethod
    def eval(cls, e: Any) -> Any:
        """The number, where e is one."""
        return sp.Float(restitution_damping(float(e))) if e.is_number else None


SYMBOLS = Functions(sp.sqrt, sp.sin, sp.cos, sp.tan, sp.atan, InverseInvolute, sp.pi)
"""What tooth geometry computes with in laws."""


@lru_cache(maxsize=1)
def clock() -> Any:
    """The symbol of time."""
    return sp.Symbol("t", real=True)


class Pool:
    """Makes the symbols of one kind of block and remembers what each stands for."""

    def __init__(self, *, reading: bool = False) -> None:
        self.reading = reading
        self.definitions: dict[Any, Any] = {}
        self.slots: dict[Any, Slot] = {clock(): Slot("time", None)}
        self._made: dict[Slot, Any] = {}

    def symbol(self, role: str, of: Any, text: str) -> Any:
        """The symbol for a role, made on first use."""
        slot = Slot(role, of)
        if slot not in self._made:
            made = sp.Symbol(text, real=True)
            while made in self.slots:
                made = sp.Symbol(made.name + "_", real=True)
            self.slots[made] = slot
            self._made[slot] = made
        return self._made[slot]

    def leaf(self, leaf: Expr) -> Any:
        """The symbol (or table call) of a leaf of an expression."""
        if leaf.op == "time":
            return clock()
        if leaf.op == "parameter":
            return self.symbol("shared", leaf.args[0], leaf.args[0].name)
        if leaf.op == "input":
            return self.symbol("input", leaf.args[0], leaf.args[0].name)
        if leaf.op == "sense":
            return self.symbol("sense", leaf.args[0], leaf.args[0])
        assert leaf.op == "table", leaf.op
        table = self.symbol("table", leaf.args[0], f"table_{leaf.args[0].digest()}")
        return TableAt(table, to_sympy(leaf.args[1], self.leaf), sp.Integer(0))

    def level(self, expr: Any) -> int:
        """CONSTANT, TIMED or MOVING: what can change the expression during a run."""
        found = CONSTANT
        for atom in expr.free_symbols:
            slot = self.slots[atom]
            found = max(found, slot.of.level if slot.role == "mode" else _level_of(slot))
        return found


def _level_of(slot: Slot) -> int:
    if slot.role == "column":
        return int(slot.of[0])
    return CONSTANT if slot.role == "table" else LEVEL.get(slot.role, MOVING)


class FlangeSymbols:
    """phi, w, alpha, tau and mobility of one flange; zeros where it is the ground."""

    __slots__ = ("_name", "_pool", "alpha", "phi", "w")

    def __init__(self, pool: Pool, name: str, grounded: bool) -> None:
        self._pool, self._name = pool, name
        zero = sp.Integer(0)
        self.phi = zero if grounded else pool.symbol("phi", name, f"phi_{name}")
        self.w = zero if grounded else pool.symbol("w", name, f"w_{name}")
        self.alpha = zero if grounded else pool.symbol("alpha", name, f"alpha_{name}")

    @property
    def tau(self) -> Any:
        """Torque that the block exerts on the flange, for Shows."""
        return self._pool.symbol("tau", self._name, f"tau_{self._name}")

    @property
    def mobility(self) -> Any:
        """1/J of everything tied rigidly to the flange."""
        return self._pool.symbol("mobility", self._name, f"mobility_{self._name}")


class Symbols:
    """Symbols of a block or effect, by the names of its members."""

    def __init__(self, owner: _Declared, pool: Pool, grounded: frozenset[str], prefix: str = "") -> None:
        self._owner, self._pool, self._prefix = owner, pool, prefix
        self.time = clock()
        cls = type(owner)
        for name in cls.flanges:
            setattr(self, name, FlangeSymbols(pool, name, name in grounded))
        for name in cls.states:
            setattr(self, name, pool.symbol("state", prefix + name, name))
        for name, field in cls.fields.items():
            value = getattr(owner, name)
            if isinstance(value, _Declared):
                setattr(self, name, Symbols(value, pool, grounded, f"{prefix}{name}."))
            elif field.role == "option" or value is None or isinstance(value, str):
                setattr(self, name, value)
            else:
                setattr(self, name, self._value(name, field.role, value))

    def _value(self, name: str, role: str, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(self._value(f"{name}[{i}]", role, v) for i, v in enumerate(value))
        if role == "exact":
            return self._pool.symbol("exact", self._prefix + name, name)
        if isinstance(value, (Parameter, Input, Table)):
            return self._pool.leaf(value._expr_())
        if isinstance(value, Expr):
            if any(leaf.op == "local" for leaf in value.leaves()):
                return value
            return to_sympy(value, self._pool.leaf)
        return self._pool.symbol("own", self._prefix + name, name)

    def is_constant(self, name: str) -> bool:
        """Whether a signal can only change when a parameter is set."""
        return self._pool.level(getattr(self, name)) == CONSTANT

    def named(self, name: str, expr: Any) -> Any:
        """The expression; in equations for reading a symbol of that name, with the expression as its definition."""
        if not self._pool.reading or sp.sympify(expr).is_Symbol:
            return expr
        symbol = self._pool.symbol("named", self._prefix + name, name)
        self._pool.definitions[symbol] = sp.sympify(expr)
        return symbol

    def local(self, field: str, **values: Any) -> Any:
        """A field that is an expression of the block's own quantities, or a Table over the single one given."""
        value = getattr(self._owner, field)
        if isinstance(value, Table):
            (quantity,) = values.values()
            table = self._pool.symbol("table", value, f"table_{value.digest()}")
            return TableAt(table, quantity, sp.Integer(0))
        if not isinstance(value, Expr):
            return getattr(self, field)
        return to_sympy(value, lambda leaf: values[leaf.args[0]] if leaf.op == "local" else self._pool.leaf(leaf))

    def tabled(self, table: Table, x: Any) -> Any:
        """A Table that a law makes itself, over a quantity. Tables with the same joints share one switch."""
        return TableAt(self._pool.symbol("table", table, f"table_{table.digest()}"), x, sp.Integer(0))

    @property
    def reading(self) -> bool:
        """Whether the law is derived for people: no tables that they cannot read."""
        return self._pool.reading

    def slope(self, expr: Any, flange: FlangeSymbols) -> Any:
        """d expr / d phi of a flange; 0 at the ground."""
        return sp.diff(expr, flange.phi) if flange.phi.is_Symbol else sp.Integer(0)

    def rate_of(self, expr: Any, rates: Iterable[Rate] = ()) -> Any:
        """d expr / dt along the motion, for expressions of angles, time and states with the given rates."""
        total = sp.diff(expr, clock())
        for name in type(self._owner).flanges:
            flange = getattr(self, name)
            total += self.slope(expr, flange) * flange.w
        return total + sum(sp.diff(expr, r.state) * r.expr for r in rates)

    def energy_of(self, field: str, name: str, x: Any) -> Any:
        """Stored energy of a polynomial field over its quantity, else None (the work then counts as exchange)."""
        dummy = sp.Dummy(name, real=True)
        force = self.local(field, **{name: dummy})
        if not force.is_polynomial(dummy) or any(self._pool.level(a) != CONSTANT for a in _others(force, dummy)):
            return None
        return sp.integrate(force, dummy).xreplace({dummy: x})


def _others(expr: Any, symbol: Any) -> set[Any]:
    return set(expr.free_symbols) - {symbol}
