"""The reference that errors of a scene are told against, and how far it can be trusted.

    settled:    values of a tight tolerance,  noise |values - those of ten times the tolerance|
    scattered:  mean of n runs with parameters (1 + 1e-6 xi),  noise that of the mean (`scatter.py`)

both relative to the values. Where the motion scatters, an error is that of a mean.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Bench, Effort, Outcome
from gearblocks.analysis.scenes.scatter import Estimate, estimate, more_runs
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]
Attempt = Callable[[Effort], Outcome]

_TIGHT = tuple(10.0**-k for k in (12, 11, 10, 9, 8, 7))
_ORDER = {"dp8": 8.0, "dp5": 5.0, "rk4": 4.0, "rodas": 4.5}
_MEAN = Effort("auto", 1e-8)  # of the runs of a mean
_SHARE = 1 / 3  # of the accuracy wanted: how well the mean of a reference is known
_LEAST, _MOST = 4, 256  # runs of a mean


class Mean(NamedTuple):
    """Means over runs, shape (Q,), and what they are uncertain by, in the same units; stats: counters of one run."""

    values: Array
    errors: Array
    stats: Stats


@final
@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Values of the quantities, shape (Q,), and noise, what they are uncertain by, relative to each. effort: how they were
    made; members: number of runs whose mean they are (1: of one run, the motion is settled); enough: of how many a mean is
    known to a third of the accuracy wanted."""

    values: Array
    noise: Array
    effort: Effort
    members: int = 1
    enough: int = 1

    @property
    def scattered(self) -> bool:
        """Whether the values are means."""
        return self.members > 1

    @property
    def scale(self) -> Array:
        """What errors are relative to: the values, 1 where one is 0."""
        return np.where(self.values == 0.0, 1.0, np.abs(self.values))

    def errors(self, values: Array) -> Array:
        """Deviation from the reference, relative to it."""
        found: Array = np.abs(values - self.values) / self.scale
        return found


def growth(method: str) -> float:
    """By what a tenth of the tolerance makes a run of these methods dearer, where accuracy sets its steps."""
    return float(10.0 ** (1.0 / min(_ORDER[name] for name in method.split("+"))))


def reference_of(bench: Bench, attempt: Attempt, limit: float) -> Reference:
    """The reference, whose runs take at most about `limit` CPU seconds each, or together where they make a mean.

    Raises SimulationError."""
    within = bench.scene.within
    first = estimate(bench, within, Effort())
    if first.scattered:
        return _mean_reference(bench, within, limit)
    tight = _tightest(first, limit)
    fine, coarse = Effort("auto", tight), Effort("auto", 10 * tight)
    values = attempt(fine).values
    found = Reference(values, np.zeros(len(values)), fine)
    return replace(found, noise=found.errors(attempt(coarse).values))


def mean_of(bench: Bench, effort: Effort, members: int) -> Mean:
    """The means over runs with parameters that differ by 1e-6. Raises SimulationError where many cannot go on."""
    first = bench.outcome(effort)
    none = Estimate(first.values, first.values, np.empty((0, len(first.values))), effort, first.stats, 0)
    found = more_runs(bench, none, members)
    return Mean(found.values, found.errors, first.stats)


def _mean_reference(bench: Bench, within: float, limit: float) -> Reference:
    """As many runs as tell the mean to a third of what is wanted, as far as they are affordable."""
    members = 8
    while True:
        found = mean_of(bench, _MEAN, members)
        reference = Reference(found.values, found.errors, _MEAN, members)
        noise = found.errors / reference.scale
        needed = math.ceil(members * float(np.max(noise) / (_SHARE * within)) ** 2)
        most = min(_MOST, int(limit / max(found.stats.cpu_seconds, 1e-9)))
        if needed <= members or members >= most:
            return replace(reference, noise=noise, enough=min(max(needed, _LEAST), members))
        members = max(min(needed * 5 // 4, 2 * members + needed // 2, most), members + 1)


def _tightest(first: Estimate, limit: float) -> float:
    seconds, factor = first.stats.cpu_seconds, growth(first.stats.method)
    for rtol in _TIGHT:
        if seconds * factor ** math.log10(first.effort.rtol / rtol) <= limit:
            return rtol
    return _TIGHT[-1]
