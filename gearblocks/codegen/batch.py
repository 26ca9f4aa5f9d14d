"""Code of one batch: its law with hoisted terms, and expressions as functions that the template prints."""

from __future__ import annotations

from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.assembly.tables import Batch
from gearblocks.codegen.comments import of_components
from gearblocks.codegen.common_terms import CommonTerms
from gearblocks.codegen.event_functions import EventFunctions
from gearblocks.codegen.function import OUTPUTS, SELDOM, UNROLLED, Argument, Function, Names, column
from gearblocks.codegen.hoisting import Hoister
from gearblocks.codegen.layout import Layout
from gearblocks.codegen.massless_balance import balance_of
from gearblocks.codegen.operands import NONE, Assignment, Operand, Role, Statement
from gearblocks.codegen.parts import Balance
from gearblocks.codegen.symbol_names import Offsets, SymbolNames
from gearblocks.laws.features import narrow_features
from gearblocks.laws.prescribed_motion import frozen_motion

_OF_CONSTRAINTS = ("lower", "upper", "forward", "backward", "engaged", "restitution", "share")


class BatchCode:
    """The hoisted law of one batch, and its expressions as functions."""

    def __init__(self, lay: Layout, number: int, batch: Batch, offsets: Offsets) -> None:
        self.lay, self.number, self.batch, self.offsets = lay, number, batch, offsets
        self.law = batch.law
        self.n = len(batch.components)
        self.components = [lay.assembly.train.components[i] for i in batch.components]
        self.paths = [c.path for c in self.components]
        self.words = of_components(type(self.components[0].block).__name__, self.paths)
        self.hoister = Hoister(self.law.pool)
        self._in_motion: list[Any] = []
        self.symbols = SymbolNames(lay, number, batch, offsets)

    # -- the law with hoisted terms -----------------------------------------------------------------------------------

    def hoist_all(self) -> None:
        """Hoists constant and timed parts of the law's expressions."""
        hoist, apart, law = self.hoist, self.hoister.hoist, self.law
        self.forces = {x: hoist(self.hoister.spread(e)) for x, e in law.forces.items()}
        self.symbols.forces = self.forces
        self.torques = {n: hoist(e) for n, e in law.torques.items()}
        self.rates = {n: hoist(e) for n, e in law.rates.items()}
        self.loss = None if law.loss is None else hoist(law.loss)
        self.supplied = None if law.supplied is None else hoist(law.supplied)
        self.stored = None if law.stored is None else apart(law.stored)
        self.events = EventFunctions(self.lay.assembly, self.batch, hoist)
        self.surfaces = [
            hoist(s.surface) if sort in ("affine", "general") else s.surface
            for s, sort in zip(law.switches, self.events.sorts, strict=True)
        ]
        self.bands = [None if s.band is None else hoist(s.band) for s in law.switches]
        self.whens = [hoist(sp.sympify(s.when)) for s in law.switches]
        self.features = [(hoist(x.argument), x.bounded) for x in narrow_features(law)]
        self.shows = [(x, apart(x.expr)) for x in law.shows]
        self.holds = [(state, hoist(self._held(*rest, state=state))) for state, *rest in law.holds]
        self.speeds = [self._coordinate_rate(j) for j in range(len(law.forms))]
        self.prescribed = [frozen_motion(x, hoist) for x in law.prescribed]
        self.starts = {n: hoist(e) for n, e in law.starts.items()}
        self.constraint_values = {
            name: {k: hoist(v) for k in _OF_CONSTRAINTS if (v := getattr(constraint, k)) is not None}
            for name, constraint in law.constraints.items()
        }
        for name, constraint in law.constraints.items():
            self.constraint_values[name] |= {f"loss_{i}": hoist(x) for i, x in enumerate(constraint.losses or ())}
        self.constraint_loss = None if law.constraint_loss is None else hoist(law.constraint_loss)
        massless = self.offsets.massless
        of = self.offsets.floating_bases, self.offsets.by_mode
        self.balance = balance_of(self.batch, hoist, massless, *of) if massless else Balance()

    def hoist(self, expr: Any) -> Any:
        """An expression that the motion needs, with hoisted terms in it; outputs and energies are hoisted apart."""
        hoisted = self.hoister.hoist(expr)
        self._in_motion.append(hoisted)
        return hoisted

    def _held(self, value: Any, when: Any, *, state: str) -> Any:
        """A state of Hold after an event: the value where `when` has just come to 1 or -1, else as it was."""
        pool = self.law.pool
        modes = [x for x in when.free_symbols if pool.roles[x].role == "mode"]
        before = {x: pool.symbol("before", pool.roles[x].of, f"before{pool.roles[x].of.number}") for x in modes}
        kept = when * when.xreplace(before)  # 1: as before; 0 or -1: not
        starts = when**2 * (1 - kept * (1 + kept) / 2)
        return starts * value + (1 - starts) * pool.symbol("state", state, state)

    def _coordinate_rate(self, j: int) -> Any:
        """Rate of a coordinate from the flange speeds."""
        total: Any = sp.Integer(0)
        for flange, expr in self.law.forms[j].coefficients.items():
            if self.batch.groups[flange][0] != GROUND_GROUP:
                total += self.hoist(expr) * self.law.pool.symbol("w", flange, f"w_{flange}")
        return total

    def moving_terms(self, sensed: set[str]) -> set[Any]:
        """Hoisted terms that the motion needs; the others are read by outputs and energies alone. sensed: names of outputs
        that signals read."""
        exprs = [*self._in_motion, *(e for x, e in self.shows if x.name in sensed)]
        found = {x for e in exprs for x in e.free_symbols}
        for c in reversed(self.hoister.terms):
            if c.symbol in found:
                found |= c.expr.free_symbols
        return found

    def mobile_groups(self) -> list[tuple[int, str]]:
        """(group, path) of every shaft whose mobility the law reads."""
        used = {x for c in self.hoister.terms for x in c.expr.free_symbols}
        flanges = [meaning.of for x, meaning in self.law.pool.roles.items() if meaning.role == "mobility" and x in used]
        return [
            item
            for f in flanges
            if f in self.batch.groups
            for item in zip(self.batch.groups[f], self.paths, strict=True)
            if item[0] != GROUND_GROUP
        ]

    # -- functions ----------------------------------------------------------------------------------------------------

    def names(self, exprs: list[Any], *, vector: Role = Role.STATES) -> Names:
        """C names of all symbols in the expressions, see Names."""
        return self.symbols.of(exprs, vector=vector)

    def function(self, what: str, assignments: list[Assignment], *, vector: Role = Role.STATES) -> Function:
        """A function that stores expressions; vector: see Names. What they have in common is computed once, unless one of
        them reads what another has stored."""
        names = self.names([a.expr for a in assignments], vector=vector)
        for flange in (a.flange for a in assignments):
            if flange is not None:
                self.symbols.speed_key(flange, names)
                self.symbols.gain(flange, names)
        written = NONE.union(*(a.target.written for a in assignments))
        common = CommonTerms(() if written & names.reads else [a.expr for a in assignments])
        body: list[Statement] = []
        for a in assignments:
            body += [names.common(x) for x in common.of(a.expr)]
            body.append(self._statement(a, names))
        return self._function(what, names, body)

    def _function(self, what: str, names: Names, body: list[Statement]) -> Function:
        arguments, constants = list(names.arguments.values()), list(names.constants.items())
        unrolled = 1 if what in SELDOM else UNROLLED
        name = f"{what}_{self.batch.name}"
        return Function(
            name, arguments, constants, body, names.reads, self.n, self.words, (), unrolled, is_apart=what in OUTPUTS
        )

    def _statement(self, a: Assignment, names: Names) -> Statement:
        text = names.print(a.expr)
        factor = a.factor if a.flange is None else self.symbols.gain(a.flange, names)
        return Statement(a.target, a.op, f"{factor} * ({text})" if factor else text, a.full, a.table, a.words)

    def torque(self, flange: str, expr: Any) -> Assignment:
        """Adds a torque on a flange to that on its group, where the balance of the law stands."""
        vector = Role.RATES if self.lay.assembly.plain else Role.TORQUES
        return Assignment(Operand(vector, self.speed_key(flange)), "+=", expr, flange=flange)

    def speed_key(self, flange: str) -> str:
        """The argument with the index of a flange's speed."""
        return self.symbols.speed_key(flange, Names(Role.STATES))

    def coordinate_argument(self, j: int) -> Argument:
        """The argument with the state of coordinate j."""
        return Argument("int", f"q{j}", column(f"{self.batch.name}_q{j}", self.batch.sources[j]))

    def mass(self, flange: str, inertia: Any) -> Function:
        """Adds the bodies of the batch to the inertia of their groups: k^2 J."""
        names = self.names([inertia])
        key = self.symbols.group_key(flange, names, "m")
        gain = self.symbols.gain(flange, names)
        text = f"({names.print(inertia)})" if gain and inertia.is_Add else names.print(inertia)
        target = Operand(Role.PARAMETERS, f"{self.offsets.mass} + {key}")
        body = [Statement(target, "+=", f"{gain} * {gain} * {text}" if gain else text)]
        return self._function(f"mass_{flange}", names, body)
