"""Angle wrapping: by how many whole turns an absolute angle may be shifted so that no law changes its value.

    f(phi + 2 pi n) = f(phi) for every law f: n = lcm of the denominators of the turns that periodic functions see

A law may read an angle that grows for ever (sin(z phi), a periodic table over the mesh phase). The solver keeps such an
angle near zero and keeps the wrap count apart: z phi keeps its digits after 1e9 turns.

Along a free angle everything else moves by exact ratios. A shift is written as 2 pi^p times exact numbers of turns.
Knows nothing of when the solver wraps.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import lcm, pi
from typing import Any

import sympy as sp

from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.kinematics import PrescribedRow
from gearblocks.assembly.tables import GROUND_GROUP, Assembly, Batch
from gearblocks.errors import ModelError
from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import TableAt
from gearblocks.laws.law import WRAPPED
from gearblocks.laws.rational import Exact, exact_value, over

MOST_TURNS = 10**6
"""Turns beyond which an angle is not wrapped: it would not stay small."""

Form = dict[int, Exact]
"""Turns of a quantity by free angle, per turn of that angle."""


@dataclass(frozen=True, slots=True)
class WrappedAngle:
    """A free angle (its number in Assembly.angles) from which `turns` whole turns are taken off at a time.

    steps: (batch, switch of the law, instance, by how much its mode falls) of periodic tables over the angle.
    """

    number: int
    turns: int
    steps: tuple[tuple[int, int, int, int], ...]


@dataclass(slots=True)
class AngleWrapping:
    """Wrapped angles; forms: turns of each group per turn of each of them (by index in `wrapped`).

    unwrapped: (batch, output of the law) that must be computed from unwrapped angles.
    """

    wrapped: list[WrappedAngle] = field(default_factory=list)
    forms: dict[int, Form] = field(default_factory=dict)
    unwrapped: set[tuple[int, int]] = field(default_factory=set)


@dataclass(slots=True)
class _Reading:
    """What an expression asks of the free angles: turns to shift by, and angles that must not be shifted.

    tables: (table symbol, quantity) -> how many periods the table goes on per turn of each angle.
    """

    pool: Any
    values: Mapping[Any, Exact]
    shifts: Mapping[Any, Form]
    turns: dict[int, int] = field(default_factory=dict)
    bad: set[int] = field(default_factory=set)
    tables: dict[tuple[Any, Any], Form] = field(default_factory=dict)

    def periodic(self, expr: Any) -> None:
        """Notes that an expression must not change."""
        _, form = self.shift(expr)
        self.bad.update(form)

    def shift(self, e: Any) -> tuple[int, Form]:
        """(p, turns) of an expression; what is neither linear nor periodic forbids its angles to be wrapped."""
        if not self.touched(e):
            return 1, {}
        if e.is_Symbol:
            return 1, dict(self.shifts[e])
        if e.is_Add:
            return self._sum(e)
        if e.is_Mul:
            return self._product(e)
        if isinstance(e, (sp.sin, sp.cos, sp.tan)):
            return self._whole(e.args[0], 1)
        if isinstance(e, sp.frac):
            return self._whole(e.args[0], 0)
        if isinstance(e, TableAt):
            return self._table(e)
        for a in e.args:
            self.periodic(a)
        return 1, {}

    def touched(self, e: Any) -> bool:
        """Whether any free angle stands in an expression."""
        return any(self.shifts.get(x) for x in symbols_in(e))

    def _spoil(self, form: Iterable[int]) -> tuple[int, Form]:
        self.bad.update(form)
        return 1, {}

    def _sum(self, e: Any) -> tuple[int, Form]:
        parts = [part for part in map(self.shift, e.args) if part[1]]
        if len({p for p, _ in parts}) > 1:
            return self._spoil(f for _, form in parts for f in form)
        total = Combination()
        for _, form in parts:
            total.add(Combination(dict(form)), 1)
        return (parts[0][0] if parts else 1), total.groups

    def _product(self, e: Any) -> tuple[int, Form]:
        factors = [self.shift(a) for a in e.args if self.touched(a)]
        moving = [part for part in factors if part[1]]
        if not moving:
            return 1, {}
        if len(factors) > 1:
            return self._spoil(f for _, form in moving for f in form)
        (p, form), c = moving[0], Fraction(1)
        for a in e.args:
            if self.touched(a):
                continue
            base, exponent = a.as_base_exp()
            if base == sp.pi and exponent.is_Integer:
                p += int(exponent)
                continue
            try:
                c *= exact_value(a, self.values)
            except (ModelError, KeyError, TypeError, AttributeError, ArithmeticError):  # not a fixed rational number
                return self._spoil(form)
        return p, {f: over(c.numerator, c.denominator) * r for f, r in form.items() if c}

    def _whole(self, quantity: Any, p: int) -> tuple[int, Form]:
        """The quantity must move by whole periods: 2 pi of an angle (p = 1), 1 of a number of cycles (p = 0)."""
        power, form = self.shift(quantity)
        if form and power != p:
            return self._spoil(form)
        self._demand(form if p == 1 else {f: 2 * r for f, r in form.items()})
        return 1, {}

    def _demand(self, form: Form) -> None:
        for f, r in form.items():
            self.turns[f] = lcm(self.turns.get(f, 1), Fraction(r).denominator)

    def _table(self, e: Any) -> tuple[int, Form]:
        table, quantity = e.args[:2]
        power, form = self.shift(quantity)
        source = self.pool.roles[table].of
        if not form:
            return 1, {}
        period = float(source.x[-1] - source.x[0])
        unit = _turns_of(period) if power == 1 else Fraction(period) / 2 if power == 0 else None
        if not source.periodic or unit is None:
            return self._spoil(form)
        periods = {f: over(r, unit) for f, r in form.items()}
        self._demand(periods)
        self.tables[table, quantity] = periods
        return 1, {}


def located(expr: Any) -> Any:
    """An output over unwrapped angles: its tables find their segments themselves, since the modes belong to the remainders."""
    tables = {e: e.func(*e.args[:3]) for e in expr.atoms(TableAt)}
    return expr.xreplace(tables)


def _turns_of(period: float) -> Fraction | None:
    """A period in rad as turns: a simple fraction of 2 pi to within rounding, else None."""
    turns = Fraction(period / (2 * pi)).limit_denominator(1000)
    return turns if turns and abs(float(turns) * 2 * pi - period) <= 1e-15 * period else None


# -- the whole train --------------------------------------------------------------------------------------------------


def find_wrapped_angles(assembly: Assembly, sensed: Iterable[str]) -> AngleWrapping:
    """Angles that can be wrapped. sensed: paths of the feedback signals (they belong to the laws)."""
    search = _Search(assembly, frozenset(sensed))
    search.find_dependent()
    for number in range(len(assembly.batches)):
        search.read_laws(number)
    return search.result()


class _Search:
    def __init__(self, assembly: Assembly, sensed: frozenset[str]) -> None:
        self.assembly, self.sensed = assembly, sensed
        self.free = {group: i for i, group in enumerate(assembly.angles)}
        self.groups: dict[int, Form] = {group: {i: 1} for group, i in self.free.items()}
        self.turns: dict[int, int] = {}
        self.bad: set[int] = set()
        self.steps: dict[int, list[tuple[int, int, int, Exact]]] = {}
        self.shown: dict[tuple[int, int], list[_Reading]] = {}
        self.instance = {c: (b, e) for b, batch in enumerate(assembly.batches) for e, c in enumerate(batch.components)}

    def find_dependent(self) -> None:
        """Turns of dependent groups, through rows and prescribed motions."""
        for group, row in self.assembly.definitions:
            if isinstance(row, PrescribedRow):
                b, e = self.instance[row.component]
                batch = self.assembly.batches[b]
                motion = batch.law.prescribed[row.number]
                reading = self._reading(batch, e, angles_alone=True)
                power, form = reading.shift(motion.angle)
                reading.bad.update(form if power != 1 else ())
                self._take(reading)
                c = over(1, batch.gains[motion.flange][e])
                self.groups[group] = {f: r * c for f, r in form.items()}
            else:
                self.groups[group] = self._combined(row)

    def _combined(self, row: Combination) -> Form:
        total = Combination()
        for source, c in row.groups.items():
            total.add(Combination(dict(self.groups[source])), c)
        return total.groups

    def _take(self, reading: _Reading) -> None:
        self.bad |= reading.bad
        for f, n in reading.turns.items():
            self.turns[f] = lcm(self.turns.get(f, 1), n)

    def _reading(self, batch: Batch, e: int, *, angles_alone: bool = False) -> _Reading:
        shifts: dict[Any, Form] = {}
        for x, meaning in batch.law.pool.roles.items():
            if meaning.role == "phi" and meaning.of in batch.groups:
                group, gain = batch.groups[meaning.of][e], batch.gains[meaning.of][e]
                form = {} if group == GROUND_GROUP else self.groups.get(group, {})
                shifts[x] = {f: r * gain for f, r in form.items()}
            elif meaning.role == "coordinate" and not angles_alone and meaning.of < len(batch.used):
                shifts[x] = self._coordinate(batch, meaning.of, e)
        return _Reading(batch.law.pool, {x: v[e] for x, v in batch.exact.items()}, shifts)

    def _coordinate(self, batch: Batch, j: int, e: int) -> Form:
        """Turns of a coordinate: only a dependent one over angles moves, and one that is read off angles."""
        if batch.used[j]:
            return self._combined(self.assembly.dependents[batch.sources[j][e]]) if batch.dependent[j] else {}
        values = {x: v[e] for x, v in batch.exact.items()}
        total = Combination()
        for flange, c in batch.law.forms[j].coefficients.items():
            group = batch.groups[flange][e]
            if group != GROUND_GROUP:
                total.add(Combination(dict(self.groups[group])), batch.gains[flange][e] * exact_value(c, values))
        return total.groups

    def read_laws(self, number: int) -> None:
        """What a batch asks of the angles: its laws, and (kept apart) its outputs."""
        batch = self.assembly.batches[number]
        known: dict[Any, tuple[_Reading, list[_Reading]]] = {}
        for e in range(len(batch.components)):
            reading = self._reading(batch, e)
            if not any(reading.shifts.values()):
                continue
            key = (
                tuple(reading.values.items()),
                repr(sorted((str(x), sorted(f.items())) for x, f in reading.shifts.items())),
            )
            if key not in known:
                known[key] = self._read(number, reading), self._read_shows(number, reading)
            law, shows = known[key]
            self._note_tables(number, e, law)
            path = self.assembly.train.components[batch.components[e]].path
            for show, shown in zip(batch.law.shows, shows, strict=True):
                if f"{path}.{show.name}" in self.sensed:
                    self._take(shown)

    def _read(self, number: int, reading: _Reading) -> _Reading:
        law = self.assembly.batches[number].law
        exprs = [*law.expressions(WRAPPED), *(s.surface for s in law.switches if s.table is None)]
        for expr in exprs:
            reading.periodic(sp.sympify(expr))
        self._take(reading)
        return reading

    def _read_shows(self, number: int, law: _Reading) -> list[_Reading]:
        """Each output by itself. One that reads a loop over angles cannot be unwrapped."""
        found = []
        roles, batch = law.pool.roles, self.assembly.batches[number]
        for i, show in enumerate(batch.law.shows):
            reading = _Reading(law.pool, law.values, law.shifts)
            reading.periodic(sp.sympify(show.expr))
            loops = [x for x in show.expr.free_symbols if roles[x].role == "coordinate" and batch.used[roles[x].of]]
            if any(reading.bad & set(law.shifts[x]) for x in loops):
                self.bad |= reading.bad
            found.append(reading)
            self.shown.setdefault((number, i), []).append(reading)
        return found

    def _note_tables(self, number: int, e: int, law: _Reading) -> None:
        switches = self.assembly.batches[number].law.switches
        for (table, quantity), periods in law.tables.items():
            cells = len(law.pool.roles[table].of.x) - 1
            for i, switch in enumerate(switches):
                if switch.table == table and switch.surface == quantity:
                    for f, r in periods.items():
                        self.steps.setdefault(f, []).append((number, i, e, r * cells))

    def result(self) -> AngleWrapping:
        """Wrapped angles, with as many outputs periodic as their turns allow."""
        read = {*self.turns, *(f for readings in self.shown.values() for r in readings for f in r.turns)}
        turns = {f: n for f in read - self.bad if (n := self.turns.get(f, 1)) <= MOST_TURNS}
        found = AngleWrapping()
        for key, readings in self.shown.items():
            if any(reading.bad & turns.keys() for reading in readings):
                found.unwrapped.add(key)
                continue
            wanted = {f: lcm(n, *(r.turns.get(f, 1) for r in readings)) for f, n in turns.items()}
            if any(n > MOST_TURNS for n in wanted.values()):
                found.unwrapped.add(key)
            else:
                turns = wanted
        index = {f: i for i, f in enumerate(sorted(turns))}
        for f in index:
            steps = tuple((b, i, e, int(r * turns[f])) for b, i, e, r in self.steps.get(f, ()))
            found.wrapped.append(WrappedAngle(f, turns[f], steps))
        found.forms = {g: {index[f]: r for f, r in form.items() if f in index} for g, form in self.groups.items()}
        return found
