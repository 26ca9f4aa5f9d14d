"""Trials of a scene: its train without some of its effects, built and run once each, and judged against the whole train.

    change = (value - whole) / abs(whole),   error = (e_value + (1 + abs(change)) e_whole) / abs(whole)
    needed: abs(change) - error > within     not needed: abs(change) + error <= within     else undecided

A value that there is in one of two settled motions alone (the time of an event) is needed.

Where motions scatter both are means; runs are added, and averages over time get a longer window, until it is decided or the
patience ends. Where that of the whole train does not scatter, a single run without the effects that is off by more than the
accuracy makes them needed, whatever the mean is: one run answers no more. Knows nothing of which effects are tried, and in
what order.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from enum import StrEnum
from threading import Event
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantities import Integral
from gearblocks.analysis.scenes import variants
from gearblocks.analysis.scenes.bench import Bench, Effort, bench_of
from gearblocks.analysis.scenes.scatter import Estimate, estimate, more_runs
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError, SimulationError, UnknownNameError
from gearblocks.running import build
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]

STRETCHES = (1, 2, 4)
"""How many times as long the window of averages gets where a motion scatters."""
MEMBERS = (4, 16)
"""Runs of a mean, before it gets a longer window."""
MANY = (64, 256)
"""Runs of a mean that nothing else decided, where runs are cheap: together no more than PATIENCE of counted work (work_of)."""
PATIENCE = 2e8


class Verdict(StrEnum):
    """What is said of an effect, or of several together."""

    needed = "needed"
    not_needed = "not needed"
    undecided = "undecided"
    no_influence = "cannot influence it"
    no_quantity = "takes the quantity along"
    no_run = "does not run"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """What taking effects away does to each quantity: relative change, its error, verdict. members: runs of the mean without
    them (0: the motion does not scatter); stretch: how many times as long the window was; farthest: the largest change of a
    single run, where that alone makes them needed (else 0)."""

    changes: Array
    errors: Array
    verdicts: tuple[Verdict, ...]
    members: int = 0
    stretch: int = 1
    farthest: float = 0.0

    @property
    def verdict(self) -> Verdict:
        """That of all quantities together."""
        for one in (Verdict.no_run, Verdict.no_quantity, Verdict.needed, Verdict.undecided, Verdict.not_needed):
            if one in self.verdicts:
                return one
        return Verdict.no_influence

    @property
    def made_of(self) -> str:
        """What the values are made of, where they are means: ", 16 runs, window x 2"."""
        runs = f", {self.members} runs" if self.members else ""
        runs += f", single ones up to {100 * self.farthest:+.3g} %" if self.farthest else ""
        return f"{runs}, window x {self.stretch}" if self.stretch > 1 else runs

    def worst(self, names: Sequence[str]) -> str:
        """The largest of the changes, in words; of which quantity, where there are several. Where their verdicts differ, of
        each that has the verdict of all."""
        if len(names) == 1:
            return percent(self.changes[0], self.errors[0])
        those = [i for i, one in enumerate(self.verdicts) if one is self.verdict]
        if len(those) < len(names):
            return f"{', '.join(self._of(i, names[i]) for i in those)} alone"
        sizes = np.abs(self.changes) + np.where(np.isfinite(self.changes), self.errors, 0.0)
        i = int(np.argmax(np.where(np.isnan(sizes), np.inf, sizes)))
        return self._of(i, names[i])

    def _of(self, i: int, name: str) -> str:
        words = percent(self.changes[i], self.errors[i])
        if math.isfinite(self.changes[i]):
            return f"{words} of {name}"
        return f"{name} {words}" if math.isinf(self.changes[i]) else f"{name}, a value that there is in one of them"


def percent(change: float, error: float) -> str:
    """A relative change with its error, in percent."""
    if not math.isfinite(change):
        return "from 0" if math.isinf(change) else "of a value that there is in one of them alone"
    size = f"{100 * change:+.3g}"
    return f"{size} +- {100 * error:.2g} %" if error > 1e-3 * abs(change) and error > 1e-6 else f"{size} %"


def work_of(stats: Stats, states: int, switches: int) -> float:
    """What a run takes, counted and not timed, so that no other work on the machine decides: right-hand sides, and ten for each
    Jacobian, times states and a share of the switches."""
    return (stats.rhs_calls + _JACOBIAN * stats.jacobians) * (1.0 + states + _SWITCH * switches)


def relative_cost(work: float, seconds: float, beside: float) -> float:
    """What a run costs beside another: by the ratio of counted work; by that of the CPU times where these say something quite
    different, since there is work that is not counted (of the modes of lossy gears and friction)."""
    if not beside >= _LONG or work / _UNSEEN <= seconds / beside <= _UNSEEN * work:
        return work
    return seconds / beside


@final
@dataclass(slots=True, eq=False)
class Trial:
    """A train without `effects`: its bench, or why there is none (built: whether it was built at all); estimates by stretch
    of the window; counters and CPU time [s] of a run as the scene has it; beside: CPU time of the whole
    train at the same time [s]."""

    effects: frozenset[str]
    train: Drivetrain
    bench: Bench | None = None
    built: bool = False
    message: str = ""
    lost: bool = False
    estimates: dict[int, Estimate] = field(default_factory=dict)
    stats: Stats = field(default_factory=Stats)
    beside: float = math.nan
    made: int = 0

    @property
    def n_states(self) -> int:
        """States of its equations."""
        return 0 if self.bench is None else len(self.bench.model.program.states)

    @property
    def n_switches(self) -> int:
        """Event functions and switched constraints of it."""
        return 0 if self.bench is None else len(self.bench.model.program.switches)

    @property
    def work(self) -> float:
        """What a run takes, counted."""
        return work_of(self.stats, self.n_states, self.n_switches)

    @property
    def runs(self) -> int:
        """How many runs were made of it."""
        return self.made + sum(found.runs for found in self.estimates.values())


@final
class Trials:
    """All trials of a scene; each set of effects is built once. alike: what is known of the whole train in a scene much alike.
    Raises what the whole train raises."""

    def __init__(self, scene: Scene, effort: Effort = Effort(), alike: Estimate | None = None) -> None:  # noqa: B008  frozen
        self.scene, self.effort, self._alike = scene, effort, alike
        self._known: dict[frozenset[str], Trial] = {}
        self.ended = Event()  # by Ctrl-C
        self.whole = Trial(frozenset(), scene.drivetrain, bench_of(scene), built=True)
        self._run(self.whole)
        self._known[frozenset()] = self.whole

    @property
    def count(self) -> int:
        """Trains that were built."""
        return sum(trial.built for trial in self._known.values())

    @property
    def runs(self) -> int:
        """Runs that were made in all."""
        return sum(trial.runs for trial in self._known.values())

    def known(self, effects: Iterable[str]) -> Trial | None:
        """The trial of this set, where it was made."""
        return self._known.get(variants.gone(self.scene.drivetrain, effects))

    def trial(self, effects: Iterable[str]) -> Trial:
        """The train without these effects and all that rest on them."""
        return self.all([effects])[0]

    def all(self, sets: Sequence[Iterable[str]], tell: Callable[[int, int], object] | None = None) -> list[Trial]:
        """Trials of several sets, built and run side by side. Ctrl-C ends the runs in hand and those to come; what is done by
        then is `known`."""
        wanted = [variants.gone(self.scene.drivetrain, effects) for effects in sets]
        new = [effects for effects in dict.fromkeys(wanted) if effects not in self._known]
        with ThreadPoolExecutor(max(1, min(len(new), os.cpu_count() or 1))) as pool:
            try:
                for number, trial in enumerate(pool.map(self._made, new)):
                    self._known[trial.effects] = trial
                    if tell is not None:
                        tell(number + 1, len(new))
            except BaseException:
                self.ended.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise
        return [self._known[effects] for effects in wanted]

    def _made(self, effects: frozenset[str]) -> Trial:
        assert self.whole.bench is not None
        trial = Trial(effects, variants.without(self.scene.drivetrain, effects))
        try:
            model = build(trial.train)
            trial.built = True
            trial.bench = replace(bench_of(self.scene, trial.train, self.whole.bench.model, model), ended=self.ended)
            self._run(trial)
        except UnknownNameError as error:
            trial.message, trial.lost = str(error), True
        except GearblocksError as error:
            trial.message = str(error)
        return trial

    def _run(self, trial: Trial) -> None:
        assert trial.bench is not None
        alike = self._alike if trial is self.whole else self.whole.estimates[1]
        trial.estimates[1] = estimate(trial.bench, self.scene.within, self.effort, alike)
        trial.stats = trial.bench.timed(self.effort, 1)

    def take_turns(self, trials: Iterable[Trial], seconds: float = 1.0) -> Stats:
        """Times trials and the whole train in turns, one after the other, the least of several runs each: what else the
        machine does at a time slows all of them alike. Those that would take longer than `seconds` stay as they are. Answers
        the counters of the whole train."""
        turns = [self.whole, *(trial for trial in trials if trial.effects and not trial.message)]
        found = [trial.stats for trial in turns]
        total = max(sum(stats.cpu_seconds for stats in found), 1e-9)
        for number in range(min(_MOST_TURNS, int(seconds / total))):
            for i, trial in enumerate(turns):
                assert trial.bench is not None
                again = trial.bench.timed(self.effort, 1)
                found[i] = again if number == 0 or again.cpu_seconds < found[i].cpu_seconds else found[i]
        for trial, stats in zip(turns[1:], found[1:], strict=True):
            trial.stats, trial.beside = stats, found[0].cpu_seconds
        return found[0]

    def cost(self, trial: Trial) -> float:
        """What a run without some effects costs, relative to one of the whole train."""
        return relative_cost(trial.work / self.whole.work, trial.stats.cpu_seconds, trial.beside)

    # -- judging ------------------------------------------------------------------------------------------------------

    def judged(self, trial: Trial, patience: bool = True) -> Judgement:
        """What the train without some effects comes to beside the whole one. patience: runs are added until it is decided."""
        n = len(self.scene.measures)
        if trial.message:
            kind = Verdict.no_quantity if trial.lost else Verdict.no_run
            return Judgement(np.full(n, np.nan), np.full(n, np.nan), (kind,) * n)
        found = self._judged(trial, 1)
        if not patience or not found.members or Verdict.undecided not in found.verdicts:
            return found
        for stretch, members in self._efforts(trial):
            try:
                found = self._judged(trial, stretch, members)
            except SimulationError:  # of runs that were to make it surer
                return found
            if Verdict.undecided not in found.verdicts:
                return found
        return found

    def _efforts(self, trial: Trial) -> Iterator[tuple[int, int]]:
        """Windows and runs that means are made of, one after the other until it is decided."""
        yield from ((1, members) for members in MEMBERS)
        longest = 1
        for stretch in STRETCHES[1:]:
            if not self._steady(stretch):
                break
            longest = stretch
            yield stretch, MEMBERS[-1]
        work = longest * max(trial.work, self.whole.work)
        yield from ((longest, members) for members in MANY if members * work <= PATIENCE)

    def _judged(self, trial: Trial, stretch: int, members: int = 0) -> Judgement:
        whole, other = (self._estimate(one, stretch, members) for one in (self.whole, trial))
        scattered = whole.scattered or other.scattered
        with np.errstate(invalid="ignore", divide="ignore"):
            size, off = np.abs(whole.values), other.values - whole.values
            uncertain = other.errors + whole.errors * (1 + np.where(off == 0.0, 0.0, np.abs(off) / size))
            neither = np.isnan(other.values) & np.isnan(whole.values) & (not scattered)
            same = neither | ((off == 0.0) & ((uncertain == 0.0) | (not scattered)))
            changes, errors = np.where(same, 0.0, off / size), np.where(same, 0.0, uncertain / size)
        verdicts = [self._verdict(c, e, scattered) for c, e in zip(changes.tolist(), errors.tolist(), strict=True)]
        farthest = 0.0
        for i, one in enumerate(self._single_runs(whole, other)):
            if abs(one) > self.scene.within and verdicts[i] is not Verdict.needed:
                verdicts[i] = Verdict.needed
                farthest = max(farthest, one, key=abs)
        return Judgement(changes, errors, tuple(verdicts), len(other.members) or len(whole.members), stretch, farthest)

    @staticmethod
    def _single_runs(whole: Estimate, other: Estimate) -> list[float]:
        """The largest change of single runs, by quantity, where their motion scatters and that of the whole train does not."""
        if whole.scattered or not other.scattered:
            return []
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.nan_to_num((other.members - whole.values) / np.abs(whole.values), nan=0.0)
        found: list[float] = off[np.argmax(np.abs(off), axis=0), np.arange(off.shape[1])].tolist()
        return found

    def _verdict(self, change: float, error: float, scattered: bool) -> Verdict:
        within = self.scene.within
        if abs(change) + error <= within:
            return Verdict.not_needed
        if math.isnan(abs(change) - error):
            return Verdict.undecided if scattered else Verdict.needed
        return Verdict.undecided if abs(change) - error <= within else Verdict.needed

    def _estimate(self, trial: Trial, stretch: int, members: int) -> Estimate:
        bench, found = trial.bench, trial.estimates.get(stretch)
        assert bench is not None
        if stretch > 1:
            bench = bench.lengthened(stretch)
        if found is None:
            found = estimate(bench, self.scene.within, self.effort)
        if found.scattered and len(found.members) < members:
            found = more_runs(bench, found, members)
        trial.estimates[stretch] = found
        return found

    def _steady(self, stretch: int) -> bool:
        """Whether the quantities are averages that a longer window of the whole train leaves as they are."""
        if not all(isinstance(m, Integral) and m.before is None for m in self.scene.measures):
            return False
        try:
            short, long = (self._estimate(self.whole, n, MEMBERS[-1]) for n in (1, stretch))
        except SimulationError:
            return False
        return bool(np.all(np.abs(long.values - short.values) <= 1.5 * (long.errors + short.errors)))


_SWITCH = 0.3  # of a state, in CPU time (rattle without friction: 0.55 of the time, 0.50 were it a whole one)
_JACOBIAN = 10  # right-hand sides that a Jacobian and its factors take
_MOST_TURNS = 9
_LONG = 2e-3  # s; below, times are those of the start of a run
_UNSEEN = 1.5  # what the time differs from counted work by, where work does not see what takes the time
