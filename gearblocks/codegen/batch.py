"""Code of one batch: every function of its law as a view that the template prints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import HELD
from gearblocks.assembly.tables import Batch
from gearblocks.codegen.function import Column, Function, Statement, column, identifier
from gearblocks.codegen.hoisting import Hoister
from gearblocks.codegen.layout import Layout, speed_index
from gearblocks.codegen.massless_balance import balance_of
from gearblocks.codegen.parts import Balance, HiddenRows
from gearblocks.laws.prescribed_motion import frozen_drive
from gearblocks.laws.printer import c_text
from gearblocks.laws.symbols import CONSTANT, MOVING, TIMED, clock

_OF_STICKS = ("lower", "upper", "forward", "backward", "engaged", "restitution", "share")


@dataclass(slots=True)
class Places:
    """Where the columns of a batch lie; filled by the generator before functions are printed."""

    own: Mapping[str, int]
    exact: dict[Any, int] = field(default_factory=dict)
    hoisted: dict[Any, str] = field(default_factory=dict)
    modes: int = 0
    locks: dict[str, int] = field(default_factory=dict)
    switches: list[int] = field(default_factory=list)
    inverse_mass: int = 0
    mass: int = 0
    hidden: HiddenRows = field(default_factory=dict)
    floats: frozenset[int] = frozenset()
    tau: dict[str, int] = field(default_factory=dict)
    senses: Mapping[str, int] = field(default_factory=dict)
    tables: Mapping[Any, str] = field(default_factory=dict)


def _by_name(*exprs: Any) -> list[Any]:
    """The symbols of expressions in a fixed order."""
    return sorted({x for e in exprs for x in sp.sympify(e).free_symbols}, key=lambda x: str(x.name))


def _states(vector: str) -> str:
    return "y" if vector == "whole" else vector


class BatchCode:
    """Prints the expressions of one batch as functions."""

    def __init__(self, lay: Layout, number: int, batch: Batch, places: Places) -> None:
        self.lay, self.number, self.batch, self.places = lay, number, batch, places
        self.law = batch.law
        self.n = len(batch.components)
        self.paths = [lay.assembly.train.components[i].path for i in batch.components]
        self.hoister = Hoister(self.law.pool)

    # -- names of symbols ---------------------------------------------------------------------------------------------

    def names(
        self, exprs: Iterable[Any], *, vector: str = "y"
    ) -> tuple[dict[Any, str], list[Any], list[tuple[str, str]]]:
        """C names of all symbols in the expressions, the arguments they need and the constants to define.

        vector: what coordinates and speeds are read from: "y" ("whole": with whole angles), a "direction", speeds of
        groups alone ("speed"), or a "lane" of time columns (none).
        """
        names: dict[Any, str] = {}
        args: dict[str, tuple[str, str, Column]] = {}
        prologue: dict[str, str] = {}
        for symbol in _by_name(*exprs):
            names[symbol] = self._name(symbol, args, prologue, vector)
        return names, list(args.values()), list(prologue.items())

    def _name(self, symbol: Any, args: dict[str, Any], prologue: dict[str, str], vector: str) -> str:
        slot = self.law.pool.slots[symbol]
        role, of = slot.role, slot.of
        if role == "own":
            prologue[name := f"p_{identifier(of)}"] = f"par[{self.places.own[of]} + e]"
        elif role == "exact":
            prologue[name := f"x_{identifier(of)}"] = f"par[{self.places.exact[symbol]} + e]"
        elif role == "shared":
            name = f"par[{self.lay.shared[of.name]}]"
        elif role == "column":
            name = self.places.hoisted[symbol]
            if vector == "lane" and of[0] == TIMED:
                name = f"{name[:-1]} + i]"
        elif role == "coordinate":
            prologue[name := f"u{of}"] = self._coordinate(of, args, vector)
        elif role in ("w", "phi", "alpha"):
            prologue[name := f"{role}_{of}"] = self._flange(role, of, args, vector)
        elif role == "tau":
            name = f"flange_tau[{self.places.tau[of]} + e]"
        elif role == "state":
            prologue[name := f"z_{identifier(of)}"] = f"{_states(vector)}[{self.lay.state0[self.number, of]} + e]"
        elif role == "sense":
            name = f"sense[{self.places.senses[of]}]"
        elif role == "mode":
            prologue[name := f"mode{of.number}"] = f"mode[{self.places.switches[of.number]} + e]"
        elif role in ("direction", "stuck"):
            name = self._lock_mode(role, of, prologue)
        elif role == "held":
            name = f"held[{self.places.locks[of]} + e]"
        elif role == "before":
            prologue[name := f"before{of.number}"] = f"before[{self.places.switches[of.number]} + e]"
        elif role in ("table", "table2"):
            name = self.places.tables[symbol]
        elif role == "force":
            inner = {x: self._name(x, args, prologue, vector) for x in _by_name(self.forces[symbol])}
            prologue[name := f"force{of}"] = c_text(self.forces[symbol], inner)
        elif role == "mobility":
            name = self._mobility(of, args)
        elif role == "gain":
            name = self._gain(of, args).removesuffix(" * ") or "1.0"
        elif role == "local":
            name = of
        elif role == "time":
            name = "t[i]"
        else:
            assert role == "input", role
            name = f"u[{list(self.lay.inputs).index(of.name)} * GB_LANES + i]"
        return name

    def _lock_mode(self, role: str, stick: str, prologue: dict[str, str]) -> str:
        """The direction of a stick, or whether it is stuck, from its modes."""
        switches = self.law.sticks[stick].switches
        number = switches["hold"] if role == "stuck" else next(iter(switches.values()))
        name = f"{role}_{identifier(stick)}"
        prologue[name] = f"mode[{self.places.switches[number]} + e]"
        return name

    def _coordinate(self, j: int, args: dict[str, Any], vector: str) -> str:
        key = f"q{j}"
        if self.batch.used and not self.batch.used[j]:
            return self._from_angles(j, args, vector)
        args[key] = ("int", key, column(f"{self.batch.name}_{key}", self.batch.sources[j]))
        if self.batch.dependent[j]:
            return f"{'loop_direction' if vector == 'direction' else 'loop'}[{key}]"
        return f"{_states(vector)}[{key}]"

    def _from_angles(self, j: int, args: dict[str, Any], vector: str) -> str:
        """A coordinate that no state carries, from absolute angles (outputs only)."""
        terms = []
        for flange, expr in self.law.forms[j].coefficients.items():
            values = [float(v) for v in self._exact_column(expr)]
            key = f"c{j}_{flange}"
            args[key] = ("double", key, column(f"{self.batch.name}_{key}", values))
            terms.append(f"{key} * ({self._flange('phi', flange, args, vector)})")
        return " + ".join(terms)

    def _exact_column(self, expr: Any) -> list[Any]:
        from gearblocks.laws.rational import exact_value

        return [exact_value(expr, {s: v[e] for s, v in self.batch.exact.items()}) for e in range(self.n)]

    def _flange(self, role: str, flange: str, args: dict[str, Any], vector: str) -> str:
        groups = self.batch.groups[flange]
        if groups[0] == HELD:
            return self._held_angle(flange, args) if role == "phi" and vector != "direction" else "0.0"
        gain = self._gain(flange, args)
        if role == "phi" or vector == "speed":
            key = f"g_{flange}"
            args[key] = ("int", key, column(f"{self.batch.name}_{key}", groups))
            return f"{gain}{vector if role != 'phi' or vector == 'whole' else 'phi'}[{key}]"
        key = self.speed_key(flange, args)
        if not self.lay.assembly.plain:
            return f"{gain}{role}[{key}]"
        return f"{gain}{'dy' if role == 'alpha' else _states(vector)}[{key}]"

    def speed_key(self, flange: str, args: dict[str, Any]) -> str:
        """The index of a flange's speed: in the state vector, or among all groups where some of them follow others."""
        if self.lay.assembly.plain:
            key = f"v_{flange}"
            args[key] = ("int", key, column(f"{self.batch.name}_{key}", speed_index(self.lay, self.batch, flange)))
        else:
            key = f"g_{flange}"
            args[key] = ("int", key, column(f"{self.batch.name}_{key}", self.batch.groups[flange]))
        return key

    def torque_place(self, flange: str) -> str:
        """Where the torque on a flange is added up."""
        key = self.speed_key(flange, {})
        return f"dy[{key}]" if self.lay.assembly.plain else f"torque[{key}]"

    def _held_angle(self, flange: str, args: dict[str, Any]) -> str:
        key = f"h_{flange}"
        offsets = self.lay.assembly.held_offset
        at = [self.lay.path_of.get(offsets[node] or "", -1) for node in self.batch.nodes[flange]]
        if all(i < 0 for i in at):
            return "0.0"
        args[key] = ("int", key, column(f"{self.batch.name}_{key}", at))
        return f"{self._gain(flange, args)}({key} < 0 ? 0.0 : par[{key} < 0 ? 0 : {key}])"

    def _gain(self, flange: str, args: dict[str, Any]) -> str:
        gains = column(f"{self.batch.name}_k_{flange}", [float(g) for g in self.batch.gains[flange]])
        if all(g == 1.0 for g in gains.values):
            return ""
        args[f"k_{flange}"] = ("double", f"k_{flange}", gains)
        return f"k_{flange} * "

    def _mobility(self, flange: str, args: dict[str, Any]) -> str:
        if flange not in self.batch.groups or self.batch.groups[flange][0] == HELD:
            return "0.0"
        key = f"m_{flange}"
        args[key] = ("int", key, column(f"{self.batch.name}_{key}", self.batch.groups[flange]))
        gain = self._gain(flange, args)
        return f"({gain}{gain}par[{self.places.inverse_mass} + {key}])"

    def moving_columns(self, sensed: set[str]) -> set[Any]:
        """Columns that the motion needs; the others are read by outputs and energies alone. sensed: names of outputs."""
        drives = [e for x in self.drives for e in (*x.gains.values(), x.bias, x.surplus, x.angle)]
        balance = (*self.balance.torques.values(), *self.balance.growths.values())
        exprs = [
            *self.forces.values(), *self.torques.values(), *self.rates.values(), self.loss, self.supplied, *self.surfaces,
            *self.bands, *self.whens, *self.speeds, *drives, *balance, *self.balance.drags.values(),
            *self.balance.stiffnesses.values(), *self.starts.values(), *(e for _, e in self.holds),
            self.late_loss, *(e for values in self.stick_values.values() for e in values.values()),
            *(e for x, e in self.shows if x.name in sensed), *(e for i in range(len(self.sorts)) for e in self._watched(i)),
        ]  # fmt: skip
        found = {x for e in exprs if e is not None for x in sp.sympify(e).free_symbols}
        for c in reversed(self.hoister.columns):
            if c.symbol in found:
                found |= c.expr.free_symbols
        return found

    def _watched(self, i: int) -> list[Any]:
        """What the location of switch i reads besides its surface."""
        if self.sorts[i] in ("line", "wave"):
            return self.prediction(i)[1]
        scale = self.gap_scale(i) if self.sorts[i] == "affine" else None
        return [self.direction_of(i), *([] if scale is None else [scale[1]])] if self.sorts[i] == "affine" else []

    def mobile_groups(self) -> list[tuple[int, str]]:
        """(group, path) of every shaft whose mobility the law reads."""
        used = {x for c in self.hoister.columns for x in c.expr.free_symbols}
        flanges = [slot.of for x, slot in self.law.pool.slots.items() if slot.role == "mobility" and x in used]
        return [
            item
            for f in flanges
            if f in self.batch.groups
            for item in zip(self.batch.groups[f], self.paths, strict=True)
            if item[0] != HELD
        ]

    # -- functions ----------------------------------------------------------------------------------------------------

    def function(
        self, what: str, targets: list[tuple[str, str, Any, bool]], *, vector: str = "y", extra: Iterable[str] = ()
    ) -> Function:  # fmt: skip
        """A function that stores expressions: (lhs, op, expression, only in the full variant)."""
        names, args, prologue = self.names([expr for _, _, expr, _ in targets], vector=vector)
        more: dict[str, Any] = {key: (kind, key, col) for kind, key, col in args}
        for flange in extra:
            if self.batch.groups[flange][0] != HELD:
                self.speed_key(flange, more)
                self._gain(flange, more)
        body = [Statement(lhs, op, c_text(expr, names), full) for lhs, op, expr, full in targets]
        return Function(f"{what}_{self.batch.name}", list(more.values()), prologue, body, self.n)

    def scaled(self, flange: str, text: str) -> str:
        """A flange torque as a torque of its group."""
        gain = self._gain(flange, {})
        return f"{gain}({text})" if gain else text

    def mass(self, flange: str, inertia: Any) -> Function:
        """Adds the bodies of the batch to the inertia of their groups."""
        key = f"m_{flange}"
        function = self.function(f"mass_{flange}", [(f"par[{self.places.mass} + {key}]", "+=", inertia, False)])
        args: dict[str, Any] = {key: ("int", key, column(f"{self.batch.name}_{key}", self.batch.groups[flange]))}
        gain = self._gain(flange, args)
        function.args += list(args.values())
        function.body[0].rhs = f"{gain}{gain}{function.body[0].rhs}"
        return function

    def hoist_all(self) -> None:
        """Moves constant and timed parts of the law's expressions into columns."""
        hoist = self.hoister.hoist
        law = self.law
        self.forces = {x: hoist(self.hoister.spread(e)) for x, e in law.forces.items()}
        self.torques = {n: hoist(e) for n, e in law.torques.items()}
        self.rates = {n: hoist(e) for n, e in law.rates.items()}
        self.loss = None if law.loss is None else hoist(law.loss)
        self.supplied = None if law.supplied is None else hoist(law.supplied)
        self.stored = None if law.stored is None else hoist(law.stored)
        self.sorts = [self._sort(i) for i in range(len(law.switches))]
        self.surfaces = [
            hoist(s.surface) if sort in ("affine", "general") else s.surface
            for s, sort in zip(law.switches, self.sorts, strict=True)
        ]
        self.bands = [None if s.band is None else hoist(s.band) for s in law.switches]
        self.whens = [hoist(sp.sympify(s.when)) for s in law.switches]
        self.shows = [(x, hoist(x.expr)) for x in law.shows]
        self.holds = [(state, hoist(self._held(*rest, state=state))) for state, *rest in law.holds]
        self.speeds = [self._coordinate_rate(j) for j in range(len(law.forms))]
        self.drives = [frozen_drive(x, hoist) for x in law.drives]
        self.starts = {n: hoist(e) for n, e in law.starts.items()}
        self.stick_values = {
            name: {k: hoist(v) for k in _OF_STICKS if (v := getattr(stick, k)) is not None}
            for name, stick in law.sticks.items()
        }
        for name, stick in law.sticks.items():
            self.stick_values[name] |= {f"loss_{i}": hoist(x) for i, x in enumerate(stick.losses or ())}
        self.late_loss = None if law.late_loss is None else hoist(law.late_loss)
        self.balance = (
            balance_of(self.batch, self.hoister.hoist, self.places.hidden, self.places.floats)
            if self.places.hidden
            else Balance()
        )

    def _held(self, value: Any, when: Any, *, state: str) -> Any:
        """What a held state is after an event: the value where `when` has just turned to 1, else as it was."""
        pool = self.law.pool
        modes = [x for x in when.free_symbols if pool.slots[x].role == "mode"]
        before = {x: pool.symbol("before", pool.slots[x].of, f"before{pool.slots[x].of.number}") for x in modes}
        starts = when * (1 - when.xreplace(before))
        return starts * value + (1 - starts) * pool.symbol("state", state, state)

    def _coordinate_rate(self, j: int) -> Any:
        """Rate of a coordinate from the flange speeds."""
        total: Any = sp.Integer(0)
        for flange, expr in self.law.forms[j].coefficients.items():
            if self.batch.groups[flange][0] != HELD:
                total += self.hoister.hoist(expr) * self.law.pool.symbol("w", flange, f"w_{flange}")
        return total

    def _sort(self, i: int) -> str:
        """How switch i is watched: "affine" or "general" over the state, "line" or "wave" predicted over time."""
        switch = self.law.switches[i]
        if switch.lock in ("hold", "sign"):
            return "general_lock"
        if switch.lock == "slip":
            return "general_lock" if any(f.drive is not None for f in self.lay.assembly.followers) else "affine_lock"
        roles = {x: self.law.pool.slots[x].role for x in switch.surface.free_symbols}
        if switch.level == TIMED and set(roles.values()) <= {"own", "exact", "shared", "mobility", "time"}:
            if switch.band is None and self._line(switch.surface) is not None:
                return "line"
            if switch.is_sign and self._wave(switch.surface) is not None:
                return "wave"
        if switch.level != MOVING:
            return "general"
        moving = [x for x in switch.surface.free_symbols if self.law.pool.level(x) == MOVING]
        timed = any(self.law.pool.level(x) == TIMED for x in switch.surface.free_symbols)
        assembly = self.lay.assembly
        known = {"coordinate", "state", *(["w"] if assembly.plain else []), *([] if assembly.driven else ["phi"])}
        if timed or any(roles[x] not in known for x in moving):
            return "general"
        if any(assembly.dependents[k].groups for x in moving if roles[x] == "coordinate" for k in self._loops(x)):
            return "general"
        slopes = [sp.diff(switch.surface, x) for x in moving]
        return "affine" if all(self.law.pool.level(slope) == CONSTANT for slope in slopes) else "general"

    def _loops(self, symbol: Any) -> list[int]:
        """The combinations that a coordinate of the law is, where it is no state."""
        j = self.law.pool.slots[symbol].of
        return self.batch.sources[j] if self.batch.dependent[j] else []

    @staticmethod
    def _line(surface: Any) -> tuple[Any, Any] | None:
        """(rate, offset) of a surface affine in time."""
        rate = sp.diff(surface, clock())
        if rate == 0 or rate.has(clock()):
            return None
        return rate, surface.xreplace({clock(): sp.Integer(0)})

    def _wave(self, surface: Any) -> tuple[Any, Any, Any, Any] | None:
        """(size, rate, phase, offset) of size cos(rate t + phase) + offset."""
        waves = [a for a in sp.Add.make_args(surface) if a.has(clock())]
        if len(waves) != 1:
            return None
        size, wave = waves[0].as_independent(clock())
        if not isinstance(wave, (sp.cos, sp.sin)):
            return None
        line = self._line(wave.args[0])
        if line is None:
            return None
        phase = line[1] - sp.pi / 2 if isinstance(wave, sp.sin) else line[1]
        return size, line[0], phase, surface - waves[0]

    def wave_of(self, i: int) -> tuple[Any, Any, Any, Any]:
        """(size, rate, phase, offset) of a switch of sort "wave"."""
        found = self._wave(self.law.switches[i].surface)
        assert found is not None
        return found

    def prediction(self, i: int) -> tuple[str, list[Any]]:
        """The C function that foretells time switch i, and its constant arguments."""
        switch = self.law.switches[i]
        if self.sorts[i] == "wave":
            return "gb_wave_next", [self.hoister.hoist(x) for x in self.wave_of(i)]
        line = self._line(switch.surface)
        assert line is not None
        return ("gb_table_next" if switch.table is not None else "gb_line_next"), [self.hoister.hoist(x) for x in line]

    def direction_of(self, i: int) -> Any:
        """The linear part of an affine surface."""
        surface = self.law.switches[i].surface
        moving = [x for x in sorted(surface.free_symbols, key=str) if self.law.pool.level(x) == MOVING]
        return self.hoister.hoist(sp.Add(*(sp.diff(surface, x) * x for x in moving)))

    def gap_scale(self, i: int) -> tuple[int, Any] | None:
        """(coordinate, natural size) where an affine surface knows one: abs(constant part / slope)."""
        surface = self.law.switches[i].surface
        moving = [x for x in surface.free_symbols if self.law.pool.level(x) == MOVING]
        if len(moving) != 1 or self.law.pool.slots[moving[0]].role != "coordinate":
            return None
        j = self.law.pool.slots[moving[0]].of
        constant = surface.xreplace({moving[0]: sp.Integer(0)})
        if self.law.switches[i].band is not None:
            constant = self.law.switches[i].band
        if constant == 0 or self.batch.dependent[j]:
            return None
        return j, self.hoister.hoist(constant / sp.diff(surface, moving[0]))
