"""Motions over values of a parameter, up and down, each begun where the last one ended.

The period of the section changes with the parameter, so that its phase and the time cannot both go on. Its phase does, and that
of all that repeats with it; time begins again, unless something acts once (a ramp, a step) or at a frequency of its own: then
time goes on, by less than a period more. A motion that cannot be run is told by its error; the next one begins at the start
anew. Knows nothing of what is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from math import ceil
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.designs import with_numbers
from gearblocks.analysis.regimes.drives import repeating
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


_EARLY = 1e-6  # of a period: it has passed


class Passed(NamedTuple):
    """What has passed where a motion ends: time [s] and periods of the section since the start. repeats: periods after which
    all that acts repeats at every value, or 0; anew: whether it acts so from the time 0 on, where time may begin again."""

    time: float
    periods: int
    repeats: int
    anew: bool

    def goes_on(self, seen: Strobe) -> Strobe:
        """The next one, begun when as much has passed."""
        if self.anew:
            begun = self.periods % self.repeats
        else:
            begun = ceil(self.time / seen.period - _EARLY)
            begun += (self.periods - begun) % max(1, self.repeats)
        return replace(seen, begun=begun)

    def after(self, seen: Strobe, periods: int) -> Passed:
        """When that one has gone on for so many periods."""
        return self._replace(time=(seen.begun + periods) * seen.period, periods=self.periods + periods)


class Motion(NamedTuple):
    """The motion at value `number` on the way `direction` (a number in DIRECTIONS): its states at the section, shape
    (periods, n), or why there is none; and what has passed at its end."""

    direction: int
    number: int
    seen: Strobe
    states: Array
    error: SimulationError | None
    passed: Passed


def carried(
    at: Callable[[float], Strobe], values: Array, initial: Any, periods: int, *, on: bool,
    known: Mapping[tuple[int, int], Array | None] = MappingProxyType({}),
) -> Iterator[Motion]:  # fmt: skip
    """Motions of so many periods over the values, up and then down; on: down goes on where up has ended; known: last states of
    motions by (direction, number), None where there is none, which are not run again."""
    y: Array | None = None
    passed, acts = Passed(0.0, 0, 1, True), None
    for direction in range(len(DIRECTIONS)):
        y = y if on else None
        order = range(len(values)) if direction == 0 else reversed(range(len(values)))
        for j in order:
            passed = passed._replace(time=0.0, periods=0) if y is None else passed
            seen = passed.goes_on(at(float(values[j])))
            states, error = np.empty((0, seen.n)), None
            if (direction, j) in known:
                y = known[direction, j]
            else:
                try:
                    states = seen.follow(seen.start(initial) if y is None else y, periods).states
                    y = states[-1]
                except SimulationError as failed:
                    y, error = None, failed
            if y is not None:
                acts = _acts(at, values, y, periods) if acts is None else acts
                passed = passed.after(seen, periods)._replace(repeats=acts[0], anew=acts[1])
            if (direction, j) not in known:
                yield Motion(direction, j, seen, states, error, passed)


def _acts(at: Callable[[float], Strobe], values: Array, y: Array, periods: int) -> tuple[int, bool]:
    """Periods after which all that acts repeats at every value, 0: none; and whether it does so from the time 0 on."""
    try:
        found = {repeating(at(float(value)), y, periods) for value in (values[0], values[-1])}
    except SimulationError:  # at one of them the states stand beyond a stop, or the like
        return 1, True
    repeats = {one for one, _ in found}
    return (repeats.pop() if len(repeats) == 1 else 0), 0 not in repeats and all(anew for _, anew in found)


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
        raise ParameterError(f"values = {values!r:.80} must be finite and increase, one number or more")
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
