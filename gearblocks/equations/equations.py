"""The equations of a train, written out: their parts in the order for reading, as text, LaTeX or MathML."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.equations.latex import latex_name
from gearblocks.equations.switched_constraints import Sentence, SwitchedConstraint, constraint_torques, in_order, wanted
from gearblocks.laws.functions import ContactSide, DeadZone
from gearblocks.laws.printer import latex_text, plain_text
from gearblocks.laws.symbols import time_symbol


@dataclass(frozen=True)
class Equations:
    """Equations of motion of a train: mass_matrix * v' = forcing, q' = v, and rates of the states of blocks.

    q, v: angles [rad] and speeds [rad/s] of the groups that are not dependent (a massless one has a row of zeros in the
    mass matrix: its torques are in balance); states: states of blocks with their rates; held: states that take a
    value at an event (a contact starts, say) and keep it; definitions: symbols that stand for longer expressions (a mesh
    force N); parameters: all other symbols with their paths. forcing names the defined symbols; `expanded` has them put in.
    switched_constraints: their constraint forces are symbols of the forcing whose values depend on the active set;
    `in_modes` gives them.
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
    symbol_names: Mapping[Any, str]
    held: Mapping[Any, Any] = dataclasses.field(default_factory=dict)
    switched_constraints: tuple[SwitchedConstraint, ...] = ()

    def __repr__(self) -> str:
        counts = f"{len(self.q)} angles, {len(self.states)} states of blocks, {len(self.definitions)} definitions"
        return f"<Equations of '{self.name}': {counts}, {len(self.parameters)} parameters>"

    @property
    def expanded(self) -> Any:
        """The forcing without defined symbols."""
        return self.forcing.applyfunc(self._insert)

    def _insert(self, expr: Any) -> Any:
        definitions = dict(self.definitions)
        while expr.free_symbols & set(definitions):
            expr = expr.xreplace(definitions)
        return expr

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
            switched_constraints=tuple(r for r in self.switched_constraints if r not in given),
            states={s: e.xreplace(shown) for s, e in self.states.items()},
        )  # fmt: skip
        stuck = [r for r, e in acting.items() if e is None]
        if stuck:
            held = constraint_torques(stuck, self.mass_matrix, made.expanded, self.q, self.v, time_symbol())
            made.definitions.update(zip((r.torque for r in stuck), held, strict=True))  # type: ignore[attr-defined]
        return made

    def jacobian(self) -> Any:
        """d forcing / d (q, v), dead zones differentiated side by side; torques of friction as they are (see in_modes)."""
        return self.expanded.jacobian([*self.q, *self.v])

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
        acceleration = list(inverse * self.forcing)
        result = []
        for x, expr in self.coordinates.items():
            total = sum((sp.diff(expr, q) * a for q, a in zip(self.q, acceleration, strict=True)), sp.Integer(0))
            total = sp.expand(sp.sympify(total).xreplace(replace))
            terms = [*(s for x in self.coordinates for s in (x, _dot(x))), *self.definitions]
            result.append(sp.Eq(_dot(_dot(x)), sp.collect(total, terms), evaluate=False))
        absolute = {*self.q, *self.v}
        closed = not any(e.rhs.free_symbols & absolute for e in [*result, *self.relative_definitions()])
        return result if closed else []

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

    def notes(self) -> list[Any]:
        """The piecewise functions that occur, spelled out."""
        exprs = [*self.forcing, *self.definitions.values()]
        x, b = sp.symbols("x b", real=True)
        found = []
        if any(e.has(DeadZone) for e in exprs):
            found.append(sp.Eq(DeadZone(x, b, 0), DeadZone(x, b, 0).spelled_out(), evaluate=False))
        if any(isinstance(f, DeadZone) and f.args[2] == -1 for e in exprs for f in e.atoms(DeadZone)):
            found.append(sp.Eq(DeadZone(x, b, -1), DeadZone(x, b, -1).spelled_out(), evaluate=False))
        if any(e.has(ContactSide) for e in exprs):
            found.append(sp.Eq(ContactSide(x, b), sp.Piecewise((1, x > b), (-1, x < -b), (0, True)), evaluate=False))
        return found

    def _used(self) -> set[Any]:
        """Symbols of everything that is written out beside the cases of friction."""
        parts = [*self.forcing, *self.states.values(), *self.definitions.values()]
        switched_constraints = [e for r in self.switched_constraints for e in r.expressions()]
        return {x for e in [*parts, *switched_constraints] for x in sp.sympify(e).free_symbols}

    def sections(self) -> list[tuple[str, list[Any]]]:
        """(heading, equations) in the order for reading."""
        rates = [sp.Eq(sp.Symbol(f"{s.name}'", real=True), e, evaluate=False) for s, e in self.states.items()]
        relative = self.relative_form()
        meaning = [sp.Eq(x, e, evaluate=False) for x, e in self.coordinates.items()] if relative else []
        parts = [
            ("Angle form", self.angle_form()),
            ("Friction and stops", in_order(self.switched_constraints, self._used())),
            ("States of blocks", rates),
            ("taken at an event and held", [sp.Eq(s, e, evaluate=False) for s, e in self.held.items()]),
            ("where", [sp.Eq(s, e, evaluate=False) for s, e in self.definitions.items()]),
            ("Relative coordinates", meaning),
            ("Relative form", relative),
            ("where, in relative coordinates", self.relative_definitions() if relative else []),
            ("Functions", self.notes()),
        ]
        return [(heading, equations) for heading, equations in parts if equations]

    def latex(self) -> str:
        """All sections as LaTeX display equations."""
        blocks = []
        for heading, equations in self.sections():
            lines = " \\\\\n".join(map(self._latex_line, equations))
            blocks.append(f"% {heading}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}")
        return "\n\n".join(blocks)

    def _latex_line(self, line: Any) -> str:
        if isinstance(line, Sentence):
            return "&" + "".join(rf"\text{{{x}}}" if isinstance(x, str) else self.latex_of(x) for x in line.parts)
        return f"{self.latex_of(line.lhs)} &= {self.latex_of(line.rhs)}"

    def latex_of(self, expr: Any) -> str:
        """LaTeX of one expression with the names of this train."""
        return latex_text(expr, self._names(expr))

    def _names(self, expr: Any) -> dict[Any, str]:
        names = dict(self.symbol_names)
        for x in sp.sympify(expr).free_symbols - set(names):
            names[x] = latex_name(x.name)
        return names

    def _repr_latex_(self) -> str:
        lines = [self._latex_line(e) for _, part in self.sections() for e in part]
        return "$$\\begin{aligned}" + r" \\ ".join(lines) + "\\end{aligned}$$"

    def __str__(self) -> str:
        blocks = [f"Equations of motion of '{self.name}'"]
        for heading, equations in self.sections():
            blocks.append("\n".join([heading, *("    " + _line(e) for e in equations)]))
        return "\n\n".join(blocks)


def _line(line: Any) -> str:
    return str(line) if isinstance(line, Sentence) else plain_text(line)


def _dot(symbol: Any) -> Any:
    return sp.Symbol(symbol.name + "'", real=True)


def _collapse(expr: Any) -> Any:
    """Expands inside products where that lets angles cancel."""
    return expr.replace(lambda e: e.is_Add, sp.expand)
