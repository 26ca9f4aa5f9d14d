"""Neutral directions: moved along them the motion is as it was, from every state (a rigid turn, a free angle).

    M(y) e = e  for the map over a period at every y,  and again in what is left without them

Their multipliers are 1 and their exponents 0 by structure. So are those of an angle that a source of speed gives, which no
motion is beside. Found from the maps at several states, since one orbit may have a
multiplier of 1 by chance. Knows nothing of orbits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]

_SAME = 3e-8  # of the size of the maps: what they are told to
_SPLIT = 1e-6  # of 1: eigenvalues of neutral directions nearer to it are not split
_STATES = 3  # at which it is looked
_SPREAD = 0.1  # of the sizes: how far these lie apart
_WATCHED = 100  # periods, over which motions along them stay as far apart as they begin
_STAYS = 1e-8  # of that: 1e-10 a period
_RTOL = 1e-12
_RECORDS = (".impulse", ".impacts")
_SHARE = 0.05  # of its largest entry: what of a direction has a name


@final
@dataclass(frozen=True, slots=True, eq=False)
class Neutral:
    """basis: orthonormal directions in units of the sizes of the states, shape (n, p); rest: those orthogonal to them that
    lossy gears and sources of motion allow, (n, m); words: what each of the first moves, and what is given."""

    basis: Array
    rest: Array
    words: tuple[str, ...]

    @property
    def allowed(self) -> Array:
        """All directions that the train can move in, shape (n, p + m)."""
        return np.column_stack([self.basis, self.rest])

    def multipliers(self, scaled: Array) -> NDArray[np.complex128]:
        """Eigenvalues of a map over the states, in units of their sizes, without the p of the neutral directions; the largest
        first, shape (m,). Those next to 1 are theirs; where these are split by rounding (a free angle and its speed are a
        Jordan block) what is left is taken from the map without the directions."""
        p = self.basis.shape[1]
        every = np.linalg.eigvals(self.allowed.T @ scaled @ self.allowed)
        every = every[np.argsort(np.abs(every - 1.0))]
        if p and not abs(every[p - 1] - 1.0) < _SPLIT:
            every = np.concatenate([np.ones(p), np.linalg.eigvals(self.rest.T @ scaled @ self.rest)])
        own = every[p:]
        return own[np.argsort(-np.abs(own))].astype(np.complex128)

    def apart(self, off: Array) -> Array:
        """A difference of states, in units of their sizes, without what is along the directions: shape (m,)."""
        return self.rest.T @ off

    def resized(self, ratio: Array) -> Neutral:
        """The same directions where sizes are so many times as large, shape (n,)."""
        basis, _ = np.linalg.qr(self.basis / ratio[:, None])
        allowed, _ = np.linalg.qr(self.allowed / ratio[:, None])
        return Neutral(basis, allowed @ _null(basis.T @ allowed), self.words)


def scaled(strobe: Strobe, matrix: Array) -> Array:
    """A map in units of the sizes of the states."""
    return matrix * (strobe.scale[None, :] / strobe.scale[:, None])


def unclosed(seen: Strobe, off: Array, neutral: Neutral) -> Array:
    """What an orbit must not be off by of differences in sizes, shape (n, ...): along neutral directions angles and slips may
    go on, speeds may not."""
    found: Array = neutral.rest @ neutral.apart(off)
    speeds = [i for i, q in enumerate(seen.model.program.states) if q.kind == "speed"]
    found[speeds] += (neutral.basis @ (neutral.basis.T @ off))[speeds]
    return found


def neutral_directions(strobe: Strobe, y: Array) -> Neutral:
    """Those of a train, from maps over a period around the states y. Raises SimulationError."""
    rng = np.random.default_rng(0)
    allowed = _null(strobe.ties(y) * strobe.scale)
    maps = [scaled(strobe, strobe.map(y, 1).maps[-1])]
    for _ in range(4 * _STATES):
        if len(maps) == _STATES:
            break
        try:
            beside = y + _SPREAD * strobe.scale * (allowed @ rng.standard_normal(allowed.shape[1]))
            maps.append(scaled(strobe, strobe.map(beside, 1).maps[-1]))
        except SimulationError:  # a state that the train cannot be in
            continue
    return _without_given(strobe, maps, _neutral(strobe, maps, allowed))


def leaves(strobe: Strobe, y: Array, periods: int, neutral: Neutral) -> str:
    """What of a stable orbit of so many periods through y does not stay as it is along neutral directions, in words, or "":
    a speed on it, or how far motions beside it are off it. What maps do not tell shows in a hundred periods. Raises
    SimulationError."""
    if not neutral.basis.shape[1]:
        return ""
    fine, watched = strobe.finer(min(strobe.rtol, _RTOL)), periods * -(-_WATCHED // periods)
    here = fine.follow(y, watched).states[-1]
    is_speed = np.array([q.kind == "speed" for q in strobe.model.program.states])
    if np.abs(strobe.off(here, y)[is_speed]).max(initial=0.0) > _STAYS:
        return "a speed goes on growing or falling"
    for j, words in enumerate(neutral.words[: neutral.basis.shape[1]]):
        step, end = _beside(fine, y, _SPREAD * neutral.basis[:, j], watched)
        if end is None:
            return f"no motion can begin beside it, along the {words}"
        off = strobe.off(end, here) - step
        told = is_speed if np.abs(step[is_speed]).max(initial=0.0) > _SPLIT else np.ones(strobe.n, dtype=bool)  # shear
        if np.abs(off[told]).max(initial=0.0) > _STAYS * _SPREAD:
            return f"motions beside it, along the {words}, come nearer or go away"
    return ""


def _beside(strobe: Strobe, y: Array, step: Array, periods: int) -> tuple[Array, Array | None]:
    """Where a motion begun beside it comes to, and how far beside that was: the other way where the train cannot be there
    (a stop is in its way); None where it can be at neither."""
    for way in (step, -step):
        try:
            return way, strobe.follow(strobe.moved(y, way), periods).states[-1]
        except SimulationError:
            continue
    return step, None


def without_records(strobe: Strobe, y: Array, neutral: Neutral) -> Neutral:
    """The same with what stops record (the impulse of the last impact) as neutral where no rate reads it: whether an orbit
    strikes or not, it has then the same directions."""
    records = [i for i, q in enumerate(strobe.model.program.states) if q.name.endswith(_RECORDS)]
    if not records:
        return neutral
    others = np.setdiff1d(np.arange(strobe.n), records)
    read = np.abs(scaled(strobe, strobe.map(y, 1).maps[-1])[others]).max(axis=0, initial=0.0)
    unread = np.eye(strobe.n)[:, [i for i in records if read[i] < _SPLIT]]
    left, sizes, _ = np.linalg.svd(np.column_stack([neutral.basis, unread]), full_matrices=False)
    rows = unread.T @ neutral.rest
    rows[np.abs(rows) < _SPLIT] = 0.0
    return Neutral(left[:, sizes > _SPLIT], neutral.rest @ _null(rows), neutral.words)


def _null(rows: Array) -> Array:
    """Orthonormal directions that rows, shape (r, n), are zero along."""
    _, sizes, directions = np.linalg.svd(rows)
    found: Array = directions[int((sizes > 1e-12 * sizes.max(initial=0.0)).sum()) :].T
    return found


def _neutral(strobe: Strobe, maps: Sequence[Array], allowed: Array) -> Neutral:
    basis, rest = np.empty((strobe.n, 0)), allowed
    while rest.shape[1]:
        stack = np.vstack(
            [(rest.T @ m @ rest - np.eye(rest.shape[1])) / max(1.0, float(np.abs(m).max())) for m in maps]
        )
        _, sizes, rows = np.linalg.svd(stack)
        found = rows[sizes < _SAME].T
        if not found.shape[1]:
            break
        basis = np.column_stack([basis, rest @ found])
        rest = rest @ _null(found.T)
    return Neutral(basis, rest, tuple(_words(strobe, basis[:, j]) for j in range(basis.shape[1])))


def _without_given(strobe: Strobe, maps: Sequence[Array], found: Neutral) -> Neutral:
    """The same without angles that a source gives over time, whatever else moves: nothing of an orbit is beside it in these."""
    states = strobe.model.program.states
    given = [
        i
        for i, row in enumerate(np.eye(strobe.n))
        if states[i].kind == "angle"
        and np.abs(row @ found.rest).max(initial=0.0) > _SPLIT
        and max(float(np.abs(m[i] - row).max()) for m in maps) < _SAME
    ]
    if not given:
        return found
    words = tuple(f"given angle of {states[i].name.rsplit('.', 1)[0]}" for i in given)
    return Neutral(found.basis, found.rest @ _null(found.rest[given]), found.words + words)


def _words(strobe: Strobe, direction: Array) -> str:
    """What a direction moves."""
    direction = direction * strobe.scale
    moved = np.abs(direction) > _SHARE * np.abs(direction).max()
    states = [q for q, m in zip(strobe.model.program.states, moved, strict=True) if m]
    parts = dict.fromkeys(q.name.rsplit(".", 1)[0] for q in states)
    kind = "rigid turn of" if all(q.kind == "speed" for q in states) else "free angle of"
    return f"{kind} {', '.join(parts)}"
