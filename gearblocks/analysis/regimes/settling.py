"""The periodic orbit that a motion nears, if it nears one: points propose periods, shooting decides, and the motion has to come
nearer as the multipliers say.

    e_k = y_k - y*,   e_{k + m} = M e_k

Knows nothing of chaos.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.families import family
from gearblocks.analysis.regimes.neutral import Neutral, scaled, unclosed
from gearblocks.analysis.regimes.orbit import PeriodicOrbit, shoot
from gearblocks.analysis.regimes.strobe import Strobe

Array = NDArray[np.float64]

_NEAR = 0.05  # of the sizes: points that miss each other by more propose no period
_REPEATS = 1e-4  # of the sizes: there is an orbit
_PHASES = 4  # of it, that shooting begins from
_CANDIDATES = 5
ARRIVED = 1e-6
"""Of the sizes: nearer than that the motion is the orbit."""
_STANDS = 1e-9  # of the sizes: the motion is on an orbit that is not stable
_AWAY = 1000  # periods over which it is watched whether it moves away
_GROWN = 1e-5  # by which it has grown then
_AS_SAID = 0.1  # of the distance that multipliers let expect
_LONGER = 4  # times as many periods are looked at where that is not said yet
_LOOKS = 4
_MARGINAL = 1e-9  # multipliers nearer to the unit circle decide nothing


@final
@dataclass(frozen=True, slots=True, eq=False)
class Nearing:
    """An orbit and how the motion nears it: distances in units of the sizes before and after so many periods. neutral: with
    the directions of the family that it belongs to, if it does, which `family` describes."""

    orbit: PeriodicOrbit
    neutral: Neutral
    before: float
    after: float
    periods: int
    family: str = ""


def misses(points: Array, seen: Strobe, neutral: Neutral, longest: int) -> Array:
    """By how much the later half of the points, shape (k, n), miss those m periods later, m = 1 .. longest."""
    late = points[len(points) // 2 :]

    def miss(m: int) -> float:
        if m >= len(late):
            return np.inf
        return float(np.abs(unclosed(seen, seen.off(late[m:], late[:-m]).T, neutral)).max(initial=0.0))

    return np.array([miss(m) for m in range(1, longest + 1)])


def nearing(seen: Strobe, points: Array, neutral: Neutral, base: int, longest: int, after: int) -> Nearing | None:
    """The stable orbit that points, shape (k, n), of a motion come nearer to, or None. base: periods of the drives; after:
    those that had passed at the last of the points."""
    back = after % base
    y = points[-1 - back]
    off = misses(points, seen, neutral, longest)
    proposed = [m for m in range(base, longest + 1, base) if off[m - 1] <= _NEAR]
    best = sorted(proposed, key=lambda m: off[m - 1])[:_CANDIDATES]
    watched: list[int] = []  # periods at which orbits side by side were looked for
    for m in sorted(best):
        # where points repeat an orbit is there: beside corners Newton's method may come to another one, from some of them
        phases = range(0, m, max(base, m // _PHASES // base * base)) if off[m - 1] <= _REPEATS else range(1)
        for phase in phases:
            start = points[-1 - back - phase] if back + phase < len(points) else y
            orbit = shoot(seen, start, m, neutral, base)
            found = None
            if orbit is not None and orbit.stable and abs(orbit.multipliers[:1]).max(initial=0.0) <= 1.0 - _MARGINAL:
                found = _nears(seen, y, orbit, neutral)
            elif off[m - 1] <= _REPEATS and not any(m % other == 0 for other in watched):
                least = next(k for k in range(base, m + 1, base) if m % k == 0 and off[k - 1] <= _REPEATS)
                watched.append(least)
                found = _nears_family(seen, y, least, neutral, base)
            if found is not None:
                return found
    return None


def _nears_family(seen: Strobe, y: Array, m: int, neutral: Neutral, base: int) -> Nearing | None:
    """The same where orbits lie side by side, and the motion comes to one of them."""
    orbit = shoot(seen, y, m, neutral, m)  # divisors of its period are tried beside the others
    one = None if orbit is None else family(seen, orbit, neutral, base)
    if orbit is None or one is None:
        return None
    beside = shoot(seen, orbit.points[0], orbit.periods, one.neutral, base)
    if beside is None or not beside.stable or beside.periods != orbit.periods:
        return None
    found = _nears(seen, y, beside, one.neutral)
    return None if found is None else replace(found, family=one.words)


def leaving(seen: Strobe, points: Array, neutral: Neutral, m: int, base: int, after: int) -> Nearing | None:
    """The unstable orbit of m periods that a motion stands on, or moves away from as the multipliers say, or None; the rest as
    of `nearing`."""
    y = points[-1 - after % base]
    orbit = shoot(seen, y, m, neutral, base)
    if orbit is None or orbit.stable or abs(orbit.multipliers[:1]).max(initial=0.0) <= 1.0 + _MARGINAL:
        return None
    target = _at_phase(seen, y, orbit, neutral)
    before = _distance(seen, neutral, y, target)
    if before <= max(_STANDS, 100 * orbit.closure):
        return Nearing(orbit, neutral, before, before, 0)
    periods = orbit.periods * max(1, _AWAY // orbit.periods)
    with np.errstate(over="ignore", invalid="ignore"):
        expected = _expected(seen, orbit, neutral, y, target, periods)
        grown = np.linalg.norm(expected) / np.linalg.norm(neutral.apart(seen.off(y, target))) - 1.0
    if not _GROWN < grown < np.inf:
        return None
    left = neutral.apart(seen.off(seen.follow(y, periods).states[-1], target))
    if np.abs(left - expected).max() > _AS_SAID * grown * before:
        return None
    return Nearing(orbit, neutral, before, float(np.abs(left).max()), periods)


def _nears(seen: Strobe, y: Array, orbit: PeriodicOrbit, neutral: Neutral) -> Nearing | None:
    """Whether the motion from y comes as near as the multipliers say."""
    floor = max(ARRIVED, 100 * orbit.closure)
    periods = orbit.periods * max(1, round(20 / orbit.periods))
    for _ in range(_LOOKS):
        target = _at_phase(seen, y, orbit, neutral)
        before = _distance(seen, neutral, y, target)
        if before <= floor:
            return Nearing(orbit, neutral, before, before, 0)
        run = seen.follow(y, periods)
        expected = _expected(seen, orbit, neutral, y, target, periods)
        left = neutral.apart(seen.off(run.states[-1], target))
        after = float(np.abs(left).max(initial=0.0))
        if after <= floor or np.abs(left - expected).max() <= _AS_SAID * np.abs(expected).max() + floor:
            return Nearing(orbit, neutral, before, after, periods)
        y, periods = run.states[-1], periods * _LONGER
    return None


def _at_phase(seen: Strobe, y: Array, orbit: PeriodicOrbit, neutral: Neutral) -> Array:
    """The point of the orbit that the motion is next to."""
    found: Array = min(orbit.points, key=lambda point: _distance(seen, neutral, y, point))
    return found


def _distance(seen: Strobe, neutral: Neutral, y: Array, other: Array) -> float:
    return float(np.abs(neutral.apart(seen.off(y, other))).max(initial=0.0))


def _expected(seen: Strobe, orbit: PeriodicOrbit, neutral: Neutral, y: Array, target: Array, periods: int) -> Array:
    """What is left of the small difference between y and a point of the orbit after so many periods, a multiple of its own."""
    one = neutral.rest.T @ scaled(seen, seen.map(target, orbit.periods).maps[-1]) @ neutral.rest
    left: Array = np.linalg.matrix_power(one, periods // orbit.periods) @ neutral.apart(seen.off(y, target))
    return left
