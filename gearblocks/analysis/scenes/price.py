"""Price of effects: what each adds to a scene in states, events and CPU time, and what it changes in the quantity.

Every effect is taken away by itself, alike ones together, then all of an element together. Single changes mislead, in both
directions: two may cancel, and one may matter only beside another. So what may go by itself is taken away together, and
where that is not what the single changes add up to, the smallest set that makes the difference is looked for; and pairs
whose changes cancel are priced. What cannot act on the quantity, by structure, is free.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from gearblocks.analysis.scenes.influence import without_influence
from gearblocks.analysis.scenes.price_result import Price, Row
from gearblocks.analysis.scenes.scene import Scene, check_scene
from gearblocks.analysis.scenes.trials import Judgement, Trial, Trials, Verdict
from gearblocks.analysis.scenes.variants import Part, elements, parts
from gearblocks.analysis.study_progress import progress as shown_progress
from gearblocks.errors import by_name_only

MOST = 40
"""Trains that a scene may take in all; each is built."""
_PAIRS = 4  # pairs whose changes cancel, that are priced
_FIRST = 26  # trains that single effects and elements may take
_TURNS = 3.0  # CPU seconds for times of all rows that are comparable
_SEARCH = 8  # trains that the search for a set that matters together may take


@by_name_only
def price(scene: Scene, *, progress: Callable[[int, int], object] | None = None) -> Price:
    """What each effect of a scene's train costs and changes: rows by effect, element, and sets that matter together.

    Alike effects ("mesh[1].backlash", "mesh[2].backlash") are one row. Every change has an error; the verdict is needed, not
    needed or undecided. progress: called with the trains that are built and run, and how many there are to be. Ctrl-C
    keeps the rows that are done (`complete` is False then). Raises what a run of the scene raises.
    """
    check_scene("price", scene)
    return priced(Trials(scene), progress)


def priced(trials: Trials, progress: Callable[[int, int], object] | None = None) -> Price:
    """The price of the effects of a scene whose trials are under way."""
    train = trials.scene.drivetrain
    idle = without_influence(train.train(), trials.scene.measures)
    single, whole = parts(train), elements(train)
    free = [part for part in single if _owners(part) <= idle]
    wanted = [part for part in (*single, *whole) if not _owners(part) <= idle]
    asked = _chosen(wanted)
    untried = tuple(part.name for part in single if part in wanted and part not in asked)
    complete, rows = True, [_free_row(trials, part) for part in free]
    try:
        with shown_progress(len(asked), 0, progress, "price", "trains") as show:
            found = trials.all([part.effects for part in asked], lambda done, _: show(done))
        for i, (part, trial) in enumerate(zip(asked, found, strict=True)):
            rows.insert(i, _row(trials, part, trial))
        for part in _together(trials, tuple(rows)):
            rows.append(_row(trials, part, trials.trial(part.effects), together=True))
        rows = _timed(trials, rows)
    except KeyboardInterrupt:
        complete = False
        told = {row.name for row in rows}
        known = [(part, trials.known(part.effects)) for part in asked if part.name not in told]
        rows += [_row(trials, part, trial, patience=False) for part, trial in known if trial is not None]
        untried += tuple(part.name for part, trial in known if trial is None)
    return Price(
        trials.scene, trials.whole.estimates[1], trials.whole, tuple(rows), trials.count, trials.runs, untried, complete
    )  # fmt: skip


def _owners(part: Part) -> set[str]:
    return {name.rpartition(".")[0] for name in part.effects}


def _chosen(wanted: Sequence[Part]) -> list[Part]:
    """As many of them as may be built; those that take most along first, in their order otherwise."""
    if len(wanted) <= _FIRST:
        return list(wanted)
    kept = sorted(range(len(wanted)), key=lambda i: -len(wanted[i].effects))[:_FIRST]
    return [wanted[i] for i in sorted(kept)]


def _row(trials: Trials, part: Part, trial: Trial, together: bool = False, patience: bool = True) -> Row:
    judgement = trials.judged(trial, patience)
    bench, whole = trial.bench, trials.whole
    fastest = math.nan
    if bench is not None:
        try:
            fastest = bench.fastest()
        except (ArithmeticError, RuntimeError, np.linalg.LinAlgError):
            fastest = math.nan
    return Row(
        part.name, part.effects, judgement, whole.n_states - trial.n_states, whole.n_switches - trial.n_switches,
        None if trial.message else trial.stats, fastest, trial.message, together,
    )  # fmt: skip


def _timed(trials: Trials, rows: Sequence[Row]) -> list[Row]:
    """The rows with CPU times that are comparable, also with that of the whole train."""
    known = {row.effects: trials.trial(row.effects) for row in rows if row.stats is not None}
    trials.whole.stats = trials.take_turns(known.values(), _TURNS)
    return [replace(row, stats=known[row.effects].stats) if row.effects in known else row for row in rows]


def _free_row(trials: Trials, part: Part) -> Row:
    n = len(trials.scene.measures)
    nothing = Judgement(np.zeros(n), np.zeros(n), (Verdict.no_influence,) * n)
    return Row(part.name, part.effects, nothing, 0, 0, None, math.nan, "")


# -- effects together -------------------------------------------------------------------------------------------------


def _together(trials: Trials, rows: Sequence[Row]) -> Iterator[Part]:
    """Sets whose change is not what single changes say: pairs that cancel, and what matters only together."""
    within = trials.scene.within
    ran = [row for row in rows if row.judgement.verdict in (Verdict.needed, Verdict.not_needed, Verdict.undecided)]
    yield from _cancelling(ran, within)
    alone = _outermost([row for row in ran if row.judgement.verdict is Verdict.not_needed])
    if len(alone) > 1 and trials.count < MOST:
        everything = Part("all that is not needed by itself", frozenset().union(*(row.effects for row in alone)))
        yield everything
        if _matters(trials, everything):
            smallest = _smallest(trials, [Part(row.name, row.effects) for row in alone])
            if smallest is not None and smallest.effects != everything.effects:
                yield smallest


def _outermost(rows: Sequence[Row]) -> list[Row]:
    """Rows that no other one contains."""
    return [row for row in rows if not any(row.effects < other.effects for other in rows)]


def _cancelling(rows: Sequence[Row], within: float) -> Iterator[Part]:
    """Pairs of rows, one of them needed by itself, whose changes add up to less than the accuracy wanted."""
    found: list[tuple[float, Part]] = []
    for i, one in enumerate(rows):
        for other in rows[i + 1 :]:
            if one.effects & other.effects or not any(r.judgement.verdict is Verdict.needed for r in (one, other)):
                continue
            total = float(np.max(np.abs(one.judgement.changes + other.judgement.changes)))
            if total <= within:
                found.append((total, Part(one.name, one.effects) | Part(other.name, other.effects)))
    yield from (part for _, part in sorted(found, key=lambda pair: pair[0])[:_PAIRS])


def _matters(trials: Trials, part: Part) -> bool:
    found = trials.judged(trials.trial(part.effects), patience=False).verdict
    return found in (Verdict.needed, Verdict.undecided)


def _smallest(trials: Trials, chosen: list[Part]) -> Part | None:
    """A smallest set of them that still matters together, by halves and then one by one."""
    begun = trials.count
    size = len(chosen) // 2
    most = min(MOST, begun + _SEARCH)
    while size >= 1 and len(chosen) > 2 and trials.count < most:
        for start in range(0, len(chosen), size):
            rest = chosen[:start] + chosen[start + size :]
            if len(rest) >= 2 and trials.count < most and _matters(trials, _union(rest)):
                chosen = rest
                break
        else:
            size //= 2
            continue
        size = min(size, len(chosen) // 2)
    return _union(chosen) if len(chosen) >= 2 else None


def _union(chosen: Sequence[Part]) -> Part:
    found = chosen[0]
    for part in chosen[1:]:
        found = found | part
    return found
