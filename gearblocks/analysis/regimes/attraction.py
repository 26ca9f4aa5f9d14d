"""Basins of attraction: a grid of starts (or parameters), each told by the attractor that its motion ends on.

The motions are points of a study (threads, executors, store); attractors are told apart by their points of the section: those
that repeat within the longest period, and all that do not. What they are is asked of one motion of each (`regime.py`).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.analysis.parameter_study import sweep
from gearblocks.analysis.quantities import points
from gearblocks.analysis.regimes.regime import Regime, classify
from gearblocks.analysis.sections import LONGEST, RELATIVE, Section
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, UnknownNameError, by_name_only
from gearblocks.language.starts import values_of
from gearblocks.model.listing import matches
from gearblocks.running import build
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

FAILED, IRREGULAR = -2, -1
_REPEATS = 1e-5  # of the extent
_ONE = 1e-3  # of the extent: attractors that are nearer are one
_NEARS = 1e-2  # of the extent: a motion that near to an attractor ends on it


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Attractor:
    """What motions end on. period: of its points, None where they do not repeat; points: of the outputs, shape (period,
    outputs), or all that were kept of one motion; share: of the starts; start: one of these, by path; regime: what it is,
    or None."""

    period: int | None
    points: Array
    share: float
    start: Mapping[str, float]
    regime: Regime | None = None

    @property
    def label(self) -> str:
        """What it is, as far as it is known."""
        if self.regime is not None:
            return self.regime.label
        return "quick: not periodic" if self.period is None else f"quick: period {self.period}"

    def __repr__(self) -> str:
        return f"<{self.label}, of {100 * self.share:.3g} % of the starts>"


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Basins:
    """Basins over two paths. levels: the values of each; numbers: of the attractor of each start, shape (a, b), -1 where points
    do not repeat and are near none, -2 where a run failed; names: outputs that tell attractors apart; attractors, by number,
    the one whose points do not repeat last; messages: why runs failed, by number of the start."""

    paths: tuple[str, str]
    units: tuple[str, str]
    levels: tuple[Array, Array]
    numbers: Numbers
    names: tuple[str, ...]
    attractors: tuple[Attractor, ...]
    messages: Mapping[int, str]

    def __repr__(self) -> str:
        listed = ", ".join(f"{one.label} {100 * one.share:.3g} %" for one in self.attractors)
        return f"<basins over {' x '.join(self.paths)}, {' x '.join(map(str, self.numbers.shape))}: {listed}>"

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """A colour for each attractor, with its points where the paths are outputs that were looked at; saved where a path is
        given."""
        from gearblocks.analysis.regimes.basin_picture import draw_basins

        return draw_basins(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Numbers of the attractors over both paths, with units; labels of the attractors."""
        import xarray

        coords = {p: (p, x, {"units": u}) for p, x, u in zip(self.paths, self.levels, self.units, strict=True)}
        data = {"attractor": (self.paths, self.numbers)}
        return xarray.Dataset(data, coords, attrs={"labels": [one.label for one in self.attractors]})


@by_name_only
def basins(
    train: Drivetrain | Model, values: Mapping[str, ArrayLike], *, section: Section, of: Sequence[str] | None = None,
    transient: int = 200, longest: int = LONGEST, labels: str = "full", rtol: float = 1e-7,
    steps_per_period: int | None = None, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
    executor: Any = None, threads: int | None = None, store: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], Any] | None = None,
) -> Basins:  # fmt: skip
    """Which attractor the motion ends on, over a grid of two start values or parameters.

    values: by path ("disc.phi", "disc.w") the rows of the grid; of: outputs or patterns that tell attractors apart (default:
    deflections, twists and their rates); transient: periods of the section that pass first; longest: period that is looked
    for; labels: "full", what `gb.classify` says of one motion of each attractor, or "quick"; the rest as of `gb.sweep`, whose
    threads, executors and store do the work. Raises ParameterError, UnknownNameError.
    """
    model = build(train)
    if len(values) != 2 or labels not in ("quick", "full") or longest < 1:
        raise ParameterError(
            f"basins are over two paths, not {len(values)}; labels = {labels!r} must be 'quick' or 'full', and longest = "
            f"{longest} >= 1"
        )
    names = _outputs(model, of)
    study = sweep(
        model, values, quantity=[points(name) for name in names], section=section, transient=transient, keep=2 * longest + 1,
        rtol=rtol, steps_per_period=steps_per_period, parameters=parameters, initial=initial, executor=executor,
        threads=threads, store=store, progress=progress,
    )  # fmt: skip
    found = np.stack([study[f"points({name})"].reshape(len(study), -1) for name in names], axis=2)
    numbers, told = _told_apart(found, longest)
    attractors = []
    for number, period in told:
        mine = np.flatnonzero(numbers == number)
        start = dict(zip(study.paths, study.points[mine[0]].tolist(), strict=True))
        kept = found[mine[0]] if period is None else found[mine[0], -period:]
        one = Attractor(period, kept, len(mine) / len(study), start)
        attractors.append(_asked(model, section, one, parameters, initial, transient) if labels == "full" else one)
    rows, columns = study.shape
    levels = study.points[:, 0].reshape(rows, columns)[:, 0], study.points[:, 1].reshape(rows, columns)[0]
    paths, units = (study.paths[0], study.paths[1]), (study.units[0], study.units[1])
    return Basins(paths, units, levels, numbers.reshape(rows, columns), names, tuple(attractors), dict(study.messages))


def _outputs(model: Model, of: Sequence[str] | None) -> tuple[str, ...]:
    patterns = [f"*.{kind}" for kind in RELATIVE] if of is None else [of] if isinstance(of, str) else list(of)
    known = model.program.output_numbers
    names = tuple(name for name in known if any(matches(name, pattern) for pattern in patterns))
    if not names:
        raise UnknownNameError(f"no output matches {', '.join(patterns)}; rig.outputs() lists them")
    return names


def _told_apart(found: Array, longest: int) -> tuple[Numbers, list[tuple[int, int | None]]]:
    """Number of the attractor of each motion, from its points, shape (motions, keep, outputs); and the period of each."""
    whole = np.isfinite(found).all(axis=(1, 2))
    extent = np.abs(found[whole]).max(axis=(0, 1), initial=0.0)
    x = found / np.where(extent > 0.0, extent, 1.0)
    numbers = np.where(whole, IRREGULAR, FAILED).astype(np.int64)
    periods = np.zeros(len(x), dtype=np.int64)
    for m in range(longest, 0, -1):
        off = np.abs(x[:, m:] - x[:, :-m]).max(axis=(1, 2))
        periods[whole & (off <= _REPEATS)] = m
    told: list[tuple[int, int | None]] = []
    while len(left := np.flatnonzero((periods > 0) & (numbers == IRREGULAR))):
        m, cycle = int(periods[left[0]]), x[left[0], -int(periods[left[0]]) :]
        same = left[(periods[left] == m) & (_off(x[left], cycle) <= _ONE)]
        numbers[same] = len(told)
        told.append((len(told), m))
        late = np.flatnonzero((periods == 0) & (numbers == IRREGULAR))
        numbers[late[_off(x[late], cycle) <= _NEARS]] = numbers[left[0]]
    return numbers, [*told, *([(IRREGULAR, None)] if (numbers == IRREGULAR).any() else [])]


def _off(x: Array, cycle: Array) -> Array:
    """How far the last points of motions, shape (motions, keep, outputs), are off a cycle, in the phase that fits best."""
    m = len(cycle)
    shifts = [np.abs(x[:, -m:] - np.roll(cycle, k, axis=0)).max(axis=(1, 2)) for k in range(m)]
    nearest: Array = np.min(shifts, axis=0) if len(x) else np.empty(0)
    return nearest


def _asked(
    model: Model, section: Section, one: Attractor, parameters: Mapping[str, float | str] | None, initial: Any, transient: int
) -> Attractor:  # fmt: skip
    """The attractor with what it is."""
    known = model.program.parameter_numbers
    fixed = {path: value for path, value in one.start.items() if path in known}
    started = {path: value for path, value in one.start.items() if path not in known}
    begin = {**values_of(initial), **started} if started else initial
    try:
        regime = classify(
            model, section, transient=transient, parameters={**(parameters or {}), **fixed}, initial=begin
        )
    except SimulationError as error:
        regime = Regime("unresolved", (str(error),))
    return replace(one, regime=regime)
