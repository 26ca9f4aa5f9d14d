"""Conditions as modes: Piecewise, Abs, sign, Min, Max, Heaviside and tables become event functions and mode symbols.

H(g(x)) becomes a mode m in {0, 1} with the event function g. Within a step a law runs on the branch that its modes name,
continued smoothly past g = 0. What stays at g = 0 (a pedal that is not touched) has the mode that > or >= asks for.
Knows nothing of when a mode changes: the solver does that at events.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.errors import GearblocksError
from gearblocks.language.contributions import Switch
from gearblocks.language.signals import Table
from gearblocks.laws.functions import ContactSide, DeadZone, InverseInvolute, Table2At, TableAt, Where
from gearblocks.laws.switched_constraints import ConstraintLaw
from gearblocks.laws.symbols import CONSTANT, MOVING, Pool

_OUT_OF_REACH = -1e300

_COUNT = Table([0.0, 1.0], [0.0, 0.0], "step", True)
"""floor(x) as a periodic step table over x: its segments are numbered by the whole part."""


_IN_A_ROW = 16
"""Cases that are nested one inside the other; halves of longer rows stand side by side, or sympy would go too deep."""

_COMPARED, _LONG = 4, 100
"""Values that are compared one after the other, and nodes of an expression that stands twice in what is made of it."""

_NEXT_TO_NOTHING = sp.Float(1e-300)
"""Beside a divisor that is 0: the side of the quotient is then that of n/(+0.0), as a run begins at rest; else no bit of it."""
_WITHOUT_VALUES = (sp.log, sp.exp, sp.tan, sp.asin, sp.acos, sp.acosh, sp.atanh, sp.sinh, sp.cosh, InverseInvolute)
"""Functions that have no value for some arguments, or one that is no longer a number."""


@dataclass(frozen=True, slots=True)
class Mode:
    """Identity of one switch of a kind: its number and what moves its event function."""

    number: int
    level: int


@dataclass(slots=True)
class EventFunction:
    """One event function of a kind, with its name and the values in the events.

    surface: the expression g. Its mode is the sign of g (0 or 1), the segment of a `table` over it, or its side of a `band`
    about zero of that half width (-1, 0, 1). constraint: its part in a switched one: "slip", "gap", "sign" (of a force), "hold"
    or "free"; the solver then decides about its mode together with those of all others ("free" apart: 1 where it is not
    engaged). of_slip: g is the size of a slip, which has a direction once the constraint has been decided about. form: g as it
    was asked for, where it reads its own mode (Pool.own_mode). at_zero: the mode where g stays exactly 0, or a quantity at a
    joint of its table, as the condition says; None: nothing depends on it.
    """

    name: str
    surface: Any
    symbol: Any
    level: int
    when: Any = 1
    low: float = 0.0
    high: float = 1.0
    table: Any = None
    band: Any = None
    constraint: str | None = None
    of_slip: bool = False
    form: Any = None
    at_zero: int | None = None

    @property
    def is_sign(self) -> bool:
        """Whether the mode is the sign of the event function."""
        return self.table is None and self.band is None and self.constraint is None


@dataclass
class Freezer:
    """Replaces conditions by mode symbols and collects the switches. One per kind.

    sizes: expressions that are no less than 0 but for rounding, since a switched constraint decides about their side.
    """

    pool: Pool
    sizes: frozenset[Any] = frozenset()
    switches: list[EventFunction] = field(default_factory=list)
    locating: bool = True
    _memo: dict[Any, Any] = field(default_factory=dict)
    _sizes: dict[Any, int] = field(default_factory=dict)

    def declare(self, declared: Iterable[Switch]) -> None:
        """Takes the named switches first, so that conditions with the same event functions find them."""
        for item in declared:
            indicator = self._indicator(sp.sympify(item.surface), item.name)
            for switch in self.switches:
                if switch.symbol in indicator.free_symbols:
                    switch.low, switch.high = float(item.low), float(item.high)
                    if item.when != 1:
                        switch.when = self.freeze(sp.sympify(item.when))

    def add_constraint(self, constraint: ConstraintLaw) -> ConstraintLaw:
        """The switched constraint with its switches: its slip (or gap), its constraint force, and whether it is engaged."""
        first = {"stop": "gap", "tie": "sign"}.get(constraint.kind, "slip")
        name = "" if constraint.kind in ("tie", "loss") else constraint.name
        for what, surface in (
            (first, constraint.gap if constraint.is_stop else constraint.slip),
            ("hold", sp.Integer(0)),
        ):
            constraint.switches[what] = len(self.switches)
            mode = Mode(len(self.switches), MOVING)
            symbol = self.pool.symbol("mode", mode, f"mode{mode.number}")
            self.switches.append(EventFunction(name, surface, symbol, MOVING, constraint=what))
        if (level := self.pool.level(constraint.engaged)) != CONSTANT:
            mode = Mode(len(self.switches), level)
            constraint.switches["engaged"] = mode.number
            symbol = self.pool.symbol("mode", mode, f"mode{mode.number}")
            self.switches.append(EventFunction(constraint.name, -constraint.engaged, symbol, level, constraint="free"))
        return constraint

    def freeze(self, expr: Any) -> Any:
        """expr with every condition replaced."""
        if expr not in self._memo:
            self._memo[expr] = self._freeze(expr)
        return self._memo[expr]

    def _freeze(self, e: Any) -> Any:
        if e.is_Atom:
            return sp.Integer(e == sp.true) if e.is_Boolean and not e.is_Symbol else e
        if isinstance(e, sp.Piecewise):
            return self._piecewise(e)
        if isinstance(e, (TableAt, Table2At)):
            return e if len(e.args) in (4, 7) else self._table(e)
        if isinstance(e, (DeadZone, ContactSide)):
            return self._dead_zone(e)
        if isinstance(e, sp.floor) and self.pool.level(e) != CONSTANT:
            return self._floor(e)
        if isinstance(e, (sp.Max, sp.Min)) and self._stays(e):
            return e
        a = [self.freeze(x) for x in e.args]
        if isinstance(e, sp.atan2) and self.pool.level(e) != CONSTANT:
            return self._angle_of(*a)
        if isinstance(e, sp.Abs):
            return (2 * self._indicator(a[0]) - 1) * a[0]
        if isinstance(e, sp.sign):
            return self._sign(a[0])
        if isinstance(e, sp.Heaviside):
            return self._indicator(a[0], at_zero=1 if self._may_stay(a[0]) else None)
        if isinstance(e, (sp.Max, sp.Min)):
            return self._extremum(a, isinstance(e, sp.Max))
        if isinstance(e, (sp.Ne, sp.Eq)):
            raise GearblocksError(f"the condition '{e}' asks for equality, which a run never meets exactly; use < or >")
        if e.is_Relational:
            least = a[0] - a[1] if isinstance(e, (sp.Gt, sp.Ge)) else a[1] - a[0]
            return self._indicator(least, at_zero=int(isinstance(e, (sp.Ge, sp.Le))) if self._may_stay(least) else None)
        if isinstance(e, sp.And):
            return sp.Mul(*a)
        if isinstance(e, sp.Or):
            return 1 - sp.Mul(*(1 - x for x in a))
        if isinstance(e, sp.Not):
            return 1 - a[0]
        if isinstance(e, sp.ITE):
            return a[0] * a[1] + (1 - a[0]) * a[2]
        return e.func(*a)

    def _may_stay(self, x: Any) -> bool:
        """Whether an expression may be exactly on a limit for a time: a signal, not what a block itself knows of its motion."""
        return self.pool.level(x) != MOVING or any(self.pool.roles[s].role == "sense" for s in x.free_symbols)

    def _sign(self, x: Any) -> Any:
        """-1, 0 or 1; of what moves by itself -1 or 1, as it does not stay at 0."""
        level = self.pool.level(x)
        stays = level == CONSTANT or (
            level != MOVING and any(self.pool.roles[s].role != "time" for s in self._timed(x))
        )
        return (
            self._indicator(x, at_zero=0) + self._indicator(x, at_zero=1) - 1 if stays else 2 * self._indicator(x) - 1
        )

    def _timed(self, x: Any) -> list[Any]:
        """The symbols of an expression that change in a run."""
        return [s for s in x.free_symbols if self.pool.level(s) != CONSTANT]

    def _extremum(self, values: Sequence[Any], largest: bool) -> Any:
        """The largest or the least of several, by comparing two at a time: few one after the other, of many each half by
        itself. Of two the first stands in the result once where it is long, so that what is nested stays linear; of signals
        the result is exactly one of both, so that it can stay on a limit."""
        if len(values) > _COMPARED:
            half = len(values) // 2
            values = [self._extremum(values[:half], largest), self._extremum(values[half:], largest)]
        result = values[0]
        for x in values[1:]:
            above = self._indicator(x - result) if largest else 1 - self._indicator(x - result)
            if self._may_have_no_value(x) or self._may_have_no_value(result):
                result = self._where(1 - above, result) + self._where(above, x)
            elif self._size(result) > _LONG or MOVING not in (self.pool.level(x), self.pool.level(result)):
                result = (1 - above) ** 2 * result + above * x
            else:
                result = result + above * (x - result)
        return result

    def _stays(self, e: Any) -> bool:
        """Whether the largest of so many is no condition to be taken apart: of what does not move, without tables."""
        if self.pool.level(e) != CONSTANT or e.has(TableAt, Table2At, DeadZone, ContactSide, sp.floor):
            return False
        return sum(len(x.args) for x in e.atoms(sp.Max, sp.Min)) > _COMPARED

    def _size(self, expr: Any) -> int:
        """Nodes of an expression, as often as they stand in it."""
        if expr not in self._sizes:
            self._sizes[expr] = 1 + sum(map(self._size, expr.args))
        return self._sizes[expr]

    def _where(self, indicator: Any, value: Any) -> Any:
        """The value where the indicator is 1, and 0 where it is 0."""
        return Where(indicator, value) if self._may_have_no_value(value) else indicator * value

    def _may_have_no_value(self, expr: Any) -> bool:
        """Whether an expression of what moves may be infinite or NaN: 1/x, roots, logarithms and their like."""
        return any(
            self.pool.level(x) != CONSTANT
            for node in sp.sympify(expr).atoms(sp.Pow, *_WITHOUT_VALUES)
            for x in (node.base if isinstance(node, sp.Pow) else node.args[0],)
            if not (isinstance(node, sp.Pow) and node.exp.is_Integer and node.exp > 0)
        )

    def _piecewise(self, e: Any) -> Any:
        """Nested selection by indicators m; the last condition must be True, else the value outside is NaN.

        What holds elsewhere has the factor (1 - m)^2 in place of 1 - m, which sympy would multiply out: a small value beside
        200 - 200 m keeps no digit below those of 200.
        """
        *cases, (elsewhere, last) = e.args
        if last is not sp.true:
            raise GearblocksError(f"'{e}' has no value where no condition holds: end it with (value, True)")
        elsewhere = self.freeze(elsewhere)
        frozen = [(self.freeze(condition), self.freeze(value)) for value, condition in reversed(cases)]
        return self._selected(frozen[::-1], elsewhere)

    def _selected(self, cases: Sequence[tuple[Any, Any]], elsewhere: Any) -> Any:
        """The value of the first case whose indicator is 1."""
        if len(cases) > _IN_A_ROW:
            half = len(cases) // 2
            none = sp.Mul(*((1 - chosen) ** 2 for chosen, _ in cases[:half]))
            rest = self._selected(cases[half:], elsewhere)
            return self._selected(cases[:half], sp.Integer(0)) + self._where(none, rest)
        for chosen, value in reversed(cases):
            elsewhere = self._where(chosen, value) + self._where((1 - chosen) ** 2, elsewhere)
        return elsewhere

    def _indicator(self, surface: Any, name: str | None = None, at_zero: int | None = None) -> Any:
        """1 where surface > 0, else 0, and at_zero (None: either) where it is 0, as the mode symbol of a switch (or a plain
        condition on constants)."""
        surface = self._without_poles(self.freeze(surface))
        if surface.is_number:
            return sp.Integer(1 if surface > 0 or (surface == 0 and at_zero != 0) else 0)
        for switch in self.switches:
            known = switch.surface if switch.form is None else switch.form
            if switch.is_sign and known == surface and self._agrees_at_zero(switch, at_zero):
                return switch.symbol
            if (
                switch.is_sign
                and known == -surface
                and self._agrees_at_zero(switch, None if at_zero is None else 1 - at_zero)
            ):
                return 1 - switch.symbol
        if not self.locating or self.pool.level(surface) == CONSTANT:
            return 1 - sp.Heaviside(-surface, 1) if at_zero == 0 else sp.Heaviside(surface, 1)
        if name is None:
            name = f"switch {len(self.switches) + 1}"
        made = self._add(name, surface)
        made.at_zero = at_zero
        if surface.has(self.pool.own_mode):
            made.form, made.surface = surface, surface.xreplace({self.pool.own_mode: made.symbol})
        return made.symbol

    def _agrees_at_zero(self, switch: EventFunction, at_zero: int | None) -> bool:
        """Whether a switch serves a condition that asks for this mode at 0. What moves has one switch on either side: a law
        that jumps there slides along it."""
        if switch.at_zero is None:
            switch.at_zero = at_zero
        return at_zero in (None, switch.at_zero) or switch.level == MOVING

    def _without_poles(self, surface: Any) -> Any:
        """n d in place of n/d, which is of the same sign, at d = 0 too: what changes it through infinity has to pass 0 to be
        located."""
        tangents = (x for x in surface.atoms(sp.tan) if self.pool.level(x) != CONSTANT)
        spelled = surface.xreplace({x: sp.sin(x.args[0]) / sp.cos(x.args[0]) for x in tangents})
        if not any(self._may_pass_zero(x.base) for x in spelled.atoms(sp.Pow) if x.exp.is_Integer and x.exp < 0):
            return surface
        above, below = sp.fraction(sp.together(spelled), exact=True)
        powers = [factor.as_base_exp() for factor in sp.Mul.make_args(below)]
        poles = [(base, n) for base, n in powers if n.is_Integer and self._may_pass_zero(base)]
        rest = sp.Mul(*(base**n for base, n in powers if (base, n) not in poles))
        return above / rest * sp.Mul(*((base + _NEXT_TO_NOTHING) ** (n % 2) for base, n in poles)) if poles else surface

    def _may_pass_zero(self, expr: Any) -> bool:
        """Whether an expression of what moves may change its sign; not where a constant outweighs the waves beside it."""
        constant, waves = expr.as_independent(*expr.free_symbols, as_Add=True)
        terms = [x.as_coeff_Mul() for x in sp.Add.make_args(waves)]
        waves_alone = all(wave.func in (sp.sin, sp.cos) for _, wave in terms)
        outweighed = waves_alone and bool(abs(constant) > sum(abs(size) for size, _ in terms))
        return self.pool.level(expr) != CONSTANT and not outweighed

    def _angle_of(self, y: Any, x: Any) -> Any:
        """atan2(y, x) by the half angles from the axis that (x, y) is closer to; it jumps where y passes 0 left of the
        origin."""
        right, up = self._indicator(x), self._indicator(y)
        half = sp.atan(y / (sp.sqrt(x**2 + y**2) + (2 * right - 1) * x))
        return 2 * (2 * right - 1) * half + (1 - right) * (2 * up - 1) * sp.pi

    def _dead_zone(self, e: Any) -> Any:
        """With the side m = -1, 0, 1 as one mode: g = m^2 x - m b, its integral g^2/2, its slope m^2."""
        x, b = (self.freeze(a) for a in e.args[:2])
        side = self._side(x, b)
        if isinstance(e, ContactSide):
            return side
        # r u - b as r (u - b/r), so that r can join the other constant factors
        constant = [a for a in sp.Mul.make_args(x) if self.pool.level(a) == CONSTANT]
        moving = [a for a in sp.Mul.make_args(x) if self.pool.level(a) != CONSTANT]
        r = sp.Mul(*constant)
        g = r * (side**2 * sp.Mul(*moving) - side * (b / r))
        return {-1: g**2 / 2, 0: g, 1: side**2}.get(int(e.args[2]), sp.Integer(0))

    def _side(self, x: Any, b: Any) -> Any:
        for switch in self.switches:
            if switch.band == b and switch.surface == x:
                return switch.symbol
        if not self.locating:
            return sp.Heaviside(x - b, 1) + sp.Heaviside(x + b, 1) - 1
        switch = self._add("", x)
        switch.band = b
        return switch.symbol

    def _table(self, e: Any) -> Any:
        """With the segment of each of its quantities as a mode, where these are located; a step needs no more than that."""
        n = 1 if isinstance(e, TableAt) else 2
        symbol, quantities, orders = e.args[0], [self.freeze(x) for x in e.args[1 : n + 1]], e.args[n + 1 : 2 * n + 1]
        axes = [symbol] if n == 1 else [self.pool.table(axis) for axis in self.pool.roles[symbol].of.axes]
        jumps = n == 1 and self.pool.roles[symbol].of.kind == "step"
        modes = [
            self._segment(axis, x, jumps=jumps, least=isinstance(raw, sp.Abs) or sp.expand(x) in self.sizes)
            for axis, x, raw in zip(axes, quantities, e.args[1 : n + 1], strict=True)
        ]
        if None in modes:
            return e.func(symbol, *quantities, *orders)
        if jumps:
            quantities = [sp.Integer(0)]
        return e.func(symbol, *quantities, *orders, *modes)

    def _segment(self, table: Any, x: Any, name: str = "table", *, jumps: bool = False, least: bool = False) -> Any:
        """The mode that is the segment of a table over x, shared by all with the same joints; None where none is located.

        jumps: a joint belongs to the segment that begins there. least: x is a size, whose side is decided elsewhere: no joint
        below or at 0 is a corner.
        """
        table = self._beyond_zero(table) if least else table
        for switch in self.switches:
            if switch.table is not None and switch.surface == x and self._same_joints(switch.table, table):
                switch.at_zero = 1 if jumps and self._may_stay(x) else switch.at_zero
                return switch.symbol
        smooth = not getattr(self.pool.roles[table].of, "joints", True)
        if not self.locating or smooth or self.pool.level(x) == CONSTANT:
            return None
        made = self._add(name, x, table)
        made.of_slip, made.at_zero = sp.expand(x) in self.sizes, 1 if jumps and self._may_stay(x) else None
        return made.symbol

    def _beyond_zero(self, table: Any) -> Any:
        """A table with the same numbers of segments whose joints up to 0 are out of reach."""
        of = self.pool.roles[table].of
        if not isinstance(of, Table) or of.periodic or of.x[0] > 0:
            return table
        below = [i for i, x in enumerate(of.x) if x <= 0]
        x = [_OUT_OF_REACH * (below[-1] + 1 - i) for i in below] + [float(x) for x in of.x[len(below) :]]
        made = Table(x, [0.0] * len(x), "step")
        return self.pool.symbol("table", made, f"table_{made.digest()}")

    def _same_joints(self, one: Any, other: Any) -> bool:
        """Whether two tables have the same segments, so that one switch serves both."""
        a, b = (self.pool.roles[x].of for x in (one, other))
        if not (isinstance(a, Table) and isinstance(b, Table)):
            return bool(a == b)
        return a is b or (a.periodic == b.periodic and list(a.x) == list(b.x))

    def _floor(self, e: Any) -> Any:
        """The whole number below, as the mode of a table that counts."""
        x = self.freeze(e.args[0])
        mode = self._segment(self.pool.symbol("table", _COUNT, "table_count"), x, "count", jumps=True)
        return sp.floor(x) if mode is None else mode

    def _add(self, name: str, surface: Any, table: Any = None) -> EventFunction:
        level = self.pool.level(surface)
        mode = Mode(len(self.switches), level if level != MOVING else MOVING)
        switch = EventFunction(name, surface, self.pool.symbol("mode", mode, f"mode{mode.number}"), level, table=table)
        self.switches.append(switch)
        return switch
