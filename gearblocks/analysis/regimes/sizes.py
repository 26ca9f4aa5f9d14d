"""Sizes of the states of a motion, in which distances are told, and steps within which derivatives beside it are.

Knows nothing of what is looked for.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.drives import DRIVES, Drives, begun_at, drives
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.analysis.regimes.whole_turns import turns_of
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]

_SIZED, _PARTS = 4, 16  # periods that sizes are told from, and parts of each
_LOOKS = 8  # points at which the fastest motion is looked for
_BESIDE = 1e-4  # of the sizes
_UNSEEN = 1e-6  # of the largest state with the same unit: steps of differences are told from no less
_LEAST = 1e-3  # of what the states beside it carry into a state: less is their rounding, and no size of its own
_TERMS = 6  # of the series of exp over an eighth of the fastest motion
REACH = 2.0  # a step times the fastest rate: there order 8 is stable and right to 1e-3 in each step


class _Along(NamedTuple):
    """States and times of a motion."""

    y: Array
    times: Array


def sized(seen: Strobe, y: Array, after: int) -> Strobe:
    """The same with the sizes that the states come to within a few periods from y on, and steps within which the fastest of
    the motions beside these is told: a run whose own motion is slow takes steps in which derivatives along a fast one
    grow. after: as of `follow`."""
    states = _along(seen, y, after)
    turns = turns_of(seen, *states)
    size = np.abs(states.y).max(axis=0)
    size = np.where(turns > 0.0, np.minimum(size, turns), size)
    jacobians = _jacobians(seen, states, size)
    rates = np.array([np.linalg.eigvals(j) for j in jacobians])
    fastest, fading = float(np.abs(rates).max(initial=0.0)), float(-rates.real.min(initial=0.0))
    driven = np.max([_driven(j, size, seen.period) for j in jacobians], axis=0)
    scale = np.maximum(size, _LEAST * driven)
    scale = np.where(scale > 0.0, scale, 1.0)
    return replace(seen, scale=scale, turns=turns, max_step=REACH / max(fastest, 1e-300), fading=fading)


def turned(seen: Strobe, y: Array, after: int) -> Strobe:
    """The same with the whole turns by which the motion from y on may go on. after: as of `follow`."""
    return replace(seen, turns=turns_of(seen, *_along(seen, y, after)))


def _along(seen: Strobe, y: Array, after: int) -> _Along:
    states = np.vstack([y, seen.follow(y, _SIZED, after=after, parts=_PARTS).states])
    return _Along(states, seen.period * (after + np.arange(len(states)) / _PARTS))


class Settled(NamedTuple):
    """A sized model; states after so many periods, after a whole number of those of the drives; what acts there."""

    seen: Strobe
    y: Array
    passed: int
    drives: Drives


def settled(seen: Strobe, initial: Any, transient: int) -> Settled:
    """The same, sized by the motion after so many periods or a few more, and its states there."""
    y, passed = seen.start(initial), transient
    if transient:
        y = seen.follow(y, transient).states[-1]
    acts = drives(seen, y, DRIVES, passed)
    if acts.periods and (more := -passed % acts.periods):
        y, passed = seen.follow(y, more, after=passed).states[-1], passed + more
    seen = begun_at(sized(seen, y, passed), y, passed)
    return Settled(seen, seen.near(y), passed, acts)


def _jacobians(seen: Strobe, along: _Along, size: Array) -> list[Array]:
    """Rates by the states [1/s], at points along a motion, of which the first is one that a run begins at."""
    units = [q.unit for q in seen.model.program.states]
    alike = np.array([max(s for s, unit in zip(size, units, strict=True) if unit == own) for own in units])
    beside = _BESIDE * np.maximum(size, np.where(alike > 0.0, _UNSEEN * alike, 1.0))
    found = []
    full = np.zeros(seen.model.program.n_total)
    some = slice(None, None, len(along.y) // _LOOKS)
    for t, y in zip(along.times[some].tolist(), along.y[some], strict=True):
        full[: seen.n] = y
        columns = []
        try:
            with seen.opened(y, t) as sim:
                for j in range(seen.n):
                    step = np.zeros_like(full)
                    step[j] = beside[j]
                    ends = [sim.probe(t, full + sign * step, None, "rates")[: seen.n] for sign in (1, -1)]
                    columns.append((ends[0] - ends[1]) / (2 * step[j]))
        except SimulationError:  # it rests on a stop that moves, beyond it by what a run is off
            continue
        found.append(np.array(columns).reshape(seen.n, seen.n).T)
    return found


def _driven(jacobian: Array, size: Array, period: float) -> Array:
    """What a motion of these sizes carries into each state within a period: max |exp(J t)| size. Of one that grows by itself,
    in as long as it takes to grow by a factor of e."""
    values = np.linalg.eigvals(jacobian)
    end = period / max(1.0, period * float(values.real.max(initial=0.0)))
    halvings = max(0, int(np.ceil(np.log2(max(1.0, end * float(np.abs(values).max(initial=0.0)))))) + 2)
    step, found, flow = jacobian * end / 2.0**halvings, size, np.eye(len(size))
    for k in range(_TERMS, 0, -1):
        flow = np.eye(len(size)) + step @ flow / k
    for _ in range(halvings + 1):
        found = np.maximum(found, np.abs(flow) @ size)
        flow = flow @ flow
    return found
