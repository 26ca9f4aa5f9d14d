"""Families of orbits: where motions beside an orbit repeat as it does, a multiplier is 1, and belongs to the family.

    P^m(y + s v) = y + s v + O(s^2) + what fades,   M v = v

A part that friction holds for good rests wherever it came to rest; what swings by itself, once in the section's time, does so
in any phase. Of a multiplier of 1 alone (a fold, a rest that is left as t^3, a motion that drifts) nothing repeats beside, or
not for long: that is looked at, on both sides. Knows nothing of labels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral, scaled
from gearblocks.analysis.regimes.orbit import PeriodicOrbit
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]

_ONE = 1e-6  # of 1: a multiplier of the family
_FADED = 1e-12  # of what lies beside the family, before it is watched
_MOST = 2000  # periods in which it has to fade so far
_WATCHED = 1000  # periods
_BESIDE = 1e-2  # of the sizes: how far motions beside it begin
_STAYS = 0.5  # of that, along the family, is left
_DRIFTS = 1e-9  # of the sizes, over the periods that are watched: 1e-12 a period
_SOONER = 1e-6  # of the sizes: a shorter period misses itself by more
_RTOL = 1e-12


class Family(NamedTuple):
    """neutral: with the directions along the family aside; words: what has been seen."""

    neutral: Neutral
    words: str


def family(seen: Strobe, orbit: PeriodicOrbit, neutral: Neutral, base: int) -> Family | None:
    """That of an orbit whose multipliers are 1, once or more, and else inside the unit circle; None where it has none, or
    where its least period, a multiple of `base`, is another one."""
    ones = np.abs(orbit.multipliers - 1.0) <= _ONE
    left = float(np.abs(orbit.multipliers[~ones]).max(initial=0.0))
    settling = np.log(_FADED) / np.log(max(left, _FADED)) if left < 1.0 else np.inf
    if orbit.corner or not ones.any() or settling * orbit.periods > _MOST:
        return None
    fine, settling, y = seen.finer(min(seen.rtol, _RTOL)), orbit.periods * int(np.ceil(settling)), orbit.points[0]
    try:
        if _repeats(fine, y, orbit.periods, settling, base) is None:
            return None
        directions = _along(fine, y, orbit.periods, neutral, int(ones.sum()))
        if directions is None:
            return None
        for direction in _beside(directions):
            step = _BESIDE * (directions @ direction)
            beside = _repeats(fine, fine.moved(y, step), orbit.periods, settling, base)
            if beside is None or not _stays(fine, beside - y, step, directions):
                return None
    except SimulationError:
        return None
    aside = Neutral(
        neutral.basis, neutral.rest @ _null(directions.T @ neutral.rest), (*neutral.words, "along a family of orbits")
    )
    words = f"motions {_BESIDE:g} of its size beside it repeat as it does, all to {_DRIFTS:g} after {_WATCHED} periods"
    return Family(aside, words)


def _along(seen: Strobe, y: Array, periods: int, neutral: Neutral, count: int) -> Array | None:
    """Orthonormal directions along the family in units of the sizes, shape (n, count); None where growth by shear hides behind
    multipliers of 1."""
    run = seen.told_finely.map(y, periods)
    off = neutral.rest.T @ scaled(seen, run.maps[-1]) @ neutral.rest - np.eye(neutral.rest.shape[1])
    _, sizes, rows = np.linalg.svd(off)
    if run.corner or int((sizes <= _ONE * max(1.0, float(sizes[0]))).sum()) != count:
        return None
    found: Array = neutral.rest @ rows[-count:].T
    return found


def _beside(directions: Array) -> Array:
    """Both ways along each of them, and along one between."""
    count = directions.shape[1]
    each = np.eye(count) if count == 1 else np.vstack([np.eye(count), np.ones(count) / np.sqrt(count)])
    return np.vstack([each, -each])


def _repeats(seen: Strobe, y: Array, periods: int, settling: int, base: int) -> Array | None:
    """The states that a motion from y settles to, if it comes back to them after so many periods and no fewer, for as long as
    it is watched."""
    watched = periods * -(-_WATCHED // periods)
    states = seen.follow(y, settling + watched).states[settling - 1 :]
    off = np.abs(seen.off(states, states[0])).max(axis=1)
    sooner = [off[m] for m in range(base, periods, base) if periods % m == 0]
    return states[0] if off[::periods].max() <= _DRIFTS and min(sooner, default=np.inf) > _SOONER else None


def _stays(seen: Strobe, off: Array, step: Array, directions: Array) -> bool:
    """Whether what a motion has settled to lies as far along the family as it began."""
    along = directions.T @ (off / seen.scale)
    begun = directions.T @ step
    return bool(np.linalg.norm(along - begun) <= _STAYS * np.linalg.norm(begun))


def _null(rows: Array) -> Array:
    """Orthonormal directions that independent rows are zero along."""
    found: Array = np.linalg.svd(rows)[2][len(rows) :].T
    return found
