"""The Jacobian of a train in generated code: offsets in the matrix, and what each batch adds to it.

A batch whose flanges sit on different independent groups adds by columns of offsets; any other entry goes through a
sparse table that spreads it over the unknowns it stands for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import sympy as sp

from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.function import Argument, Function, column
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.jacobian.law_derivatives import Slopes
from gearblocks.codegen.jacobian.sparsity import Pattern, eliminate, read_by_none
from gearblocks.codegen.jacobian.unknowns import Unknowns
from gearblocks.codegen.jacobian.unknowns_varying import Varying
from gearblocks.codegen.operands import Assignment, Choice, Index, Local, Operand, Role
from gearblocks.codegen.parts import Call, Computed, GroupRows, Linear, SignalDerivatives
from gearblocks.train.disjoint_sets import DisjointSets


def linear_part(g: Generator) -> Linear | None:
    """The functions of implicit methods and the pattern; None where a law has no derivative."""
    try:
        unknowns: Unknowns | Varying = Unknowns(g) if is_linear(g) else Varying(g)
        batches, kept = [], 0
        for code in g.codes:
            slopes = Slopes(code, kept, code.n, direct=isinstance(unknowns, Varying))
            slopes.add_all(with_torque_rates=unknowns.by_rate)
            batches.append(slopes)
            kept = slopes.kept_end
        feedback = SignalSlopes(g, unknowns, kept)
        feedback.find({fed.path for slopes in batches for fed in slopes.fed})
        matrix = Matrix(unknowns, feedback)
        forces = frozenset(unknowns.first_speed + group for group in g.assembly.force_unknowns)
        pattern = _pattern(g, unknowns, matrix.coupled(batches), forces)
        linear = Linear(pattern, unknowns.n_kinematic, unknowns.first_speed, feedback.kept, feedback.n_slopes)
        if isinstance(unknowns, Unknowns) and not unknowns.plain:
            linear.group_rows = GroupRows(
                unknowns.speeds,
                unknowns.with_inertia,
                unknowns.torques,
                unknowns.torque_rates,
                unknowns.by_rate,
                *unknowns.tilts(),
            )
        matrix.write(linear, batches)
        linear.feedback = feedback.codes()
    except NotImplementedError:  # a law without derivative, or one that C does not know
        return None
    return linear


def _pattern(
    g: Generator, unknowns: Unknowns | Varying, pairs: Iterator[tuple[int, int]], forces: frozenset[int]
) -> Pattern:
    """That of the matrix: states that nothing reads go ahead, and speeds that a constraint may tie are neighbours where that
    closes no ring (gb_step_constraints.h)."""
    ties = [row for row in g.constraints.rows if len(row) == 2]
    if isinstance(unknowns, Varying) or not (ties or unknowns.first_speed):
        return eliminate(unknowns.count, pairs, forces)
    coupled = list(pairs)
    ahead = read_by_none(coupled, range(unknowns.first_speed))
    rings: DisjointSets[int] = DisjointSets()
    away = set(ahead)
    for i, j in coupled if ties else ():
        if i not in away and j not in away:
            rings.join(i, j)
    for row in ties:
        one, other = (unknowns.first_speed + g.constraints.speeds[k] for k in row)
        if rings.root(one) != rings.root(other):
            rings.join(one, other)
            coupled.append((one, other))
    return eliminate(unknowns.count, coupled, forces, ahead)


def is_linear(g: Generator) -> bool:
    """Whether all groups move by fixed combinations of speeds and states."""
    return len(g.assembly.steady) == g.assembly.n_groups


def _single(rows: Sequence[Any]) -> list[int] | None:
    """The unknowns themselves where no row combines or scales any."""
    found: list[int] = []
    for row in rows:
        if len(row) != 1 or 1 not in row.values():
            return None
        found += row
    return found


# -- outputs that signals read ----------------------------------------------------------------------------------------


class SignalSlopes:
    """Slopes of the feedback signals that laws read: b over unknowns of their own and of what they read in turn."""

    def __init__(self, g: Generator, unknowns: Unknowns | Varying, kept: int) -> None:
        self.g, self.unknowns, self.kept = g, unknowns, kept
        self.n_slopes = 0
        self.first: dict[str, int] = {}
        self.rows: dict[str, list[Any]] = {}
        self._parts: list[tuple[Slopes, int, int, list[Assignment], Any]] = []

    def find(self, wanted: set[str]) -> None:
        """Derivatives of the wanted outputs and of those they read, the latter first."""
        needed: dict[str, None] = {}
        for path in reversed(self.g.feedback):  # each reads only earlier ones
            if path in wanted or path in needed:
                needed[path] = None
                signal = self.g.feedback[path]
                roles = self.g.codes[signal.batch].law.pool.roles
                needed.update({roles[x].of: None for x in signal.expr.free_symbols if roles[x].role == "sense"})
        for path in self.g.feedback:
            if path in needed:
                self._add(path)

    def _add(self, path: str) -> None:
        signal = self.g.feedback[path]
        code = self.g.codes[signal.batch]
        slopes = Slopes(code, self.kept, 1, direct=isinstance(self.unknowns, Varying))
        found = slopes.gradient(signal.expr)
        self.kept = slopes.kept_end
        self.first[path] = self.n_slopes
        exprs, rows = [], []
        for x, b in slopes.own(found).items():
            exprs.append(b)
            rows.append(self.unknowns.columns(code, x)[signal.instance])
        for other, slope in found.feedback.items():
            exprs += [
                slope * slopes.local(Operand(Role.SIGNAL_SLOPES, self.first[other] + i))
                for i in range(len(self.rows[other]))
            ]
            rows += self.rows[other]
        targets = [
            Assignment(Operand(Role.SIGNAL_SLOPES, self.n_slopes + i), "=", expr) for i, expr in enumerate(exprs)
        ]
        self.n_slopes += len(exprs)
        self.rows[path] = rows
        self._parts.append((slopes, signal.index, signal.instance, slopes.statements + targets, found.change))

    def codes(self) -> list[SignalDerivatives]:
        """The functions, in the order in which they are called."""
        made = []
        for slopes, index, e, statements, change in self._parts:
            function = slopes.code.function(f"feedback_slope_{index}", statements)
            along = Assignment(Operand(Role.SIGNAL_CHANGES, index), "=", change)
            side = slopes.code.function(f"feedback_change_{index}", [along], vector=Role.DIRECTION)
            made.append(SignalDerivatives(Call(function, e), Call(side, e)))
        return made


# -- the matrix -------------------------------------------------------------------------------------------------------


class Matrix:
    """Where the entries of batches go."""

    def __init__(self, unknowns: Unknowns | Varying, feedback: SignalSlopes) -> None:
        self.unknowns, self.feedback = unknowns, feedback
        self.spread: list[Any] = []
        self._lone: dict[tuple[int, Any], tuple[list[int] | None, list[int] | None]] = {}
        self.op = "spread_terms" if isinstance(unknowns, Varying) else "spread"

    def coupled(self, batches: Sequence[Slopes]) -> Iterator[tuple[int, int]]:
        """Pairs of unknowns that share an entry."""
        inertias: Iterator[Any] = zip(self.unknowns.torques, self.unknowns.with_inertia, strict=True)
        rows: list[Any] = [pair for pair in inertias if len(pair[1]) > 1]
        if isinstance(self.unknowns, Varying):
            rows += self.unknowns.own()
        for slopes in batches:
            for x, y in slopes.entries:
                one, other = (
                    (None, None) if self.op != "spread" else (self._alone(slopes, x)[0], self._alone(slopes, y)[1])
                )
                if one is not None and other is not None:
                    yield from zip(one, other, strict=True)
                else:
                    of_x, of_y = self.unknowns.equations(slopes.code, x), self.unknowns.columns(slopes.code, y)
                    rows += zip(of_x, of_y, strict=True)
            for fed in slopes.fed:
                rows += product(self.unknowns.equations(slopes.code, fed.row), self.feedback.rows[fed.path])
        for pair in rows:
            yield from ((i, j) for i, j in product(*pair) if j >= 0)

    def _alone(self, slopes: Slopes, x: Any) -> tuple[list[int] | None, list[int] | None]:
        """Of a symbol, by instance, the equation of a torque on it and the unknown behind it, where each is one alone."""
        key = slopes.code.number, x
        if key not in self._lone:
            rows = self.unknowns.equations(slopes.code, x), self.unknowns.columns(slopes.code, x)
            self._lone[key] = _single(rows[0]), _single(rows[1])
        return self._lone[key]

    def write(self, linear: Linear, batches: Sequence[Slopes]) -> None:
        """The functions of all batches and the table that spreads."""
        for slopes in batches:
            targets, args = self._direct(slopes, linear.pattern) or (self._spread(slopes, linear.pattern), [])
            targets += self._sensed(slopes, linear.pattern)
            function = slopes.code.function("step_matrix", [*slopes.statements, *targets])
            function.take(args)
            linear.keep("step_matrix", function)
            if self.op == "spread":
                linear.keep("right_side", self._side(slopes))
                linear.keep("kinematic_rates", _kinematic_rates(slopes.code))
        linear.first_mass = len(self.spread)
        if not self.unknowns.plain:
            inertias = zip(self.unknowns.torques, self.unknowns.with_inertia, strict=True)
            self.spread += [self._entry(linear.pattern, *pair) for pair in inertias]
        if isinstance(self.unknowns, Varying):
            self._write_computed(self.unknowns, linear)
        else:
            linear.spread = self.spread

    def _write_computed(self, unknowns: Varying, linear: Linear) -> None:
        """What groups with gains that change add, and the tables of their rows."""
        pattern, numbers = linear.pattern, unknowns.numbers
        for function in unknowns.functions:
            linear.keep("prescribed_derivatives", function)
        linear.computed = computed = Computed(
            [float(x) for x in numbers.start], unknowns.g, unknowns.gains, numbers.steps, unknowns.with_inertia,
            unknowns.accelerations, [],
            unknowns.kinematic_rates(), [group for group, *_ in unknowns.reduced],
        )  # fmt: skip
        computed.first_acceleration_bias = len(self.spread)
        biased = zip(unknowns.with_inertia, unknowns.accelerations, strict=True)
        self.spread += [self._entry(pattern, *pair) for pair in biased]
        computed.first_reduced = len(self.spread)
        self.spread += [self._entry(pattern, row, other) for _, row, other in unknowns.reduced]
        computed.rates = len(self.spread)
        self.spread.append([term for pair in unknowns.rates() for term in self._entry(pattern, *pair)])
        linear.terms, computed.entries = self.spread, list(unknowns.kept)

    def _direct(self, slopes: Slopes, pattern: Pattern) -> tuple[list[Assignment], list[Argument]] | None:
        """Entries by columns of offsets, where every symbol is one unknown and no two are the same."""
        if self.op != "spread":
            return None
        places: dict[Any, list[int]] = {}
        for x in {x: None for pair in slopes.entries for x in pair}:
            if slopes.code.law.pool.roles[x].role == "torque_rate":
                return None
            equation, single = self._alone(slopes, x)
            if single is None or single != equation:
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
        targets: list[Assignment] = []
        args: list[Argument] = []
        for i, x in enumerate(symbols):
            if (x, x) in slopes.entries:
                args.append(_argument(slopes, f"d{i}", places[x]))
                targets.append(Assignment(Operand(Role.DIAGONAL, f"d{i}"), "+=", slopes.entries[x, x]))
        for i, (x, y) in enumerate(pairs):
            at = [pattern.place(a, b) for a, b in zip(places[x], places[y], strict=True)]
            args.append(_argument(slopes, f"p{i}", at))
            one, other = (slopes.entries.get(pair, sp.Integer(0)) for pair in ((x, y), (y, x)))
            parts: tuple[Operand | Choice, ...] = (Operand(Role.LOWER, f"p{i}"), Operand(Role.UPPER, f"p{i}"))
            if one != other:
                side = [int(pattern.is_lower(a, b)) for a, b in zip(places[x], places[y], strict=True)]
                args.append(_argument(slopes, f"l{i}", side))
                parts = (
                    Choice(f"l{i}", Role.LOWER, Role.UPPER, f"p{i}"), Choice(f"l{i}", Role.UPPER, Role.LOWER, f"p{i}")
                )  # fmt: skip
            targets += [Assignment(parts[0], "+=", one), Assignment(parts[1], "+=", other)]
        return targets, args

    def _spread(self, slopes: Slopes, pattern: Pattern) -> list[Assignment]:
        """Entries through the table."""
        targets: list[Assignment] = []
        for (x, y), value in slopes.entries.items():
            targets.append(Assignment(Index(len(self.spread), instance=True), self.op, value))
            equations, columns = self.unknowns.equations(slopes.code, x), self.unknowns.columns(slopes.code, y)
            self.spread += [self._entry(pattern, a, b) for a, b in zip(equations, columns, strict=True)]
        return targets

    def _sensed(self, slopes: Slopes, pattern: Pattern) -> list[Assignment]:
        """Entries that a feedback signal brings: one per unknown that it depends on."""
        targets: list[Assignment] = []
        for fed in slopes.fed:
            rows = self.unknowns.equations(slopes.code, fed.row)
            for i, other in enumerate(self.feedback.rows[fed.path]):
                value = fed.value * slopes.local(Operand(Role.SIGNAL_SLOPES, self.feedback.first[fed.path] + i))
                targets.append(Assignment(Index(len(self.spread), instance=True), self.op, value))
                self.spread += [self._entry(pattern, row, other) for row in rows]
        return targets

    def _entry(self, pattern: Pattern, row: Any, other: Any) -> Any:
        """Where an entry between two rows goes."""
        return self.unknowns.entry(pattern, row, other)

    def _side(self, slopes: Slopes) -> Function:
        """What the batch adds to the right side: torques of groups, rates of states."""
        targets: list[Assignment] = []
        args: dict[str, Argument] = {}
        for i, (row, change) in enumerate(slopes.sides):
            if change == 0:
                continue
            value = slopes.local(Local(f"r{i}"))
            targets.append(Assignment(Local(f"r{i}"), "define", slopes.g * change))
            for x, a in row.items():
                meaning = slopes.code.law.pool.roles[x]
                if meaning.role == "state":
                    first = self.unknowns.columns(slopes.code, x)[0]
                    out = Operand(Role.OUTPUTS, next(iter(first)), instance=True)
                    targets.append(Assignment(out, "+=", a * value))
                else:
                    args[f"g_{meaning.of}"] = _argument(slopes, f"g_{meaning.of}", slopes.code.batch.groups[meaning.of])
                    vector = Role.TORQUE_CHANGES if meaning.role == "w" else Role.TORQUE_RATE_CHANGES
                    targets.append(Assignment(Operand(vector, f"g_{meaning.of}"), "+=", a * value))
        function = slopes.code.function("right_side", targets, vector=Role.DIRECTION)
        function.take(args.values())
        return function


def _argument(slopes: Slopes, name: str, values: Sequence[int]) -> Argument:
    return Argument("int", name, column(f"{slopes.code.batch.name}_{name}", values))


def _kinematic_rates(code: BatchCode) -> Function:
    """Rates of the coordinates of a batch from the speeds of groups."""
    own = [j for j in range(len(code.speeds)) if code.batch.used[j] and not code.batch.dependent[j]]
    targets = [Assignment(Operand(Role.OUTPUTS, f"q{j}"), "=", code.speeds[j]) for j in own]
    function = code.function("kinematic_rates", targets, vector=Role.GROUP_SPEEDS)
    function.take(code.coordinate_argument(j) for j in own)
    return function
