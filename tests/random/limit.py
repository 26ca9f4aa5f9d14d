"""The limit of runs whose small part (a width, an inertia) is halved from one to the next: extrapolated, and where not."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Event = tuple[str, float]
"""What switched, and when."""


def samples_that_switches_pass(one: Iterable[Event], other: Iterable[Event], t: Array) -> Array:
    """Samples that lie between a switch of the last two runs and where it is in the limit.

    They are before it in all runs and behind it in the limit, or the other way round, and what two extrapolations agree
    on is wrong there.
    """
    passed = np.zeros(len(t), dtype=bool)
    first, second = _by_name(one), _by_name(other)
    for name in first.keys() | second.keys():
        a, b = first[name], second[name]
        for x, y in zip(a, b, strict=False):
            passed |= np.abs(t - y) <= 4.0 * abs(y - x) + 1e-9 * t[-1]
        for y in [*a[len(b) :], *b[len(a) :]]:  # a switch of one of them alone: nothing tells where it goes
            passed |= np.abs(t - y) <= 2e-2 * t[-1]
    return t[passed]


def _by_name(events: Iterable[Event]) -> dict[str, Sequence[float]]:
    out: dict[str, list[float]] = defaultdict(list)
    for name, at in events:
        out[name].append(at)
    return defaultdict(list, out)
