"""Impacts of a system: Newton's law at stops that close, and locks that close at once."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from tests.random.reference.dynamics import Dynamics
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array

LEAVING = 32


class Impacts:
    """Speeds after impacts, and what is known of speeds and forces so far."""

    def __init__(self, dynamics: Dynamics) -> None:
        self.d, self.s = dynamics, dynamics.s
        self.speed = 0.0  # largest speed so far
        self.free = 0.0  # speed that the largest forces would give to what is free, within the run
        self.most = 0.0  # largest force so far
        self.left = 0  # impacts at one instant beside a stop that a body was leaving
        self.still = 0  # events in a row at one instant
        self.jumps: list[float] = []
        self.rebound: dict[int, float] = {}

    # -- state --------------------------------------------------------------------------------------------------------

    def qv(self, y: Array) -> tuple[Array, Array]:
        """q and v of units."""
        qr, _, vr, _, _ = self.d.split(y)
        return self.s.Ur @ qr, self.s.Ur @ vr

    def with_v(self, y: Array, v: Array) -> Array:
        """y with other speeds."""
        y = y.copy()
        y[self.d.cut[1] : self.d.cut[2]] = self.s.Ur.T @ v
        return y

    def small(self) -> float:
        """A speed that counts as none."""
        return 1e-9 * max(self.speed, 1e-6 * self.free)

    def reach(self, largest: Array) -> Array:
        """The largest angles that the gap of every stop is the difference of."""
        q = np.abs(self.s.Ur) @ largest[: self.d.cut[0]]
        return np.array([float(np.abs(x.row) @ q) for x in self.s.stops])

    def note(self, y: Array) -> None:
        """Keeps the largest speed."""
        _, v = self.qv(y)
        self.speed = max(self.speed, float(np.abs(self.s.N @ v).max(initial=0.0)))
        self.s.context.small = self.small()

    def impact(self, t: float, y: Array) -> Array:
        """Newton's law at stops that close, plastic locks; several at once as one complementarity problem.

        v+ = v + M^-1 G' P,  P >= 0,  G v+ >= target,  P (G v+ - target) = 0; locks without limit: G v+ = 0.
        """
        s, small = self.s, self.small()
        endless, leaving = self.left > LEAVING, self.leaving(t, y)
        q, v = self.qv(y)
        one: list[tuple[Array, float, int]] = []
        both: list[tuple[Array, float]] = []
        heats: list[int] = []  # of what is in `both`, then of what is in `one`: the states that count what each loses
        heats_of_one: list[int] = []
        hit = False
        doubtful: list[int] = []  # of `one`: locks that have begun to slip, by less than counts
        for i, stop in enumerate(s.stops):
            gap, rate = float(stop.row @ q) - stop.bound, float(stop.row @ v)
            if gap <= 1e-10 * max(1.0, abs(stop.bound)) and rate <= small:
                closing = rate < -small
                hit = hit or closing
                if i not in leaving:
                    one.append((stop.row, -stop.restitution * rate if closing and not endless else 0.0, i))
                    heats_of_one.append(stop.heat)
        for d in s.dry:
            slip = float(d.row @ v)
            on = [m for m in d.members if m.on]
            if any(m.dog or m.locked for m in on):
                both.append((d.row, 0.0))
                heats.append(_heat_of([m for m in on if m.dog or m.locked]))
                hit = hit or abs(slip) > small
            # what is ahead is caught in the next round; two that lock against each other hold both ways
            locks_of = [m for m in on if m.one_way and m.scale * slip <= small]
            hit = hit or any(m.scale * slip < -small for m in locks_of)
            for way in {math.copysign(1.0, m.scale) for m in locks_of}:
                doubtful += [len(one)] if d.mode != 0 and 1e-14 * self.speed < way * slip <= small else []
                one.append((way * d.row, 0.0, -1))
                heats_of_one.append(_heat_of([m for m in locks_of if m.scale * way > 0]))
        if not hit:
            return self._settled(t, y, 1e-15) if self.still > 1 else y
        self._refuse_hair_gaps(t, y)
        self.left += bool(leaving)
        both += [n.rate(q, v, s.context)[:2] for n in s.nonlinear]
        both += [(g.ra - g.ratio * g.rb, 0.0) for g in s.lossy]  # no loss in an impact
        self.jumps.append(t)
        heats += [-1] * (len(both) - len(heats)) + heats_of_one
        self._refuse_doubtful_locks(v, one, both, doubtful)
        y, v = self._struck(y, v, one, both, heats)
        died = False
        for row, target, i in one:
            if i >= 0 and target > 0:
                fast = self.rebound[i] = max(self.rebound.get(i, 0.0), target)
                flat = 1e-13 if target < 1e-3 * fast else 1e-16
                if self._dies(t, self.with_v(y, v), row, float(row @ v), i, flat):
                    y, v = self._struck(y, v, [(row, 0.0, -1)], [(row, 0.0), *both], [s.stops[i].heat])
                    died = True
        y = self.onto(self.with_v(y, v), [s.stops[i] for _, target, i in one if i >= 0 and target > 0])
        y = self._settled(t, y, 1e-13) if died else y  # what its end throws off its stop
        self.note(y)
        return y

    def _refuse_hair_gaps(self, t: float, y: Array) -> None:
        """What a cascade left of speeds that count as none opens stops by next to nothing until something strikes there, or
        by nothing at all and nothing presses on them: as if they touched, or one after the other, nobody here can tell."""
        q, v = self.qv(y)
        for i, stop in enumerate(self.s.stops):
            gap, unit = float(stop.row @ q) - stop.bound, 1e-10 * max(1.0, abs(stop.bound))
            if not (gap < 1e3 * unit and abs(float(stop.row @ v)) <= 10 * self.small()):
                continue
            bounced = self.rebound.get(i, 0.0) > 0.0 and stop.mode == 0
            if gap > unit or (bounced and self._is_idle(t, y, stop.row)):
                raise NoEvidenceError("a strike beside a stop that is hardly open")

    def _is_idle(self, t: float, y: Array, row: Array) -> bool:
        """Nothing presses what rests on a stop against it: it would stay there by itself."""
        modes = [stop.mode for stop in self.s.stops]
        for stop in self.s.stops:
            stop.mode = 1 if stop.row is row else stop.mode
        rates = self.s.Ur @ self.d(t, y)[self.d.cut[1] : self.d.cut[2]]
        for stop, mode in zip(self.s.stops, modes, strict=True):
            stop.mode = mode
        largest = self.most * float(np.abs(np.diag(self.s.Minv)).max(initial=0.0))  # acceleration so far
        return abs(float(row @ rates)) <= 1e-9 * largest

    def _refuse_doubtful_locks(
        self, v: Array, one: list[tuple[Array, float, int]], both: list[tuple[Array, float]], doubtful: list[int]
    ) -> None:
        """A strike after so short a flight that a lock has slipped by next to nothing: with it at once, or the lock after it
        (which ends otherwise), nobody here can tell."""
        if doubtful:
            first = self._impulse(v, [o for k, o in enumerate(one) if k not in doubtful], both)[0]
            if np.abs(first - self._impulse(v, one, both)[0]).max() > 1e-7 * self.speed:
                raise NoEvidenceError("a strike beside a lock that hardly slips")

    def _struck(
        self, y: Array, v: Array, one: list[tuple[Array, float, int]], both: list[tuple[Array, float]], heats: list[int]
    ) -> tuple[Array, Array]:
        """y with the heat of impulses, and the speeds after them: each loses -P (slip before + slip after)/2, in all the energy
        that goes lost. heats: states that count it, of what is in `both`, then in `one` (none: -1)."""
        after, P = self._impulse(v, one, both)
        rows = [*(row for row, _ in both), *(o[0] for o in one)]
        for k, row, impulse in zip(heats, rows, P, strict=False):
            if k < -1:
                raise NoEvidenceError("heat of what strikes in locks side by side")
            if k >= 0:
                y = y.copy()
                y[self.d.cut[3] + k] -= 0.5 * float(impulse) * float(row @ (v + after))
        return y, after

    def leaving(self, t: float, y: Array) -> set[int]:
        """Stops at which a body rests from which it is pulled away: what strikes it does so when it has left.

        None at the start, nor where such strikes have no end: then all that touches comes to rest on each other.
        """
        q, v = self.qv(y)
        small, found = self.small(), set()
        for i, stop in enumerate(self.s.stops):
            touches = abs(float(stop.row @ q) - stop.bound) <= 1e-10 * max(1.0, abs(stop.bound))
            if t > 0 and self.left <= LEAVING and stop.mode == 1 and touches and abs(float(stop.row @ v)) <= small:
                rates = self._rates_off(t, y, stop.row)
                if float(stop.row @ rates) > 1e-9 * float(np.abs(stop.row) @ np.abs(rates)):
                    found.add(i)
        return found

    def _rates_off(self, t: float, y: Array, row: Array) -> Array:
        """Accelerations in which whatever sticks slips, the way that leaves a stop: who is held at it by friction is not
        pulled away."""
        push = self.s.Minv @ row
        stuck = [d for d in self.s.dry if d.mode == 0 and not any(m.on and m.dog for m in d.members)]
        for d in stuck:
            way = float(d.row @ push)
            d.mode = int(np.sign(way)) if abs(way) > 1e-12 * float(np.abs(d.row) @ np.abs(push)) else 0
        rates = self.s.Ur @ self.d(t, y)[self.d.cut[1] : self.d.cut[2]]
        for d in stuck:
            d.mode = 0
        return rates

    def closes(self, y: Array, gap: float) -> bool:
        """Whether a body moves into a stop at which it is: no gap comes to zero any more that tells. Where it bounces between
        two stops and comes to an end at both, the last flights are shorter than a gap can be told."""
        q, v = self.qv(y)
        gaps = [(float(x.row @ q) - x.bound) / max(1.0, abs(x.bound)) for x in self.s.stops]
        return any(g <= gap and float(x.row @ v) < -self.small() for g, x in zip(gaps, self.s.stops, strict=True))

    def _dies(self, t: float, y: Array, row: Array, speed: float, i: int, flat: float) -> bool:
        """Whether a body comes back to its stop so soon that only rounding would be seen of its flight, or nothing at all."""
        stop = self.s.stops[i]
        if stop.restitution >= 1 and flat > 1e-14:
            return False
        stop.mode = 1
        rate = float(row @ self.s.Ur @ self.d(t, y)[self.d.cut[1] : self.d.cut[2]])
        turned = float(np.abs(row) @ np.abs(self.qv(y)[0]))
        return speed * speed < -2 * flat * rate * max(abs(stop.bound), turned if flat < 1e-13 else 0.0, 1e-3)

    def _settled(self, t: float, y: Array, flat: float, always: bool = False) -> Array:
        """Without flights that are lower than the rounding of their gap: nothing is seen of them but that time stands."""
        q, v = self.qv(y)
        rows, flies = [], False
        for i, stop in enumerate(self.s.stops):
            gap, rate = float(stop.row @ q) - stop.bound, float(stop.row @ v)
            if abs(gap) > 1e-10 * max(1.0, abs(stop.bound)):
                continue
            if rate > self.small() and self._dies(t, y, stop.row, rate, i, flat):
                rows.append((stop.row, 0.0))
                flies = True
            elif abs(rate) <= self.small():
                rows.append((stop.row, 0.0))
        if not rows or not (flies or always):
            return y
        rows += [n.rate(q, v, self.s.context)[:2] for n in self.s.nonlinear]
        rows += [(g.ra - g.ratio * g.rb, 0.0) for g in self.s.lossy]
        G, asked = np.array([row for row, _ in rows]), np.array([x for _, x in rows])
        MG = self.s.Minv @ G.T
        return self.with_v(y, v - MG @ np.linalg.lstsq(G @ MG, G @ v - asked, rcond=1e-11)[0])

    def onto(self, y: Array, stops: list[Any]) -> Array:
        """Gaps of rounding become 0, so that the smallest bounces leave their stop."""
        q, _ = self.qv(y)
        y = y.copy()
        for stop in stops:
            push = self.s.Minv @ stop.row
            q = q - push * (float(stop.row @ q) - stop.bound) / float(stop.row @ push)
        y[: self.d.cut[0]] = self.s.Ur.T @ q
        return y

    def _impulse(
        self, v: Array, one: list[tuple[Array, float, int]], both: list[tuple[Array, float]]
    ) -> tuple[Array, Array]:
        """The speeds after the impulses, and these: along `both`, then along `one`."""
        if len(one) > 8:
            raise NoEvidenceError("too many contacts at once")
        size = self.speed
        found: list[tuple[Array, Array]] = []
        for active in itertools.product((False, True), repeat=len(one)):
            rows = [*(row for row, _ in both), *(o[0] for o, a in zip(one, active, strict=True) if a)]
            target = np.array([x for _, x in both] + [o[1] for o, a in zip(one, active, strict=True) if a])
            new, P = v, np.zeros(0)
            if rows:
                G = np.array(rows)
                MG = self.s.Minv @ G.T
                W = G @ MG
                if np.linalg.cond(W) > 1e11:
                    continue
                P = np.linalg.solve(W, target - G @ v)
                new = v + MG @ P
            scale = 1e-10 * size
            if (P[len(both) :] >= 0).all() and all(float(r @ new) >= x - scale for r, x, _ in one):
                every = np.zeros(len(both) + len(one))
                every[[True] * len(both) + list(active)] = P
                found.append((new, every))
        if not found:
            raise NoEvidenceError("no impulse fits")
        if any(np.abs(f - found[0][0]).max() > 1e-7 * max(size, 1e-300) for f, _ in found):
            raise NoEvidenceError("several impulses fit")
        return found[0]


def _heat_of(members: list[Any]) -> int:
    """The state that counts the heat of what locks: -1 none, -2 that of one of several that share their impulse."""
    heats = {m.heat for m in members}
    return -2 if len(members) > 1 and heats != {-1} else heats.pop()
