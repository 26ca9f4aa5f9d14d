"""A run between its samples: its steps done again where the run knows what it follows from, else splines through its samples.

Dense segments are not stored: what was not asked for while it ran is found by running it again, to the bit.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, arguments_told
from gearblocks.language.units import seconds
from gearblocks.simulation.case import Case
from gearblocks.simulation.needs import Along, Needs, Solution
from gearblocks.simulation.sampled_run import Run, SampledRun
from gearblocks.train.summary import span_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_BETWEEN = 8  # parts that an interval between samples is cut into
_MOST = 40_000  # samples of a run that are cut
_CLOSER = 64  # parts of a neighbourhood that is looked at more closely


class Extremes(NamedTuple):
    """The lowest and the highest value of an output [its unit], and when they were [s]."""

    low: float
    low_at: float
    high: float
    high_at: float

    def __str__(self) -> str:
        low, high = span_text(self.low, self.high).split(" .. ")
        return f"low {low} at {self.low_at:.6g} s, high {high} at {self.high_at:.6g} s"


@final
@arguments_told
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Spectrum:
    """Amplitudes [unit] of the parts of an output, by name, at frequencies [Hz], shape (n,) each. It unpacks into both."""

    frequency: Array
    amplitude: Array
    name: str = ""
    unit: str = ""
    title: str = ""

    def __iter__(self) -> Iterator[Array]:
        """Frequencies, then amplitudes."""
        return iter((self.frequency, self.amplitude))

    def __repr__(self) -> str:
        mean, top = float(self.amplitude[0]), 2 + int(np.argmax(self.amplitude[2:]))  # the mean is two lines wide
        return (
            f"<spectrum of {self.name}: mean {mean:.4g} {self.unit}, largest {self.amplitude[top]:.4g} {self.unit} at "
            f"{self.frequency[top]:.6g} Hz, lines {self.frequency[1]:.4g} Hz apart up to {self.frequency[-1]:.4g} Hz>"
        )

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Amplitudes but the mean over the frequency, up to where all of them are less than a hundredth of the largest; saved
        to `path` where given."""
        from gearblocks.simulation.plotting import spectrum_picture

        return spectrum_picture(self.frequency, (self.name, self.unit, self.amplitude), title=self.title, path=path)


@contextmanager
def solution_of(run: Run, case: Case | None, needs: Needs) -> Iterator[Solution]:
    """The solution that a run shows: its steps done again where the run knows what it follows from, else its samples."""
    if case is None or case.again is None:
        yield SampledRun(run, [time for one in needs.along for time in (one.after, one.before)])
        return
    with case.again(case, needs) as solution:
        yield solution


def along(run: Run, case: Case | None, kinds: Sequence[str], name: str, window: tuple[float, float]) -> list[float]:
    """What an output is along a window [s] of a run: peak, trough, mean, rms."""
    wanted = [Along(kind, name, *window) for kind in kinds]
    with solution_of(run, case, Needs(along=tuple(wanted))) as solution:
        return [solution.along_run(one) for one in wanted]


def window_of(run: Run, after: float | str | None, before: float | str | None) -> tuple[float, float]:
    """A window within a run. Raises ParameterError for one that is empty, or outside."""
    if len(run.t) < 2:
        raise ParameterError("a run of less than two samples has nothing between them")
    begin, end = float(run.t[0]), float(run.t[-1])
    low = begin if after is None else seconds("after", after)
    high = end if before is None else seconds("before", before)
    if not begin <= low < high <= end:
        raise ParameterError(f"from {low:g} s to {high:g} s is no part of a run from {begin:g} s to {end:g} s")
    return low, high


def values_at(run: Run, case: Case | None, names: Sequence[str], times: Array) -> Array:
    """Outputs at times [s] that increase, shape (times, names), right limits at events."""
    needs = Needs(outputs=tuple(names), times=tuple(times.tolist()))
    with solution_of(run, case, needs) as solution:
        return solution.table(names, times)


def between_samples(run: Run, window: tuple[float, float]) -> Array:
    """Times [s] within a window that fill the gaps between the samples."""
    t = np.unique(np.clip(run.t, *window))
    if len(t) < 2 or len(t) > _MOST:
        return np.empty(0)
    inner = t[:-1, None] + np.diff(t)[:, None] * (np.arange(1, _BETWEEN) / _BETWEEN)
    found = np.unique(inner.ravel())
    return found[~np.isin(found, t)]


def extremes(run: Run, case: Case | None, name: str, window: tuple[float, float]) -> Extremes:
    """Located extrema of the solution, not the largest samples."""
    high, low = along(run, case, ("peak", "trough"), name, window)
    times = np.unique(np.concatenate([np.clip(run.t, *window), between_samples(run, window)]))
    found = values_at(run, case, (name,), times)[:, 0]
    places = [int(np.argmin(found)), int(np.argmax(found))]
    near = [(times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]) for i in places]
    for _ in range(2):
        times = np.unique(np.concatenate([np.linspace(*ends, _CLOSER + 1) for ends in near]))
        found = values_at(run, case, (name,), times)[:, 0]
        places = [int(np.argmin(found)), int(np.argmax(found))]
        near = [(times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]) for i in places]
    return Extremes(low, float(times[places[0]]), high, float(times[places[1]]))


def spectrum(
    run: Run, case: Case | None, name: str, unit: str, window: tuple[float, float], samples: int | None
) -> Spectrum:
    """Amplitudes by Fourier's transform of the solution at equal distances, under the window of Hann."""
    n = samples or min(1 << 16, max(2048, 1 << int(np.ceil(np.log2(4 * len(run.t))))))
    if not isinstance(n, int) or n < 8:
        raise ParameterError(f"samples = {samples!r} must be a whole number >= 8")
    times = window[0] + (window[1] - window[0]) * np.arange(n) / n
    shape = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    size = np.abs(np.fft.rfft(values_at(run, case, (name,), times)[:, 0] * shape)) / shape.sum()
    size[1 : n // 2] *= 2  # each part stands at a frequency and at its negative
    frequency = np.arange(n // 2 + 1) / (window[1] - window[0])
    return Spectrum(frequency, size, name, unit, str(run.meta.get("train", "")))


def drawn(run: Run, case: Case | None, names: Sequence[str]) -> tuple[Array, dict[str, Array]]:
    """Times [s] and outputs as curves: the samples, both sides of events, and the solution between them."""
    columns = {name: run[name] for name in names}
    more = (
        between_samples(run, (float(run.t[0]), float(run.t[-1])))
        if len(run.t) > 1 and case is not None
        else np.empty(0)
    )
    if not len(more) or not names or len(more) * len(names) > _MOST * _BETWEEN:
        return run.t, columns
    table = values_at(run, case, names, more)
    t = np.concatenate([run.t, more])
    order = np.argsort(t, kind="stable")
    return t[order], {name: np.concatenate([columns[name], table[:, i]])[order] for i, name in enumerate(names)}


def event_times(run: Run, names: Iterable[str]) -> Array:
    """Times of the events [s] of the components that these outputs belong to."""
    of = {name.rpartition(".")[0] for name in names}
    return np.array([event.t for event in run.events if event.component in of])
