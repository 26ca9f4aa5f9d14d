"""The unknowns of implicit methods: states of blocks, then speeds of independent groups, then those of massless groups."""

from __future__ import annotations

from itertools import product
from typing import Any

import sympy as sp

from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.kinematics import PrescribedRow
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.laws.rational import Exact, exact_value

Row = dict[int, Exact]
"""Something of a group as a combination of unknowns."""


class Unknowns:
    """Numbers of the unknowns, and how the speeds and torques of groups belong to them.

    n_kinematic: states before them; first_speed: the unknown of the first speed. speeds: of each group (what time alone
    moves is left aside); torques, torque_rates: where the torque on a group counts, and the rate of it (shafts that springs
    alone hold); with_inertia: speeds of the groups with inertia.
    """

    def __init__(self, g: Generator) -> None:
        lay, assembly = g.lay, g.assembly
        self.lay, self.plain = lay, assembly.plain
        self.n_kinematic = lay.n_coordinates + (len(assembly.angles) if lay.angle0 < lay.n else 0)
        self.first_speed = lay.v0 - self.n_kinematic
        self.count = lay.n + assembly.n_massless - self.n_kinematic
        free = range(assembly.n_speeds + assembly.n_massless)
        self.speeds: list[Row] = [{self.first_speed + group: 1} for group in free]
        self.speeds += [{} for _ in range(assembly.n_groups - len(free))]
        self._drives = {f.group: _Drive(g, f.prescribed) for f in assembly.dependent_groups if f.prescribed is not None}
        for f in assembly.dependent_groups:  # each after what it follows
            total, drive = Combination(), self._drives.get(f.group)
            for source, c in (f.row or drive or total).groups.items():
                total.add(Combination(self.speeds[source]), c)
            if drive is not None:
                total.add(Combination({y - self.n_kinematic: c for y, c in drive.speed.items()}), 1)
            self.speeds[f.group] = total.groups
        damped = g.massless.damped if g.massless is not None else []
        held = {self.first_speed + assembly.n_speeds + i for i, by_damper in enumerate(damped) if not by_damper}
        self.by_rate = bool(held)
        self.torques, self.torque_rates = self.speeds, self.speeds[:0]
        if not self.plain:
            self.torques = [{i: a for i, a in row.items() if self._turns(i) and i not in held} for row in self.speeds]
            self.torque_rates = [{i: a for i, a in row.items() if i in held} for row in self.speeds]
        with_inertia = assembly.with_inertia | set(range(assembly.n_speeds))
        self.with_inertia = [row if group in with_inertia else {} for group, row in enumerate(self.speeds)]
        self.definitions = assembly.definitions

    def _turns(self, unknown: int) -> bool:
        return unknown >= self.first_speed

    def columns(self, code: BatchCode, x: Any) -> list[Row]:
        """The unknowns behind a flange speed or state of each instance."""
        return self._of(code, x, self.speeds)

    def equations(self, code: BatchCode, x: Any) -> list[Row]:
        """The equations that the torque on a flange, its rate of change or the rate of a state belongs to."""
        is_rate = code.law.pool.roles[x].role == "growth"
        return self._of(code, x, self.torque_rates if is_rate else self.torques)

    def _of(self, code: BatchCode, x: Any, of_group: list[Row]) -> list[Row]:
        meaning = code.law.pool.roles[x]
        if meaning.role == "state":
            first = self.lay.state0[code.number, meaning.of] - self.n_kinematic
            return [{first + e: 1} for e in range(code.n)]
        return [of_group[group] for group in code.batch.groups[meaning.of]]

    @staticmethod
    def entry(pattern: Pattern, row: Row, other: Row) -> Row:
        """Where an entry between two combinations of unknowns goes: 3 place + 0 in diag, 1 in lower, 2 in upper."""
        found: Row = {}
        for (i, a), (j, b) in product(row.items(), other.items()):
            key = 3 * i if i == j else 3 * pattern.place(i, j) + (1 if pattern.is_lower(i, j) else 2)
            found[key] = found.get(key, 0) + a * b
        return found

    def tilts(self) -> tuple[list[Row], list[Row]]:
        """How defined angles change with the angles of other groups and with the state vector, drives included."""
        groups: list[Row] = []
        states: list[Row] = []
        for group, row in self.definitions:
            if isinstance(row, Combination):
                groups.append(row.groups)
                states.append(row.coordinates)
            else:
                groups.append(self._drives[group].groups)
                states.append(self._drives[group].angle)
        return groups, states


class _Drive:
    """A drive with constant gains: on groups, and of states of its block (by place in y) on the speed and the angle."""

    def __init__(self, g: Generator, driven: PrescribedRow) -> None:
        code = next(code for code in g.codes if driven.component in code.batch.components)
        drive = code.law.prescribed[driven.number]
        total = Combination()
        for flange, (group, factor) in driven.factors.items():
            total.add(Combination({group: factor}), exact_value(drive.gains[flange], {}))
        self.groups = total.groups
        e = code.batch.components.index(driven.component)
        self.speed = _states(g, code, drive.velocity_bias, e, driven.scale)
        self.angle = _states(g, code, drive.angle, e, driven.scale) if drive.angle is not None else {}


def _states(g: Generator, code: BatchCode, expr: Any, e: int, scale: Exact) -> Row:
    """The factors of the states of instance e in an expression that is linear in them, by place in y."""
    slots = code.law.pool.roles
    states = [x for x in sp.sympify(expr).free_symbols if slots[x].role == "state"]
    return {
        g.lay.state0[code.number, slots[x].of] + e: exact_value(sp.diff(expr, x), {}) * scale
        for x in sorted(states, key=lambda x: str(x.name))
    }
