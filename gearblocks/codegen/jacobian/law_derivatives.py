"""Symbolic derivatives of the laws of one batch, as a step of an implicit method needs them.

The unknowns of a law are the speeds of its flanges and its states; their symbols stand for them here. Coordinates and
angles follow from them: with g = gamma h, an expression E contributes b = g dE/dx + g^2 dE/ds B, where s' = B x. The
derivatives are those of the hoisted expressions, so that they need no terms of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.operands import Assignment, Local, Operand, Role
from gearblocks.laws.derivative import derivative
from gearblocks.laws.vanishing import vanishes


@dataclass(slots=True)
class Gradient:
    """What an expression changes by: b of each unknown; its change along kinematic states, over numbers that are kept; and
    its slope over each feedback signal, by path."""

    unknowns: dict[Any, Any] = field(default_factory=dict)
    change: Any = 0
    feedback: dict[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class Fed:
    """An entry of the matrix that comes from a feedback signal: row of the unknown, minus value * b of the output."""

    row: Any
    path: str
    value: Any


class Slopes:
    """Derivatives of one batch: statements that compute them and what they add to the matrix.

    kept_at: the first of the numbers that it keeps (`width` of each kind); kept_end: the first after them.
    entries: by (row, column) in symbols of unknowns. sides: what right_side does. direct: whether coordinates and angles
    stand for themselves (unknowns_varying.py); else their rates stand for them.
    """

    def __init__(self, code: BatchCode, kept_at: int, width: int, *, direct: bool = False) -> None:
        self.code, self.width, self.direct = code, width, direct
        self.kept_end = kept_at
        self.statements: list[Assignment] = []
        self.entries: dict[tuple[Any, Any], Any] = {}
        self.fed: list[Fed] = []
        self.sides: list[tuple[dict[Any, Any], Any]] = []
        self.g = self.local(Operand(Role.STEP))

    def local(self, operand: Operand | Local) -> Any:
        """The symbol of a number that the functions here write or are given."""
        return self.code.law.pool.symbol("local", operand, f"local_{operand}")

    def number(self, name: str, expr: Any) -> Any:
        """The symbol of a number that a statement computes under that name."""
        self.statements.append(Assignment(Local(name), "define", expr))
        return self.local(Local(name))

    def keep(self, expr: Any) -> tuple[Any, Any]:
        """A number that later functions need as well: its symbol now, and then."""
        place = Operand(Role.KINEMATIC_TERMS, self.kept_end, instance=self.width > 1)
        symbol = self.number(f"n{self.kept_end}", expr)
        self.statements.append(Assignment(place, "=", symbol))
        self.kept_end += self.width
        return symbol, self.local(place)

    # -- derivatives --------------------------------------------------------------------------------------------------

    def gradient(self, expr: Any) -> Gradient:
        """The derivatives of an expression of the batch. NotImplementedError where there is no formula."""
        found = Gradient()
        roles, g = self.code.law.pool.roles, self.g
        for x, slope in partial(self.code, sp.sympify(expr).xreplace(self.code.forces)):
            role = roles[x].role
            if role in ("w", "state") or (self.direct and role != "sense"):
                found.unknowns[x] = found.unknowns.get(x, 0) + g * slope
                continue
            if self.direct:
                found.feedback[roles[x].of] = slope
                continue
            now, then = self.keep(slope)
            if role == "sense":
                found.feedback[roles[x].of] = now
                found.change += then * self.local(self._change(roles[x].of))
                continue
            for w, c in self._rate_of(x):
                found.unknowns[w] = found.unknowns.get(w, 0) + g**2 * c * now
            found.change += then * x
        return found

    def _change(self, path: str) -> Operand:
        """The change of a feedback signal."""
        return Operand(Role.SIGNAL_CHANGES, self.code.offsets.feedback[path])

    def _rate_of(self, x: Any) -> Iterator[tuple[Any, Any]]:
        """(speed, coefficient) of the rate of a coordinate or an angle."""
        meaning = self.code.law.pool.roles[x]
        if meaning.role == "phi":
            yield self._speed(meaning.of), sp.Integer(1)
            return
        rate = self.code.speeds[meaning.of]
        for w in sorted(rate.free_symbols, key=lambda x: str(x.name)):
            if self.code.law.pool.roles[w].role == "w":
                yield w, derivative(rate, w)

    def _speed(self, flange: str) -> Any:
        return self.code.law.pool.symbol("w", flange, f"w_{flange}")

    # -- what the batch adds ------------------------------------------------------------------------------------------

    def add_all(self, *, with_torque_rates: bool) -> None:
        """Forces along their deflections, other torques, rates of states, and rates of torques where they are wanted."""
        code, pool = self.code, self.code.law.pool
        torques = {f: e for f, e in code.torques.items() if code.batch.groups[f][0] != GROUND_GROUP}
        for force, expr in code.forces.items():
            row = {self._speed(f): a for f, e in torques.items() if (a := derivative(e, force)) != 0}
            if row:
                self._add(row, expr)
        none = dict.fromkeys(code.forces, sp.Integer(0))
        for flange, expr in torques.items():
            self._add({self._speed(flange): sp.Integer(1)}, expr.xreplace(none))
        for state, expr in code.rates.items():
            self._add({pool.symbol("state", state, state): sp.Integer(1)}, expr)
        for flange, expr in code.balance.torque_rates.items() if with_torque_rates else ():
            self._add({pool.symbol("torque_rate", flange, f"torque_rate_{flange}"): sp.Integer(1)}, expr)
        self._add_losses()
        self._add_heat()

    def _add_heat(self) -> None:
        """What a lossy gear heats by the force inside it, at a fixed force; what that does: heat_of_forces.c.jinja."""
        law = self.code.law
        if law.heat and self.code.constraint_loss is not None:
            state = law.pool.symbol("state", law.heat, law.heat)
            names = {name: f"held_{name}".rstrip("_") for name in law.constraints}
            forces = {law.pool.symbol("constraint_force", x, held): self._force(x) for x, held in names.items()}
            self._add({state: sp.Integer(1)}, self.code.constraint_loss.xreplace(forces))

    def _force(self, name: str) -> Any:
        """The symbol of the force of a switched constraint, as it is at the front."""
        return self.local(Operand(Role.CONSTRAINT_FORCES, self.code.offsets.constraints[name], instance=True))

    def _add_losses(self) -> None:
        """What lossy gears lose of the force inside them, where that part changes with the motion, at a fixed force."""
        for name, constraint in self.code.law.constraints.items():
            if constraint.share is None or constraint.partner is None:
                continue
            share = self.code.constraint_values[name]["share"]
            if next(partial(self.code, share), None) is None:
                continue
            row = {
                self._speed(flange): -c
                for flange, c in self.code.law.constraints[constraint.partner].row.items()
                if self.code.batch.groups[flange][0] != GROUND_GROUP
            }
            self._add(row, share * self._force(name))

    def _add(self, row: dict[Any, Any], expr: Any) -> None:
        """A term of the rates of the unknowns of `row`, each with its coefficient: S -= row b'."""
        found = self.gradient(expr)
        name = len(self.sides)
        pivot = next((x for x, a in row.items() if a.is_Number), None)
        if pivot is not None and self._is_along(row, found.unknowns, pivot):
            one = self.number(f"s{name}", -found.unknowns[pivot] / row[pivot])
            columns = {x: one * a for x, a in row.items()}
        else:
            columns = {x: self.number(f"s{name}_{i}", -b) for i, (x, b) in enumerate(found.unknowns.items())}
        for x, a in row.items():
            for y, b in columns.items():
                self.entries[x, y] = self.entries.get((x, y), 0) + a * b * self._gain(x) * self._gain(y)
            for path, slope in found.feedback.items():
                self.fed.append(Fed(x, path, -a * slope * self._gain(x)))
        self.sides.append(({x: a * self._gain(x) for x, a in row.items()}, found.change))

    def _gain(self, x: Any) -> Any:
        """The gain of an unknown on the unknown of its group, where it is not 1 throughout."""
        meaning = self.code.law.pool.roles[x]
        if meaning.role in ("state", "coordinate") or all(gain == 1 for gain in self.code.batch.gains[meaning.of]):
            return sp.Integer(1)
        return self.code.law.pool.symbol("gain", meaning.of, f"k_{meaning.of}")

    def own(self, found: Gradient) -> dict[Any, Any]:
        """b by unknown, with the gains of flanges."""
        return {x: b * self._gain(x) for x, b in found.unknowns.items()}

    def _is_along(self, row: dict[Any, Any], b: dict[Any, Any], pivot: Any) -> bool:
        """Whether b is a multiple of the row, as where damping and spring act along one deflection."""
        if len(row) < 2 or set(b) != set(row):
            return False
        whole = {c.symbol: c.expr for c in self.code.hoister.terms}
        for x, a in row.items():
            left = b[x] * row[pivot] - b[pivot] * a
            while left.free_symbols & whole.keys():
                left = left.xreplace(whole)
            if not vanishes(left, self.code.law):
                return False
        return True


def partial(code: BatchCode, expr: Any) -> Iterator[tuple[Any, Any]]:
    """(symbol, derivative) of an expression of a batch over everything that moves, branches frozen.

    NotImplementedError where there is no formula.
    """
    expr = sp.sympify(expr)
    roles = code.law.pool.roles
    steady = {h: sp.Dummy(real=True) for h in expr.atoms(sp.Heaviside)}
    expr = expr.xreplace(steady)
    for x in sorted(expr.free_symbols & roles.keys(), key=lambda x: str(x.name)):
        meaning = roles[x]
        if meaning.role in ("alpha", "tau", "constraint_force"):
            raise NotImplementedError(f"no derivative by {x}")
        if meaning.role not in ("w", "phi", "state", "coordinate", "sense"):
            continue
        if meaning.role in ("w", "phi") and code.batch.groups[meaning.of][0] == GROUND_GROUP:
            continue
        slope = derivative(expr, x)
        if slope.has(sp.Derivative, sp.Subs, sp.DiracDelta):
            raise NotImplementedError(f"no formula for the derivative of {expr} by {x}")
        if slope != 0:
            yield x, slope.xreplace({dummy: h for h, dummy in steady.items()})
