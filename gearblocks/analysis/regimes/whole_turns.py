"""Whole turns: by how much an angle may be turned so that the train is as it was, however often.

    f(t, y + g e_j) = f(t, y),   P(y + g e_j) = P(y) + g e_j

A motion that goes on by such turns repeats (a synchronous machine, a pendulum that goes round); the solver takes whole turns
off some angles by itself. Relative angles and states of blocks may be turned likewise; a state that is a number has turns of
1, too, and one that events alone read is told by maps. Knows nothing of orbits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import GearblocksError

Array = NDArray[np.float64]

_TURNED = ("angle", "coordinate", "state")
_MOVES = 0.5  # rad: an angle that stays below, and comes back, goes round nowhere
_DRIFTS = 0.01  # rad in the periods that are looked at
_MOST = 200  # turns, and parts of a turn (teeth), that are tried
_AHEAD = (1, -3, 1000)  # times that it is turned
_ASIDE = 0.61  # rad, beside the motion: where nothing is as it by chance
_ANY = 1.2345  # rad: a train that is as it was after that reads no angle
_FAR = 100.0  # times the rates: what pulls back so much over a thousand turns is no law of where in a turn it is
_LOOKS = 5
_ALIKE = 1e-8  # of the rates: the same
_FLOOR = 1e-10  # of the largest rate
_MAPPED = 1e-6  # of the sizes
_TOLD = 1e-8  # of the sizes: by maps alone
_OUT = 100.0  # rad, or a number: derivatives are differences over 1e-4 of it
_EVENLY = 2.0  # times as much in one half of the points as in the other, at the most


def turns_of(seen: Strobe, states: Array, times: Array) -> Array:
    """The least such turn [rad] of each state that goes round, shape (n,); 0 of others. states, times: of a motion, from one
    point of the section to another."""
    found, kinds = np.zeros(seen.n), seen.model.program.states
    looks = np.linspace(0, len(states) - 1, _LOOKS + 2).astype(int)[1:-1]
    for j in range(seen.n):
        moves, drifts = np.abs(states[:, j]).max(), abs(states[-1, j] - states[0, j])
        if kinds[j].kind in _TURNED and (moves > _MOVES or drifts > _DRIFTS):
            wholes = (2 * np.pi, 1.0) if kinds[j].kind == "state" and kinds[j].unit == "1" else (2 * np.pi,)
            turns = (_turn(seen, j, states[looks], times[looks], whole) for whole in wholes)
            found[j] = next((turn for turn in turns if turn), 0.0)
    return found


def goes_on(seen: Strobe, points: Array, neutral: Neutral) -> str:
    """The state, in words, that goes on far out without a turn that leaves the train as it is, though laws read it; or "".
    Laws bend over less there than what differences are taken over."""
    kinds, middle = seen.model.program.states, len(points) // 2
    first, second = (
        neutral.rest @ neutral.apart(seen.off(points[b], points[a])) * seen.scale
        for a, b in ((0, middle), (middle, -1))
    )
    for j in range(seen.n):
        at, ends = abs(points[-1, j]), sorted((abs(first[j]), abs(second[j])))
        evenly = first[j] * second[j] > 0.0 and ends[1] <= _EVENLY * ends[0]
        if kinds[j].kind in _TURNED and not seen.turns[j] and at > _OUT and evenly and sum(ends) > _MOVES:
            return (
                f"{kinds[j].name} goes on, to {points[-1, j]:.4g} so far, and no turn of it leaves the train as it is"
            )
    return ""


def in_turns(turn: float) -> float:
    """What a turn is told in: 2 pi, where it is a part of that or some of these, else 1."""
    parts = turn / (2 * np.pi) * np.arange(1, _MOST + 1)
    return 2 * np.pi if np.abs(parts - np.round(parts)).min() < _ALIKE else 1.0


def _turn(seen: Strobe, j: int, states: Array, times: Array, whole: float) -> float:
    here = [_rates(seen, t, y) for t, y in zip(times, states, strict=True)]
    if any(rates is None for rates in here):
        return 0.0
    size = np.abs(np.array(here)).max(axis=0, initial=1e-300)
    # a motion in step is always at one place of its law, where another one may be as it by chance
    aside = states + np.outer(_ASIDE * np.arange(1, len(states) + 1), np.arange(seen.n) == j)
    here += [_rates(seen, t, y) for t, y in zip(times, aside, strict=True)]
    looks = zip(np.tile(times, 2), np.vstack([states, aside]), here, strict=True)
    known = [(t, y, rates) for t, y, rates in looks if rates is not None]

    def same(turn: float) -> bool:
        step = np.zeros(seen.n)
        step[j] = turn
        for t, y, rates in known:
            allowed = np.maximum(_ALIKE * size, _FLOOR * max(float(np.abs(rates).max()), float(size.max())))
            for times_turned in _AHEAD:
                there = _rates(seen, t, y + times_turned * step)
                if there is None or (np.abs(there - rates) > allowed).any():
                    return False
        return True

    far = _rates(seen, times[0], states[0] + _AHEAD[-1] * whole * (np.arange(seen.n) == j))
    if far is None or np.abs(far - known[0][2]).max() > _FAR * size.max():
        return 0.0
    if same(_ANY):  # events alone may read it
        starts = [states[0], *aside[:2]]

        def same(turn: float) -> bool:
            return all(_mapped(seen, j, y, turn, ahead, _TOLD) for y in starts for ahead in _AHEAD)

        if same(_ANY):
            return 0.0
    turns = next((n for n in range(1, _MOST + 1) if same(n * whole)), 0)
    if not turns:
        return 0.0
    least, parts = turns * whole, 1
    for prime in (p for p in range(2, _MOST) if all(p % q for q in range(2, p))):
        while parts * prime <= _MOST * turns and same(least / (parts * prime)):
            parts *= prime
    return least / parts if _mapped(seen, j, states[0], least / parts, _AHEAD[-1], _MAPPED) else 0.0


def _mapped(seen: Strobe, j: int, y: Array, turn: float, times: int, least: float) -> bool:
    """Whether a period later, too, the motion is as it was but for so many turns."""
    ahead = np.zeros(seen.n)
    ahead[j] = times * turn
    try:
        here, there = (seen.follow(start, 1).states[-1] for start in (y, y + ahead))
    except GearblocksError:
        return False
    off = there - here - ahead
    off[j] -= turn * np.round(off[j] / turn)  # those that the solver takes off
    size = np.maximum(np.abs(here), np.abs(y)) + turn * (np.arange(len(y)) == j)
    return bool((np.abs(off) <= least * np.maximum(size, size.max())).all())


def _rates(seen: Strobe, t: float, y: Array) -> Array | None:
    """At an instant; None where no run can begin."""
    try:
        with seen.opened(y, t) as sim:
            full = sim.state()
            rates: Array = sim.probe(t, full, None, "rates")[: seen.n]
            return rates
    except GearblocksError:
        return None
