"""Inputs given as series of samples: a pair (t, y), or a Series of pandas whose index is time, as a table of straight lines.

Knows nothing of pandas: a series is what has an `index` and `to_numpy`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from gearblocks.errors import ParameterError, by_name
from gearblocks.language.signals import Table, check_increasing
from gearblocks.solver.structures import Array


class TimeSeries(Protocol):
    """What is asked of a Series of pandas: its index is time."""

    @property
    def index(self) -> Any:
        """Times [s], or durations."""

    def to_numpy(self) -> Any:
        """Values."""


def with_tables(inputs: Mapping[str, Any] | None) -> Mapping[str, Any]:
    """The inputs by name, those that are series as tables."""
    if not inputs and (inputs is None or isinstance(inputs, dict)):
        return {}
    return {name: table_of_series(name, given) for name, given in by_name("inputs", inputs).items()}


def table_of_series(name: str, given: Any) -> Any:
    """A `Table` where an input is given as a series, else what was given. Raises ParameterError for times that do not increase,
    numbers that are not finite, and lengths that differ."""
    if isinstance(given, tuple):
        if len(given) != 2:
            raise ParameterError(
                f"input '{name}' is given as a tuple of {len(given)}: give the pair (t, y), times and values"
            )
        t, y = given
    elif hasattr(given, "to_numpy") and hasattr(given, "index"):
        t, y = given.index, given.to_numpy()
    else:
        return given
    what = f"input '{name}'"
    times, values = _row(what, "t", _seconds(what, t)), _row(what, "y", y)
    if len(times) != len(values):
        raise ParameterError(
            f"{what}: t has {len(times)} numbers and y has {len(values)}; give one value for each time"
        )
    if len(times) < 2:
        raise ParameterError(f"{what} is a series of {len(times)} points: give two at least, or a number")
    check_increasing(f"{what}: t", times)
    return Table(times, values)


def _seconds(what: str, t: Any) -> Any:
    """Times in s: durations are converted, dates have no origin."""
    values = t.to_numpy() if hasattr(t, "to_numpy") else t
    kind = np.asarray(values).dtype.kind
    if kind == "m":
        return np.asarray(values) / np.timedelta64(1, "s")
    if kind == "M":
        raise ParameterError(f"{what}: t = {values[0]} ... are dates: give seconds since the start, such as t - t[0]")
    return values


def _row(what: str, name: str, values: Any) -> Array:
    try:
        if isinstance(values, (str, bytes)):
            raise TypeError
        row = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"{what}: {name} = {values!r:.80} must be a row of numbers") from None
    if row.ndim != 1:
        raise ParameterError(f"{what}: {name} of shape {row.shape} must be a row of numbers; give one column")
    if not np.isfinite(row).all():
        i = int(np.argmin(np.isfinite(row)))
        raise ParameterError(f"{what}: {name}[{i}] = {row[i]} must be a finite number; drop the point or repair it")
    return row
