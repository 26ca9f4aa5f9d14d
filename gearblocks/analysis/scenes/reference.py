"""The reference that errors of a scene are told against, and how far it can be trusted.

    values: those of a tight tolerance;   noise = max(|values - those of ten times the tolerance|, |change by 1e-9|)/|values|

The change: every parameter times 1 +- 1e-9, at random, as no one knows it better. Where that alone moves a quantity by more
than is wanted, the motion is irregular and no single run is right: the quantity is scattered.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Bench, Effort, Outcome
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]
Attempt = Callable[[Effort], Outcome]

CHANGE = 1e-9
_PROBES = (1e-6, 1e-8, 1e-4)
_TIGHT = tuple(10.0**-k for k in (12, 11, 10, 9, 8, 7))
_ORDER = {"dp8": 8.0, "dp5": 5.0, "rk4": 4.0, "rodas": 4.5}


@final
@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Values of the quantities, shape (Q,), and noise, what they are uncertain by, relative to each. moved: how far a change
    of the parameters by 1e-9 moves them, likewise. effort: how they were made."""

    values: Array
    noise: Array
    moved: Array
    effort: Effort

    def errors(self, values: Array) -> Array:
        """Deviation from the reference, relative to it; from a value of 0 as it is."""
        return np.abs(values - self.values) / np.where(self.values == 0.0, 1.0, np.abs(self.values))


def growth(method: str) -> float:
    """By what a tenth of the tolerance makes a run of these methods dearer, where accuracy sets its steps."""
    return float(10.0 ** (1.0 / min(_ORDER[name] for name in method.split("+"))))


def reference_of(bench: Bench, attempt: Attempt, limit: float) -> Reference:
    """The reference by the tightest tolerance whose run takes at most about `limit` CPU seconds. Raises SimulationError."""
    probe, first = _probe(attempt)
    tight = _tightest(probe, first, limit)
    fine, coarse = Effort("auto", tight), Effort("auto", 10 * tight)
    values, less = attempt(fine).values, attempt(coarse).values
    scale = np.where(values == 0.0, 1.0, np.abs(values))
    moved = np.abs(bench.outcome(coarse, _factors(len(bench.parameters))).values - less) / scale
    return Reference(values, np.maximum(np.abs(values - less) / scale, moved), moved, fine)


def _probe(attempt: Attempt) -> tuple[Effort, Outcome]:
    """The first run that comes to its end."""
    failure: SimulationError | None = None
    for rtol in _PROBES:
        try:
            return Effort("auto", rtol), attempt(Effort("auto", rtol))
        except SimulationError as error:
            failure = failure or error
    assert failure is not None
    raise failure


def _tightest(probe: Effort, first: Outcome, limit: float) -> float:
    seconds, factor = first.stats.cpu_seconds, growth(first.stats.method)
    for rtol in _TIGHT:
        if seconds * factor ** math.log10(probe.rtol / rtol) <= limit:
            return rtol
    return _TIGHT[-1]


def _factors(n: int) -> Array:
    """1 +- 1e-9 for every parameter."""
    signs: Array = np.random.default_rng(1).choice([-1.0, 1.0], n)
    return 1.0 + CHANGE * signs
