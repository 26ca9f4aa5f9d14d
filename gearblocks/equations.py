"""The equations of a whole train for people: every equation written out in sympy, as text, LaTeX or MathML.

Angle form: J w' = sum of torques for every shaft. Relative form: the same in deflections, where only they matter.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.assemble import HELD, Assembly, assemble
from gearblocks.carrying import carry
from gearblocks.drives import Drive, frozen_drive
from gearblocks.errors import ModelError
from gearblocks.expression import to_sympy
from gearblocks.graph import GROUND, Component, Train, structure_of
from gearblocks.laws import Law, derive
from gearblocks.printer import latex_text, plain_text
from gearblocks.sliding import flange_names, slider_names
from gearblocks.symbols import ContactSide, DeadZone, clock

_LETTERS = {
    "half_gap": "b", "damping_ratio": r"\zeta", "radius": "r", "driven_by": r"\omega", "phase": r"\vartheta",
    "teeth": "z", "module": "m", "pressure_angle": r"\alpha", "helix_angle": r"\beta", "r_base": "r", "tau": r"\tau",
    "coeffs": "c", "ripple": r"\epsilon", "contact_ratio": r"\epsilon_\alpha", "ratio": "i", "cos": "a", "sin": "b",
    "k_t": "k", "torque": "T", "torque_variation": r"\varepsilon", "speed": r"\omega",
}  # fmt: skip


@dataclass(frozen=True)
class Equations:
    """Equations of motion of a train: mass_matrix * v' = forcing, q' = v, and rates of the states of blocks.

    q, v: angles [rad] and speeds [rad/s], one per shaft that turns by itself (a shaft without inertia has a row of zeros in
    the mass matrix: its torques are in balance); states: states of blocks with their rates; held: states that take a
    value at an event (a contact starts, say) and keep it; definitions: symbols that stand for longer expressions (a mesh
    force N); parameters: all other symbols with their paths. forcing names the defined symbols; `expanded` has them put in.
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

    @property
    def expanded(self) -> Any:
        """The forcing without defined symbols."""
        return self.forcing.applyfunc(self._insert)

    def _insert(self, expr: Any) -> Any:
        definitions = dict(self.definitions)
        while expr.free_symbols & set(definitions):
            expr = expr.xreplace(definitions)
        return expr

    def jacobian(self) -> Any:
        """d forcing / d (q, v), dead zones differentiated side by side."""
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

    def sections(self) -> list[tuple[str, list[Any]]]:
        """(heading, equations) in the order for reading."""
        rates = [sp.Eq(sp.Symbol(f"{s.name}'", real=True), e, evaluate=False) for s, e in self.states.items()]
        relative = self.relative_form()
        meaning = [sp.Eq(x, e, evaluate=False) for x, e in self.coordinates.items()] if relative else []
        parts = [
            ("Angle form", self.angle_form()),
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
            lines = " \\\\\n".join(
                f"{self.latex_of(e.lhs)} &= {self.latex_of(e.rhs)}" for e in equations
            )  # fmt: skip
            blocks.append(f"% {heading}\n\\begin{{align*}}\n{lines}\n\\end{{align*}}")
        return "\n\n".join(blocks)

    def latex_of(self, expr: Any) -> str:
        """LaTeX of one expression with the names of this train."""
        return latex_text(expr, self._names(expr))

    def _names(self, expr: Any) -> dict[Any, str]:
        names = dict(self.symbol_names)
        for x in sp.sympify(expr).free_symbols - set(names):
            names[x] = _latex_name(x.name)
        return names

    def _repr_latex_(self) -> str:
        lines = [rf"{self.latex_of(e.lhs)} &= {self.latex_of(e.rhs)}" for _, part in self.sections() for e in part]
        return "$$\\begin{aligned}" + r" \\ ".join(lines) + "\\end{aligned}$$"

    def __str__(self) -> str:
        blocks = [f"Equations of motion of '{self.name}'"]
        for heading, equations in self.sections():
            blocks.append("\n".join([heading, *("    " + plain_text(e) for e in equations)]))
        return "\n\n".join(blocks)


def _dot(symbol: Any) -> Any:
    return sp.Symbol(symbol.name + "'", real=True)


def _collapse(expr: Any) -> Any:
    """Expands inside products where that lets angles cancel."""
    return expr.replace(lambda e: e.is_Add, sp.expand)


def _latex_name(name: str) -> str:
    """phi_disc' as a dotted letter with an index."""
    base = name.rstrip("'")
    dots = len(name) - len(base)
    match = re.fullmatch(r"([A-Za-z]|phi)(?:_(.+)|(\d+))?", base)
    letter, index = (match[1], match[2] or match[3] or "") if match else (_word(base), "")
    for field in sorted(_LETTERS, key=len, reverse=True):
        match = re.fullmatch(rf"{field}(\d*)(?:_(.*))?", base)
        if match:
            letter, index = _LETTERS[field], " ".join(x for x in match.groups() if x)
            break
    if base.startswith("k_t_"):
        return rf"k_{{{_word(index)}}}\!\left(t\right)"
    letter = {"phi": r"\varphi", "w": r"\varphi"}.get(letter, letter)
    dots += 1 if base.startswith("w_") else 0
    if dots:
        letter = {1: rf"\dot{{{letter}}}", 2: rf"\ddot{{{letter}}}", 3: rf"\dddot{{{letter}}}"}[dots]
    return f"{letter}_{{{index if index.isdigit() else _word(index)}}}" if index else letter


def _word(text: str) -> str:
    """A word upright, its underscores as such."""
    escaped = text.replace("_", r"\_")
    return rf"\mathrm{{{escaped}}}"


# -- writing ----------------------------------------------------------------------------------------------------------


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
        names = [(*flange_names(start.phi0 in sliders), _flat(start.phi0)) for start in assembly.starts]
        names += [(*flange_names(False), f"shaft{group}") for group in range(len(names), assembly.n_groups)]
        self.q = [sp.Symbol(f"{angle}_{owner}", real=True) for angle, _, _, _, owner in names]
        self.v = [sp.Symbol(f"{speed}_{owner}", real=True) for _, speed, _, _, owner in names]
        n = assembly.n_groups
        self.drives: dict[tuple[int, int], Drive] = {}
        self.mass: list[Any] = [sp.Integer(0)] * n
        self.torque: list[Any] = [sp.Integer(0)] * n
        self.states: dict[Any, Any] = {}
        self.held: dict[Any, Any] = {}
        self.definitions: dict[Any, Any] = {}
        self.parameters: dict[Any, str] = {}
        self.shows: dict[str, Any] = {}
        self.deflections: dict[Any, Any] = {}
        self.inputs: set[Any] = set()
        self.number = 0
        self.claimed: dict[str, Any] = {x.name: x for x in (*self.q, *self.v)}

    def write(self, c: Component) -> None:
        """Adds one component."""
        grounded = frozenset(n for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node == GROUND)
        key = (structure_of(c.block), grounded)
        if key not in self.laws:
            self.laws[key] = derive(c.block, grounded, reading=True)
        law = self.laws[key]
        names = list(type(c.block).flanges)
        places = {n: self.assembly.group_of_node[c.nodes[names.index(n)]] for n in names if n not in grounded}
        replace = {x: self._symbol(c, slot, str(x.name), places) for x, slot in law.pool.slots.items()}
        replace = {x: y for x, y in replace.items() if y is not None}
        for flange, tau in law.torques.items():
            group, gain = places[flange]
            if group != HELD:
                self.torque[group] += sp.Rational(gain.numerator, gain.denominator) * tau.xreplace(replace)
        for flange, inertia in law.bodies:
            group, gain = places[flange]
            if group != HELD:
                self.mass[group] += sp.Rational(gain.numerator, gain.denominator) ** 2 * inertia.xreplace(replace)
        for number, drive in enumerate(law.drives):
            self.drives[self.number, number] = frozen_drive(drive, lambda e: sp.sympify(e).xreplace(replace))
        self.number += 1
        for state, rate in law.rates.items():
            symbol = self._claim(f"{_flat(state.split('.')[-1])}_{_flat(c.path)}", ("state", c.path, state))
            self.states[symbol] = rate.xreplace(replace)
        for state, value, _when in law.holds:
            symbol = self._claim(f"{_flat(state.split('.')[-1])}_{_flat(c.path)}", ("state", c.path, state))
            self.held[symbol] = value.xreplace(replace)
        for symbol, expr in law.pool.definitions.items():
            self.definitions[replace[symbol]] = expr.xreplace(replace)
        for show in law.shows:
            expr = show.expr.xreplace(replace)
            self.shows[f"{c.path}.{show.name}"] = expr
            if show.name in ("twist", "deflection") and law.torques:
                self.deflections[sp.Symbol(f"x_{_flat(c.path)}", real=True)] = expr

    def _symbol(self, c: Component, slot: Any, text: str, places: Mapping[str, Any]) -> Any:
        """The symbol of the whole train for one of a kind."""
        role, of = slot.role, slot.of
        if role in ("phi", "w"):
            group, gain = places[of]
            if group == HELD:
                return self._held_angle(c, of) if role == "phi" else sp.Integer(0)
            return sp.Rational(gain.numerator, gain.denominator) * (self.q if role == "phi" else self.v)[group]
        if role == "mobility":
            return self._mobility(places.get(of))
        if role in ("own", "exact", "named", "state"):
            kind = "own" if role == "exact" else role
            symbol = self._claim(f"{_flat(of.split('.')[-1])}_{_flat(c.path)}", (kind, c.path, of))
            if role in ("own", "exact"):
                self.parameters[symbol] = f"{c.path}.{of}"
            return symbol
        if role in ("direction", "stuck", "held"):
            stem = "dir" if role == "direction" else role
            return self._claim(f"{stem}_{_flat(c.path)}{_flat('_' + of) if of else ''}", (role, c.path, of))
        if role in ("shared", "input"):
            symbol = self._claim(text, (role, of.name))
            self.parameters[symbol] = of.name
            if role == "input":
                self.inputs.add(symbol)
            return symbol
        return None

    def _claim(self, text: str, meaning: Any) -> Any:
        """The symbol of one thing: its short name, with the path inside the block or a dash where that is taken."""
        longer = f"{_flat(meaning[2])}_{_flat(meaning[1])}" if len(meaning) == 3 else text
        while self.claimed.setdefault(text, meaning) != meaning:
            text = longer if text != longer and not text.startswith(longer) else text + "_"
        return sp.Symbol(text, real=True)

    def _held_angle(self, c: Component, flange: str) -> Any:
        """The angle at which the ground holds a flange: 0 where the ground is given as 0."""
        node = c.nodes[list(type(c.block).flanges).index(flange)]
        offset = self.assembly.held_offset.get(node)
        if offset is None:
            return sp.Integer(0)
        gain = self.assembly.group_of_node[node][1]
        return sp.Rational(gain.numerator, gain.denominator) * self._offset(offset)

    def _offset(self, offset: str) -> Any:
        """The symbol of an angle that the ground holds, 0 where it is given as 0."""
        path, _, name = offset.rpartition(".")
        block = next(other.block for other in self.assembly.train.components if other.path == path)
        if getattr(block, name) == 0:
            return sp.Integer(0)
        symbol = self._claim(f"{name}_{_flat(path)}", ("own", path, name))
        self.parameters[symbol] = offset
        return symbol

    def _mobility(self, place: Any) -> Any:
        """1/J of a shaft as a symbol, defined when everything is added up."""
        if place is None or place[0] == HELD:
            return sp.Integer(0)
        return sp.Rational(place[1].numerator, place[1].denominator) ** 2 / sp.Symbol(f"__J{place[0]}")

    def finish(self) -> Equations:
        """The frozen equations."""
        carried = carry(self.assembly, self.drives, self.q, self.v, self._offset)
        mass, torque = carried.balance(self.mass, self.torque)
        mobility = {
            sp.Symbol(f"__J{i}"): m if self.assembly.plain else carried.inertia(mass, i) for i, m in enumerate(self.mass)
        }  # fmt: skip
        torque = [self._sensed(e.xreplace(mobility)) for e in torque]
        definitions = {s: self._sensed(carried.put(e).xreplace(mobility)) for s, e in self.definitions.items()}
        self.states = {s: self._sensed(carried.put(e)) for s, e in self.states.items()} | carried.paced
        self.shows = {path: carried.put(e) for path, e in self.shows.items()}
        self.deflections = {x: carried.put(e) for x, e in self.deflections.items()}
        self.q, self.v = self.q[: carried.n], self.v[: carried.n]
        used: set[Any] = set()
        for e in [*torque, *self.states.values()]:
            used |= e.free_symbols
        kept: dict[Any, Any] = {}
        while new := [s for s in definitions if s in used and s not in kept]:
            for s in new:
                kept[s] = definitions[s]
                used |= definitions[s].free_symbols
        ordered = {s: kept[s] for s in definitions if s in kept}
        parameters = {s: p for s, p in self.parameters.items() if s in used or s in mass.free_symbols}
        everything = [*self.q, *self.v, *self.states, *ordered, *parameters]
        return Equations(
            self.assembly.train.name, tuple(self.q), tuple(self.v), mass, sp.Matrix(torque), self.states,
            ordered, parameters, self._coordinates(), {s: _latex_name(s.name) for s in everything},
            {s: self._sensed(e) for s, e in self.held.items()},
        )  # fmt: skip

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
            moving = {clock(), *self.states, *self.inputs}
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
                return symbol
            if x.args[0] not in self.shows:
                raise ModelError(f"a coordinate reads '{x.args[0]}', which no block shows")
            return self.shows[x.args[0]]

        return to_sympy(expr, leaf)


def _flat(path: str) -> str:
    return path.replace(".", "_").replace("[", "").replace("]", "")
