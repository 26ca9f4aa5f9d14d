"""Units: SI and radians. Their text is read, never guessed."""

from __future__ import annotations

import math
import re
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units of FMI, in its order."""

_NAMED: dict[str, dict[str, int]] = {
    **{name: {name: 1} for name in BASE},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "C": {"A": 1, "s": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}
_FACTOR = re.compile(r"([A-Za-z]+)\^?([+-]?\d+)?")


def base_exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units (and rad), zeros left out: "N m/rad" gives kg 1, m 2, s -2, rad -1.

    Factors are separated by blanks; everything after a slash divides ("W/m2 K" is W m-2 K-1); "m2", "m^2" and "s-2" are
    powers; "" and "1" are the number one. Raises ParameterError for text that is no SI unit known here.
    """
    total: dict[str, int] = {}
    for position, part in enumerate(unit.replace("(", " ").replace(")", " ").replace("*", " ").split("/")):
        for word in part.split():
            for base, power in _powers(word, unit).items():
                total[base] = total.get(base, 0) + (power if position == 0 else -power)
    return {base: total[base] for base in BASE if total.get(base, 0) != 0}


_WAYS_OUT = {
    "rpm": "give the value as gb.rpm(...) with the unit 'rad/s'",
    "deg": "give the value in radians with the unit 'rad'",
    "Nm": "write 'N m' with a blank",
}


def check_unit(what: str, unit: Any) -> None:
    """Raises ParameterError where a unit is not text, or no SI unit: its value would be taken as it stands."""
    if not isinstance(unit, str):
        raise ParameterError(f"{what}: unit = {unit!r} must be text such as 'N m'")
    try:
        base_exponents(unit)
    except ParameterError:
        way = next(
            (words for word, words in _WAYS_OUT.items() if word in unit), "give the value in SI units and radians"
        )
        known = ", ".join(_NAMED)
        raise ParameterError(
            f"{what}: unit '{unit}' is none that values are taken in ({known}; 'N m/rad', 'kg m2'): {way}"
        ) from None


def _powers(word: str, unit: str) -> dict[str, int]:
    """Base exponents of one factor such as "N" or "s-2"."""
    if word == "1":
        return {}
    match = _FACTOR.fullmatch(word)
    if match is None or match[1] not in _NAMED:
        raise ParameterError(f"unit '{unit}': '{word}' is no SI unit known here; write it in {', '.join(_NAMED)}")
    power = int(match[2] or 1)
    return {base: exponent * power for base, exponent in _NAMED[match[1]].items()}


@overload
def rpm(speed: float) -> float: ...
@overload
def rpm(speed: NDArray[Any] | list[float] | tuple[float, ...]) -> NDArray[np.float64]: ...
def rpm(speed: Any) -> Any:
    """Revolutions per minute as rad/s, for a number or an array."""
    if isinstance(speed, (int, float)):
        return speed / 60.0 * (2.0 * math.pi)
    return np.asarray(speed, dtype=np.float64) / 60.0 * (2.0 * math.pi)
