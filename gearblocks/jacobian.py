"""The Jacobian of a train in generated code: places of the matrix, and what each batch adds to it.

A batch whose flanges sit on different independent groups adds by columns of places; any other entry goes through a
sparse table that spreads it over the unknowns it stands for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import sympy as sp

from gearblocks.assemble import speed_row
from gearblocks.batchcode import BatchCode, Function
from gearblocks.generator import Generator, Linear, SenseCode
from gearblocks.layout import Column, column
from gearblocks.pattern import Pattern, eliminate
from gearblocks.rational import Exact
from gearblocks.slopes import Slopes, Target

Row = dict[int, Exact]
"""An unknown of a flange as a combination of unknowns of the train."""
Argument = tuple[str, str, Column]
"""An argument of a function, see Function.args."""


def linear_part(g: Generator) -> Linear | None:
    """The functions of implicit methods and the pattern; None where a law has no derivative, or nothing moves."""
    unknowns = Unknowns(g)
    if unknowns.count == 0:
        return None
    try:
        batches, kept = [], 0
        for code in g.codes:
            slopes = Slopes(code, kept, code.n)
            slopes.add_all()
            batches.append(slopes)
            kept = slopes.kept_end
        senses = SensedSlopes(g, unknowns, kept)
        senses.find({fed.path for slopes in batches for fed in slopes.fed})
        matrix = Matrix(unknowns, senses)
        pattern = eliminate(unknowns.count, matrix.coupled(batches))
        linear = Linear(pattern, unknowns.n_simple, unknowns.first_speed, senses.kept, senses.n_slopes)
        linear.rows = None if unknowns.plain else unknowns.rows
        matrix.write(linear, batches)
        linear.senses = senses.codes()
    except NotImplementedError:  # a law without derivative, or one that C does not know
        return None
    return linear


class Unknowns:
    """Numbers of the unknowns: states of blocks, then independent speeds.

    rows: speed of each group as a combination of independent speeds; plain: each group has a speed of its own.
    """

    def __init__(self, g: Generator) -> None:
        lay, assembly = g.lay, g.assembly
        in_law = lay.angle0 < lay.n
        self.lay = lay
        self.n_simple = lay.n_coordinates + (len(assembly.angles) if in_law else 0)
        self.first_speed = lay.v0 - self.n_simple
        self.count = lay.n - self.n_simple
        self.rows = [speed_row(assembly, group) for group in range(assembly.n_groups)]
        self.plain = all(row == {group: 1} for group, row in enumerate(self.rows))
        shifted = [{self.first_speed + i: a for i, a in row.items()} for row in self.rows]
        self.of_group = shifted

    def of(self, code: BatchCode, x: Any) -> list[Row]:
        """The unknown behind a flange speed or state of each instance."""
        slot = code.law.pool.slots[x]
        if slot.role == "state":
            first = self.lay.state0[code.number, slot.of] - self.n_simple
            return [{first + e: 1} for e in range(code.n)]
        return [self.of_group[group] for group in code.batch.groups[slot.of]]


def _single(rows: Sequence[Row]) -> list[int] | None:
    """The unknowns themselves where no row combines or scales any."""
    found: list[int] = []
    for row in rows:
        if len(row) != 1 or 1 not in row.values():
            return None
        found += row
    return found


# -- outputs that signals read ----------------------------------------------------------------------------------------


class SensedSlopes:
    """Slopes of the sensed outputs that laws depend on: b over unknowns of their own and of what they read in turn."""

    def __init__(self, g: Generator, unknowns: Unknowns, kept: int) -> None:
        self.g, self.unknowns, self.kept = g, unknowns, kept
        self.n_slopes = 0
        self.first: dict[str, int] = {}
        self.rows: dict[str, list[Row]] = {}
        self._parts: list[tuple[Slopes, int, int, list[Target], Any]] = []

    def find(self, wanted: set[str]) -> None:
        """Derivatives of the wanted outputs and of those they read, the latter first."""
        needed: dict[str, None] = {}
        for path in reversed(self.g.senses):  # each reads only earlier ones
            if path in wanted or path in needed:
                needed[path] = None
                sense = self.g.senses[path]
                slots = self.g.codes[sense.batch].law.pool.slots
                needed.update({slots[x].of: None for x in sense.expr.free_symbols if slots[x].role == "sense"})
        for path in self.g.senses:
            if path in needed:
                self._add(path)

    def _add(self, path: str) -> None:
        sense = self.g.senses[path]
        code = self.g.codes[sense.batch]
        slopes = Slopes(code, self.kept, 1)
        found = slopes.gradient(sense.expr)
        self.kept = slopes.kept_end
        self.first[path] = self.n_slopes
        texts, rows = [], []
        for x, b in slopes.own(found).items():
            texts.append(b)
            rows.append(self.unknowns.of(code, x)[sense.instance])
        for other, slope in found.senses.items():
            texts += [slope * slopes.local(f"slope[{self.first[other] + i}]") for i in range(len(self.rows[other]))]
            rows += self.rows[other]
        targets = [(f"slope[{self.n_slopes + i}]", "=", text, False) for i, text in enumerate(texts)]
        self.n_slopes += len(texts)
        self.rows[path] = rows
        self._parts.append((slopes, sense.index, sense.instance, slopes.statements + targets, found.change))

    def codes(self) -> list[SenseCode]:
        """The functions, in the order in which they are called."""
        made = []
        for slopes, index, e, statements, change in self._parts:
            function = slopes.code.function(f"sense_slope_{index}", statements)
            side = slopes.code.function(
                f"sense_change_{index}", [(f"change[{index}]", "=", change, False)], vector="direction"
            )
            made.append(SenseCode(function, _arguments(function, e), side, _arguments(side, e)))
        return made


def _arguments(function: Function, e: int) -> str:
    return ", ".join([str(e), *(c.at(e) for _, _, c in function.args)])


# -- the matrix -------------------------------------------------------------------------------------------------------


class Matrix:
    """Where the entries of batches go."""

    def __init__(self, unknowns: Unknowns, senses: SensedSlopes) -> None:
        self.unknowns, self.senses = unknowns, senses
        self.spread: list[Row] = []

    def coupled(self, batches: Sequence[Slopes]) -> Iterator[tuple[int, int]]:
        """Pairs of unknowns that share an entry."""
        for row in self.unknowns.of_group:
            if len(row) > 1:
                yield from product(row, row)
        for slopes in batches:
            rows = {x: self.unknowns.of(slopes.code, x) for pair in slopes.entries for x in pair}
            for x, y in slopes.entries:
                one, other = _single(rows[x]), _single(rows[y])
                if one is not None and other is not None:
                    yield from zip(one, other, strict=True)
                    continue
                for a, b in zip(rows[x], rows[y], strict=True):
                    yield from product(a, b)
            for fed in slopes.fed:
                for a in self.unknowns.of(slopes.code, fed.row):
                    for b in self.senses.rows[fed.path]:
                        yield from product(a, b)

    def write(self, linear: Linear, batches: Sequence[Slopes]) -> None:
        """The functions of all batches and the table that spreads."""
        for slopes in batches:
            targets, args = self._direct(slopes, linear.pattern) or self._spread(slopes, linear.pattern)
            targets += self._sensed(slopes, linear.pattern)
            function = slopes.code.function("jacobian", [*slopes.statements, *targets])
            function.args += args
            linear.keep("jacobian", function)
            linear.keep("right_side", self._side(slopes))
            linear.keep("simple_rates", _simple_rates(slopes.code))
        linear.first_mass = len(self.spread)
        if not self.unknowns.plain:
            self.spread += [self._entry(linear.pattern, row, row) for row in self.unknowns.of_group]
        linear.spread = self.spread

    def _direct(self, slopes: Slopes, pattern: Pattern) -> tuple[list[Target], list[Argument]] | None:
        """Entries by columns of places, where every symbol is one unknown and no two are the same."""
        places: dict[Any, list[int]] = {}
        for x in {x: None for pair in slopes.entries for x in pair}:
            single = _single(self.unknowns.of(slopes.code, x))
            if single is None:
                return None
            places[x] = single
        symbols = list(places)
        pairs = [
            (x, y)
            for i, x in enumerate(symbols)
            for y in symbols[i + 1 :]
            if (x, y) in slopes.entries or (y, x) in slopes.entries
        ]
        if any(a == b for x, y in pairs for a, b in zip(places[x], places[y], strict=True)):
            return None
        targets: list[Target] = []
        args: list[Argument] = []
        for i, x in enumerate(symbols):
            if (x, x) in slopes.entries:
                args.append(_argument(slopes, f"d{i}", places[x]))
                targets.append((f"diag[d{i}]", "+=", slopes.entries[x, x], False))
        for i, (x, y) in enumerate(pairs):
            at = [pattern.place(a, b) for a, b in zip(places[x], places[y], strict=True)]
            args.append(_argument(slopes, f"p{i}", at))
            one, other = (slopes.entries.get(pair, sp.Integer(0)) for pair in ((x, y), (y, x)))
            parts = ("lower", "upper")
            if one != other:
                side = [int(pattern.is_lower(a, b)) for a, b in zip(places[x], places[y], strict=True)]
                args.append(_argument(slopes, f"l{i}", side))
                parts = (f"(l{i} ? lower : upper)", f"(l{i} ? upper : lower)")
            targets += [(f"{parts[0]}[p{i}]", "+=", one, False), (f"{parts[1]}[p{i}]", "+=", other, False)]
        return targets, args

    def _spread(self, slopes: Slopes, pattern: Pattern) -> tuple[list[Target], list[Argument]]:
        """Entries through the table."""
        targets: list[Target] = []
        for (x, y), value in slopes.entries.items():
            targets.append((f"{len(self.spread)} + e", "spread", value, False))
            pairs = zip(self.unknowns.of(slopes.code, x), self.unknowns.of(slopes.code, y), strict=True)
            self.spread += [self._entry(pattern, a, b) for a, b in pairs]
        return targets, []

    def _sensed(self, slopes: Slopes, pattern: Pattern) -> list[Target]:
        """Entries that a sensed output brings: one per unknown that it depends on."""
        targets: list[Target] = []
        for fed in slopes.fed:
            rows = self.unknowns.of(slopes.code, fed.row)
            for i, other in enumerate(self.senses.rows[fed.path]):
                value = fed.value * slopes.local(f"slope[{self.senses.first[fed.path] + i}]")
                targets.append((f"{len(self.spread)} + e", "spread", value, False))
                self.spread += [self._entry(pattern, row, other) for row in rows]
        return targets

    @staticmethod
    def _entry(pattern: Pattern, row: Row, other: Row) -> Row:
        """Where an entry between two combinations of unknowns goes: 3 place + 0 in diag, 1 in lower, 2 in upper."""
        found: Row = {}
        for (i, a), (j, b) in product(row.items(), other.items()):
            key = 3 * i if i == j else 3 * pattern.place(i, j) + (1 if pattern.is_lower(i, j) else 2)
            found[key] = found.get(key, 0) + a * b
        return found

    def _side(self, slopes: Slopes) -> Function:
        """What the batch adds to the right side: torques of groups, rates of states."""
        targets: list[Target] = []
        args: dict[str, Argument] = {}
        for i, (row, change) in enumerate(slopes.sides):
            if change == 0:
                continue
            value = slopes.local(f"r{i}")
            targets.append((f"const double r{i}", "=", slopes.g * change, False))
            for x, a in row.items():
                slot = slopes.code.law.pool.slots[x]
                if slot.role == "w":
                    args[f"g_{slot.of}"] = _argument(slopes, f"g_{slot.of}", slopes.code.batch.groups[slot.of])
                    targets.append((f"turn[g_{slot.of}]", "+=", a * value, False))
                else:
                    first = self.unknowns.of(slopes.code, x)[0]
                    targets.append((f"out[{next(iter(first))} + e]", "+=", a * value, False))
        function = slopes.code.function("right_side", targets, vector="direction")
        known = {name for _, name, _ in function.args}
        function.args += [arg for name, arg in args.items() if name not in known]
        return function


def _argument(slopes: Slopes, name: str, values: Sequence[int]) -> Argument:
    return "int", name, column(f"{slopes.code.batch.name}_{name}", values)


def _simple_rates(code: BatchCode) -> Function:
    """Rates of the coordinates of a batch from the speeds of groups."""
    own = [j for j in range(len(code.speeds)) if code.batch.used[j] and not code.batch.dependent[j]]
    function = code.function("simple_rates", [(f"out[q{j}]", "=", code.speeds[j], False) for j in own], vector="speed")
    function.args += [("int", f"q{j}", column(f"{code.batch.name}_q{j}", code.batch.sources[j])) for j in own]
    return function
