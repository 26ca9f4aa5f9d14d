"""The equations of a whole train for people: every equation written out in sympy, as text, LaTeX or MathML.

Angle form: J w' = sum of torques for every shaft. Relative form: the same in deflections, where only they matter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import assemble
from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.equations import names, nomenclature
from gearblocks.equations.dependent_groups import over_independent_groups
from gearblocks.equations.equations import Equations
from gearblocks.equations.switched_constraints import SwitchedConstraint
from gearblocks.errors import ModelError
from gearblocks.language.expression import to_sympy
from gearblocks.language.units import unit_along
from gearblocks.laws.derivation import derive
from gearblocks.laws.law import Law
from gearblocks.laws.prescribed_motion import PrescribedMotion, frozen_motion
from gearblocks.laws.switched_constraints import ConstraintLaw
from gearblocks.laws.symbols import SymbolRole, time_symbol
from gearblocks.train.graph import GROUND, Component, Train
from gearblocks.train.structure import structure_of
from gearblocks.train.translational import flange_names, slider_names

_OF_SWITCHED = {
    "friction": "T",
    "slip": "w_rel",
    "direction": "direction",
    "stuck": "stuck",
    "constraint_force": "held",
}
"""Names of the symbols of switched constraints, by role."""
_SWITCHED = {
    "friction": ("T", "torque of the constraint", "N m"),
    "slip": ("Δω", "slip, or rate of the gap", "rad/s"),
    "direction": ("σ", "direction of sliding: 1, -1, or 0 while it does not slide", "1"),
    "stuck": ("s", "1 while stuck or closed, else 0", "1"),
    "constraint_force": ("λ", "torque while stuck or closed, else 0", "N m"),
}
"""Letter, words and unit of the symbols of switched constraints, by role."""


def write_equations(train: Train) -> Equations:
    """The equations of a train; laws are derived once per kind and written out for every component."""
    assembly = assemble(train, reading=True)
    writer = _Writer(assembly)
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
        self.q = [sp.Symbol(f"{angle}_{_flat(owner)}", real=True) for angle, *_, owner in names_of_groups]
        self.v = [sp.Symbol(f"{speed}_{_flat(owner)}", real=True) for _, speed, *_, owner in names_of_groups]
        n = assembly.n_groups
        feet = names.owners([owner for *_, owner in names_of_groups])
        self.names: dict[Any, names.Name] = {}
        self.entries: dict[Any, nomenclature.Entry] = {}
        self.owners: dict[Any, str] = {}
        for q, v, (angle, *_, owner) in zip(self.q, self.v, names_of_groups, strict=True):
            self._coordinate(q, v, angle == "s", feet[owner])
        self.prescribed: dict[tuple[int, int], PrescribedMotion] = {}
        self.mass: list[Any] = [sp.Integer(0)] * n
        self.torque: list[dict[str, Any]] = [{} for _ in range(n)]
        self.states: dict[Any, Any] = {}
        self.held: dict[Any, Any] = {}
        self.definitions: dict[Any, Any] = {}
        self.parameters: dict[Any, str] = {}
        self.shows: dict[str, Any] = {}
        self.switched_constraints: list[SwitchedConstraint] = []
        self.deflections: dict[Any, Any] = {}
        self.inputs: set[Any] = set()
        self.number = 0
        self.claimed: dict[str, Any] = {x.name: x for x in (*self.q, *self.v)}

    def write(self, c: Component) -> None:
        """Adds one component."""
        grounded = frozenset(n for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node == GROUND)
        inverted = self.number in self.assembly.inverted
        key = (structure_of(c.block), grounded, inverted)
        if key not in self.laws:
            self.laws[key] = derive(c.block, grounded, reading=True, inverted=inverted)
        law = self.laws[key]
        names = list(type(c.block).flanges)
        groups = {n: self.assembly.group_of_node[c.nodes[names.index(n)]] for n in names if n not in grounded}
        replace = {x: self._symbol(c, meaning, str(x.name), groups) for x, meaning in law.pool.roles.items()}
        replace = {x: y for x, y in replace.items() if y is not None}
        for flange, tau in law.torques.items():
            group, gain = groups[flange]
            if group != GROUND_GROUP:
                part = sp.Rational(gain.numerator, gain.denominator) * tau.xreplace(replace)
                self.torque[group][c.path] = self.torque[group].get(c.path, 0) + part
        for flange, inertia in law.bodies:
            group, gain = groups[flange]
            if group != GROUND_GROUP:
                self.mass[group] += sp.Rational(gain.numerator, gain.denominator) ** 2 * inertia.xreplace(replace)
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
            self.states[self._state(c, state)] = rate.xreplace(replace)
        for state, value, _when in law.holds:
            self.held[self._state(c, state)] = value.xreplace(replace)
        for symbol, expr in law.pool.definitions.items():
            self.definitions[replace[symbol]] = expr.xreplace(replace)
            self._define(c, replace[symbol], str(symbol.name), *law.pool.words[symbol])
        for show in law.shows:
            expr = show.expr.xreplace(replace)
            self.shows[f"{c.path}.{show.name}"] = expr
            if show.name in ("twist", "deflection") and law.torques:
                self._deflection(c, expr)

    def _symbol(self, c: Component, meaning: Any, text: str, groups: Mapping[str, Any]) -> Any:
        """The symbol of the whole train for one of a kind."""
        role, of = meaning.role, meaning.of
        if role in ("phi", "w"):
            group, gain = groups[of]
            if group == GROUND_GROUP:
                return self._ground_angle(c, of) if role == "phi" else sp.Integer(0)
            return sp.Rational(gain.numerator, gain.denominator) * (self.q if role == "phi" else self.v)[group]
        if role == "mobility":
            return self._mobility(groups.get(of))
        if role == "state":
            return self._state(c, of)
        if role == "named":
            return self._claim(f"{_flat(of.split('.')[-1])}_{_flat(c.path)}", (role, c.path, of))
        if role in ("own", "exact"):
            symbol = self._claim(f"{_flat(of.split('.')[-1])}_{_flat(c.path)}", ("own", c.path, of))
            self.parameters[symbol] = f"{c.path}.{of}"
            self._note(symbol, names.of_field(of, self._foot(c)), nomenclature.of_number(c, of), c)
            return symbol
        if role in ("table", "table2"):
            return self._table(c, of)
        if role in _OF_SWITCHED:
            letter = ("F" if c.slides else "T") if role == "friction" else _OF_SWITCHED[role]
            symbol = self._claim(f"{letter}_{_flat(c.path)}{'_' if of else ''}{_flat(of)}", (role, c.path, of))
            shown, words, unit = _SWITCHED[role]
            shown = {"T": "F", "Δω": "Δv"}.get(shown, shown) if c.slides else shown
            unit = unit_along(unit, c.slides)
            owner = f"{self._foot(c)} {of}".rstrip()
            self._note(symbol, names.Name(shown, "", owner), nomenclature.Entry(words, "", unit, c.path), c)
            return symbol
        if role in ("shared", "input"):
            symbol = self._claim(text, (role, of.name))
            self.parameters[symbol] = of.name
            self._note(symbol, names.of_shared(of.name), nomenclature.of_shared(of), None)
            if role == "input":
                self.inputs.add(symbol)
            return symbol
        return None

    # -- names and meanings -------------------------------------------------------------------------------------------

    def _foot(self, c: Component) -> str:
        return names.owners([c.path])[c.path]

    def _note(self, symbol: Any, name: names.Name, entry: nomenclature.Entry, c: Component | None) -> None:
        """Keeps what a symbol is called and means, and the part that it belongs to."""
        self.names[symbol], self.entries[symbol] = name, entry
        if c is not None:
            self.owners[symbol] = c.path

    def _coordinate(self, q: Any, v: Any, slides: bool, owner: str) -> None:
        letter, words, unit = ("s", "position", "m") if slides else ("φ", "angle", "rad")
        self.names[q] = names.Name(letter, "", owner)
        self.names[v] = self.names[q].rate()
        self.entries[q] = nomenclature.Entry(f"{words} of {owner}", "", unit)

    def _state(self, c: Component, state: str) -> Any:
        """The symbol of a state of a block."""
        symbol = self._claim(f"{_flat(state.split('.')[-1])}_{_flat(c.path)}", ("state", c.path, state))
        name = names.plain(state.split(".")[-1])
        self._note(symbol, names.Name(name.letter, name.number, self._foot(c)), nomenclature.of_state(c, state), c)
        return symbol

    def _define(self, c: Component, symbol: Any, name: str, words: str, unit: str) -> None:
        """Keeps what a symbol is that a law defines; a mean stiffness beside one that varies is k_0."""
        called = names.of_defined(name, self._foot(c), c.slides)
        self._note(symbol, called, nomenclature.Entry(words, "", unit_along(unit, c.slides), c.path), c)
        if name == "k_t":
            mean = self._claim(f"k_{_flat(c.path)}", ("own", c.path, "k"))
            if mean in self.names:
                self.names[mean] = names.of_field("k", self._foot(c), varies=True)

    def _table(self, c: Component, table: Any) -> Any:
        """The symbol of a table, named by the field that it stands in."""
        path = next((p for p, own in nomenclature.tables_of(c.block) if _same_table(own, table)), "law")
        symbol = self._claim(f"{_flat(path.split('.')[-1])}_table_{_flat(c.path)}", ("table", c.path, path))
        entry = nomenclature.of_table(c, path, table)
        self._note(symbol, names.of_table(path, self._foot(c)), entry, c)
        return symbol

    def _deflection(self, c: Component, expr: Any) -> None:
        """A relative coordinate: the name that the law has for it, else x."""
        if expr.is_Symbol:
            self.deflections[expr] = self.definitions.get(expr, expr)
            return
        symbol = sp.Symbol(f"x_{_flat(c.path)}", real=True)
        self.names[symbol] = names.Name("x", "", self._foot(c))
        self.deflections[symbol] = expr

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

    def _claim(self, text: str, meaning: Any) -> Any:
        """The symbol of one thing: its short name, with the path inside the block or a dash where that is taken."""
        longer = f"{_flat(meaning[2])}_{_flat(meaning[1])}" if len(meaning) == 3 else text
        while self.claimed.setdefault(text, meaning) != meaning:
            text = longer if text != longer and not text.startswith(longer) else text + "_"
        return sp.Symbol(text, real=True)

    def _ground_angle(self, c: Component, flange: str) -> Any:
        """The angle of a grounded flange: 0 where the ground is given as 0."""
        node = c.nodes[list(type(c.block).flanges).index(flange)]
        offset = self.assembly.ground_offset.get(node)
        if offset is None:
            return sp.Integer(0)
        gain = self.assembly.group_of_node[node][1]
        return sp.Rational(gain.numerator, gain.denominator) * self._offset(offset)

    def _offset(self, offset: str) -> Any:
        """The symbol of a ground angle, 0 where it is given as 0."""
        path, _, name = offset.rpartition(".")
        block = next(other.block for other in self.assembly.train.components if other.path == path)
        if getattr(block, name) == 0:
            return sp.Integer(0)
        symbol = self._claim(f"{name}_{_flat(path)}", ("own", path, name))
        self.parameters[symbol] = offset
        c = next(other for other in self.assembly.train.components if other.path == path)
        self._note(symbol, names.Name("φ", "0", self._foot(c)), nomenclature.of_number(c, name), c)
        return symbol

    def _mobility(self, group: Any) -> Any:
        """1/J of a shaft as a symbol, defined when everything is added up."""
        if group is None or group[0] == GROUND_GROUP:
            return sp.Integer(0)
        return sp.Rational(group[1].numerator, group[1].denominator) ** 2 / sp.Symbol(f"__J{group[0]}")

    def finish(self) -> Equations:
        """The frozen equations."""
        dependent = over_independent_groups(self.assembly, self.prescribed, self.q, self.v, self._offset)
        mass, terms = dependent.balance(self.mass, self.torque)
        mobility = {
            sp.Symbol(f"__J{i}"): m if self.assembly.plain else dependent.inertia(mass, i) for i, m in enumerate(self.mass)
        }  # fmt: skip
        order = {c.path: i for i, c in enumerate(self.assembly.train.components)}
        contributions = tuple(
            tuple(
                (p, self._sensed(row[p].xreplace(mobility)))
                for p in sorted(row, key=lambda p: order.get(p, len(order)))
            )
            for row in terms
        )
        torque = [sp.Add(*(e for _, e in row)) for row in contributions]
        definitions = {s: self._sensed(dependent.put(e).xreplace(mobility)) for s, e in self.definitions.items()}
        self.states = {s: self._sensed(dependent.put(e)) for s, e in self.states.items()} | dependent.rates
        self.shows = {path: dependent.put(e) for path, e in self.shows.items()}
        self.switched_constraints = [
            r.mapped(lambda e: self._sensed(dependent.put(e).xreplace(mobility))) for r in self.switched_constraints
        ]
        self.deflections = {x: dependent.put(e) for x, e in self.deflections.items()}
        self.q, self.v = self.q[: dependent.n], self.v[: dependent.n]
        used: set[Any] = set()
        for e in [*torque, *self.states.values(), *(e for r in self.switched_constraints for e in r.expressions())]:
            used |= e.free_symbols
        kept: dict[Any, Any] = {}
        while new := [s for s in definitions if s in used and s not in kept]:
            for s in new:
                kept[s] = definitions[s]
                used |= definitions[s].free_symbols
        ordered = {s: kept[s] for s in definitions if s in kept}
        parameters = {s: p for s, p in self.parameters.items() if s in used or s in mass.free_symbols}
        return Equations(
            self.assembly.train.name, tuple(self.q), tuple(self.v), mass, sp.Matrix(torque), self.states,
            ordered, parameters, self._coordinates(), self._distinct(), {s: self._sensed(e) for s, e in self.held.items()},
            tuple(self.switched_constraints), contributions, frozenset(self.inputs), self.entries, self.owners,
            {c.path: type(c.block).__name__ for c in self.assembly.train.components},
        )  # fmt: skip

    def _distinct(self) -> dict[Any, names.Name]:
        """The names; where two things would share one, each by the words of its path."""
        spare = {
            s: e.path.split(".")[-1].partition("[")[0]
            for s, e in self.entries.items()
            if e.path and (s in self.parameters or e.table is not None)
        }
        return names.distinct(self.names, spare)

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
            moving = {time_symbol(), *self.states, *self.inputs}
            linear = all(not x.free_symbols & {*self.q, *moving} for row in rows for x in row)
            linear &= not any(sp.sympify(e).free_symbols & moving for e in candidate.values())
            if len(candidate) == wanted > 0 and linear and sp.Matrix(rows).rank() == wanted:
                return candidate
        return {}

    def _read(self, expr: Any) -> Any:
        def leaf(x: Any) -> Any:
            if x.op == "parameter":
                symbol = self._claim(x.args[0].name, ("shared", x.args[0].name))
                self.parameters[symbol] = x.args[0].name
                self._note(symbol, names.of_shared(x.args[0].name), nomenclature.of_shared(x.args[0]), None)
                return symbol
            if x.args[0] not in self.shows:
                raise ModelError(f"a coordinate reads '{x.args[0]}', which no block shows")
            return self.shows[x.args[0]]

        return to_sympy(expr, leaf)


def _same_table(one: Any, other: Any) -> bool:
    return type(one) is type(other) and one.digest() == other.digest()


def _flat(path: str) -> str:
    return path.replace(".", "_").replace("[", "").replace("]", "")
