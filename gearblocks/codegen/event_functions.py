"""Event functions of one batch: how the crossings of each switch are located, and what its location reads.

"affine" or "general" over the state ("affine_constraint" or "general_constraint" of switched constraints), "line" or "wave"
where time alone moves it, which gives its crossings in advance. Knows nothing of how crossings are located.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import sympy as sp

from gearblocks.laws.symbols import CONSTANT, MOVING, TIMED, time_symbol

if TYPE_CHECKING:
    from gearblocks.assembly.tables import Assembly, Batch
    from gearblocks.laws.law import Law

Hoist = Callable[[Any], Any]

_PREDICTED = {"own", "exact", "shared", "mobility", "time"}
"""Roles of symbols in event functions whose crossings follow in advance."""


class EventFunctions:
    """The event functions of the switches of one law. sorts: how each is located."""

    def __init__(self, assembly: Assembly, batch: Batch, hoist: Hoist) -> None:
        self.assembly, self.batch, self.hoist = assembly, batch, hoist
        self.law: Law = batch.law
        self.sorts = [self._sort(i) for i in range(len(self.law.switches))]

    def _sort(self, i: int) -> str:
        switch = self.law.switches[i]
        if switch.constraint in ("hold", "sign"):
            return "general_constraint"
        if switch.constraint == "slip":
            return (
                "general_constraint"
                if any(f.prescribed is not None for f in self.assembly.dependent_groups)
                else "affine_constraint"
            )
        roles = {x: self.law.pool.roles[x].role for x in switch.surface.free_symbols}
        if switch.level == TIMED and set(roles.values()) <= _PREDICTED:
            if switch.band is None and line(switch.surface) is not None:
                return "line"
            if switch.is_sign and _wave(switch.surface) is not None:
                return "wave"
        return "affine" if switch.level == MOVING and self._is_affine(switch.surface, roles) else "general"

    def _is_affine(self, surface: Any, roles: dict[Any, str]) -> bool:
        """Whether it is affine in states, with slopes that parameters alone give."""
        pool, assembly = self.law.pool, self.assembly
        moving = [x for x in surface.free_symbols if pool.level(x) == MOVING]
        timed = any(pool.level(x) == TIMED for x in surface.free_symbols)
        known = {
            "coordinate",
            "state",
            *(["w"] if assembly.plain else []),
            *([] if assembly.has_prescribed_angles else ["phi"]),
        }
        if timed or any(roles[x] not in known for x in moving):
            return False
        if any(assembly.dependents[k].groups for x in moving if roles[x] == "coordinate" for k in self._loops(x)):
            return False
        return all(pool.level(sp.diff(surface, x)) == CONSTANT for x in moving)

    def _loops(self, symbol: Any) -> list[int]:
        """The combinations that a coordinate of the law is, where it is no state."""
        j = self.law.pool.roles[symbol].of
        return self.batch.sources[j] if self.batch.dependent[j] else []

    def wave(self, i: int) -> tuple[Any, Any, Any, Any]:
        """(size, rate, phase, offset) of a switch of sort "wave"."""
        found = _wave(self.law.switches[i].surface)
        assert found is not None
        return found

    def prediction(self, i: int) -> tuple[str, list[Any]]:
        """The C function that gives the next crossing of a switch of time, and its constant arguments."""
        switch = self.law.switches[i]
        if self.sorts[i] == "wave":
            return "gb_wave_next", [self.hoist(x) for x in self.wave(i)]
        found = line(switch.surface)
        assert found is not None
        return ("gb_table_next" if switch.table is not None else "gb_line_next"), [self.hoist(x) for x in found]

    def direction(self, i: int) -> Any:
        """The linear part of an affine event function."""
        surface = self.law.switches[i].surface
        moving = [x for x in sorted(surface.free_symbols, key=str) if self.law.pool.level(x) == MOVING]
        return self.hoist(sp.Add(*(sp.diff(surface, x) * x for x in moving)))

    def gap_scale(self, i: int) -> tuple[int, Any] | None:
        """(coordinate, natural size) where an affine event function knows one: abs(constant part / slope)."""
        surface = self.law.switches[i].surface
        moving = [x for x in surface.free_symbols if self.law.pool.level(x) == MOVING]
        if len(moving) != 1 or self.law.pool.roles[moving[0]].role != "coordinate":
            return None
        j = self.law.pool.roles[moving[0]].of
        constant = surface.xreplace({moving[0]: sp.Integer(0)})
        if self.law.switches[i].band is not None:
            constant = self.law.switches[i].band
        if constant == 0 or self.batch.dependent[j]:
            return None
        return j, self.hoist(constant / sp.diff(surface, moving[0]))

    def read(self, i: int) -> list[Any]:
        """The expressions that the location of switch i reads besides its event function."""
        if self.sorts[i] in ("line", "wave"):
            return self.prediction(i)[1]
        if self.sorts[i] != "affine":
            return []
        direction, scale = self.direction(i), self.gap_scale(i)
        return [direction] if scale is None else [direction, scale[1]]


def line(expr: Any) -> tuple[Any, Any] | None:
    """(rate, offset) of an expression affine in time, None for others."""
    rate = sp.diff(expr, time_symbol())
    if rate == 0 or rate.has(time_symbol()):
        return None
    return rate, expr.xreplace({time_symbol(): sp.Integer(0)})


def _wave(surface: Any) -> tuple[Any, Any, Any, Any] | None:
    """(size, rate, phase, offset) of size cos(rate t + phase) + offset."""
    waves = [a for a in sp.Add.make_args(surface) if a.has(time_symbol())]
    if len(waves) != 1:
        return None
    size, wave = waves[0].as_independent(time_symbol())
    if not isinstance(wave, (sp.cos, sp.sin)):
        return None
    found = line(wave.args[0])
    if found is None:
        return None
    phase = found[1] - sp.pi / 2 if isinstance(wave, sp.sin) else found[1]
    return size, found[0], phase, surface - waves[0]
