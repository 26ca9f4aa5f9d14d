"""Periodic orbits by shooting, and their multipliers.

    P^m(y) = y by Newton's method,  dy = -(M - I)^+ (P^m(y) - y),   M = dP^m/dy;    multipliers: eigenvalues of M (Floquet 1883)

The pseudo-inverse leaves out neutral directions. Stable and unstable orbits are found alike. Knows nothing of labels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.drives import DRIVES, Drives
from gearblocks.analysis.regimes.neutral import Neutral, neutral_directions, scaled, unclosed
from gearblocks.analysis.regimes.sizes import settled
from gearblocks.analysis.regimes.small_multipliers import with_small_ones
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import Followed, Strobe, strobe
from gearblocks.analysis.regimes.turns import without_turns
from gearblocks.analysis.sections import Section, check_whole
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.simulation.records import FinalState
from gearblocks.simulation.start_states import standing_run
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model

Array = NDArray[np.float64]

CLOSED = 1e-9
"""Of the sizes of the states: what an orbit closes to, at the least."""
_MOST = 40  # steps of Newton's method
_HALVINGS = 8
_STALLED = 6  # steps, in which what an orbit misses itself by has to fall to a half
_RANK = 1e-10  # of the largest singular value: smaller ones are neutral directions
_APART = 100.0  # closures that a divisor of the period has to be off by
_ROUNDING = 30.0  # tolerances that a closed orbit is off by


@final
@dataclass(frozen=True, slots=True, eq=False)
class PeriodicOrbit:
    """An orbit that repeats after `periods` periods of the section, which last `period` [s] each.

    points: states (names) at the section, shape (periods, n); closure: how far the last point misses the first one, in sizes
    of the states; multipliers: shape (n - p,), the largest first, without the p neutral directions, whose words are in
    `neutral` (0: nothing is left behind an event, or less than the least number); exponents: growth rates of motions beside it
    [1/s], log(abs(multipliers)) per second, told however small these are; corner: where no derivative exists, in words, or "";
    parameters: by path; states: the points as runs begin with them, of which `starts` is made; turns: by how much each state
    may be turned so that nothing changes [rad], or 0; ahead: by how many of these an orbit goes on [rad], both of shape (n,).
    """

    names: tuple[str, ...]
    points: Array
    periods: int
    period: float
    closure: float
    multipliers: NDArray[np.complex128]
    exponents: Array
    neutral: tuple[str, ...]
    corner: str
    rtol: float
    parameters: Mapping[str, float]
    states: tuple[FinalState, ...]
    turns: Array
    ahead: Array

    @property
    def starts(self) -> tuple[Trajectory, ...]:
        """Runs of no length that stand at each of the points: `gb.simulate(train, initial=orbit.starts[0], t_end=...)` goes on
        along the orbit, at its parameters and from the time of the point."""
        return tuple(standing_run(state, "", self.parameters) for state in self.states)

    @property
    def stable(self) -> bool:
        """Whether motions beside it come nearer: all multipliers lie inside the unit circle."""
        return self.corner == "" and bool((np.abs(self.multipliers) < 1.0).all())

    def __repr__(self) -> str:
        largest = f"{abs(self.multipliers[0]):.6g}" if len(self.multipliers) else "none"
        kind = "stable" if self.stable else "unstable" if self.corner == "" else "no derivative"
        return f"<period {self.periods}, {kind}: largest multiplier {largest}, closes to {self.closure:.1e}>"


@by_name_only
def periodic_orbit(
    train: Drivetrain | Model, section: Section, *, periods: int = 1, transient: int = 300, rtol: float = 1e-11,
    parameters: Mapping[str, float | str] | None = None, initial: Any = None,
) -> PeriodicOrbit:  # fmt: skip
    """The periodic orbit near the motion after `transient` periods: one that repeats after `periods` of them, or after a
    divisor of that many. Stable or not; without a transient near the start. rtol: of its runs; parameters and initial: as for
    `simulate`. Raises SimulationError where none is found."""
    if periods < 1 or transient < 0:
        raise ParameterError(f"periods = {periods} must be >= 1 and transient = {transient} must be >= 0")
    check_whole(periods=periods, transient=transient)
    seen = strobe(build(train), section, parameters, initial, rtol)
    warn_of_parameters(seen.model, parameters)
    warn_if_stiff(seen, initial)
    seen, y, passed, acts = settled(seen, initial, transient)
    if not acts.periods:
        raise no_period(seen, passed, acts)
    if periods % acts.periods:
        raise ParameterError(
            f"periods = {periods} must be a multiple of {acts.periods}: after so many periods of the section the drives of the "
            "train repeat"
        )
    neutral = neutral_directions(seen, y)
    orbit = shoot(seen, y, periods, neutral, acts.periods)
    if orbit is None:
        raise SimulationError(
            passed * seen.period, "", f"no orbit that repeats after {periods} periods was found near the motion",
            "give another number of periods, a start nearer to it, or a longer transient", None,
        )  # fmt: skip
    return orbit


def no_period(seen: Strobe, passed: int, acts: Drives) -> SimulationError:
    """Why there is no periodic orbit after so many periods."""
    words = acts.changing or f"the drives do not repeat together within {DRIVES} periods of the section"
    return SimulationError(
        passed * seen.period, "", words,
        "an orbit repeats with what acts on the train: give a longer transient, or another section", None,
    )  # fmt: skip


def shoot(seen: Strobe, y: Array, periods: int, neutral: Neutral, base: int = 1) -> PeriodicOrbit | None:
    """The orbit by Newton's method from the states y, or None. Its period is the least one; base: that of the drives."""
    found = _newton(seen, y, periods, neutral)
    if found is None:
        return None
    y, run, closure = found
    same = _APART * max(closure, _floor(seen), _unsure(seen, run, closure, neutral))
    for divisor in range(base, periods, base):
        if periods % divisor == 0 and _misses(seen, y, run.states[divisor - 1], neutral) <= same:
            return shoot(seen, y, divisor, neutral, base)
    told = _mapped(seen.told_finely, y, periods)
    whole = scaled(seen, (told or run).maps[-1])
    multipliers, logs = with_small_ones(seen, y, periods, neutral, whole, neutral.multipliers(whole))
    names = tuple(q.name for q in seen.model.program.states)
    points = np.vstack([y, run.states[:-1]])
    states = tuple(seen.standing(point, k) for k, point in enumerate(points))
    off = run.states[-1] - y
    return PeriodicOrbit(
        names, points, periods, seen.period, closure, multipliers, logs / (periods * seen.period), neutral.words, run.corner,
        seen.rtol, seen.values, states, seen.turns, off - without_turns(off, seen.turns),
    )  # fmt: skip


def _misses(seen: Strobe, y: Array, other: Array, neutral: Neutral) -> float:
    """How far apart two states are, whatever neutral directions do."""
    return float(np.abs(neutral.apart(seen.off(y, other))).max(initial=0.0))


def _unsure(seen: Strobe, run: Followed, closure: float, neutral: Neutral) -> float:
    """How far off the orbit a point may be that closes so well: far, where multipliers are next to 1."""
    if not neutral.rest.shape[1]:
        return 0.0
    off = neutral.rest.T @ scaled(seen, run.maps[-1]) @ neutral.rest - np.eye(neutral.rest.shape[1])
    return max(closure, 0.1 * seen.rtol) / float(max(np.linalg.svd(off, compute_uv=False)[-1], 1e-300))


def _floor(seen: Strobe) -> float:
    return _ROUNDING * seen.rtol


def _newton(seen: Strobe, y: Array, periods: int, neutral: Neutral) -> tuple[Array, Followed, float] | None:
    run, rest = _mapped(seen, y, periods), neutral.rest
    best: tuple[Array, Followed, float] | None = None
    closures: list[float] = []
    for _ in range(_MOST):
        if run is None:
            return best
        miss = neutral.apart(seen.off(run.states[-1], y))
        closure = _missed(seen, run.states[-1], y, neutral)
        closures.append(closure)
        if closure <= max(CLOSED, _floor(seen)):
            # a step of rounding, off the stop that it rests on
            if best is not None and run.corner and not best[1].corner:
                return best
            if best is not None and closure > 0.1 * best[2]:  # as near as it comes
                return best if best[2] <= closure else (y, run, closure)
            best = y, run, closure
        elif best is not None or closure > 0.5 * min(closures[:-_STALLED], default=np.inf):
            return best
        if not rest.shape[1]:
            return best  # what is neutral goes on, or repeats
        off = rest.T @ scaled(seen, run.maps[-1]) @ rest - np.eye(rest.shape[1])
        step = rest @ np.linalg.lstsq(off, -miss, rcond=_RANK)[0]
        y, run = _damped(seen, y, step, periods, closure, neutral)
    return best


def _damped(
    seen: Strobe, y: Array, step: Array, periods: int, closure: float, neutral: Neutral
) -> tuple[Array, Followed | None]:
    """The step, or the part of it that comes nearer."""
    share = 1.0
    for _ in range(_HALVINGS):
        trial = seen.moved(y, share * step)
        if _closure(seen, trial, periods, neutral) < max(closure, _floor(seen)):
            return trial, _mapped(seen, trial, periods)
        share *= 0.5
    return y, None


def _missed(seen: Strobe, end: Array, y: Array, neutral: Neutral) -> float:
    """How far the end of an orbit is off its begin."""
    return float(np.abs(unclosed(seen, seen.off(end, y), neutral)).max(initial=0.0))


def _closure(seen: Strobe, y: Array, periods: int, neutral: Neutral) -> float:
    """How far the motion from y misses it later, by a run without derivatives, which cost many times as much."""
    try:
        return _missed(seen, seen.follow(y, periods).states[-1], y, neutral)
    except SimulationError:
        return np.inf


def _mapped(seen: Strobe, y: Array, periods: int) -> Followed | None:
    try:
        return seen.map(y, periods)
    except SimulationError:
        return None
