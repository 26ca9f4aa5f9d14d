"""Motions over values of a parameter, up and down, each begun where the last one ended.

A motion that cannot be run is told by its error; the next one begins at the start anew. Knows nothing of what is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.designs import with_numbers
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.analysis.sections import RELATIVE
from gearblocks.codegen.program import ParameterInfo, Program
from gearblocks.errors import ParameterError, SimulationError
from gearblocks.language.units import has_unit
from gearblocks.model.listing import matches
from gearblocks.simulation.arguments import in_given_unit, resolve

Array = NDArray[np.float64]

DIRECTIONS = ("up", "down")


class Jump(NamedTuple):
    """A jump on the way up or down: the two values of the parameter that it lies between, in the order in which they are
    reached, and the peak-to-peak at each."""

    direction: str
    last: float
    first: float
    before: float
    after: float


class Motion(NamedTuple):
    """The motion at value `number` on the way `direction` (a number in DIRECTIONS): its states at the section, shape
    (periods, n), or why there is none."""

    direction: int
    number: int
    seen: Strobe
    states: Array
    error: SimulationError | None


def carried(
    at: Callable[[float], Strobe], values: Array, initial: Any, periods: int, *, on: bool,
    known: Mapping[tuple[int, int], Array | None] = MappingProxyType({}),
) -> Iterator[Motion]:  # fmt: skip
    """Motions of so many periods over the values, up and then down; on: down goes on where up has ended; known: last states of
    motions by (direction, number), None where there is none, which are not run again."""
    y: Array | None = None
    for direction in range(len(DIRECTIONS)):
        y = y if on else None
        order = range(len(values)) if direction == 0 else reversed(range(len(values)))
        for j in order:
            if (direction, j) in known:
                y = known[direction, j]
                continue
            seen = at(float(values[j]))
            try:
                states = seen.follow(seen.start(initial) if y is None else y, periods).states
                y = states[-1]
                yield Motion(direction, j, seen, states, None)
            except SimulationError as error:
                y = None
                yield Motion(direction, j, seen, np.empty((0, seen.n)), error)


def rising(values: Any, info: ParameterInfo) -> Array:
    """Values of a parameter that increase, in the unit in which bare numbers of it are given; texts bring their own.
    Raises ParameterError."""
    if has_unit(values):
        values = [values]
    cells = with_numbers({info.path: values}, lambda path, x: in_given_unit(path, x, info.unit, info.given_in))[
        info.path
    ]
    try:
        asked = np.atleast_1d(np.asarray(cells, dtype=np.float64))
    except (TypeError, ValueError):
        unit = info.given_in or info.unit
        raise ParameterError(f"values = {values!r:.80} must be numbers in {unit}, or texts with their unit") from None
    if asked.ndim != 1 or not len(asked) or not np.isfinite(asked).all() or (np.diff(asked) <= 0).any():
        raise ParameterError(f"values = {values!r:.80} must be finite and increase")
    return asked


def output_of(program: Program, of: str | None) -> int:
    """The number of an output, by default of the first deflection or twist. Raises UnknownNameError, ParameterError."""
    numbers = program.output_numbers
    if of is not None:
        return resolve(of, numbers, "output")
    relative = [name for name in numbers for kind in RELATIVE if matches(name, f"*.{kind}")]
    if not relative:
        raise ParameterError("of: the train has no deflection or twist to show; name an output")
    return numbers[relative[0]]
