"""The equations of a train, written out: their parts in the order for reading, as text, LaTeX or MathML."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.equations import sections
from gearblocks.equations.document import Document, Nomenclature, Section
from gearblocks.equations.families import families, names_in, of_entries, of_lines, of_parts
from gearblocks.equations.latex import latex
from gearblocks.equations.linearized import sections as of_small_deviations
from gearblocks.equations.long_numbers import with_constants
from gearblocks.equations.names import Name
from gearblocks.equations.nomenclature import Entry
from gearblocks.equations.switched_constraints import SwitchedConstraint, constraint_torques, wanted
from gearblocks.errors import ParameterError, arguments_told, did_you_mean
from gearblocks.laws.symbols import time_symbol
from gearblocks.plurals import singular


@arguments_told
@dataclass(frozen=True)
class Equations:
    """Equations of motion of a train: mass_matrix * v' = forcing, q' = v, and rates of the states of blocks.

    q, v: angles [rad] and speeds [rad/s] of the groups that are not dependent (a massless one has a row of zeros in the
    mass matrix: its torques are in balance); states: states of blocks with their rates; held: states that take a
    value at an event (a contact starts, say) and keep it; definitions: symbols that stand for longer expressions (a mesh
    force N); parameters: all other symbols with their paths. forcing names the defined symbols; `expanded` has them put in.
    switched_constraints: their constraint forces are symbols of the forcing whose values depend on the active set;
    `in_modes` gives them. contributions: the forcing term by term, (path, term), in the order of the train; names, entries,
    owners: what symbols are called, what they mean, and to which part they belong; kinds: class of each part; unread: states
    that are not printed, since they move nothing; ties: angles of bodies that ratios and planetary sets give, over q.
    """

    name: str
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    mass_matrix: Any
    forcing: Any
    states: Mapping[Any, Any]
    definitions: Mapping[Any, Any]
    parameters: Mapping[Any, str]
    coordinates: Mapping[Any, Any]
    names: Mapping[Any, Name]
    held: Mapping[Any, Any] = dataclasses.field(default_factory=dict)
    switched_constraints: tuple[SwitchedConstraint, ...] = ()
    contributions: tuple[tuple[tuple[str, Any], ...], ...] = ()
    inputs: frozenset[Any] = frozenset()
    entries: Mapping[Any, Entry] = dataclasses.field(default_factory=dict)
    owners: Mapping[Any, str] = dataclasses.field(default_factory=dict)
    kinds: Mapping[str, str] = dataclasses.field(default_factory=dict)
    unread: frozenset[Any] = frozenset()
    ties: Mapping[Any, Any] = dataclasses.field(default_factory=dict)

    def __repr__(self) -> str:
        counts = f"{len(self.q)} angles, {len(self.states)} states of blocks, {len(self.definitions)} definitions"
        return singular(f"<Equations of '{self.name}': {counts}, {len(self.parameters)} parameters>")

    @property
    def expanded(self) -> Any:
        """The forcing without defined symbols."""
        return self.forcing.applyfunc(lambda expr: inserted(expr, dict(self.definitions)))

    def in_modes(self, modes: Mapping[str, float]) -> Equations:
        """The equations while friction and stops are in these modes, as events and outputs show them: {"clutch": 0}.

        Of friction 0 stuck, 1 and -1 sliding, 2 free; of a stop 1 closed, 0 open; of a tie with losses the sign of its
        torque. The torque of what is stuck or closed is defined as the constraint force that keeps its slip at 0 (the
        minimum-norm split where several share a load); those that are not named stay symbols. Raises ParameterError for
        a name or mode that does not exist.
        """
        found = wanted(self.switched_constraints, modes)
        given = {r: found[r.path] for r in self.switched_constraints if r.path in found}
        shown = {x: e for r, mode in given.items() for x, e in r.shown_in(mode).items()}
        sign = {r.torque: mode for r, mode in given.items() if r.kind == "tie"}
        acting = {r: r.torque_in(mode, sign.get(r.tie, 1)) for r, mode in given.items()}
        torques = {r.torque: e for r, e in acting.items() if e is not None}
        slips = {r.slip: r.sliding for r in given if r.slip != r.sliding}
        definitions = {**{s: e.xreplace(shown) for s, e in self.definitions.items()}, **torques, **slips}
        made = dataclasses.replace(
            self, definitions=definitions, forcing=self.forcing.xreplace(shown),
            contributions=tuple(tuple((p, e.xreplace(shown)) for p, e in row) for row in self.contributions),
            switched_constraints=tuple(r for r in self.switched_constraints if r not in given),
            states={s: e.xreplace(shown) for s, e in self.states.items()}, unread=frozenset(sections.counters(self)),
        )  # fmt: skip
        stuck = [r for r, e in acting.items() if e is None]
        if stuck:
            forcing = made._without({r.torque for r in stuck})
            rates = self._rates()
            within = {s: e for s, e in self.definitions.items() if s not in rates}
            spelled = [r.mapped(lambda e: inserted(sp.sympify(e), within)) for r in stuck]
            rates |= dict(zip(self.q, self.v, strict=True))
            held = constraint_torques(spelled, self.mass_matrix, forcing, self.v, rates, time_symbol())
            made.definitions.update(zip((r.torque for r in stuck), held, strict=True))  # type: ignore[attr-defined]
        return made

    def _rates(self) -> dict[Any, Any]:
        """The rates of defined symbols that have one by name, of which no speeds are needed."""
        pairs = {sections.base(x): x for x in self.definitions}
        found = {s: x for s, x in pairs.items() if s in self.definitions}
        return {s: x for s, x in found.items() if not inserted(s, self.definitions).free_symbols & {*self.v}}

    def _without(self, torques: set[Any]) -> Any:
        """The forcing without the defined symbols that depend on these."""
        found = set(torques)
        while more := {s for s, e in self.definitions.items() if s not in found and e.free_symbols & found}:
            found |= more
        depend = {s: self.definitions[s] for s in found - torques}
        return self.forcing.applyfunc(lambda expr: inserted(expr, depend))

    def jacobian(self) -> Any:
        """d forcing / d (q, v), dead zones differentiated side by side; torques of friction as they are (see in_modes).
        Without rows and columns where no shaft moves by itself."""
        return self.expanded.jacobian([*self.q, *self.v]) if self.q else sp.zeros(0, 0)

    def angle_form(self) -> list[Any]:
        """One equation per shaft: inertia times acceleration = torques."""
        accelerations = [sp.Symbol(f"{v.name}'", real=True) for v in self.v]
        left = self.mass_matrix * sp.Matrix(accelerations)
        return [sp.Eq(a, b, evaluate=False) for a, b in zip(left, self.forcing, strict=True)]

    def relative_form(self) -> list[Any]:
        """One equation per relative coordinate: x'' = ..., in relative coordinates alone.

        The coordinates are those named with Drivetrain.coordinate, else the deflections. Empty where there are none, where
        one of them moves with time by itself (an error driven by time), and where a law reads an absolute angle.
        """
        if not self.coordinates:
            return []
        replace = self._to_relative()
        inverse = self.mass_matrix.inv() if self.mass_matrix.is_diagonal() else None
        if inverse is None:
            return []
        result = []
        for x, expr in self.coordinates.items():
            gains = [sp.diff(expr, q) * inverse[i, i] for i, q in enumerate(self.q)]
            total = sp.Add(*(_collapse(sp.sympify(part).xreplace(replace)) for part in self._along(gains)))
            result.append(sp.Eq(_dot(_dot(x)), total, evaluate=False))
        absolute = {*self.q, *self.v}
        closed = not any(e.rhs.free_symbols & absolute for e in [*result, *self.relative_definitions()])
        return result if closed else []

    def _along(self, gains: list[Any]) -> Iterator[Any]:
        """The terms of gains times forcing: of each part of the train one, where it acts on all shafts by one expression."""
        by_part: dict[Any, list[tuple[Any, Any]]] = {}
        for gain, row in zip(gains, self.contributions, strict=True):
            for path, term in row if gain != 0 else ():
                by_part.setdefault(path, []).append((gain, term))
        for found in by_part.values():
            base = next((term for _, term in found if term != 0), sp.Integer(1))
            shares = [sp.cancel(term / base) if base.is_Mul or base.is_Symbol else None for _, term in found]
            if all(share is not None and share.is_number for share in shares):
                whole = sp.factor_terms(sp.Add(*(gain * share for (gain, _), share in zip(found, shares, strict=True))))
                yield base * whole
            else:
                yield from (gain * term for gain, term in found)

    def relative_definitions(self) -> list[Any]:
        """Definitions of the named symbols in relative coordinates."""
        replace = self._to_relative() if self.coordinates else {}
        return [sp.Eq(s, _collapse(e.xreplace(replace)), evaluate=False) for s, e in self.definitions.items()]

    def _to_relative(self) -> dict[Any, Any]:
        """Angles and speeds in relative coordinates, up to what nothing depends on."""
        angles: dict[Any, Any] = {}
        for x, expr in self.coordinates.items():
            left = sp.expand(sp.sympify(expr).xreplace(angles))
            pivot = next(q for q in reversed(self.q) if left.has(q) and q not in angles)
            slope = sp.diff(left, pivot)
            solved = sp.expand((x - (left - slope * pivot)) / slope)
            angles = {**{k: sp.expand(e.xreplace({pivot: solved})) for k, e in angles.items()}, pivot: solved}
        speed = dict(zip(self.q, self.v, strict=True)) | {x: _dot(x) for x in self.coordinates}
        return {**angles, **{speed[q]: e.xreplace(speed) for q, e in angles.items()}}

    def used(self) -> set[Any]:
        """Symbols of everything that is written out."""
        exprs = [
            *self.forcing,
            *self.mass_matrix,
            *self.states.values(),
            *self.definitions.values(),
            *self.held.values(),
            *self.ties.values(),
        ]
        exprs += [e for r in self.switched_constraints for e in r.expressions()]
        return {x for e in exprs for x in sp.sympify(e).free_symbols}

    # -- as people read them ------------------------------------------------------------------------------------------

    def document(self) -> Document:
        """Everything: balances, parts, relative form, functions and the symbols; of alike parts one stands for all."""
        relative, functions = tuple(sections.relative(self)), sections.functions(self)
        begins = [sections.balances(self), sections.ties(self)]
        parts, entries = sections.parts(self), self.nomenclature()
        alike = families(self.kinds)
        while True:
            found = [x for section in begins if section is not None for x in of_lines(alike, section)]
            found += of_parts(alike, parts, self.kinds)
            found += (x for x in (sections.others(self), sections.active(self)) if x is not None)
            found += (x for section in relative for x in of_lines(alike, section))
            found += [functions] if functions is not None else []
            nomenclature = of_entries(alike, entries, found)
            if not (apart := alike.unexplained(found, nomenclature)):
                return Document(f"Equations of motion of '{self.name}'", *with_constants(found, nomenclature))
            alike = alike.without(apart)

    def form(self, name: str) -> Document:
        """The balances alone: "angle" of the shafts, "relative" in relative coordinates. Raises ParameterError where there is
        no such form."""
        if name == "angle":
            found = [sections.balances(self)]
        elif name == "relative":
            found = list(sections.relative(self))
        else:
            raise ParameterError(f"form = {name!r} must be 'angle' or 'relative'")
        if not found:
            raise ParameterError(
                f"'{self.name}' has no relative form: its laws read absolute angles, or its deflections do not tell its "
                "motion; take form('angle'), or name its coordinates by rig.coordinate(...)"
            )
        return Document(f"'{self.name}', {name} form", tuple(found), Nomenclature(()))

    def linearized(self) -> Document:
        """The equations for small deviations, M Δq'' = -C Δq' - K Δq, with their matrices; contacts keep their side, the
        torques of friction and stops are as they are (see in_modes)."""
        return Document(f"Small deviations of '{self.name}'", tuple(of_small_deviations(self)), Nomenclature(()))

    def element(self, path: str) -> Document:
        """What one part of the train introduces. Raises ParameterError for a name that there is not."""
        if path not in self.kinds:
            parts = ", ".join([*self.kinds][:12]) + ", ..." * (len(self.kinds) > 12)
            raise ParameterError(
                f"'{path}' is no part of '{self.name}'; it has {parts}{did_you_mean(path, self.kinds)}"
            )
        lines = tuple(sections.part(self, path))
        printed = {dataclasses.replace(name, dots=0) for name in names_in(lines)}
        entries = tuple((name, entry) for name, entry in self.nomenclature().entries if name in printed)
        section = Section(f"{path} ({self.kinds[path]})", lines)
        return Document(f"'{path}' of '{self.name}'", *with_constants((section,) * bool(lines), Nomenclature(entries)))

    def nomenclature(self) -> Nomenclature:
        """The symbols with words, value, unit and path."""
        shown = {*self.q, *self.ties, *self.coordinates, *self.states, *self.definitions, *self.used()}
        return sections.nomenclature(self, shown | {c.slip for c in self.switched_constraints})

    def latex(self) -> str:
        """Everything as LaTeX, for a document with amsmath."""
        return self.document().latex()

    def html(self, drawing: str = "") -> str:
        """Everything as a page that a browser shows without a network. drawing: SVG of the train, str(rig.draw())."""
        return self.document().html(str(drawing))

    def mathml(self) -> str:
        """The equations as <math> elements, one in a line."""
        return self.document().mathml()

    def latex_of(self, expr: Any) -> str:
        """LaTeX of one expression with the names of this train."""
        return latex(sections.reader(self).read(expr))

    def _repr_latex_(self) -> str:
        return self.document()._repr_latex_()

    def _repr_html_(self) -> str:
        return self.document()._repr_html_()

    def __str__(self) -> str:
        return str(self.document())


def inserted(expr: Any, definitions: Mapping[Any, Any]) -> Any:
    """An expression with defined symbols put in, and those in them."""
    while expr.free_symbols & definitions.keys():
        expr = expr.xreplace(definitions)
    return expr


def _dot(symbol: Any) -> Any:
    return sp.Symbol(symbol.name + "'", real=True)


def _collapse(expr: Any) -> Any:
    """Expands inside products where that lets angles cancel."""
    return expr.replace(lambda e: e.is_Add, sp.expand)
