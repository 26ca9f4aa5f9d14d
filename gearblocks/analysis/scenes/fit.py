"""Fit of a train to a scene: the cheapest set of effects, method and tolerance that keep every quantity within the accuracy.

Searched from both ends: everything that may go away at once, then put back what changes most, whole elements first; and what
single changes say may go together, then one part more at a time. Only runs judge: a set counts where the train without it,
built and run, is within the accuracy beside the whole train, errors counted in. Then it is held against the whole train at
load and speed 10 % lower and higher.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Effort
from gearblocks.analysis.scenes.fit_result import Fit, Neighbour
from gearblocks.analysis.scenes.neighbours import neighbours
from gearblocks.analysis.scenes.price import MOST, priced
from gearblocks.analysis.scenes.price_result import GAIN, Price, Row
from gearblocks.analysis.scenes.scene import Scene, check_scene
from gearblocks.analysis.scenes.trials import Judgement, Trial, Trials, Verdict
from gearblocks.analysis.scenes.variants import members, parts
from gearblocks.analysis.scenes.work_precision import work_precision_of
from gearblocks.errors import GearblocksError, by_name_only

Array = NDArray[np.float64]

_STEPS = 6  # trains that each end of the search may take
_TURNS = 2.0  # CPU seconds for times of the whole and the fitted train that are comparable
_BUDGET = 20.0  # CPU seconds for the choice of method and tolerance


@by_name_only
def fit(scene: Scene, *, progress: Callable[[int, int], object] | None = None) -> Fit:
    """The cheapest train, method and tolerance that keep the quantities of a scene within its accuracy, with the evidence.

        best = gb.fit(scene)
        start = gb.carried_start(rig, best.drivetrain, initial=scene.initial)
        gb.simulate(best.drivetrain, t_end=0.5, initial=start, method=best.method, rtol=best.rtol, locate=best.locate)

    At most 40 trains are built. progress: as of `gb.price`. Raises what a run of the scene raises.
    """
    check_scene("fit", scene)
    trials = Trials(scene)
    prices = priced(trials, progress)
    if not prices.complete:
        raise KeyboardInterrupt  # nothing is known yet of what holds
    return fitted(trials, prices)


def fitted(trials: Trials, price: Price) -> Fit:
    """The fit of a scene whose effects are priced."""
    search = _Search(trials, price)
    search.from_both_ends()
    best, judgement = search.best, search.judgement
    around = _around(trials, best)
    gains = search.gain(best)
    if best.effects and gains <= GAIN and not all(one.holds for one in around):
        best, judgement, given_up, spoilt = trials.whole, trials.judged(trials.whole), best, around
        around = ()
    else:
        given_up, spoilt = None, ()
    choice = _choice(trials, best, judgement)
    full = trials.take_turns([best], _TURNS) if best.effects else trials.whole.stats
    return Fit(
        trials.scene, price, best, judgement, full, choice, around, given_up, spoilt, trials.count, trials.runs
    )  # fmt: skip


@final
class _Search:
    """The cheapest trial that holds so far, and what single changes predict of sets."""

    def __init__(self, trials: Trials, price: Price) -> None:
        self.trials, self.price = trials, price
        free = frozenset().union(*(r.effects for r in price.rows if r.judgement.verdict is Verdict.no_influence))
        self.free: frozenset[str] = frozenset(free)
        usable = (Verdict.not_needed, Verdict.needed, Verdict.undecided)
        self.rows = [r for r in price.rows if r.judgement.verdict in usable]
        self.best, self.judgement = trials.whole, trials.judged(trials.whole)
        for row in self.rows:
            self._consider(trials.trial(row.effects))

    def gain(self, trial: Trial) -> float:
        """Share of the cost that is saved."""
        return 1 - self.trials.cost(trial)

    def from_both_ends(self) -> None:
        """Tries sets of rows until the trains, or the steps, are used up."""
        if self.free and not self._full():
            self._try(frozenset())
        self._from_rigid()
        self._from_whole()
        self._one_by_one()

    def _from_rigid(self) -> None:
        """Everything away that may go at all; then what changes most comes back, element by element."""
        rows = sorted((r for r in self.rows if not r.together), key=_size)
        for _ in range(_STEPS):
            if not rows or self._full():
                return
            judgement = self._try(_union(rows))
            if judgement is not None and judgement.verdict is Verdict.not_needed:
                return
            rows.pop()
            while rows and _size(rows[-1]) > 3 * self.trials.scene.within:
                rows.pop()

    def _from_whole(self) -> None:
        """What single changes add up to within the accuracy; then without what changes most."""
        chosen: list[Row] = []
        for row in sorted(self.rows, key=_size):
            if not _nested(row, chosen) and self._fits([*chosen, row]):
                chosen.append(row)
        for _ in range(_STEPS):
            if not chosen or self._full():
                return
            judgement = self._try(_union(chosen))
            if judgement is not None and judgement.verdict is Verdict.not_needed:
                return
            chosen.pop()

    def _one_by_one(self) -> None:
        """One row more, or one member of a group of alike effects, as long as it holds."""
        train = self.trials.scene.drivetrain
        candidates = [r.effects for r in sorted(self.rows, key=_size)]
        candidates += [one.effects for part in parts(train) if "*" in part.name for one in members(train, part)]
        steps = 0
        for effects in candidates:
            if steps >= _STEPS or self._full():
                return
            if effects <= self.best.effects or not self._may_join(effects):
                continue
            steps += 1
            self._try(self.best.effects | effects)

    def _may_join(self, effects: frozenset[str]) -> bool:
        """Whether single changes allow that these go, too; nothing is known of single members."""
        row = next((r for r in self.rows if r.effects == effects), None)
        if row is None:
            return True
        total = np.abs(self.judgement.changes + row.judgement.changes)
        return bool(np.all(total <= 1.5 * self.trials.scene.within))

    def _fits(self, rows: Sequence[Row]) -> bool:
        changes = np.sum([r.judgement.changes for r in rows], axis=0)
        return bool(np.all(np.abs(changes) <= self.trials.scene.within))

    def _full(self) -> bool:
        return self.trials.count >= MOST

    def _try(self, effects: frozenset[str]) -> Judgement | None:
        return self._consider(self.trials.trial(effects | self.free))

    def _consider(self, trial: Trial) -> Judgement | None:
        """Keeps a trial that holds and is cheaper, or as cheap with fewer states or effects."""
        if trial.message:
            return None
        judgement = self.trials.judged(trial)
        if np.isnan(trial.beside):
            self.trials.take_turns([trial])
        if judgement.verdict is Verdict.not_needed and self._cheaper(trial):
            self.best, self.judgement = trial, judgement
        return judgement

    def _cheaper(self, trial: Trial) -> bool:
        now, then = self.trials.cost(trial), self.trials.cost(self.best)
        if abs(now - then) <= GAIN * then:
            return (trial.n_states, -len(trial.effects)) < (self.best.n_states, -len(self.best.effects))
        return now < then


def _size(row: Row) -> float:
    return float(np.max(np.abs(row.judgement.changes) + row.judgement.errors))


def _nested(row: Row, chosen: Sequence[Row]) -> bool:
    return any(row.effects & other.effects for other in chosen)


def _union(rows: Sequence[Row]) -> frozenset[str]:
    return frozenset[str]().union(*(row.effects for row in rows))


# -- around the scene, and how it is run ------------------------------------------------------------------------------


def _around(trials: Trials, best: Trial) -> tuple[Neighbour, ...]:
    """What the fitted train is off by at other loads and speeds."""
    return (
        tuple(_beside(trials, best, words, scene) for words, scene in neighbours(trials.scene)) if best.effects else ()
    )


def _beside(trials: Trials, best: Trial, words: str, scene: Scene) -> Neighbour:
    names = scene.names
    try:
        there = Trials(scene, trials.effort, trials.whole.estimates[1])
        trial = there.trial(best.effects)
        return Neighbour(words, there.judged(trial), names, trial.message)
    except GearblocksError as error:
        nothing = np.full(len(names), np.nan)
        return Neighbour(words, Judgement(nothing, nothing, (Verdict.no_run,) * len(names)), names, str(error))


def _choice(trials: Trials, best: Trial, judgement: Judgement) -> Effort:
    """The cheapest method and tolerance that use up no more than what the change leaves of the accuracy."""
    used = float(np.max(np.abs(judgement.changes) + judgement.errors))
    left = (trials.scene.within - used) / (1 + used)  # errors of a run are relative to the fitted value
    if best.estimates[1].scattered or not left > 0:
        return best.estimates[1].effort
    assert best.bench is not None
    found = work_precision_of(best.bench, _BUDGET)
    point = found.cheapest_or_none(left)
    return best.estimates[1].effort if point is None else point.effort
