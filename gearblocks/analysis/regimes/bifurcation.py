"""Points of a section over a parameter, up and down, each motion begun where the last one ended, with labels; or each begun
at the start, as the points of a study.

    quick labels    points that repeat to 1e-5 of their extent; they call themselves so and prove nothing
    full labels     those of `regime.py`, with their evidence

A point that cannot be run is named; its neighbours begin as if it had not been there.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping
from concurrent.futures import Future
from contextlib import closing
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.dynamic_quantities import period
from gearblocks.analysis.parameter_study import Row, sweep
from gearblocks.analysis.quantities import points as section_points
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.regimes.carried import DIRECTIONS, Motion, carried, output_of, rising
from gearblocks.analysis.regimes.diagram_store import DiagramStore, Told
from gearblocks.analysis.regimes.regime import Asked, Regime
from gearblocks.analysis.regimes.sizes import turned
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import GrowthError, Strobe, strobe
from gearblocks.analysis.regimes.turns import around
from gearblocks.analysis.sections import LONGEST, RELATIVE, Section, repeats
from gearblocks.analysis.study_progress import progress as shown
from gearblocks.analysis.study_result import Study
from gearblocks.analysis.study_task import start_text
from gearblocks.analysis.workers import executor_of, result_of
from gearblocks.codegen.program import ParameterInfo
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.files import write_text
from gearblocks.language.units import has_unit
from gearblocks.model.listing import matches
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.arguments import resolve
from gearblocks.simulation.plausibility import warn_of_parameters, warn_of_rows
from gearblocks.solver.cache import digest
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LABELS = ("quick", "full")
GROWS = "grows without bound"  # in words of a run that could not go on


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Bifurcation:
    """A diagram. values of the parameter `path` [unit], shape (k,), rising; points: output `of` at the section, shape
    (directions, k, keep), NaN where a run failed; labels and regimes (None: quick ones), by direction and value; messages: why
    runs failed, by (direction, value). directions: "up" and "down" with the state carried over, or "start"."""

    path: str
    unit: str
    values: Array
    of: str
    of_unit: str
    points: Array
    labels: tuple[tuple[str, ...], ...]
    regimes: tuple[tuple[Regime | None, ...], ...]
    messages: Mapping[tuple[str, float], str]
    directions: tuple[str, ...] = DIRECTIONS

    def __repr__(self) -> str:
        listed = _listed(Counter(label for row in self.labels for label in row))
        return singular(
            f"<{self.of} over {len(self.values)} values of {self.path}, {' and '.join(self.directions)}: {listed}>"
        )

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Points over the parameter, those of both directions; saved where a path is given."""
        from gearblocks.analysis.regimes.pictures import draw_bifurcation

        return draw_bifurcation(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Points and labels over direction and value, with units."""
        import xarray

        return xarray.Dataset(
            {
                self.of: (("direction", self.path, "point"), self.points, {"units": self.of_unit}),
                "label": (("direction", self.path), np.array(self.labels)),
            },
            coords={"direction": [*self.directions], self.path: (self.path, self.values, {"units": self.unit})},
        )

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """A row for each direction and value: label and points. Raises StorageError."""
        columns = [f"{self.of} [{self.of_unit}]"] * self.points.shape[2]
        rows = [",".join(["direction", f"{self.path} [{self.unit}]", "label", *columns])]
        for i, direction in enumerate(self.directions):
            for j, value in enumerate(self.values):
                numbers = ",".join(f"{x:.17g}" for x in self.points[i, j])
                rows.append(f'{direction},{value:.17g},"{self.labels[i][j]}",{numbers}')
        write_text(path, "\n".join(rows) + "\n")


@by_name_only
def bifurcation(
    train: Drivetrain | Model, parameter: str, values: Row, *, section: Section, of: str | None = None,
    transient: int = 300, keep: int = 100, labels: str = "quick", longest: int = LONGEST, rtol: float = 1e-8,
    carry: bool = True, executor: Any = None, threads: int | None = None, store: str | os.PathLike[str] | None = None,
    parameters: Mapping[str, float | str] | None = None, initial: Any = None,
    progress: Callable[[int, int], Any] | None = None,
) -> Bifurcation:  # fmt: skip
    """Points of a section over values of a parameter, up and down, with the state carried over from value to value, full labels
    on `threads` (default: every core) or an executor; with carry=False each from the start: as a study of `gb.sweep`, with
    its executor, threads and store, and quick labels. store: a folder in which motions are kept as they get their labels; a
    second call goes on with what is missing.

    values: of the parameter, in its unit as `sweep` takes them (of a Parameter in rpm: rpm), or texts with a unit; of: an
    output (default: the first deflection or twist); transient, keep: periods before the points, and points, of each value;
    labels: "quick" or "full"; longest, rtol, parameters and initial: as of `classify`; progress: called with how many runs are
    done, and of how many. Raises ParameterError, UnknownNameError.
    """
    model = build(train)
    _check(carry, labels, executor, threads, store)
    _check_periods(labels, transient, keep, longest)
    names = model.program.parameter_numbers
    info = model.program.parameters[resolve(parameter, names, "parameter")]
    asked = rising(values, info)
    output = output_of(model.program, of)
    if not carry:
        row: Any = values if np.ndim(values) and not has_unit(values) else [values]
        study = sweep(
            model, {info.path: row}, quantity=_quantities(model, output, longest),
            section=section, transient=transient, keep=keep, rtol=rtol, parameters=parameters, initial=initial,
            executor=executor, threads=threads, store=store, progress=progress,
        )  # fmt: skip
        return _of_study(study, info, model.program.outputs[output].name, asked)

    def at(value: float) -> Strobe:
        return strobe(model, section, {**(parameters or {}), info.path: value}, initial, rtol)

    points = np.full((2, len(asked), keep), np.nan)
    warn_of_parameters(model, parameters)
    warn_of_rows(model, {info.path: values})
    protocol = Asked(at(asked[0]), transient, keep, longest)
    warn_if_stiff(protocol.seen, initial)
    identity = _identity(protocol, info.path, asked, output, labels, section, initial)
    kept = None if store is None else DiagramStore(store, identity)
    last = {} if kept is None else {point: told.last for point, told in kept.known.items()}
    motions = carried(at, asked, initial, transient + keep, on=False, known=last)
    ones = _told(motions, output, protocol, labels == "full", (executor, threads))
    found = _kept(ones, points, kept, progress)
    rows = [[found[i, j] for j in range(len(asked))] for i in range(2)]
    quantity = model.program.outputs[output]
    return Bifurcation(
        info.path, info.given_in or info.unit, asked, quantity.name, quantity.unit, points,
        tuple(tuple(map(_said, row)) for row in rows),
        tuple(tuple(one if isinstance(one, Regime) else None for one in row) for row in rows),
        {(DIRECTIONS[i], float(asked[j])): str(x) for (i, j), x in found.items() if isinstance(x, SimulationError)},
    )  # fmt: skip


def _kept(
    ones: Generator[tuple[tuple[int, int], Told], None, None], points: Array, kept: DiagramStore | None,
    progress: Callable[[int, int], Any] | None,
) -> dict[tuple[int, int], str | Regime | SimulationError]:  # fmt: skip
    """What is told of all motions, whose points are filled in; each is kept as it is told."""
    known = {} if kept is None else kept.known
    found = {point: told.found for point, told in known.items()}
    counts = Counter(map(_said, found.values()))
    for point, told in known.items():
        points[point] = told.points
    total = points.shape[0] * points.shape[1]
    with shown(total, len(known), progress, "bifurcation") as tell, closing(ones):
        for point, told in ones:
            found[point], points[point] = told.found, told.points
            counts[_said(told.found)] += 1
            if kept is not None:
                kept.write(point, told)
            tell(len(found), _listed(counts))
    return found


def _told(
    motions: Iterator[Motion], output: int, protocol: Asked, full: bool, workers: tuple[Any, int | None]
) -> Generator[tuple[tuple[int, int], Told], None, None]:  # fmt: skip
    """What is told of each motion; full labels by workers, an executor or a number of threads."""
    waiting: dict[tuple[int, int], tuple[Future[Regime | SimulationError], Array, Array]] = {}
    keep = protocol.keep
    with executor_of(*workers) as (pool, _):
        try:
            for i, j, seen, states, error, _ in motions:
                if error is not None:
                    yield (i, j), Told(np.full(keep, np.nan), None, error)
                    continue
                points = _outputs(seen, states[-keep:], output, seen.begun + protocol.transient + 1)
                if full:
                    waiting[i, j] = pool.submit(_full, replace(protocol, seen=seen), states), points, states[-1]
                else:
                    yield (i, j), Told(points, states[-1], _quick(seen, states, keep, protocol.longest))
            for point, (future, points, last) in waiting.items():
                yield point, Told(points, last, result_of(future))
        finally:
            for future, _, _ in waiting.values():
                future.cancel()


def _identity(
    protocol: Asked, path: str, asked: Array, output: int, labels: str, section: Section, initial: Any
) -> dict[str, str]:  # fmt: skip
    """Digests of all that a diagram follows from, by the words in which a store of another one is refused."""
    seen, fixed = protocol.seen, protocol.seen.parameters.copy()
    fixed[seen.model.program.parameter_numbers[path]] = 0.0
    parts: dict[str, list[Any]] = {
        "the train": [seen.model.program.key],
        "the parameters": [fixed.tobytes()],
        "the values": [path, asked.tobytes()],
        "the section and the output": [section.frequency, output],
        "the periods": [protocol.transient, protocol.keep, protocol.longest],
        "the labels": [labels],
        "the tolerance": [seen.rtol],
        "the start": [start_text(initial)],
    }
    return {name: digest(*(repr(part) for part in given)) for name, given in parts.items()}


def _listed(counts: Counter[str]) -> str:
    """How many there are of the most frequent labels."""
    return ", ".join(f"{count} {label}" for label, count in counts.most_common(5))


def _said(found: str | Regime | SimulationError) -> str:
    """The label of what was found."""
    if isinstance(found, SimulationError):
        return "diverged" if isinstance(found, GrowthError) else "failed"
    return str(found)


def _full(asked: Asked, states: Array) -> Regime | SimulationError:
    """The label of a motion, on a worker."""
    try:
        return asked.of(states)
    except SimulationError as error:
        return error


def _check(carry: bool, labels: str, executor: Any, threads: int | None, store: Any) -> None:
    given = [n for n, x in (("executor", executor), ("threads", threads), ("store", store)) if x is not None]
    if carry and labels == "quick" and (given := [name for name in given if name != "store"]):
        raise ParameterError(
            f"{given[-1]}: with the state carried over a diagram is one run after the other, whose full labels alone go to "
            "workers; with carry=False each value begins at the start"
        )
    if not carry and labels != "quick":
        raise ParameterError("labels = 'full' needs carry=True; gb.classify labels single values")


def _check_periods(labels: str, transient: int, keep: int, longest: int) -> None:
    if labels not in LABELS:
        raise ParameterError(f"labels = {labels!r} must be 'quick' or 'full'")
    if transient < 0 or longest < 1:
        raise ParameterError(f"transient = {transient} must be 0 or more periods, longest = {longest} 1 or more")
    if keep <= 2 * longest:
        raise ParameterError(
            f"keep = {keep} points are too few to see a period of longest = {longest} repeat: give keep >= {2 * longest + 1} "
            "or a smaller longest"
        )


def _quantities(model: Model, output: int, longest: int) -> list[Quantity]:
    """Points of the output, and after how many periods the motion repeats."""
    names = model.program.output_numbers
    relative = any(matches(name, f"*.{kind}") for name in names for kind in RELATIVE)
    name = model.program.outputs[output].name
    return [section_points(name), period(of=() if relative else name, longest=longest)]


def _of_study(study: Study, info: ParameterInfo, of: str, asked: Array) -> Bifurcation:
    points, periods = (study[name].reshape(len(asked), -1) for name in study.names)
    said, messages = [], {}
    for j, done in enumerate(study.done.tolist()):
        words = study.messages.get(j, "") if np.isnan(periods[j, 0]) else ""
        repeated = (
            "" if np.isnan(periods[j, 0]) else f"period {int(periods[j, 0])}" if periods[j, 0] else "not periodic"
        )
        said.append(("diverged" if GROWS in words else "failed") if words else f"quick: {repeated}" if done else "")
        if words:
            messages["start", float(asked[j])] = words
    return Bifurcation(
        info.path, info.given_in or info.unit, asked, of, study.name_units[0], points[None], (tuple(said),),
        ((None,) * len(asked),), messages, ("start",),
    )  # fmt: skip


def _outputs(seen: Strobe, states: Array, output: int, first: int) -> Array:
    """One output at points of the section, shape (k,); first: the number of the first of them."""
    program = seen.model.program
    rows = np.zeros((len(states), 1 + program.n_total + len(program.switches) + len(program.inputs)))
    rows[:, 0] = seen.period * np.arange(first, first + len(states))
    rows[:, 1 : 1 + seen.n] = states
    modes = slice(1 + program.n_total, 1 + program.n_total + len(program.switches))
    with seen.opened(states[-1]) as sim:
        if len(program.switches):
            for row in rows:
                row[modes] = sim.probe(row[0], row[1 : 1 + program.n_total], None, "modes")
        rows[:, modes.stop :] = sim.inputs
        _, out, _ = sim.evaluate(rows, np.array([output], dtype=np.intc))
    found: Array = out[:, 0]
    return found


def _quick(seen: Strobe, states: Array, keep: int, longest: int) -> str:
    points = states[-keep:]
    period, _, _ = repeats(points, longest, _extent(points))
    if period is None and any(q.kind == "angle" for q in seen.model.program.states):
        turns = turned(seen, states[-1], seen.begun + len(states)).turns
        if turns.any():
            points = around(np.where(turns > 0.0, 0.0, points), points, turns)
            period, _, _ = repeats(points, longest, _extent(points))
    return "quick: not periodic" if period is None else f"quick: period {period}"


def _extent(points: Array) -> Array:
    extent = np.abs(points).max(axis=0)
    found: Array = np.where(extent > 0.0, extent, 1.0)
    return found
