"""Symbols of a law and their roles: what each stands for, and what can change it during a run.

Knows nothing of values, nor of generated code.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy as sp

from gearblocks.geometry.ratio_curves import Ellipse, Pieces
from gearblocks.geometry.ratio_law import RatioLaw
from gearblocks.language.block import Declared
from gearblocks.language.contributions import Rate
from gearblocks.language.expression import Expr, to_sympy
from gearblocks.language.heat import heat_port
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.laws.derivative import derivative
from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import EllipseLead, Table2At, TableAt


@dataclass(frozen=True, slots=True)
class SymbolRole:
    """Role of a symbol: what it stands for.

    role: own (a number of the block), exact, shared (a Parameter), mobility, time, input, sense, table, table2, law_table (of
    a LawTable, in equations for reading), phi, w, alpha, tau, state, coordinate, mode, own_mode (of the switch whose event
    function reads it), direction, stuck, constraint_force, friction (of a Stick: by its name; the last one: sliding or
    constraint force, in equations for reading); in generated functions hoisted, force, gain (of a flange on its group),
    torque_rate (of a flange), local (C text).

    of: flange, state, switch number, path, or the leaf itself.
    """

    role: str
    of: Any


@dataclass(frozen=True, slots=True)
class LawTable:
    """A Table that a law makes from a field of its block, as people read it."""

    table: Table
    field: str
    name: str
    words: str
    unit: str = "1"


LEVEL = {
    "own": 0,
    "exact": 0,
    "shared": 0,
    "mobility": 0,
    "time": 1,
    "input": 1,
}  # everything else moves with the state
CONSTANT, TIMED, MOVING = 0, 1, 2


@lru_cache(maxsize=1)
def time_symbol() -> Any:
    """The symbol of time."""
    return sp.Symbol("t", real=True)


class Pool:
    """Symbols of one kind of block with their roles, each made on first use."""

    def __init__(self, *, reading: bool = False) -> None:
        self.reading = reading
        self.definitions: dict[Any, Any] = {}
        self.words: dict[Any, tuple[str, str]] = {}
        """Words and unit of the symbols that are defined."""
        self.roles: dict[Any, SymbolRole] = {time_symbol(): SymbolRole("time", None)}
        self.nonzero: set[str] = set()
        """Numbers of the block that its bounds keep from 0."""
        self.temperature: Any = None
        """What gb.temperature stands for: that of the heat port of the block."""
        self.starts: set[str] = set()
        """Numbers of the block that are start values of its bodies."""
        self._made: dict[SymbolRole, Any] = {}

    def symbol(self, role: str, of: Any, text: str) -> Any:
        """The symbol for a role, made on first use."""
        meaning = SymbolRole(role, of)
        if meaning not in self._made:
            made = sp.Symbol(text, real=True)
            while made in self.roles:
                made = sp.Symbol(made.name + "_", real=True)
            self.roles[made] = meaning
            self._made[meaning] = made
        return self._made[meaning]

    @property
    def own_mode(self) -> Any:
        """In an event function: the mode that it decides about, 1 where it is >= 0."""
        return self.symbol("own_mode", None, "m_own")

    def leaf(self, leaf: Expr, local: Mapping[str, Any] | None = None) -> Any:
        """The symbol (or table call) of a leaf of an expression; local: what stands for the block's own quantities."""
        if is_temperature(leaf):
            return self.temperature
        if leaf.op == "local" and local is not None:
            return local[leaf.args[0]]
        if leaf.op == "time":
            return time_symbol()
        if leaf.op == "parameter":
            return self.symbol("shared", leaf.args[0], leaf.args[0].name)
        if leaf.op == "input":
            return self.symbol("input", leaf.args[0], leaf.args[0].name)
        if leaf.op == "sense":
            return self.symbol("sense", leaf.args[0], leaf.args[0])
        assert leaf.op in ("table", "table2"), leaf.op
        return self.table_at(leaf.args[0], *(to_sympy(x, lambda e: self.leaf(e, local)) for x in leaf.args[1:]))

    def table_at(self, table: Table | Table2, *quantities: Any) -> Any:
        """A table over its quantities; the jumps of one beside it."""
        if isinstance(table, Table) and table.jumps:
            steps = (sp.Float(size) * sp.Heaviside(quantities[0] - sp.Float(x), 1) for x, size in table.jumps)
            return sp.Add(self.table_at(table.continuous, *quantities), *steps)
        if isinstance(table, Table):
            return TableAt(self.table(table if self.reading else table.reached), *quantities, sp.Integer(0))
        symbol = self.symbol("table2", table, f"table_{table.digest()}")
        return Table2At(symbol, *quantities, sp.Integer(0), sp.Integer(0))

    def table(self, table: Table) -> Any:
        """The symbol of a table."""
        return self.symbol("table", table, f"table_{table.digest()}")

    def named(self, name: str, expr: Any, words: str = "", unit: str = "1") -> Any:
        """The expression; in equations for reading the symbol of that name, with the expression as its definition."""
        expr = sp.sympify(expr)
        if not self.reading or expr.is_number or (expr.is_Symbol and expr not in self.definitions):
            return expr
        symbol = self.symbol("named", name, name.split(".")[-1])
        self.definitions[symbol] = expr
        self.words[symbol] = words, unit
        return symbol

    def spelled(self, expr: Any, moving: set[Any]) -> Any:
        """The expression with those defined symbols put in that depend on one of `moving`."""
        expr = sp.sympify(expr)
        while within := {
            x: self.definitions[x] for x in expr.free_symbols & set(self.definitions) if self._reads(x, moving)
        }:
            expr = expr.xreplace(within)
        return expr

    def _reads(self, symbol: Any, moving: set[Any]) -> bool:
        """Whether one of `moving` stands in the definition of a symbol, or in those that it names."""
        found = self.definitions[symbol].free_symbols
        return bool(found & moving) or any(self._reads(x, moving) for x in found & set(self.definitions))

    def by_name(self, expr: Any) -> Any:
        """The symbol that stands for an expression, or for its opposite, where there is one."""
        for symbol, definition in self.definitions.items():
            if definition == expr:
                return symbol
            if definition == -expr:
                return -symbol
        return expr

    def moving(self) -> set[Any]:
        """Symbols that change by themselves as the train moves: time, angles, states."""
        return {x for x, role in self.roles.items() if role.role in ("time", "phi", "state")}

    def level(self, expr: Any) -> int:
        """CONSTANT, TIMED or MOVING: what can change the expression during a run."""
        found = CONSTANT
        for atom in symbols_in(expr):
            meaning = self.roles[atom]
            found = max(found, meaning.of.level if meaning.role == "mode" else _level_of(meaning))
        return found


def is_temperature(leaf: Expr) -> bool:
    """Whether it is gb.temperature."""
    return leaf.op == "local" and leaf.args[0] == "temperature"


def _level_of(meaning: SymbolRole) -> int:
    if meaning.role == "hoisted":
        return int(meaning.of[0])
    return CONSTANT if meaning.role in ("table", "table2", "law_table") else LEVEL.get(meaning.role, MOVING)


class FlangeSymbols:
    """phi, w, alpha, tau and mobility of one flange; zeros where it is the ground."""

    __slots__ = ("_name", "_pool", "alpha", "phi", "w")

    def __init__(self, pool: Pool, name: str, grounded: bool) -> None:
        self._pool, self._name = pool, name
        zero = sp.Integer(0)
        self.phi = zero if grounded else pool.symbol("phi", name, f"phi_{name}")
        self.w = zero if grounded else pool.symbol("w", name, f"w_{name}")
        self.alpha = zero if grounded else pool.symbol("alpha", name, f"alpha_{name}")

    def __repr__(self) -> str:
        return f"s.{self._name}"

    @property
    def tau(self) -> Any:
        """Torque that the block exerts on the flange, for Shows."""
        return self._pool.symbol("tau", self._name, f"tau_{self._name}")

    @property
    def s(self) -> Any:
        """Position of a slider [m]: phi by its other name."""
        return self.phi

    @property
    def v(self) -> Any:
        """Speed of a slider [m/s]: w by its other name."""
        return self.w

    @property
    def f(self) -> Any:
        """Force that the block exerts on a slider [N]: tau by its other name."""
        return self.tau

    @property
    def mobility(self) -> Any:
        """1/J of the rigid group of the flange."""
        return self._pool.symbol("mobility", self._name, f"mobility_{self._name}")


class Symbols:
    """Symbols of a block or effect, by the names of its members."""

    def __init__(self, owner: Declared, pool: Pool, grounded: frozenset[str], prefix: str = "") -> None:
        self._owner, self._pool, self._prefix = owner, pool, prefix
        self.time = time_symbol()
        cls = type(owner)
        for name in cls.flanges:
            setattr(self, name, FlangeSymbols(pool, name, name in grounded))
        for name in cls.states:
            setattr(self, name, pool.symbol("state", prefix + name, name))
        port = heat_port(owner)
        if port is not None:  # first, as signals may read its temperature
            inner: Any = Symbols(port[1], pool, grounded, f"{prefix}{port[0]}.")
            pool.temperature = inner.T
        for name, field in cls.fields.items():
            value = getattr(owner, name)
            if isinstance(value, Declared):
                setattr(self, name, Symbols(value, pool, grounded, f"{prefix}{name}."))
            elif field.role == "option" or value is None or isinstance(value, str):
                setattr(self, name, value)
            else:
                setattr(self, name, self._value(name, field.role, value))
                if field.role == "exact" or (field.gt is not None and field.gt >= 0 and not field.unless):
                    pool.nonzero.add(prefix + name)
                if field.start is not None:
                    pool.starts.add(prefix + name)

    def _value(self, name: str, role: str, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(self._value(f"{name}[{i}]", role, v) for i, v in enumerate(value))
        if role == "exact":
            return self._pool.symbol("exact", self._prefix + name, name)
        if isinstance(value, (Parameter, Input, Table)):
            return self._pool.leaf(value._expr_())
        if isinstance(value, Expr):
            if any(leaf.op == "local" and not is_temperature(leaf) for leaf in value.leaves()):
                return value
            return to_sympy(value, self._pool.leaf)
        return self._pool.symbol("own", self._prefix + name, name)

    def is_constant(self, name: str) -> bool:
        """Whether a signal can only change when a parameter is set."""
        return self._pool.level(getattr(self, name)) == CONSTANT

    def named(self, name: str, expr: Any, words: str = "", unit: str = "1") -> Any:
        """The expression; in equations for reading a symbol of that name, with the expression as its definition.

        A name that ends in ' is the rate of the one without it. words, unit: for the list of symbols.
        """
        return self._pool.named(self._prefix + name, expr, words, unit)

    def turned(self, law: RatioLaw, x: Any) -> Any:
        """F(x) of a ratio law: its mean ratio times x, exactly, and a periodic part."""
        curve = law.curve
        if sp.sympify(x).is_zero:
            return sp.Integer(0)
        if isinstance(curve, Ellipse):
            ripple = EllipseLead(curve.n * x, sp.Float(curve.e)) / curve.n
        elif isinstance(curve, Pieces):
            table = self._pool.symbol("table", curve, f"ripple_{curve.digest()}")
            ripple = TableAt(table, x, sp.Integer(0))
        else:
            ripple = curve.symbolic(x)
        return sp.Rational(law.n1, law.n2) * x + ripple

    def local(self, field: str, **values: Any) -> Any:
        """A field that is an expression of the block's own quantities, or a Table or Table2 over those given, in order."""
        value = getattr(self._owner, field)
        if isinstance(value, (Table, Table2)):
            return self._pool.table_at(value, *values.values())
        if not isinstance(value, Expr):
            return getattr(self, field)
        return to_sympy(value, lambda leaf: self._pool.leaf(leaf, values))

    def tabled(self, table: Table, x: Any, field: str = "", **meaning: str) -> Any:
        """A Table that a law makes itself, over a quantity. Tables with the same joints share one switch.

        field: of the block, from which it is made; meaning: name, words and unit, for the list of symbols.
        """
        if field and self._pool.reading:
            made = LawTable(table, self._prefix + field, **meaning)
            return TableAt(self._pool.symbol("law_table", made, made.name), x, sp.Integer(0))
        return TableAt(self._pool.table(table), x, sp.Integer(0))

    def stick(self, name: str) -> tuple[Any, Any, Any]:
        """Of the Stick or Stop of that name: direction of sliding (-1, 1; 0 when stuck or free), 1 while stuck (closed),
        and the constraint force (0 unless stuck), which only Shows can read."""
        direction = self._pool.symbol("direction", name, f"dir_{name}".rstrip("_"))
        stuck = self._pool.symbol("stuck", name, f"stuck_{name}".rstrip("_"))
        return direction, stuck, self._pool.symbol("constraint_force", name, f"held_{name}".rstrip("_"))

    @property
    def reading(self) -> bool:
        """Whether the law is derived for people: no tables that they cannot read."""
        return self._pool.reading

    def slope(self, expr: Any, flange: FlangeSymbols) -> Any:
        """d expr / d phi of a flange; 0 at the ground."""
        return derivative(self._pool.spelled(expr, {flange.phi}), flange.phi) if flange.phi.is_Symbol else sp.Integer(0)

    def rate_of(self, expr: Any, rates: Iterable[Rate] = ()) -> Any:
        """d expr / dt along the motion, for expressions of angles, time and states with the given rates."""
        expr = self._pool.spelled(expr, self._pool.moving())
        total = derivative(expr, time_symbol())
        for name in type(self._owner).flanges:
            flange = getattr(self, name)
            total += self.slope(expr, flange) * flange.w
        return total + sum(derivative(expr, r.state) * r.expr for r in rates)

    def energy_of(self, field: str, name: str, x: Any) -> Any:
        """Stored energy of a polynomial field over its quantity, else None (the work then counts as exchange)."""
        dummy = sp.Dummy(name, real=True)
        force = self.local(field, **{name: dummy})
        if not force.is_polynomial(dummy) or any(self._pool.level(a) != CONSTANT for a in _others(force, dummy)):
            return None
        return sp.integrate(force, dummy).xreplace({dummy: x})


def _others(expr: Any, symbol: Any) -> set[Any]:
    return set(expr.free_symbols) - {symbol}
