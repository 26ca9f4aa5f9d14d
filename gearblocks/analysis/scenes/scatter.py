"""Estimates of a scene's quantities with their errors: by two accuracies, or, where the motion scatters, by many runs.

    settled:    value v(rtol/30, parameters (1 + 1e-9 xi)),  error 2 |v(rtol/30) - v(rtol)|, at least 2 rtol/30 |v|
    scattered:  value mean of n runs, parameters (1 + 1e-6 xi),  error t(0.975, n - 1) s/sqrt(n) + 2 rtol |value| (Student 1908)

xi: standard normal numbers, others in each run. The motion scatters where a change of 1e-9 and a finer tolerance together
move it by a share of its own amplitude in one quarter of the window, and a change of 1e-6 alone does, too: an answer that
hangs on the seventh digit of a parameter is one of many, however tight its tolerance. Two runs of such a
motion may agree in a quantity by chance; so it is the motion that is judged, and the quantity then by a mean. Where the motion
is one, but no tolerance settles the quantity (a count beside a threshold), it is a mean, too. Knows nothing of effects.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Bench, Effort, Outcome
from gearblocks.errors import SimulationError
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]

DETECTS, SPREADS = 1e-9, 1e-6
"""Relative changes of parameters: to see whether the motion scatters; to draw runs that are independent of each other."""
FINER = 30.0
"""What a tolerance is divided by, to see what it is worth."""
_SETTLED = 0.1  # of the accuracy wanted: what two accuracies of a value that is settled differ by at most
_APART = 0.03  # of the amplitude of the motion: two runs that are that far apart are two motions
_ROUNDING = 100.0  # tolerances: differences below are errors of the runs
_REST = 1e-6  # rad/s, m/s: differences of speeds below are rest
_LEAST, _FEW = 4, 2  # runs of a mean; of one whose quantities hardly scatter though the motion does
_SURE = 0.05  # of the accuracy wanted: the error of a mean that few runs tell
_TRIES = 3  # tolerances that are tried before a motion is taken to scatter


@final
@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """Values of the quantities, shape (quantities,), and how far off they may be, in the same units.

    members: the runs of a mean, shape (n, quantities), n = 0 where the motion does not scatter. effort: how they were made;
    stats: counters of a run with it; runs: how many there were.
    """

    values: Array
    errors: Array
    members: Array
    effort: Effort
    stats: Stats
    runs: int

    @property
    def scattered(self) -> bool:
        """Whether the values are means."""
        return len(self.members) > 0


def perturbed(bench: Bench, size: float, number: int) -> Array:
    """Factors of all parameters that are no start values, make no structure and lie inside their bounds: 1 + size xi, of the
    run `number`."""
    program, values = bench.model.program, bench.parameters
    free = np.array(
        [p.start == "" and p.path not in program.structural_paths for p in program.parameters], dtype=np.bool_
    )
    factors = np.ones(len(free))
    factors[free] += size * np.random.default_rng(number).standard_normal(int(free.sum()))
    low, high = (
        np.array([inf if (x := getattr(p, which)) is None else x for p in program.parameters])
        for which, inf in (("lower", -np.inf), ("upper", np.inf))
    )
    moved = values * factors
    factors[(moved <= low) | (moved >= high)] = 1.0
    return factors


def estimate(bench: Bench, within: float, effort: Effort, alike: Estimate | None = None) -> Estimate:
    """The quantities of a train to a tenth of `within`, by a finer tolerance where it needs one; a mean of four runs where the
    motion scatters. alike: that of a train much alike. Where its motion scatters, this one is asked first, at no finer
    tolerance; where its quantities hardly do, two runs are a mean that leaves nothing open. Raises SimulationError."""
    coarse, made = bench.outcome(effort), 1
    first, asked = coarse, effort
    if alike is not None and alike.scattered:
        fine = bench.outcome(effort, perturbed(bench, DETECTS, made))
        made += 1
        if not _same_motion(coarse, fine, effort.rtol):
            if not _is_sure(alike, within):
                return _scattered(bench, fine, effort, coarse.stats, made)
            few = _like(alike, _scattered(bench, fine, effort, coarse.stats, made, _FEW))
            return few if _is_sure(few, within) else more_runs(bench, few, _LEAST)
    for number in range(_TRIES):
        finer = effort._replace(rtol=max(effort.rtol / FINER, 1e-12))
        fine = bench.outcome(finer, perturbed(bench, DETECTS, made))
        made += 1
        last = number == _TRIES - 1
        one_motion = _same_motion(coarse, fine, effort.rtol)
        settled = one_motion and _close(coarse.values, fine.values, within)
        if not settled and (
            last or not one_motion
        ):  # two accuracies are two motions: are parameters as little known, too?
            again = bench.outcome(finer, perturbed(bench, DETECTS if one_motion else SPREADS, made))
            made += 1
            if not _same_motion(fine, again, finer.rtol):
                effort, coarse = asked, first
                break
            settled = last and _close(fine.values, again.values, within)
        if settled:
            errors = np.maximum(2 * np.abs(fine.values - coarse.values), 2 * finer.rtol * np.abs(fine.values))
            return Estimate(fine.values, errors, np.empty((0, len(errors))), effort, coarse.stats, made)
        effort, coarse = finer, fine
    return _scattered(bench, fine, effort, coarse.stats, made)


def _scattered(bench: Bench, one: Outcome, effort: Effort, stats: Stats, made: int, runs: int = _LEAST) -> Estimate:
    """A mean of four runs, or so many; one: a run of `made` before."""
    return more_runs(bench, Estimate(one.values, one.values, one.values[None], effort, stats, made), runs)


def _like(alike: Estimate, few: Estimate) -> Estimate:
    """A mean of few runs, which may agree by chance, with an error no less than that of a train much alike by as many."""
    with np.errstate(invalid="ignore"):
        share = np.sqrt(len(alike.members) / len(few.members)) * alike.errors / np.abs(alike.values)
    return replace(few, errors=np.fmax(few.errors, share * np.abs(few.values)))


def _is_sure(found: Estimate, within: float) -> bool:
    """Whether a mean is known far better than it is asked for."""
    return bool(np.all(found.errors <= _SURE * within * np.abs(found.values)))


def more_runs(bench: Bench, found: Estimate, runs: int) -> Estimate:
    """An estimate of a motion that scatters, by so many runs in all. Raises SimulationError where many cannot go on."""
    members, failed = list(found.members), 0
    while len(members) < runs:
        try:
            changes = perturbed(bench, SPREADS, 1000 + len(members) + failed)
            members.append(bench.outcome(found.effort, changes).values)
        except SimulationError:
            failed += 1
            if failed > 1 + runs // 8:
                raise
    table = np.array(members)
    errors = _student(len(table)) * table.std(axis=0, ddof=1) / np.sqrt(len(table))
    errors += 2 * found.effort.rtol * np.abs(table.mean(axis=0))  # of each run, which more of them do not make smaller
    made = found.runs + len(table) - len(found.members)
    return replace(found, values=table.mean(axis=0), errors=errors, members=table, runs=made)


def _student(n: int) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(n - 1, 0.975))


def _close(one: Array, other: Array, within: float) -> bool:
    """Whether two accuracies agree. A value that neither has (NaN: an event that there is not) is one, too."""
    same = (one == other) | (np.isnan(one) & np.isnan(other))
    with np.errstate(invalid="ignore"):
        return bool(np.all(same | (np.abs(one - other) <= _SETTLED * within * np.abs(other))))


def _same_motion(one: Outcome, other: Outcome, rtol: float) -> bool:
    """Whether two runs show one motion: no output is off by a share of its own amplitude."""
    if not one.trace.size:
        return True
    off = np.sqrt(np.mean((one.trace - other.trace) ** 2, axis=1))
    amplitude, largest = other.trace.std(axis=1), np.abs(other.trace).max(axis=(0, 1))
    floor = np.maximum(_ROUNDING * rtol * largest, np.where(other.rates, _REST, 0.0))
    return not bool(np.any((off > _APART * amplitude) & (off > floor)))
