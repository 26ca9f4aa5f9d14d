"""What a start asks for besides values by name: that the train rolls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, final

from gearblocks.errors import ParameterError, by_name_only

ROLLING = "rolling"
"""The same with nothing given besides what the bodies give."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Rolling:
    """A start in which the train turns as one piece, with start values by name that take the place of those of bodies; made
    by `gb.rolling`."""

    values: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))

    def __reduce__(self) -> tuple[Any, ...]:
        return Rolling, (dict(self.values),)

    def __repr__(self) -> str:
        return f"rolling({dict(sorted(self.values.items()))!r})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Rolling) and dict(self.values) == dict(other.values)

    def __hash__(self) -> int:
        return hash(tuple(sorted(self.values.items())))


@by_name_only
def rolling(values: Mapping[str, float | str] | None = None) -> Rolling:
    """A start in which the train turns as one piece: `initial=gb.rolling({"motor.w": 300})`.

    The speeds that are named determine the others through ratios, shafts, meshes, gaps, lossy gears and whatever friction
    holds, so that nothing is twisted at a rate; named angles turn the others along, so that nothing is twisted. Friction
    holds where it can, the strongest first. Start values that blocks give count where this leaves them free. What then is
    still free has the least kinetic energy: it moves as if the given bodies alone had been set going by an impact (Kelvin).
    Dampers, fluid couplings, belts and tyres with slip do not take anything along. initial="rolling": nothing is named.

    Values that contradict each other are refused by name.

    Example:
        rig = gb.Drivetrain("two discs")
        left, right = rig.add("left", gb.Inertia(J=0.02)), rig.add("right", gb.Inertia(J=0.05))
        rig.chain(left, rig.add("shaft", gb.Shaft(k=2.0e4, c=3.0)), right)
        run = gb.simulate(rig, t_end=0.1, initial=gb.rolling({"left.w": "3000 rpm"}))
    """
    if values is not None and not isinstance(values, Mapping):
        raise ParameterError(
            f"rolling({values!r:.80}): give start values by name, such as gb.rolling({{'motor.w': 300}})"
        )
    return Rolling(values or {})


def values_of(initial: Any) -> Mapping[str, float | str]:
    """The start values by name that a start gives."""
    return initial.values if isinstance(initial, Rolling) else initial if isinstance(initial, Mapping) else {}


def with_values(initial: Any, values: Mapping[str, float | str]) -> Any:
    """The start with more values by name; itself where there are none."""
    if not values:
        return initial
    return Rolling({**values_of(initial), **values}) if is_rolling(initial) else {**values_of(initial), **values}


def is_rolling(initial: Any) -> bool:
    """Whether a start asks for that."""
    return isinstance(initial, Rolling) or (isinstance(initial, str) and initial == ROLLING)
