"""A second frequency of a motion beside that of its section: a line of the spectrum of its points that stays where it is.

Knows nothing of exponents.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral
from gearblocks.analysis.regimes.strobe import Strobe

Array = NDArray[np.float64]

_POINTS = 4096
_SHARE = 0.9  # of the power, that the largest lines have together
_LINES = 12
_WIDTH = 4  # bins of a line, to each side
_STAYS = 0.5  # bins: the line of both halves


def second_frequency(seen: Strobe, y: Array, neutral: Neutral, orders: Iterable[int], after: int) -> str | None:
    """In words, or None: where lines hold the power, and the largest stays, and is no n-th of the section's, n in orders."""
    run = seen.follow(y, _POINTS, after=after)
    points = neutral.apart((run.states / seen.scale).T).T
    column = points[:, int(np.argmax(points.std(axis=0)))]
    first, second = _largest(column[: _POINTS // 2]), _largest(column[_POINTS // 2 :])
    whole = _largest(column)
    if abs(first - second) > _STAYS / (_POINTS // 2) or _power_in_lines(column) < _SHARE:
        return None
    near = min(abs(whole - k / n) for n in orders for k in range(n // 2 + 1))
    if near < 1.0 / _POINTS:
        return None
    return f"the points have a second frequency, {whole:.6g} times that of the section"


def _spectrum(x: Array) -> Array:
    window = np.hanning(len(x))
    power: Array = np.abs(np.fft.rfft((x - x.mean()) * window)) ** 2
    return power


def _largest(x: Array) -> float:
    """The frequency of the largest line, per period, between bins (parabola through the logarithms)."""
    power = np.log(_spectrum(x) + 1e-300)
    i = int(np.argmax(power[1:-1])) + 1
    bend = power[i - 1] - 2 * power[i] + power[i + 1]
    shift = 0.5 * (power[i - 1] - power[i + 1]) / bend if bend < 0 else 0.0
    return float((i + shift) / len(x))


def _power_in_lines(x: Array) -> float:
    power = _spectrum(x)
    whole, lines = power.sum(), 0.0
    for _ in range(_LINES):
        i = int(np.argmax(power))
        part = slice(max(0, i - _WIDTH), i + _WIDTH + 1)
        lines += float(power[part].sum())
        power[part] = 0.0
    return lines / float(whole) if whole > 0 else 0.0
