"""Law of one kind of block in symbols: forces, torques, rates, event functions, energies, outputs; and the traversal of
its expressions.

Everything that reads or replaces the expressions of a law goes through Law.map or Law.expressions: substitution of
relative coordinates, conditions as modes, hoisting, exact ratios. Knows nothing of how a law is derived, nor of trains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import sympy as sp

from gearblocks.language.contributions import Shows
from gearblocks.laws.prescribed_motion import PrescribedMotion
from gearblocks.laws.switched_constraints import ConstraintLaw
from gearblocks.laws.switching import EventFunction
from gearblocks.laws.symbols import Pool

Replace: TypeAlias = Callable[[Any], Any]

COORDINATES = "written in relative coordinates"
LOCATED = "conditions become located event functions"
READ = "conditions read the modes of the rest and locate nothing"
STAGE = "evaluated at each stage of a run"
WRAPPED = "reads angles whose whole turns may be taken off"
RATIOS = "enters ratios exactly"


@dataclass(frozen=True, slots=True)
class Form:
    """A linear form of flange angles with exact coefficients: sum of coefficient * phi; one of them is 1 or -1.

    The deflection it comes from is scale times the form, plus what does not depend on the angles where `whole`.
    """

    coefficients: dict[str, Any]
    scale: Any
    whole: bool


@dataclass(slots=True)
class Law:
    """Law of a kind, shared by all its instances, in symbols (see Pool.roles for their roles).

    forms: relative coordinates of the law as linear forms; coordinates: their symbols. bodies: (flange, inertia). ties:
    rigid constraints, (coefficients by flange, constant). prescribed: prescribed motions. forces: symbols of generalised
    forces along linear forms and what they are. torques: by flange, over the forces. rates, starts: by state. holds: (state,
    value, when), inverse_speeds: those of them that are one over a speed. supplied: stored' + loss + power into the flanges.
    constraint_loss: power lost that reads constraint forces. switches: event functions. constraints: switched constraints.
    replaced: angles by what they are in coordinates. invertible: the other flange that the nonlinear relation could be solved
    for, where it has one. heat: the state that counts what is lost, where it heats a thermal mass.
    """

    pool: Pool
    forms: list[Form] = field(default_factory=list)
    coordinates: list[Any] = field(default_factory=list)
    bodies: list[tuple[str, Any]] = field(default_factory=list)
    ties: list[tuple[Mapping[str, Any], Any]] = field(default_factory=list)
    prescribed: list[PrescribedMotion] = field(default_factory=list)
    starts: dict[str, Any] = field(default_factory=dict)
    forces: dict[Any, Any] = field(default_factory=dict)
    torques: dict[str, Any] = field(default_factory=dict)
    rates: dict[str, Any] = field(default_factory=dict)
    holds: list[tuple[str, Any, Any]] = field(default_factory=list)
    inverse_speeds: set[str] = field(default_factory=set)
    stored: Any = None
    loss: Any = None
    supplied: Any = None
    switches: list[EventFunction] = field(default_factory=list)
    constraints: dict[str, ConstraintLaw] = field(default_factory=dict)
    constraint_loss: Any = None
    shows: list[Shows] = field(default_factory=list)
    replaced: dict[Any, Any] = field(default_factory=dict)
    invertible: str | None = None
    heat: str = ""

    def map(self, f: Replace, *of: str) -> Law:
        """The law with f(expression) in place of every expression of these parts: a part by its name ("torques"), or all
        parts of a role (COORDINATES, LOCATED, READ, STAGE, RATIOS), or without any name all. Absent expressions stay absent."""
        law = replace(self)
        for name in _parts(of):
            part = PARTS[name]
            setattr(law, part.member, part.walk(getattr(law, part.member), f))
        return law

    def expressions(self, *of: str) -> list[Any]:
        """Every expression of these parts, in the order of the traversal."""
        found: list[Any] = []

        def note(e: Any) -> Any:
            found.append(e)
            return e

        self.map(note, *of)
        return found


# -- the traversal: one line per part ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Part:
    """Expressions of one member of a law: how to walk them, and their roles."""

    member: str
    walk: Callable[[Any, Replace], Any]
    roles: tuple[str, ...] = ()


def _alone(x: Any, f: Replace) -> Any:
    return None if x is None else f(x)


def _values(x: Mapping[Any, Any], f: Replace) -> dict[Any, Any]:
    return {name: f(e) for name, e in x.items()}


PARTS: dict[str, _Part] = {
    "forms": _Part("forms", lambda x, f: [replace(form, coefficients=_values(form.coefficients, f)) for form in x], (RATIOS,)),
    "ties": _Part("ties", lambda x, f: [(_values(coefficients, f), constant) for coefficients, constant in x], (RATIOS,)),
    "slips": _Part("constraints", lambda x, f: {n: replace(k, row=_values(k.row, f)) for n, k in x.items()}, (RATIOS,)),
    "bodies": _Part("bodies", lambda x, f: [(flange, f(inertia)) for flange, inertia in x]),
    "forces": _Part("forces", _values, (COORDINATES, LOCATED, STAGE, WRAPPED)),
    "torques": _Part("torques", _values, (COORDINATES, LOCATED, STAGE, WRAPPED)),
    "rates": _Part("rates", _values, (COORDINATES, LOCATED, STAGE, WRAPPED)),
    "surfaces": _Part("switches", lambda x, f: [replace(w, surface=f(w.surface)) for w in x], (STAGE,)),
    "bands": _Part("switches", lambda x, f: [replace(w, band=_alone(w.band, f)) for w in x]),
    "whens": _Part("switches", lambda x, f: [replace(w, when=f(sp.sympify(w.when))) for w in x]),
    "prescribed": _Part("prescribed", lambda x, f: [d.map_rates(f) for d in x], (LOCATED, STAGE, WRAPPED)),
    "prescribed angles": _Part("prescribed", lambda x, f: [replace(d, angle=_alone(d.angle, f)) for d in x], (LOCATED,)),
    "starts": _Part("starts", _values, (COORDINATES, LOCATED, WRAPPED)),
    "constraints": _Part("constraints", lambda x, f: {n: k.map(f) for n, k in x.items()}, (COORDINATES, STAGE)),
    "stored": _Part("stored", _alone, (COORDINATES, LOCATED, STAGE, WRAPPED)),
    "loss": _Part("loss", _alone, (COORDINATES, LOCATED, STAGE, WRAPPED)),
    "supplied": _Part("supplied", _alone, (STAGE, WRAPPED)),
    "constraint_loss": _Part("constraint_loss", _alone),
    "holds": _Part("holds", lambda x, f: [(state, f(value), f(when)) for state, value, when in x], (COORDINATES, READ)),
    "shows": _Part("shows", lambda x, f: [replace(show, expr=f(show.expr)) for show in x], (COORDINATES, READ)),
}  # fmt: skip


def _parts(of: tuple[str, ...]) -> list[str]:
    """Names of the parts that are asked for, in the order of the traversal."""
    assert set(of) <= {*PARTS, COORDINATES, LOCATED, READ, STAGE, WRAPPED, RATIOS}, of
    return [name for name, part in PARTS.items() if not of or name in of or not set(of).isdisjoint(part.roles)]
