"""C of the symbols of a law: operands, arguments and constants of the functions of one batch.

Knows where each symbol lies in the vectors, and nothing of what the expressions mean.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.assembly.tables import Batch
from gearblocks.codegen.function import Argument, Names, column, identifier
from gearblocks.codegen.layout import Layout, speed_index
from gearblocks.codegen.operands import Local, Operand, Role
from gearblocks.codegen.parts import MasslessRows
from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.printer import c_text
from gearblocks.laws.rational import exact_value
from gearblocks.laws.symbols import TIMED


@dataclass(slots=True)
class Offsets:
    """Offsets of the numbers of a batch; filled by the generator before functions are printed."""

    own: Mapping[str, int]
    exact: dict[Any, int] = field(default_factory=dict)
    hoisted: dict[Any, Operand] = field(default_factory=dict)
    constraints: dict[str, int] = field(default_factory=dict)
    switches: list[int] = field(default_factory=list)
    inverse_mass: int = 0
    mass: int = 0
    massless: MasslessRows = field(default_factory=dict)
    floating_bases: frozenset[int] = frozenset()
    by_mode: bool = False
    flange_torques: dict[str, int] = field(default_factory=dict)
    feedback: Mapping[str, int] = field(default_factory=dict)
    tables: Mapping[Any, str] = field(default_factory=dict)


def by_name(*exprs: Any) -> list[Any]:
    """The symbols of expressions in a fixed order."""
    return sorted({x for e in exprs for x in symbols_in(sp.sympify(e))}, key=lambda x: str(x.name))


_LETTERS = {"own": "p", "exact": "x"}
"""First letters of constants for numbers of the block."""


class SymbolNames:
    """The C of all symbols of one batch."""

    def __init__(self, lay: Layout, number: int, batch: Batch, offsets: Offsets) -> None:
        self.lay, self.number, self.batch, self.offsets = lay, number, batch, offsets
        self.law = batch.law
        self.forces: Mapping[Any, Any] = {}
        self._arguments: dict[str, Argument] = {}
        self._scaled: dict[str, bool] = {}  # by flange: whether a gain is not 1

    def of(self, exprs: Iterable[Any], *, vector: Role = Role.STATES) -> Names:
        """The names of all symbols in the expressions."""
        names = Names(vector)
        for symbol in by_name(*exprs):
            names.text[symbol] = self.name(symbol, names)
        return names

    def name(self, symbol: Any, into: Names) -> str:
        """The C of a symbol."""
        meaning = self.law.pool.roles[symbol]
        role, of = meaning.role, meaning.of
        if role == "coordinate":
            into.constants[name := f"u{of}"] = self._coordinate(of, into)
        elif role in ("w", "phi", "alpha"):
            into.constants[name := f"{role}_{of}"] = self._flange(role, of, into)
        elif role == "force":
            inner = {x: self.name(x, into) for x in by_name(self.forces[symbol])}
            into.constants[name := f"force{of}"] = c_text(self.forces[symbol], inner)
        elif role in ("table", "table2"):
            name = self.offsets.tables[symbol]
        elif role == "mobility":
            name = self._mobility(of, into)
        elif role == "gain":
            name = self.gain(of, into) or "1.0"
        else:
            constant = self._constant(symbol, role, of, into)
            name = into.define(*constant) if constant else into.place(self._operand(symbol, role, of, into))
        return name

    def _constant(self, symbol: Any, role: str, of: Any, into: Names) -> tuple[str, Operand] | None:
        """Name and operand of a symbol that the function defines as a constant."""
        at = self.offsets
        if role in ("own", "exact"):
            offset = at.own[of] if role == "own" else at.exact[symbol]
            return f"{_LETTERS[role]}_{identifier(of)}", Operand(Role.PARAMETERS, offset, instance=True)
        if role == "state":
            return f"z_{identifier(of)}", Operand(into.states, self.lay.state0[self.number, of], instance=True)
        if role in ("mode", "before"):
            vector = Role.MODES if role == "mode" else Role.MODES_BEFORE
            return f"{role}{of.number}", Operand(vector, at.switches[of.number], instance=True)
        if role in ("direction", "stuck"):  # of a switched constraint, by its modes
            switches = self.law.constraints[of].switches
            number = switches["hold"] if role == "stuck" else next(iter(switches.values()))
            return f"{role}_{identifier(of)}", Operand(Role.MODES, at.switches[number], instance=True)
        return None

    def _operand(self, symbol: Any, role: str, of: Any, into: Names) -> Operand | Local:
        """The operand of a symbol that is read where it stands."""
        at = self.offsets
        if role == "local":
            return of  # type: ignore[no-any-return]  # what a function writes itself, or is given
        if role == "shared":
            return Operand(Role.PARAMETERS, self.lay.shared[of.name])
        if role == "hoisted":
            found = at.hoisted[symbol]
            return found.of_lane() if into.vector is Role.TIME_TERMS and of[0] == TIMED else found
        if role == "tau":
            return Operand(Role.FLANGE_TORQUES, at.flange_torques[of], instance=True)
        if role == "sense":
            return Operand(Role.FEEDBACK_SIGNALS, at.feedback[of])
        if role == "constraint_force":
            return Operand(Role.CONSTRAINT_FORCES, at.constraints[of], instance=True)
        if role == "time":
            return Operand(Role.TIME, lane=True)
        assert role == "input", role
        return Operand(Role.INPUTS, list(self.lay.inputs).index(of.name), lane=True)

    def argument(self, into: Names, kind: str, name: str, values: Callable[[], Sequence[Any]]) -> str:
        """A number of the instance, of which the column is made once."""
        if name not in self._arguments:
            self._arguments[name] = Argument(kind, name, column(f"{self.batch.name}_{name}", values()))
        return into.take(self._arguments[name])

    # -- coordinates and flanges --------------------------------------------------------------------------------------

    def _coordinate(self, j: int, into: Names) -> str:
        if self.batch.used and not self.batch.used[j]:
            return self._from_angles(j, into)
        key = self.argument(into, "int", f"q{j}", lambda: self.batch.sources[j])
        if not self.batch.dependent[j]:
            return into.place(Operand(into.states, key))
        vector = Role.DIRECTION_OF_DEPENDENT if into.vector is Role.DIRECTION else Role.DEPENDENT_COORDINATES
        return into.place(Operand(vector, key))

    def _from_angles(self, j: int, into: Names) -> str:
        """A coordinate that is no state, from absolute angles (outputs only)."""
        terms = []
        for flange, values in self.form(j).items():
            key = self.argument(into, "double", f"c{j}_{flange}", partial(list, values))
            terms.append(f"{key} * ({self._flange('phi', flange, into)})")
        return " + ".join(terms)

    def form(self, j: int) -> dict[str, list[float]]:
        """The coefficients of a coordinate over the flange angles, by instance."""
        forms = self.law.forms[j].coefficients
        return {flange: [float(v) for v in self._exact_column(expr)] for flange, expr in forms.items()}

    def _exact_column(self, expr: Any) -> list[Any]:
        numbers = self.batch.exact
        return [exact_value(expr, {s: v[e] for s, v in numbers.items()}) for e in range(len(self.batch.components))]

    def _flange(self, role: str, flange: str, into: Names) -> str:
        groups = self.batch.groups[flange]
        if groups[0] == GROUND_GROUP:
            return self.held_angle(flange, into) if role == "phi" and into.vector is not Role.DIRECTION else "0.0"
        gain = self._factor(flange, into)
        if role == "phi":
            unwrapped = into.vector is Role.UNWRAPPED_ANGLES
            place = Operand(Role.UNWRAPPED_ANGLES if unwrapped else Role.ANGLES, self.group_key(flange, into))
        elif into.vector is Role.GROUP_SPEEDS:
            place = Operand(Role.GROUP_SPEEDS, self.group_key(flange, into))
        else:
            among = (into.states, Role.RATES) if self.lay.assembly.plain else (Role.SPEEDS, Role.ACCELERATIONS)
            place = Operand(among[role == "alpha"], self.speed_key(flange, into))
        return gain + into.place(place)

    def group_key(self, flange: str, into: Names, letter: str = "g") -> str:
        """The argument with the group of a flange."""
        return self.argument(into, "int", f"{letter}_{flange}", lambda: self.batch.groups[flange])

    def speed_key(self, flange: str, into: Names) -> str:
        """The index of a flange's speed: in the state vector, or among all groups where some of them are dependent."""
        if self.lay.assembly.plain:
            return self.argument(into, "int", f"v_{flange}", lambda: speed_index(self.lay, self.batch, flange))
        return self.group_key(flange, into)

    def held_angle(self, flange: str, into: Names) -> str:
        """The angle of a flange at the ground."""
        offsets = self.lay.assembly.ground_offset
        at = [self.lay.path_of.get(offsets[node] or "", -1) for node in self.batch.nodes[flange]]
        if all(i < 0 for i in at):
            return "0.0"
        key = self.argument(into, "int", f"h_{flange}", lambda: at)
        angle = into.place(Operand(Role.PARAMETERS, f"{key} < 0 ? 0 : {key}"))
        return f"{self._factor(flange, into)}({key} < 0 ? 0.0 : 1.0) * {angle}"

    def gain(self, flange: str, into: Names) -> str:
        """The argument with the gain of a flange on its group; "" where it is 1 throughout."""
        gains = self.batch.gains[flange]
        if flange not in self._scaled:
            self._scaled[flange] = any(float(g) != 1.0 for g in gains)
        return (
            self.argument(into, "double", f"k_{flange}", lambda: list(map(float, gains)))
            if self._scaled[flange]
            else ""
        )

    def _factor(self, flange: str, into: Names) -> str:
        gain = self.gain(flange, into)
        return f"{gain} * " if gain else ""

    def _mobility(self, flange: str, into: Names) -> str:
        if flange not in self.batch.groups or self.batch.groups[flange][0] == GROUND_GROUP:
            return "0.0"
        key = self.group_key(flange, into, "m")
        gain = self._factor(flange, into)
        return f"({gain}{gain}{into.place(Operand(Role.PARAMETERS, f'{self.offsets.inverse_mass} + {key}'))})"
