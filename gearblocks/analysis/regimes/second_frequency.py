"""A second frequency of a motion beside that of its section: a line of the spectrum of its points that stays where it is, and
is no n-th of the section's.

A torus that winds around an orbit of period n has lines at k/n, too, and these may be the largest. Knows nothing of exponents.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.signal.windows import blackmanharris

from gearblocks.analysis.regimes.neutral import Neutral
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.analysis.regimes.turns import around

Array = NDArray[np.float64]

_POINTS = (4096, 16384)
_SHARE = 0.9  # of the power of what is no n-th, that the largest of its lines have together
_LINES = 12
_WIDTH = 4  # bins of a line, to each side: the main lobe of the window
_ASIDE = 8  # bins beside a known line that are its own: one that slowly fades is wider than the window
_STAYS = 0.5  # bins: the line of both halves
_LASTS = 0.8  # of its power in one half, in the other: what decays is no torus
_FLOOR = 1e-9  # of the power: what the window leaves beside a line
_LEAST = 1e-7  # of the power: a second frequency has more than that


def second_frequency(seen: Strobe, y: Array, neutral: Neutral, orders: Iterable[int], after: int) -> str | None:
    """In words, or None: where lines hold the power that is at no n-th of the section's, n in orders, and the largest of them
    stays. More points are asked where few tell none: it may be next to an n-th."""
    known = np.unique([k / n for n in orders for k in range(n // 2 + 1)])
    states = np.empty((0, seen.n))
    for count in _POINTS:
        more = seen.follow(states[-1] if len(states) else y, count - len(states), after=after + len(states))
        states = np.vstack([states, more.states])
        points = around(neutral.apart((np.where(seen.turns > 0.0, 0.0, states) / seen.scale).T).T, states, seen.turns)
        frequency = _frequency(points[:, int(np.argmax(points.std(axis=0)))], known)
        if frequency is not None:
            return f"the points have a second frequency, {frequency:.6g} times that of the section"
    return None


def _frequency(x: Array, known: Array) -> float | None:
    """The second frequency of a column of points, per period."""
    half = len(x) // 2
    first, second, whole = (_others(part, known) for part in (x[:half], x[half:], x))
    powers = [float(part.max()) for part in (first, second)]
    if min(*powers, whole.max()) < _LEAST or min(powers) < _LASTS * max(powers):
        return None
    if abs(_largest(first) - _largest(second)) > _STAYS or _power_in_lines(whole) < _SHARE:
        return None
    return _largest(whole) / len(x)


def _others(x: Array, known: Array) -> Array:
    """Power by bin, as shares of the whole, without lines at known frequencies."""
    power: Array = np.abs(np.fft.rfft((x - x.mean()) * blackmanharris(len(x), sym=False))) ** 2
    power /= max(float(power.sum()), 1e-300)
    left = power.copy()
    left[: _ASIDE + 1] = 0.0  # what drifts
    for frequency in known:
        i = round(frequency * len(x))
        near = slice(max(0, i - 1), i + 2)
        at = near.start + int(np.argmax(power[near]))
        is_line = power[at] > _FLOOR and power[at] == power[max(0, at - 1) : at + 2].max()
        if is_line and abs(_between(power, at) - frequency * len(x)) < 1.0:
            left[max(0, at - _ASIDE) : at + _ASIDE + 1] = 0.0
    return left


def _largest(power: Array) -> float:
    """Where the largest line is, in bins."""
    return _between(power, int(np.argmax(power)))


def _between(power: Array, i: int) -> float:
    """Where the line at bin i is, between bins (parabola through the logarithms)."""
    if not 0 < i < len(power) - 1:
        return float(i)
    low, here, high = np.log(power[i - 1 : i + 2] + 1e-300)
    bend = low - 2 * here + high
    return float(i + (0.5 * (low - high) / bend if bend < 0 else 0.0))


def _power_in_lines(power: Array) -> float:
    left, lines = power.copy(), 0.0
    for _ in range(_LINES):
        i = int(np.argmax(left))
        part = slice(max(0, i - _WIDTH), i + _WIDTH + 1)
        lines += float(left[part].sum())
        left[part] = 0.0
    return lines / float(power.sum())
