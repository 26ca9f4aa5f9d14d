"""The kind of motion that a driven train answers with, and the evidence for it.

    period n         shooting converges to an orbit of least period n, its multipliers lie inside the unit circle, and the
                     motion comes nearer to it as they say, at two tolerances
    chaotic          the largest exponent exceeds 3 standard errors, also after ten times the transient and as many periods
                     as chaos has to last, at two tolerances
    quasi-periodic   no exponent is positive, and a second frequency shows
    diverged         the motion grows without bound
    coexisting       several starts end in several of these
    unresolved       none of them can be said

Points of a section propose; they decide nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.drives import DRIVES, begun_at, drives
from gearblocks.analysis.regimes.exponents import LyapunovExponents, longer, told_exponents
from gearblocks.analysis.regimes.neutral import Neutral, leaves, neutral_directions
from gearblocks.analysis.regimes.orbit import PeriodicOrbit, shoot
from gearblocks.analysis.regimes.second_frequency import second_frequency
from gearblocks.analysis.regimes.settling import Nearing, leaving, misses, nearing
from gearblocks.analysis.regimes.sizes import sized
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import GrowthError, Strobe, strobe
from gearblocks.analysis.regimes.whole_turns import goes_on, in_turns
from gearblocks.analysis.sections import LONGEST, Section
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.solver.library import Model

Array = NDArray[np.float64]

SIGMAS = 3.0
"""Standard errors by which a largest exponent has to exceed zero."""
_BEYOND = 8  # times the longest period, that is looked for where no exponent is positive or zero
_FARTHEST = 1024  # periods that are looked for where all exponents are negative
_TENFOLD = 10  # times the transient, before chaos is said
_GROWN = 10.0  # times the size of the quarter before: the motion grows
_ROUNDS = 200  # times the periods so far, in which what grows without bound leaves all numbers
_SAME_MULTIPLIERS = 1e-3  # of two tolerances, per period: errors of maps over many periods multiply
_REPEATS = 1e-4  # of the sizes: a torus that comes as near to itself is hardly one
_STANDS = 1e-7  # of the sizes: no motion whose differences grow repeats so well but one on an orbit
_APART = 1e-3  # of the sizes: orbits that are further apart are two


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Regime:
    """What was found: `label` as in the table of this module; settled: False where it is unresolved; evidence: sentences.

    period: periods of the section after which the motion repeats, or None; orbit, exponents: what the label rests on, or None;
    parts: by start, of several.
    """

    label: str
    evidence: tuple[str, ...]
    period: int | None = None
    orbit: PeriodicOrbit | None = None
    exponents: LyapunovExponents | None = None
    parts: tuple[Regime, ...] = field(default=())

    @property
    def settled(self) -> bool:
        """Whether the evidence suffices for the label."""
        return not self.label.startswith("unresolved")

    def __str__(self) -> str:
        return self.label

    def __repr__(self) -> str:
        return f"<{self.label}: {'; '.join(self.evidence)[:90]}>"


@by_name_only
def classify(
    train: Drivetrain | Model, section: Section, *, transient: int = 300, keep: int = 100, longest: int = LONGEST,
    lasting: int = 20000, starts: int = 1, rtol: float = 1e-9, parameters: Mapping[str, float | str] | None = None,
    initial: Any = None,
) -> Regime:  # fmt: skip
    """The regime of a motion after `transient` periods of the section, with its evidence.

    keep: points that periods up to `longest` are proposed from; lasting: periods that chaos has to last after ten times the
    transient, or it may be an irregular transient; starts: how many starts are tried, the first one as given,
    others beside it by its own size; rtol: looser of the two tolerances that must agree; parameters and initial: as for
    `simulate`. Raises ParameterError, and SimulationError where a run cannot go on.
    """
    if min(transient, lasting) < 0 or keep < 2 * longest + 1 or longest < 1 or starts < 1:
        raise ParameterError(
            f"transient = {transient} and lasting = {lasting} must be >= 0, longest = {longest} and starts = {starts} >= 1, "
            f"and keep = {keep} > twice longest: every period must be seen to repeat"
        )
    seen = strobe(build(train), section, parameters, initial, rtol)
    warn_of_parameters(seen.model, parameters)
    warn_if_stiff(seen, initial)
    found = [Asked(seen, transient, keep, longest, lasting).regime(y) for y in _starts(seen, initial, starts)]
    return found[0] if starts == 1 else _together(seen, found)


def _starts(seen: Strobe, initial: Any, count: int) -> Iterator[Array]:
    y = seen.start(initial)
    yield y
    if count == 1:
        return
    try:
        states = seen.follow(y, 100).states
    except GrowthError:  # the first start is told by its own
        states = y[None]
    size = np.abs(np.vstack([y, states])).max(axis=0)
    rng = np.random.default_rng(0)
    for _ in range(count - 1):
        yield y + size * rng.standard_normal(seen.n)


def _together(seen: Strobe, found: list[Regime]) -> Regime:
    """Of several starts."""
    kinds: list[Regime] = []
    for one in found:
        if not any(_alike(seen, one, other) for other in kinds):
            kinds.append(one)
    counted = tuple(
        f"{sum(_alike(seen, one, kind) for one in found)} of {len(found)} starts: {kind.label}, {kind.evidence[0]}"
        for kind in kinds
    )
    if len(kinds) == 1:
        return replace(found[0], evidence=(*counted, *found[0].evidence[1:]), parts=tuple(found))
    label = "coexisting: " + " and ".join(kind.label for kind in kinds)
    return Regime(label if all(k.settled for k in kinds) else "unresolved", counted, parts=tuple(found))


def _alike(seen: Strobe, one: Regime, other: Regime) -> bool:
    """Whether two motions are of one kind, and on one orbit, wherever they are along neutral directions."""
    if one.label != other.label or one.orbit is None or other.orbit is None:
        return one.label == other.label
    scale = np.abs(np.vstack([one.orbit.points, other.orbit.points])).max(axis=0)
    scale = np.where(one.orbit.turns > 0.0, one.orbit.turns, np.where(scale > 0.0, scale, 1.0))
    seen = replace(seen, scale=scale, turns=one.orbit.turns)
    off = seen.off(one.orbit.points[0], other.orbit.points)
    if one.orbit.neutral:
        off = neutral_directions(seen, one.orbit.points[0]).apart(off.T).T
    return bool(np.abs(off).max(axis=1, initial=0.0).min() <= _APART)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """How it is asked for; arguments as of `classify`."""

    seen: Strobe
    transient: int
    keep: int
    longest: int
    lasting: int = 0

    def regime(self, y: Array) -> Regime:
        """That of the motion from the states y on."""
        try:
            return self.of(self.seen.follow(y, self.transient + self.keep).states)
        except GrowthError as error:
            return _diverged(error)

    def of(self, states: Array) -> Regime:
        """That of a motion that has passed these states at the section, shape (transient + keep, n). Raises GrowthError."""
        seen = replace(self.seen, begun=0)
        grown = _grown(seen, states, self.seen.begun + len(states))
        if isinstance(grown, Regime):
            return grown
        states, after = grown
        points, acts = states[-self.keep :], drives(seen, states[-1], self._farthest, after)
        if acts.changing:
            return Regime("unresolved", (acts.changing, "give a longer transient"))
        seen = sized(seen, points[-1], after)
        seen, points = begun_at(seen, points[-1], after - after % max(1, acts.periods)), seen.near(points)
        neutral = neutral_directions(seen, points[-1])
        if words := goes_on(seen, points, neutral):
            return Regime(
                "unresolved", (words, "differences beside it are told near 0 alone: give a shorter transient")
            )
        asked = seen, points, neutral, acts.periods, after
        return self._periodic(*asked) or self._other(*asked)

    @property
    def _farthest(self) -> int:
        return max(_BEYOND * self.longest, DRIVES)

    def _periodic(self, seen: Strobe, points: Array, neutral: Neutral, drives: int, after: int) -> Regime | None:
        found = nearing(seen, points, neutral, drives, self.longest, after) if drives else None
        if found is None:
            return None
        orbit = found.orbit
        finer = shoot(seen.finer(max(seen.rtol / 100, 1e-13)), orbit.points[0], orbit.periods, found.neutral)
        words = _nearing_words(found)
        if finer is None or not finer.stable or not _same(orbit, finer):
            return Regime("unresolved", (f"period {orbit.periods} at rtol {seen.rtol:g} alone", *words), orbit=orbit)
        if left := leaves(seen, finer.points[0], finer.periods, found.neutral):
            return Regime("unresolved", (left, *words), orbit=orbit)
        return Regime(f"period {orbit.periods}", words, orbit.periods, finer)

    def _other(self, seen: Strobe, points: Array, neutral: Neutral, drives: int, after: int) -> Regime:
        """No stable orbit was found yet: what exponents say now, after ten times the transient, and once more after `lasting`
        periods, in which an irregular transient shows what it is."""
        if not neutral.rest.shape[1]:
            return Regime(
                "unresolved", (f"all that the train does is neutral ({', '.join(neutral.words)})", "it goes on")
            )
        first = last = told_exponents(seen, points[-1], neutral, after)
        for more in (max(_TENFOLD * self.transient, self.keep), self.lasting):
            run = seen.follow(last.states, more, after=last.passed)
            grown = _grown(seen, np.vstack([points, run.states]), last.passed + more)
            if isinstance(grown, Regime):
                return grown
            points, after = seen.near(grown[0][-self.keep :]), grown[1]
            if regime := self._periodic(seen, points, neutral, drives, after):
                before = (f"before, the largest exponent was {_told(first)}",) if _positive(first) else ()
                return replace(regime, evidence=(*regime.evidence, *before))
            last = told_exponents(seen, points[-1], neutral, after)
            if not (self.lasting and _positive(last)):
                break
        if _positive(first) and _positive(last):
            off = misses(points, seen, neutral, self.longest)[drives - 1 :: drives] if drives else np.array([np.inf])
            if off.min(initial=np.inf) <= _STANDS and (
                found := leaving(seen, points, neutral, drives * (int(np.argmin(off)) + 1), drives, after)
            ):
                return _left(found, last)
            return _chaos(seen, points[-1], neutral, last, after)
        if not _positive(last):
            return self._torus(seen, points, neutral, drives, last, after)
        return Regime("unresolved", (f"the largest exponent is {_told(first)}, later {_told(last)}",), exponents=last)

    def _torus(
        self, seen: Strobe, points: Array, neutral: Neutral, drives: int, last: LyapunovExponents, after: int
    ) -> Regime:  # fmt: skip
        told = f"no exponent is positive: {_told(last)}"
        if not drives:
            words = f"the drives do not repeat together within {self._farthest} periods of the section"
            return Regime("quasi-periodic", (words, told), exponents=last)
        while -SIGMAS < _late(last) < -1.0 and (more := longer(seen, neutral, last)) is not None:
            last = more  # of a torus growth and fading stay bounded
        periodic, told = _negative(last) or _late(last) <= -SIGMAS, f"no exponent is positive: {_told(last)}"
        longest = _BEYOND * max(self.longest, drives)
        longest = max(longest, min(_FARTHEST, _BEYOND * longest)) if periodic else longest
        if regime := self._long_periodic(seen, neutral, drives, last, longest):
            return regime
        if periodic:
            words = f"{told}, so that it is periodic, and no period up to {longest} was found"
            return Regime("unresolved", (words, "give a longer transient, or a larger longest"), exponents=last)
        nearest = float(misses(points, seen, neutral, self.longest).min())
        second = second_frequency(seen, points[-1], neutral, {*range(1, self.longest + 1), drives, 2 * drives}, after)
        if second is None:
            words = f"points miss each other by {nearest:.1e} of their size at the least, and no second frequency shows"
            return Regime("unresolved", (words, told, "give a longer transient"), exponents=last)
        found = leaving(seen, points, neutral, drives, drives, after)
        return _left(found, last) if found else Regime("quasi-periodic", (second, told), exponents=last)

    def _long_periodic(
        self, seen: Strobe, neutral: Neutral, drives: int, last: LyapunovExponents, longest: int
    ) -> Regime | None:  # fmt: skip
        """Nothing grows: the motion may be periodic, however long its period is, and is where all exponents are negative."""
        points = seen.follow(last.states, 2 * longest + 1, after=last.passed).states
        off = misses(points, seen, neutral, longest)[drives - 1 :: drives]
        if off.min() > _APART:
            return None
        found = replace(self, longest=longest)._periodic(seen, points, neutral, drives, last.passed + len(points))
        if found is None and off.min() <= _REPEATS:
            near = f"points repeat to {off.min():.1e} of their size after {drives * (int(np.argmin(off)) + 1)} periods"
            words = f"{near}, and no orbit was found there that attracts"
            return Regime("unresolved", (words, "give a longer transient"), exponents=last)
        return found


def _grown(seen: Strobe, states: Array, passed: int) -> tuple[Array, int] | Regime:
    """The states of a motion that grows no more, and the periods that have passed then: what leaves a rest that is unstable
    grows as long as it is small. Diverged, where it grows on."""
    begun = passed
    for _ in range(_ROUNDS):
        if not _grows(states):
            return states, passed
        try:
            states = seen.follow(states[-1], len(states), after=passed).states
        except GrowthError as error:
            return _diverged(error)
        passed += len(states)
    words = f"states grow by more than {_GROWN:g} in every {len(states) // 4} periods from {begun} to {passed}"
    return Regime("diverged", (words,))


def _grows(states: Array) -> bool:
    """Whether each of the last quarters of a run is many times as large as the one before."""
    part = len(states) // 4
    if part < 5:
        return False
    sizes = [np.abs(states[a : a + part]).max(axis=0) for a in (part, 2 * part, 3 * part)]
    return bool(((sizes[1] > _GROWN * sizes[0]) & (sizes[2] > _GROWN * sizes[1])).any())


def _diverged(error: GrowthError) -> Regime:
    return Regime("diverged", (f"the motion grows without bound until t = {error.time:.6g} s", str(error)))


def _same(one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
    """Whether two orbits have one period and, per period of the section, one largest multiplier."""
    largest = [abs(orbit.multipliers[:1]).max(initial=0.0) ** (1 / orbit.periods) for orbit in (one, other)]
    return one.periods == other.periods and bool(abs(largest[0] - largest[1]) <= _SAME_MULTIPLIERS)


def _nearing_words(found: Nearing) -> tuple[str, ...]:
    orbit, neutral = found.orbit, found.neutral
    largest = f"{abs(orbit.multipliers[0]):.6g}" if len(orbit.multipliers) else "none"
    nears = f"the motion is {found.after:.1e} of its size off it"
    if found.periods:
        sizes = f"from {found.before:.1e} to {found.after:.1e} of its size in {found.periods} periods"
        nears = f"the motion comes nearer as they say: {sizes}"
    closes = f"shooting finds an orbit of least period {orbit.periods} that closes to {orbit.closure:.1e}"
    aside = f"; {', '.join(neutral.words)}: neutral, multiplier 1" if neutral.words else ""
    words = f"{closes}, with the largest multiplier {largest}{aside}{_ahead_words(orbit)}", nears
    return (*words, found.family) if found.family else words


def _left(found: Nearing, last: LyapunovExponents) -> Regime:
    """Of a motion next to an orbit that is not stable."""
    largest = abs(found.orbit.multipliers[0]) ** (1 / found.orbit.periods)
    words = f"an orbit of period {found.orbit.periods} that is not stable, with a multiplier of {largest:.9g} a period"
    if not found.periods:
        return Regime(
            "unresolved", (f"the motion stands on {words}", "begin beside it"), orbit=found.orbit, exponents=last
        )
    sizes = f"from {found.before:.4g} to {found.after:.4g} of its size in {found.periods} periods"
    moves = f"the motion moves away from {words}, as it says: {sizes}"
    return Regime("unresolved", (moves, "give a longer transient"), orbit=found.orbit, exponents=last)


def _ahead_words(orbit: PeriodicOrbit) -> str:
    """By how many turns it goes on."""
    parts = [
        f"{orbit.names[j].rsplit('.', 1)[0]} by {orbit.ahead[j] / in_turns(orbit.turns[j]):+.6g}"
        for j in np.flatnonzero(orbit.ahead)
    ]
    return f"; it goes on by turns: {', '.join(parts)}" if parts else ""


def _positive(found: LyapunovExponents) -> bool:
    """Whether differences grow exponentially, in the later half too: those that grow as time does only double there."""
    return _exceeds(found.per_period[0], found) and _late(found) > SIGMAS


def _late(found: LyapunovExponents) -> float:
    """The logarithm by which differences grow in the later half."""
    return float(found.logs[len(found.logs) // 2 :, 0].sum())


def _negative(found: LyapunovExponents) -> bool:
    return _exceeds(-found.per_period[0], found)


def _exceeds(value: float, found: LyapunovExponents) -> bool:
    """Whether a growth per period is more than its error, and more than columns that turn come to over all of them."""
    return bool(value > SIGMAS * found.errors_per_period[0] and value * len(found.logs) > SIGMAS)


def _told(found: LyapunovExponents) -> str:
    return f"{found.per_period[0]:+.4g} +- {found.errors_per_period[0]:.1g} per period"


def _agree(one: LyapunovExponents, other: LyapunovExponents) -> bool:
    """Whether two largest exponents differ by no more than their errors."""
    both = float(np.hypot(one.errors_per_period[0], other.errors_per_period[0]))
    return bool(abs(one.per_period[0] - other.per_period[0]) <= SIGMAS * both)


def _chaos(seen: Strobe, y: Array, neutral: Neutral, last: LyapunovExponents, after: int) -> Regime:
    fine = seen.finer(max(seen.rtol / 100, 1e-13))
    try:
        finer = told_exponents(fine, y, neutral, after)
        while not (agree := _agree(last, finer)) or not _positive(finer):
            both = longer(seen, neutral, last), longer(fine, neutral, finer)
            if both == (None, None):
                break
            last, finer = both[0] or last, both[1] or finer
    except SimulationError as error:
        return Regime("unresolved", (f"the largest exponent is {_told(last)}", str(error)), exponents=last)
    words = f"the largest exponent is {_told(last)}, with rtol/100 {_told(finer)}, after {after} periods"
    if not (agree and _positive(last) and _positive(finer)):
        return Regime("unresolved", (words,), exponents=last)
    return Regime("chaotic", (words,), exponents=last)
