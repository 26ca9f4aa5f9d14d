"""Inputs of the run that a check makes: by name as plain values that another process reads, and sampled at its communication
points, over each of whose steps they are held."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, did_you_mean
from gearblocks.language.expression import finite_number
from gearblocks.language.signals import Table
from gearblocks.language.units import Unit, check_unit, has_unit, in_unit
from gearblocks.simulation.input_series import with_tables

Array = NDArray[np.float64]

_OF_TABLE = ("kind", "periodic", "ends", "extrapolate")


def plain(inputs: Mapping[str, Any] | None) -> dict[str, Any]:
    """Numbers, texts with a unit, and tables as dicts, by name. Raises ParameterError."""
    return {name: _plain(f"input '{name}'", given) for name, given in with_tables(inputs).items()}


def _plain(what: str, given: Any) -> Any:
    if isinstance(given, Table):
        points = {name: np.asarray(getattr(given, name)).tolist() for name in ("x", "y")}
        return points | {name: getattr(given, name) for name in _OF_TABLE}
    if callable(given):
        raise ParameterError(
            f"{what} is a function, which the process that runs the FMU cannot call: give (t, y) or a gb.Table"
        )
    if isinstance(given, str):
        return given
    if has_unit(given):  # of a package for units
        return f"{float(given.magnitude)!r} {given.units:~C}"
    return finite_number(what, given)


def sampled(given: Mapping[str, Any], description: Any, own: bool, times: Array) -> dict[str, Array]:
    """Values of the inputs at the times, by the names and in the units of the description.

    own: an FMU of gearblocks, where bare numbers are in the unit that the train declares for an input, as in a run; those of
    others take them as they are. Raises ParameterError for what is no real input, and for units of something else.
    """
    known = {v.name: v for v in description.modelVariables if v.causality == "input"}
    found = {}
    for name, value in given.items():
        if name not in known:
            there = f"there are {', '.join(known)}" if known else "it has none"
            raise ParameterError(f"the FMU has no input '{name}'; {there}{did_you_mean(name, known)}")
        if known[name].type != "Real":
            raise ParameterError(f"input '{name}' is of type {known[name].type}; inputs= gives real ones alone")
        found[name] = _values(f"input '{name}'", value, *_units(known[name], own), times)
    return found


def _units(variable: Any, own: bool) -> tuple[str, str]:
    """The unit in which an input is set, and that in which bare numbers are given."""
    unit = (variable.unit or "1").replace(".", " ")
    shown = (variable.displayUnit or unit).replace(".", " ") if own else unit
    return unit, shown


def _values(what: str, value: Any, unit: str, shown: str, times: Array) -> Array:
    """A constant or a table at the times."""
    if not isinstance(value, dict):
        if not isinstance(value, str) and unit == shown:
            return np.full(len(times), value)
        return np.full(
            len(times), _set(check_unit(what, shown).in_si(in_unit(what, value, check_unit(what, shown))), unit)
        )
    factor = 1.0 if unit == shown else check_unit(what, shown).factor / check_unit(what, unit).factor
    return factor * Table(**value).values(times)


def _set(number: float, unit: str) -> float:
    """A number of SI in the unit in which it is set."""
    wanted: Unit = check_unit("an input", unit)
    return wanted.of_si(number)
