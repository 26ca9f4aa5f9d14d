"""Two runs beside each other: where their outputs differ most, on the solutions and not on samples."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, UnknownNameError, arguments_told, by_name_only
from gearblocks.pages import small_table
from gearblocks.simulation import plotting
from gearblocks.simulation.solution import between_samples, values_at
from gearblocks.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_SHOWN = 20  # rows that are printed; iteration and names reach all


class Difference(NamedTuple):
    """Of one output: the largest difference [unit], when it was [s], and its share of the largest size of the output."""

    name: str
    unit: str
    largest: float
    at: float
    share: float


@final
@arguments_told
@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """What `gb.compare` found: rows of Difference, the largest share first; t [s] and both tables, shape (len(t), outputs)."""

    titles: tuple[str, str]
    rows: tuple[Difference, ...]
    t: Array
    names: tuple[str, ...]
    tables: tuple[Array, Array]

    def __iter__(self) -> Iterator[Difference]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Difference:
        for row in self.rows:
            if row.name == name:
                return row
        raise UnknownNameError(f"'{name}' was not compared; there are {', '.join(self.names[:12])}")

    def __str__(self) -> str:
        shown = self.rows[:_SHOWN]
        wide = max((len(row.name) for row in shown), default=0)
        lines = []
        for row in shown:
            largest = f"{row.largest:.3e} {row.unit if row.unit != '1' else ''}".rstrip()
            lines.append(f"{row.name:<{wide}}  {row.share:8.1e} of its size  {largest} at {row.at:.6g} s")
        if len(self.rows) > len(shown):
            lines.append(f"and {len(self.rows) - len(shown)} more by {shown[-1].share:.1e} of their size or less")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        units = ("" if row.unit == "1" else row.unit for row in self.rows)
        rows = [
            (row.name, f"{row.share:.1e}", f"{row.largest:.3e}", unit, f"{row.at:.6g} s")
            for row, unit in zip(self.rows, units, strict=True)
        ]
        head = ("output", "of its size", "largest", "unit", "at")
        return small_table(" against ".join(self.titles), rows, head=head, numbers=(1, 2, 4))

    def plot(self, *, path: str | os.PathLike[str] | None = None) -> Figure:
        """Both runs over each other; saved to `path`. Raises StorageError."""
        units = {row.name: row.unit for row in self.rows}
        series = [
            (f"{title}: {name}", units[name], table[:, i])
            for i, name in enumerate(self.names)
            for title, table in zip(self.titles, self.tables, strict=True)
        ]
        return plotting.over_time(self.t, series, title=" and ".join(self.titles), path=path)


@by_name_only
def compare(one: Trajectory, other: Trajectory, *names: str) -> Comparison:
    """Where two runs differ most, in the time that both have: over outputs (names or patterns, else all that both have).

    Each is taken on its solution between the samples. Where a contact begins or a clutch sticks at slightly other times, an
    output that jumps there differs by its jump. Raises UnknownNameError, ParameterError.
    """
    for run in (one, other):
        if not isinstance(run, Trajectory):
            raise ParameterError(f"compare: {run!r:.80} must be a run, as gb.simulate answers with")
    common = set(other)
    chosen = [n for pattern in names or ("*",) for n in one.find(pattern) if n in common]
    chosen = list(dict.fromkeys(chosen))
    if not chosen:
        raise UnknownNameError(
            "the runs have no output in common" + (f" that {', '.join(names)} means" if names else "")
        )
    if min(len(one.t), len(other.t)) < 2:
        raise ParameterError("a run of less than two samples has nothing to compare")
    window = float(max(one.t[0], other.t[0])), float(min(one.t[-1], other.t[-1]))
    if not window[0] < window[1]:
        raise ParameterError("the runs have no time in common")
    parts = [x for run in (one, other) for x in (np.clip(run.t, *window), between_samples(run, window))]
    times = np.unique(np.concatenate(parts))
    tables = values_at(one, one.case, chosen, times), values_at(other, other.case, chosen, times)
    rows = []
    for i, name in enumerate(chosen):
        apart = np.abs(tables[0][:, i] - tables[1][:, i])
        at = int(np.argmax(apart))
        size = float(max(np.abs(tables[0][:, i]).max(), np.abs(tables[1][:, i]).max())) or 1.0
        rows.append(Difference(name, one.units[name], float(apart[at]), float(times[at]), float(apart[at]) / size))
    titles = (one.name, other.name) if one.name != other.name else (f"{one.name} (1)", f"{other.name} (2)")
    return Comparison(titles, tuple(sorted(rows, key=lambda row: -row.share)), times, tuple(chosen), tables)
