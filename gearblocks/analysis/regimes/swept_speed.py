"""Response over a speed, up and down with the state carried over: mean, root mean square and peak-to-peak, with its jumps.

A jump is a change that stays as large as it is however near the two speeds lie: bracketed by bisection, the state carried
over. Where the motion jumps depends on how long it stays at each speed; folds of its orbits are told by `continue_orbit`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.parameter_study import Row
from gearblocks.analysis.regimes.carried import DIRECTIONS, Jump, Passed, carried, output_of, rising
from gearblocks.analysis.regimes.response import NONE, Response, response
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import Strobe, strobe
from gearblocks.analysis.sections import LONGEST, Section, repeats, stroboscopic
from gearblocks.analysis.study_progress import progress as shown
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.language.expression import finite_number
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.arguments import resolve
from gearblocks.simulation.plausibility import warn_of_parameters, warn_of_rows
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_STAYS = 1.0 / 3.0  # of a change: what a smooth one falls below within two halvings
_PARTS_SIZED = 16  # of a period, that sizes are told from
_PARTS = ("mean", "rms", "low", "high", "peak_to_peak")


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SpeedSweep:
    """Response of output `of` [of_unit] over values of the parameter `path` [unit], shape (k,), rising; up and then down.

    mean, rms (about the mean), low, high: shape (2, k), NaN where a run failed. misses: how far points of the section miss
    those some periods later, of their sizes: nothing where the motion has settled. states: at the section at the end of each
    value, by `names`, shape (2, k, n). jumps; messages: why runs failed, by (direction, value).
    """

    path: str
    unit: str
    values: Array
    of: str
    of_unit: str
    mean: Array
    rms: Array
    low: Array
    high: Array
    misses: Array
    names: tuple[str, ...]
    states: Array
    jumps: tuple[Jump, ...]
    messages: Mapping[tuple[str, float], str]

    @property
    def peak_to_peak(self) -> Array:
        """From the lowest to the highest value, shape (2, k)."""
        return self.high - self.low

    def __repr__(self) -> str:
        listed = ", ".join(f"{jump.direction} at {jump.last:.6g} .. {jump.first:.6g}" for jump in self.jumps)
        return singular(
            f"<{self.of} over {len(self.values)} values of {self.path}, up and down; jumps: {listed or 'none'}>"
        )

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Root mean square and peak-to-peak over the parameter, up and down, jumps marked; saved where a path is given."""
        from gearblocks.analysis.regimes.response_pictures import draw_sweep

        return draw_sweep(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """The response over direction and value, with units."""
        import xarray

        units = {"units": self.of_unit}
        parts = {name: (("direction", self.path), getattr(self, name), units) for name in _PARTS}
        misses = {"misses": (("direction", self.path), self.misses, {"units": "1"})}
        coords = {"direction": [*DIRECTIONS], self.path: (self.path, self.values, {"units": self.unit})}
        return xarray.Dataset({**parts, **misses}, coords=coords, attrs={"of": self.of})


@by_name_only
def speed_sweep(
    train: Drivetrain | Model, parameter: str, values: Row, *, of: str | None = None, section: Section | None = None,
    transient: int = 200, keep: int = 40, samples: int | None = None, jump: float = 0.05, within: float = 1e-3,
    rtol: float = 1e-8, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
    progress: Callable[[int, int], Any] | None = None,
) -> SpeedSweep:  # fmt: skip
    """Mean, root mean square and peak-to-peak of an output over a speed, up and then down, the state carried over all the way.

    The phase of the section goes on from value to value, and that of all that repeats with it; what acts once (a ramp, a step)
    acts once, and what has a frequency of its own goes on to within a period.

    values: of the parameter, rising, in its unit as `sweep` takes them (of a Parameter in rpm: rpm), or texts with a unit;
    of: an output, such as the deflection of a mesh (default: the first
    deflection or twist); section: default once per period of the parameter. At each value `transient` periods pass, and `keep`
    are looked at: the motion itself, or so many `samples` in each period. jump: the least change of the peak-to-peak, as
    a share of the largest one, that is looked at for a jump; within: of the value, how far brackets are closed. rtol,
    parameters and initial: as for `simulate`. Raises ParameterError, UnknownNameError.
    """
    model = build(train)
    output = output_of(model.program, of)
    _check(transient, keep, samples, jump, within)
    info = model.program.parameters[resolve(parameter, model.program.parameter_numbers, "parameter")]
    asked = rising(values, info)
    where = stroboscopic(info.path) if section is None else section

    def at(value: float) -> Strobe:
        return strobe(model, where, {**(parameters or {}), info.path: value}, initial, rtol)

    warn_of_parameters(model, parameters)
    warn_of_rows(model, {info.path: values})
    warn_if_stiff(at(asked[0]), initial)
    protocol = _Protocol(at, model.program.outputs[output].name, transient, keep, samples)
    found = np.full((2, len(asked), 4), np.nan)
    misses = np.full(found.shape[:2], np.nan)
    states = np.full((2, len(asked), model.program.n), np.nan)
    messages: dict[tuple[str, float], str] = {}
    ends: dict[tuple[int, int], Passed] = {}
    with shown(2 * len(asked), 0, progress, "speed sweep") as tell:
        for done, (i, j, seen, points, error, passed) in enumerate(
            carried(at, asked, initial, transient + keep, on=True)
        ):
            try:
                if error is not None:
                    raise error
                found[i, j] = protocol.response(seen, points)
                misses[i, j], states[i, j], ends[i, j] = protocol.miss(seen, points), points[-1], passed
            except SimulationError as failed:
                messages[DIRECTIONS[i], float(asked[j])] = str(failed)
            tell(done + 1)
    jumps = tuple(_jumps(protocol, asked, found[..., 3] - found[..., 2], states, ends, jump, within))
    quantity = model.program.outputs[output]
    names = tuple(q.name for q in model.program.states)
    return SpeedSweep(
        info.path, info.given_in or info.unit, asked, quantity.name, quantity.unit, found[..., 0], found[..., 1], found[..., 2],
        found[..., 3], misses, names, states, jumps, messages,
    )  # fmt: skip


def _check(transient: int, keep: int, samples: int | None, jump: float, within: float) -> None:
    for name, number, least in (("transient", transient, 1), ("keep", keep, 2), ("samples", samples, 8)):
        if number is not None and (isinstance(number, bool) or not isinstance(number, int) or number < least):
            raise ParameterError(f"{name} = {number!r} must be a whole number >= {least}")
    for name, share in (("jump", jump), ("within", within)):
        if not 0 < finite_number(name, share) < 1:
            raise ParameterError(f"{name} = {share!r} must lie between 0 and 1")


@final
@dataclass(frozen=True, slots=True)
class _Protocol:
    """What is done at each value."""

    at: Callable[[float], Strobe]
    output: str
    transient: int
    keep: int
    samples: int | None

    def response(self, seen: Strobe, states: Array) -> Response:
        """Of a motion that has passed these states."""
        y = states[self.transient - 1]
        return response(seen, y, self.keep, self.output, after=seen.begun + self.transient, samples=self.samples)

    def miss(self, seen: Strobe, states: Array) -> float:
        """How far the last points miss those some periods later, of the sizes that the states come to."""
        points, after = states[-self.keep :], seen.begun + self.transient + self.keep
        extent = np.abs(np.vstack([points, seen.follow(points[-1], 2, after=after, parts=_PARTS_SIZED).states])).max(
            axis=0
        )
        extent[extent == 0.0] = 1.0
        return repeats(points, min(LONGEST, self.keep // 2), extent)[1]

    def goes_on(self, value: float, y: Array, passed: Passed) -> tuple[Response, Array, Passed]:
        """The response at a value, from the states y on, the states and what has passed at its end; NaN where it cannot be
        run."""
        seen, periods = passed.goes_on(self.at(value)), self.transient + self.keep
        try:
            states = seen.follow(y, periods).states
            return self.response(seen, states), states[-1], passed.after(seen, periods)
        except SimulationError:
            return NONE, y, passed


def _jumps(
    protocol: _Protocol, values: Array, swings: Array, states: Array, ends: Mapping[tuple[int, int], Passed], jump: float,
    within: float,
) -> list[Jump]:  # fmt: skip
    """Those of both ways, in the order in which they are met."""
    if not np.isfinite(swings).any():
        return []
    least = jump * float(np.nanmax(swings))
    found = []
    for i, direction in enumerate(DIRECTIONS):
        order = np.arange(len(values))[:: 1 if i == 0 else -1]
        for a, b in pairwise(order):
            if abs(swings[i, b] - swings[i, a]) > least:
                met = _bracket(protocol, values[[a, b]], swings[i, [a, b]], states[i, a], ends[i, a], within)
                found += [] if met is None else [Jump(direction, *met)]
    return found


def _bracket(
    protocol: _Protocol, values: Array, swings: Array, y: Array, passed: Passed, within: float
) -> tuple[float, float, float, float] | None:
    """The two values that a jump lies between and the swings there; None where the change grows small with their distance."""
    (a, b), (before, after) = values.tolist(), swings.tolist()
    whole = abs(after - before)
    while abs(b - a) > within * max(abs(a), abs(b)):
        middle = 0.5 * (a + b)
        found, end, later = protocol.goes_on(middle, y, passed)
        swing = found.high - found.low
        if abs(swing - before) <= abs(swing - after):
            a, before, y, passed = middle, swing, end, later
        else:
            b, after = middle, swing
        if not abs(after - before) > _STAYS * whole:
            return None
    return a, b, before, after
