"""The law of one kind of block in symbols: torques, rates, event functions, energies, outputs.

Knows nothing of how it is derived, nor of trains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gearblocks.language.contributions import Shows
from gearblocks.laws.prescribed_motion import Drive
from gearblocks.laws.switched_constraints import StickOfKind
from gearblocks.laws.switching import SurfaceOfKind
from gearblocks.laws.symbols import Pool


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
    """What all instances of a kind share, in symbols (see Pool.slots for their meaning).

    forms: coordinates of the law; coordinates: their symbols. forces: symbols of generalised forces along linear forms
    and what they are. torques: by flange, over the forces. ties: linear forms and constants. starts: by state. holds:
    (state, value, when).
    """

    pool: Pool
    forms: list[Form] = field(default_factory=list)
    coordinates: list[Any] = field(default_factory=list)
    bodies: list[tuple[str, Any]] = field(default_factory=list)
    ties: list[tuple[Mapping[str, Any], Any]] = field(default_factory=list)
    drives: list[Drive] = field(default_factory=list)
    starts: dict[str, Any] = field(default_factory=dict)
    forces: dict[Any, Any] = field(default_factory=dict)
    torques: dict[str, Any] = field(default_factory=dict)
    rates: dict[str, Any] = field(default_factory=dict)
    holds: list[tuple[str, Any, Any]] = field(default_factory=list)
    stored: Any = None
    loss: Any = None
    supplied: Any = None
    switches: list[SurfaceOfKind] = field(default_factory=list)
    sticks: dict[str, StickOfKind] = field(default_factory=dict)
    late_loss: Any = None
    shows: list[Shows] = field(default_factory=list)
    replaced: dict[Any, Any] = field(default_factory=dict)
