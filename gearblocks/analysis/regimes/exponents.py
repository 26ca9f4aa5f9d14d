"""Lyapunov exponents: how fast motions beside a motion leave it, from its tangents.

    lambda_j = 1/T sum log r_jj,   Q_k R_k = M_k Q_{k-1}     (Benettin, Galgani, Giorgilli and Strelcyn 1980)

Neutral directions are taken out of the columns in each period, and shown apart. Where motions are regular the mean is weighted
with w(s) = exp(-1/(s (1 - s))), which converges faster than any power of T (Das, Saiki, Sander and Yorke 2017); where they are
not it is the plain one, with a standard error from means over batches, of growth no less than half of what both halves differ
by: beside a regular motion without damping differences grow as time does, and the mean fades. Knows nothing of labels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral, neutral_directions
from gearblocks.analysis.regimes.orbit import PeriodicOrbit, shoot
from gearblocks.analysis.regimes.settling import ARRIVED, misses
from gearblocks.analysis.regimes.sizes import settled
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import Strobe, strobe
from gearblocks.analysis.regimes.whole_turns import goes_on
from gearblocks.analysis.sections import LONGEST, Section
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

BATCHES = 20
"""Batches of periods that a standard error is told from."""
_REGULAR = 0.05  # of the error of a plain mean: parts of a regular motion agree better in their weighted means
TURNS_IN = 20
"""Periods in which the columns turn into their directions."""
_FEW, _STILL, _MANY = (
    500,
    2000,
    8000,
)  # periods that the sign of an exponent is told from: if clear, if none grows, at most
_STAY = 1e-6  # of their size: neutral directions within a period
_SURE = 6.0  # standard errors that decide it before


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LyapunovExponents:
    """Exponents of a motion, the largest first. logs: growth of each column in each period, shape (periods, m); period [s];
    neutral: words of the directions whose exponents are 0 by structure, which are not among them; corner: an event without a
    derivative on the way, in words, or ""; states: the last ones, shape (n,); passed: periods that had passed there.

    orbit: the periodic orbit that the motion has arrived at, or None; its exponents are those of the motion.
    """

    logs: Array
    period: float
    neutral: tuple[str, ...]
    corner: str
    states: Array
    passed: int
    orbit: PeriodicOrbit | None = None

    @property
    def per_period(self) -> Array:
        """Exponents per period of the section, shape (m,)."""
        return self._estimates()[0]

    @property
    def errors_per_period(self) -> Array:
        """Their standard errors, shape (m,)."""
        return self._estimates()[1]

    def _estimates(self) -> tuple[Array, Array]:
        if self.orbit is not None:
            known = self.orbit.exponents[: self.logs.shape[1]] * self.period
            return known, np.full(len(known), self.orbit.closure)
        length = len(self.logs) // BATCHES
        batches = self.logs[: length * BATCHES].reshape(BATCHES, length, -1).mean(axis=1)
        with np.errstate(invalid="ignore"):
            plain, error = self.logs.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(BATCHES)
            halves = batches.reshape(2, BATCHES // 2, -1).mean(axis=1)
            fading = np.where(plain > 0.0, 0.5 * np.abs(halves[1] - halves[0]), 0.0)  # what fades with time is no rate
            error = np.maximum(error, fading)
            weighted = _weighted_means(self.logs)
            split = np.ptp(weighted, axis=0)
            regular = split < _REGULAR * error
        return np.where(regular, weighted[0], plain), np.where(regular, split, error)

    @property
    def values(self) -> Array:
        """Exponents [1/s], shape (m,)."""
        return self.per_period / self.period

    @property
    def errors(self) -> Array:
        """Their standard errors [1/s], shape (m,)."""
        return self.errors_per_period / self.period

    @property
    def history(self) -> Array:
        """What the exponents [1/s] came to after each period, shape (periods, m)."""
        counts = np.arange(1, len(self.logs) + 1)[:, None]
        so_far: Array = np.cumsum(self.logs, axis=0) / (counts * self.period)
        return so_far

    def __repr__(self) -> str:
        listed = ", ".join(f"{v:.4g} +- {e:.1g}" for v, e in zip(self.values[:4], self.errors[:4], strict=True))
        more = ", ..." if self.logs.shape[1] > 4 else ""
        return singular(f"<exponents {listed}{more} 1/s over {len(self.logs)} periods>")

    @by_name_only
    def plot(self, path: str | Path | None = None) -> Figure:
        """The history of the exponents over the periods; saved where a path is given."""
        from gearblocks.analysis.regimes.pictures import draw_history

        return draw_history(self, path)


@by_name_only
def lyapunov(
    train: Drivetrain | Model, section: Section, *, periods: int = 2000, transient: int = 300, count: int | None = None,
    rtol: float = 1e-8, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
) -> LyapunovExponents:  # fmt: skip
    """The `count` largest exponents (default: all) of the motion after `transient` periods of the section, over `periods` of
    them. A motion that has arrived at a periodic orbit has the exponents of that orbit. rtol: of the run; parameters and
    initial: as for `simulate`. Raises SimulationError, also where a state goes on far out though laws read it, and
    ParameterError."""
    if periods < BATCHES or transient < 0 or (count is not None and count < 1):
        raise ParameterError(
            f"periods = {periods} must be >= {BATCHES}, transient = {transient} >= 0 and count = {count} >= 1"
        )
    seen = strobe(build(train), section, parameters, initial, rtol)
    warn_of_parameters(seen.model, parameters)
    warn_if_stiff(seen, initial)
    seen, y, passed, acts = settled(seen, initial, transient)
    neutral = neutral_directions(seen, y)
    if not neutral.rest.shape[1]:
        raise SimulationError(
            passed * seen.period, "", f"every motion of this train is neutral ({', '.join(neutral.words)})",
            "there are no exponents but those that are 0 by structure", None,
        )  # fmt: skip
    found = exponents_of(seen, y, neutral, periods, count, passed)
    wait = -found.passed % max(1, acts.periods)  # orbits begin with the drives
    points = np.vstack([found.states, seen.follow(found.states, wait + 2 * LONGEST, after=found.passed).states])[wait:]
    if words := goes_on(seen, points, neutral):
        raise SimulationError(
            found.passed * seen.period, "", words,
            "differences beside it are told near 0 alone: take fewer periods and a shorter transient", None,
        )  # fmt: skip
    return replace(found, orbit=_arrived(seen, points, neutral, acts.periods) if acts.periods else None)


def _arrived(seen: Strobe, points: Array, neutral: Neutral, drives: int) -> PeriodicOrbit | None:
    """The orbit that a motion with these points is on, if it is on one; drives: periods after which these repeat."""
    off = misses(points, seen, neutral, LONGEST)
    for m in np.flatnonzero(off <= ARRIVED) + 1:
        orbit = shoot(seen, points[0], int(m), neutral, drives) if m % drives == 0 else None
        if orbit is not None and orbit.stable:
            return orbit
    return None


def exponents_of(
    seen: Strobe, y: Array, neutral: Neutral, periods: int, count: int | None = None, after: int = 0
) -> LyapunovExponents:
    """Those of the motion from the states y, which it has after so many periods. Raises SimulationError."""
    m = neutral.rest.shape[1] if count is None else min(count, neutral.rest.shape[1])
    columns, fixed = (x * seen.scale[:, None] for x in (_directions(neutral, m), neutral.basis))
    parts = _parts(seen, y, neutral, after) if m > 1 else 1
    run = seen.follow(y, periods + TURNS_IN, columns, after=after, fixed=fixed, parts=parts)
    passed, logs = after + periods + TURNS_IN, run.logs.reshape(-1, parts, m).sum(axis=1)
    return LyapunovExponents(logs[TURNS_IN:], seen.period, neutral.words, run.corner, run.states[-1], passed)


def _parts(seen: Strobe, y: Array, neutral: Neutral, after: int) -> int:
    """Of a period, after which columns are made orthonormal: those in which little fades, if neutral directions are what they
    are within a period, too."""
    basis, parts = neutral.basis, seen.parts
    if parts == 1 or not basis.shape[1]:
        return parts
    maps = seen.follow(y, 1, basis * seen.scale[:, None], after=after, maps=True, parts=parts).maps
    moved = maps / seen.scale[None, :, None]
    left = moved - basis @ (basis.T @ moved)
    return parts if np.abs(left).max(initial=0.0) <= _STAY * np.abs(moved).max(initial=1.0) else 1


def longer(seen: Strobe, neutral: Neutral, found: LyapunovExponents) -> LyapunovExponents | None:
    """The same over twice as many periods; None: they are many already. Raises SimulationError."""
    if len(found.logs) >= _MANY:
        return None
    more = exponents_of(seen, found.states, neutral, len(found.logs), found.logs.shape[1], found.passed)
    return replace(more, logs=np.vstack([found.logs, more.logs]), corner=found.corner or more.corner)


def told_exponents(seen: Strobe, y: Array, neutral: Neutral, after: int) -> LyapunovExponents:
    """The largest one, over as many periods as it takes to see whether it is positive. Raises SimulationError."""
    found = exponents_of(seen, y, neutral, _FEW, 1, after)
    while not _is_told(found) and (more := longer(seen, neutral, found)) is not None:
        found = more
    return found


def _is_told(found: LyapunovExponents) -> bool:
    """Whether the largest exponent is well above its error, or has let nothing grow in many periods."""
    value, growth = found.per_period[0], found.per_period[0] * len(found.logs)
    clear = value > _SURE * found.errors_per_period[0] and growth > _SURE
    return bool(clear or (len(found.logs) >= _STILL and growth < 1.0))


def _weighted_means(logs: Array) -> Array:
    """Of the whole, both halves and the half in the middle, shape (4, m): of an irregular motion two of them agree by chance
    now and then, all four hardly ever."""
    half, quarter = len(logs) // 2, len(logs) // 4
    parts = (logs, logs[:half], logs[half:], logs[quarter : quarter + half])
    return np.array([_weighted(part) for part in parts])


def _weighted(logs: Array) -> Array:
    """Means over the periods with weights that vanish smoothly at both ends."""
    s = np.arange(1, len(logs) + 1) / (len(logs) + 1)
    weights = np.exp(-1.0 / (s * (1.0 - s)))
    mean: Array = weights @ logs / weights.sum()
    return mean


def _directions(neutral: Neutral, m: int) -> Array:
    """m directions at random orthogonal to the neutral ones: none of them is likely to miss the largest exponent."""
    width = neutral.rest.shape[1]
    mix, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((width, width)))
    found: Array = neutral.rest @ mix[:, :m]
    return found
