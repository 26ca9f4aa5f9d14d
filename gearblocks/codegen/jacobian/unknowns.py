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
    moves is left aside); torques, torque_rates: the equations that the torque on a group belongs to, and its torque rate
    (groups between springs alone); with_inertia: speeds of the groups with inertia.
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
        self._prescribed = {
            f.group: _Prescribed(g, f.prescribed) for f in assembly.dependent_groups if f.prescribed is not None
        }
        for f in assembly.dependent_groups:  # each after its sources
            total, motion = Combination(), self._prescribed.get(f.group)
            for source, c in (f.row or motion or total).groups.items():
                total.add(Combination(self.speeds[source]), c)
            if motion is not None:
                total.add(Combination({y - self.n_kinematic: c for y, c in motion.speed.items()}), 1)
            self.speeds[f.group] = total.groups
        damped = g.massless.damped if g.massless is not None else []
        sprung = {self.first_speed + assembly.n_speeds + i for i, by_damper in enumerate(damped) if not by_damper}
        self.by_rate = bool(sprung)
        self.torques, self.torque_rates = self.speeds, self.speeds[:0]
        if not self.plain:
            self.torques = [{i: a for i, a in row.items() if self._turns(i) and i not in sprung} for row in self.speeds]
            self.torque_rates = [{i: a for i, a in row.items() if i in sprung} for row in self.speeds]
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
        is_rate = code.law.pool.roles[x].role == "torque_rate"
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
        """How defined angles change with the angles of other groups and with the state vector, prescribed motions included."""
        groups: list[Row] = []
        states: list[Row] = []
        for group, row in self.definitions:
            if isinstance(row, Combination):
                groups.append(row.groups)
                states.append(row.coordinates)
            else:
                groups.append(self._prescribed[group].groups)
                states.append(self._prescribed[group].angle)
        return groups, states


class _Prescribed:
    """A prescribed motion with constant gains: on groups, and of states of its block (by offset in y) on speed and angle."""

    def __init__(self, g: Generator, row: PrescribedRow) -> None:
        code = next(code for code in g.codes if row.component in code.batch.components)
        motion = code.law.prescribed[row.number]
        total = Combination()
        for flange, (group, factor) in row.factors.items():
            total.add(Combination({group: factor}), exact_value(motion.gains[flange], {}))
        self.groups = total.groups
        e = code.batch.components.index(row.component)
        self.speed = _states(g, code, motion.velocity_bias, e, row.scale)
        self.angle = _states(g, code, motion.angle, e, row.scale) if motion.angle is not None else {}


def _states(g: Generator, code: BatchCode, expr: Any, e: int, scale: Exact) -> Row:
    """The factors of the states of instance e in an expression that is linear in them, by offset in y."""
    roles = code.law.pool.roles
    states = [x for x in sp.sympify(expr).free_symbols if roles[x].role == "state"]
    return {
        g.lay.state0[code.number, roles[x].of] + e: exact_value(sp.diff(expr, x), {}) * scale
        for x in sorted(states, key=lambda x: str(x.name))
    }
