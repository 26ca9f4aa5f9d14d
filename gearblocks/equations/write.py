"""The equations of a whole train for people: every equation written out in sympy, as text, LaTeX or MathML.

Angle form: J w' = sum of torques for every shaft. Relative form: the same in deflections, where only they matter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any, TypeAlias

import sympy as sp

from gearblocks.assembly.assemble import assemble
from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.equations.dependent_groups import DependentGroups, over_independent_groups, rational
from gearblocks.equations.equations import Equations
from gearblocks.equations.lexicon import Lexicon, flat
from gearblocks.equations.repeated_terms import Part, with_symbols
from gearblocks.equations.sections import base
from gearblocks.equations.switched_constraints import SwitchedConstraint
from gearblocks.errors import ModelError
from gearblocks.language.block import start_fields
from gearblocks.language.expression import to_sympy
from gearblocks.language.fields import ANGLE
from gearblocks.language.units import unit_along
from gearblocks.laws.derivation import derive
from gearblocks.laws.law import Law
from gearblocks.laws.prescribed_motion import PrescribedMotion, frozen_motion
from gearblocks.laws.switched_constraints import ConstraintLaw
from gearblocks.laws.symbols import SymbolRole, time_symbol
from gearblocks.train.expression_depth import refused_where_too_deep
from gearblocks.train.graph import GROUND, Component, Train
from gearblocks.train.structure import structure_of
from gearblocks.train.translational import flange_names, slider_names

Rows: TypeAlias = tuple[tuple[tuple[str, Any], ...], ...]
"""Terms of the balances by the part that they are of."""


def write_equations(train: Train) -> Equations:
    """The equations of a train; laws are derived once per kind and written out for every component."""
    with refused_where_too_deep(train.components):
        writer = _Writer(assemble(train, reading=True))
        for c in train.components:
            writer.write(c)
        return writer.finish()


class _Writer:
    """Adds up the torques of all components in the symbols of the whole train."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        self.laws: dict[Any, Law] = {}
        sliders = slider_names(assembly.train.components)
        names_of_groups = [(*flange_names(start.phi0 in sliders), start.phi0) for start in assembly.starts]
        names_of_groups += [
            (*flange_names(False), f"shaft{group}") for group in range(len(names_of_groups), assembly.n_groups)
        ]
        self.q = [sp.Symbol(f"{angle}_{flat(owner)}", real=True) for angle, *_, owner in names_of_groups]
        self.v = [sp.Symbol(f"{speed}_{flat(owner)}", real=True) for _, speed, *_, owner in names_of_groups]
        n = assembly.n_groups
        self.scales = [1 / rational(start.phi0_gain) for start in assembly.starts]
        self.scales += [sp.Integer(1)] * (n - len(self.scales))
        self.lexicon = Lexicon(c.path for c in assembly.train.components)
        for q, v, (angle, *_, owner) in zip(self.q, self.v, names_of_groups, strict=True):
            self.lexicon.coordinate(q, v, owner, slides=angle == "s")
        self.prescribed: dict[tuple[int, int], PrescribedMotion] = {}
        self.mass: list[Any] = [sp.Integer(0)] * n
        self.inertias: dict[int, Any] = {}
        self.torque: list[dict[str, Any]] = [{} for _ in range(n)]
        self.states: dict[Any, Any] = {}
        self.held: dict[Any, Any] = {}
        self.definitions: dict[Any, Any] = {}
        self.shows: dict[str, Any] = {}
        self.flanges: dict[str, Any] = {}
        self.switched_constraints: list[SwitchedConstraint] = []
        self.deflections: dict[Any, Any] = {}
        self.number = 0

    def write(self, c: Component) -> None:
        """Adds one component."""
        grounded = frozenset(n for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node == GROUND)
        inverted = self.number in self.assembly.inverted
        key = (structure_of(c.block), grounded, inverted)
        if key not in self.laws:
            self.laws[key] = derive(c.block, grounded, reading=True, inverted=inverted)
        law = self.laws[key]
        names = list(type(c.block).flanges)
        groups = {n: self._place(c.nodes[names.index(n)]) for n in names if n not in grounded}
        replace = {x: self._symbol(c, meaning, str(x.name), groups) for x, meaning in law.pool.roles.items()}
        replace = {x: y for x, y in replace.items() if y is not None}
        for flange, (group, gain) in groups.items():
            if group != GROUND_GROUP:
                angle, speed, *_ = flange_names(flange in c.sliders)
                self.flanges[f"{c.path}.{flange}.{angle}"] = gain * self.q[group]
                self.flanges[f"{c.path}.{flange}.{speed}"] = gain * self.v[group]
        for flange, tau in law.torques.items():
            group, gain = groups[flange]
            if group != GROUND_GROUP:
                part = gain * tau.xreplace(replace)
                self.torque[group][c.path] = self.torque[group].get(c.path, 0) + part
        for flange, inertia in law.bodies:
            group, gain = groups[flange]
            if group != GROUND_GROUP:
                self.mass[group] += gain**2 * inertia.xreplace(replace)
        for number, motion in enumerate(law.prescribed):
            self.prescribed[self.number, number] = frozen_motion(motion, lambda e: sp.sympify(e).xreplace(replace))
        self.number += 1
        self.switched_constraints += [
            self._switched(c, constraint, law, replace) for constraint in law.constraints.values()
        ]
        counts = {name for constraint in law.constraints.values() for name in (constraint.impulse, constraint.impacts)}
        for state, rate in law.rates.items():
            if state in counts:  # impulses and counts of impacts move nothing
                continue
            self.states[self.lexicon.symbol(c, "state", state)] = rate.xreplace(replace)
        for state, value, _when in law.holds:
            self.held[self.lexicon.symbol(c, "state", state)] = value.xreplace(replace)
        for symbol, expr in law.pool.definitions.items():
            self.definitions[replace[symbol]] = expr.xreplace(replace)
            self.lexicon.define(c, replace[symbol], str(symbol.name), *law.pool.words[symbol])
        for show in law.shows:
            expr = show.expr.xreplace(replace)
            self.shows[f"{c.path}.{show.name}"] = expr
            if show.name in ("twist", "deflection") and law.torques:
                self._deflection(c, expr, unit_along(show.unit, c.slides))

    def _place(self, node: int) -> tuple[int, Any]:
        """The group of a node, and its angle over that of the body by which the group is called."""
        group, gain = self.assembly.group_of_node[node]
        return group, rational(gain) * (1 if group == GROUND_GROUP else self.scales[group])

    def _ties(self, dependent: DependentGroups) -> dict[Any, Any]:
        """Angles of bodies that others give, over those."""
        found: dict[Any, Any] = {}
        for c in self.assembly.train.components:
            if ANGLE not in start_fields(type(c.block)) or c.nodes[0] == GROUND:
                continue
            group, gain = self._place(c.nodes[0])
            angle = sp.Integer(0) if group == GROUND_GROUP else dependent.put(gain * self.q[group])
            if angle in dependent.angles and angle == self._body(group):
                found[angle] = dependent.angles[angle]
            elif angle.free_symbols and (not angle.is_Symbol or angle in dependent.angles):
                found[self.lexicon.body(c)] = angle
        return found

    def _body(self, group: int) -> Any:
        """The angle of the first body that turns as its group does, None where there is none."""
        bodies = (
            c for c in self.assembly.train.components if ANGLE in start_fields(type(c.block)) and c.nodes[0] != GROUND
        )
        found = next((c for c in bodies if self._place(c.nodes[0]) == (group, 1)), None)
        return None if found is None else self.lexicon.body(found)

    def _symbol(self, c: Component, meaning: Any, text: str, groups: Mapping[str, Any]) -> Any:
        """The symbol of the whole train for one of a kind."""
        role, of = meaning.role, meaning.of
        if role in ("phi", "w"):
            group, gain = groups[of]
            if group == GROUND_GROUP:
                return self._ground_angle(c, of) if role == "phi" else sp.Integer(0)
            return gain * (self.q if role == "phi" else self.v)[group]
        if role == "mobility":
            return self._mobility(groups.get(of))
        if role in ("shared", "input"):
            return self.lexicon.shared(of, text)
        return self.lexicon.symbol(c, role, of)

    def _deflection(self, c: Component, expr: Any, unit: str) -> None:
        """A relative coordinate: the name that the law has for it, else x."""
        if expr.is_Symbol:
            self.deflections[expr] = self.definitions.get(expr, expr)
        else:
            self.deflections[self.lexicon.deflection(c, unit)] = expr

    def _switched(
        self, c: Component, constraint: ConstraintLaw, law: Law, replace: Mapping[Any, Any]
    ) -> SwitchedConstraint:
        """One switched constraint of a component."""

        def symbol(role: str) -> Any:
            return self._symbol(c, SymbolRole(role, constraint.name), "", {})

        slip, direction = symbol("slip"), law.pool.symbol("direction", constraint.name, "")
        own = {constraint.slip: slip, sp.expand(-constraint.slip): -slip}

        def of(expr: Any, mode: int) -> Any:
            return (
                None if expr is None else expr.xreplace(own).xreplace({direction: sp.Integer(mode)}).xreplace(replace)
            )

        tie: Any = None
        inside: dict[tuple[int, bool], Any] | None = None
        lost: dict[tuple[int, bool], Any] | None = None
        if constraint.losses is not None:
            tie = self._symbol(c, SymbolRole("friction", str(constraint.partner)), "", {})
            of_case = {True: constraint.losses[:2], False: constraint.losses[2:]}
            cases = [(mode, drives) for mode in (1, -1) for drives in (True, False)]
            inside = {(m, drives): tie + m * of(of_case[drives][1], m) for m, drives in cases}
            lost = {
                (m, drives): -of(share, m) * tie - m * of((1 + share) * rest, m)
                for m, drives in cases for share, rest in (of_case[drives],)
            }  # fmt: skip
        return SwitchedConstraint(
            f"{c.path}.{constraint.name}".rstrip("."), symbol("friction"), slip, constraint.slip.xreplace(replace),
            of(constraint.lower, 0), of(constraint.upper, 0), of(constraint.forward, 1), of(constraint.backward, -1),
            of(constraint.engaged, 0),
            None if constraint.gap is None else constraint.gap.xreplace(replace), of(constraint.restitution, 0),
            (symbol("direction"), symbol("stuck"), symbol("constraint_force")), constraint.kind, tie, lost, inside,
        )  # fmt: skip

    def _ground_angle(self, c: Component, flange: str) -> Any:
        """The angle of a grounded flange: 0 where the ground is given as 0."""
        node = c.nodes[list(type(c.block).flanges).index(flange)]
        offset = self.assembly.ground_offset.get(node)
        if offset is None:
            return sp.Integer(0)
        gain = self.assembly.group_of_node[node][1]
        return rational(gain) * self._offset(offset)

    def _offset(self, offset: str) -> Any:
        """The symbol of a ground angle, 0 where it is given as 0."""
        path, _, name = offset.rpartition(".")
        block = next(other.block for other in self.assembly.train.components if other.path == path)
        if getattr(block, name) == 0:
            return sp.Integer(0)
        c = next(other for other in self.assembly.train.components if other.path == path)
        return self.lexicon.offset(c, name)

    def _mobility(self, group: Any) -> Any:
        """1/J of a shaft as a symbol, defined when everything is added up."""
        if group is None or group[0] == GROUND_GROUP:
            return sp.Integer(0)
        return group[1] ** 2 / self.inertias.setdefault(group[0], sp.Symbol(f"__J{group[0]}"))

    def _inertias_met(self, dependent: DependentGroups, mass: Any, torques: list[Any]) -> dict[Any, Any]:
        """The inertias that stand for mobilities, as far as an expression reads them: those of coupled shafts are long."""
        exprs = [*torques, *self.definitions.values(), *(e for r in self.switched_constraints for e in r.expressions())]
        read = {x for e in exprs for x in sp.sympify(e).free_symbols} if self.inertias else set()
        return {
            x: self.mass[i] if self.assembly.plain else dependent.inertia(mass, i)
            for i, x in self.inertias.items() if x in read
        }  # fmt: skip

    def finish(self) -> Equations:
        """The frozen equations."""
        symbols = self.q, self.v, self.scales
        dependent = over_independent_groups(self.assembly, self.prescribed, *symbols, self._offset, self._body)
        exprs = [*self.shows.values(), *self.definitions.values(), *self.states.values()]
        exprs += [e for row in self.torque for e in row.values()]
        read = {x.name for e in exprs for x in sp.sympify(e).free_symbols}
        self.shows |= {path: e for path, e in self.flanges.items() if path in read}
        self.shows = {path: dependent.put(e) for path, e in self.shows.items()}
        mass, terms = dependent.balance(self.mass, self.torque)
        mobility = self._inertias_met(dependent, mass, [e for row in terms for e in row.values()])
        order = {c.path: i for i, c in enumerate(self.assembly.train.components)}
        contributions = tuple(
            tuple(
                (p, self._sensed(row[p].xreplace(mobility)))
                for p in sorted(row, key=lambda p: order.get(p, len(order)))
            )
            for row in terms
        )
        definitions = {s: self._sensed(dependent.put(e).xreplace(mobility)) for s, e in self.definitions.items()}
        definitions, contributions = self._shortened(definitions, contributions, (*self.q, *dependent.angles))
        torque = [sp.Add(*(e for _, e in row)) for row in contributions]
        definitions |= dependent.angles
        self.states = {s: self._sensed(dependent.put(e)) for s, e in self.states.items()} | dependent.rates
        self.switched_constraints = [
            r.mapped(lambda e: self._sensed(dependent.put(e).xreplace(mobility))) for r in self.switched_constraints
        ]
        self.deflections = {x: dependent.put(e) for x, e in self.deflections.items()}
        ties = self._ties(dependent)
        self.q, self.v = self.q[: dependent.n], self.v[: dependent.n]
        used: set[Any] = set(mass.free_symbols)
        for e in [*torque, *self.states.values(), *(e for r in self.switched_constraints for e in r.expressions())]:
            used |= e.free_symbols
        kept: dict[Any, Any] = {}
        while new := [s for s in definitions if s in used and s not in kept]:
            for s in new:
                kept[s] = definitions[s]
                used |= definitions[s].free_symbols | {base(s)}  # a rate is said by what it is the rate of
        ordered = {s: kept[s] for s in definitions if s in kept}
        used |= {x for e in ties.values() for x in e.free_symbols}
        parameters = {s: p for s, p in self.lexicon.parameters.items() if s in used}
        words = self.lexicon
        return Equations(
            self.assembly.train.name, tuple(self.q), tuple(self.v), mass, sp.Matrix(torque), self.states,
            ordered, parameters, self._coordinates(), words.distinct(), {s: self._sensed(e) for s, e in self.held.items()},
            tuple(self.switched_constraints), contributions, frozenset(words.inputs), words.entries, words.owners,
            {c.path: type(c.block).__name__ for c in self.assembly.train.components}, ties=ties,
        )  # fmt: skip

    def _shortened(
        self, definitions: Mapping[Any, Any], rows: Rows, angles: Iterable[Any]
    ) -> tuple[dict[Any, Any], Rows]:
        """Definitions and terms of the balances with symbols for what stands in several of one part."""
        owners, moving = self.lexicon.owners, [*angles]
        of_parts: dict[str, Part] = {}
        for s, e in definitions.items():
            of_parts.setdefault(owners[s], Part({}, {})).definitions[s] = e
        for i, row in enumerate(rows):
            for path, term in row:
                if path in of_parts:
                    of_parts[path].terms[i] = term
        found = {
            path: with_symbols(part, moving, partial(self.lexicon.phase, path), self.lexicon.slope)
            for path, part in of_parts.items()
        }
        shorter = tuple(
            tuple((path, found[path].terms[i] if path in found else term) for path, term in row)
            for i, row in enumerate(rows)
        )
        return {s: e for part in found.values() for s, e in part.definitions.items()}, shorter

    def _sensed(self, expr: Any) -> Any:
        """An expression with the outputs that it senses written out, where blocks show them."""
        shown = {sp.Symbol(path, real=True): e for path, e in self.shows.items()}
        for _ in self.shows:
            if not expr.free_symbols & set(shown):
                break
            expr = expr.xreplace(shown)
        return expr

    def _coordinates(self) -> dict[Any, Any]:
        """Relative coordinates: the named ones where they are as many as needed and independent, else deflections."""
        wanted = self.assembly.n_groups - len(self.assembly.angles) if self.assembly.plain else 0
        named = {sp.Symbol(c.name, real=True): self._read(c.expr) for c in self.assembly.train.coordinates}
        named = {x: e for x, e in named.items() if not sp.sympify(e).free_symbols & set(self.v)}
        for candidate in (named, self.deflections):
            rows = [[sp.diff(e, q) for q in self.q] for e in candidate.values()]
            moving = {time_symbol(), *self.states, *self.lexicon.inputs}
            linear = all(not x.free_symbols & {*self.q, *moving} for row in rows for x in row)
            linear &= not any(sp.sympify(e).free_symbols & moving for e in candidate.values())
            if len(candidate) == wanted > 0 and linear and sp.Matrix(rows).rank() == wanted:
                return candidate
        return {}

    def _read(self, expr: Any) -> Any:
        def leaf(x: Any) -> Any:
            if x.op == "parameter":
                return self.lexicon.shared(x.args[0], x.args[0].name)
            if x.args[0] not in self.shows:
                raise ModelError(f"a coordinate reads '{x.args[0]}', which no block shows")
            return self.shows[x.args[0]]

        return to_sympy(expr, leaf)
