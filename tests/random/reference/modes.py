"""Which modes go on from a state: every set of them is tried, and looked at a short time ahead.

A set fits where, a short time later, nothing that is stuck exceeds its bounds and nothing slides against its direction. With
several that fit, the one that sticks most counts (a static peak holds what is at rest); otherwise there is no evidence.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from tests.random.reference.impacts import LEAVING, Impacts
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array

MOST = 3000  # sets of modes
ROUNDS = 1000  # of impacts at one instant


class Modes(Impacts):
    """Decides modes of a system."""

    def begin(self, t: float, y: Array) -> None:
        """After a start or a jump of the speeds: directions of what slides, and sides of laws that are far off."""
        self.note(y)
        _, v = self.qv(y)
        small, sw = self.small(), self.s.sw
        for d in self.s.dry:
            slip = float(d.row @ v)
            d.mode = 0 if abs(slip) <= small else 1 if slip > 0 else -1
        for g in self.s.lossy:
            w = float(g.ra @ v)
            g.mode = (0, 0) if abs(w) <= small else (1 if w > 0 else -1, g.mode[1])
        for _ in range(60):
            self.d.evaluate(t, y, margins=True)
            low = [] if sw.fresh else [i for i, margin in enumerate(sw.margins()) if margin < -1e-9]
            for i in low:
                sw.flip(i)
            if not low:
                break

    # -- deciding -----------------------------------------------------------------------------------------------------

    def impacts(self, t: float, y: Array) -> Array:
        """Impacts until no one-way lock turns backwards that was ahead before: a stop tells by its gap, a lock does not."""
        self.left = 0
        for _ in range(ROUNDS + LEAVING):
            hits, (_, v) = len(self.jumps), self.qv(y)
            y = self.impact(t, y)
            if len(self.jumps) > hits:
                for struck in self.s.sw.on_strike:
                    struck()
                self.begin(t, y)
            ahead = [m.scale * d.row for d in self.s.dry for m in d.members if m.on and m.one_way]
            _, w = self.qv(y)
            caught = any(float(row @ v) > self.small() and float(row @ w) < -self.small() for row in ahead)
            if not (caught or self.closes(y, 1e-10 if self.left else 1e-15)):
                return self._settled(t, y, 1e-15, always=True) if self.left else y
        raise NoEvidenceError("impacts without end")

    def decide(self, t: float, y: Array, span: float, starting: bool = False) -> Array:
        """Sets the modes for what follows t; the state, after impacts and without slip where something is stuck.

        starting: there were none before that could go on.
        """
        for part in (0.01, 0.03, 0.1) if self.most == 0.0 else ():
            self.force(t + part * span, y)
        self.force(t, y)
        self.free = self.most * float(np.abs(np.diag(self.s.Minv)).max(initial=0.0)) * span
        self.note(y)
        if self.d.plain:
            return y
        self.d.regular.clear()
        self.d.evaluate(t, y)  # engagements as they are
        hits = len(self.jumps)
        y = self.impacts(t, y)
        _, v = self.qv(y)
        smooth = len(self.jumps) == hits
        kept = self.kept(t, y) if smooth and not starting else None
        stays = self.stays(y, kept) if kept is not None else None
        ended = self.ended(y) if kept is not None else []
        broken = self.broken(t, y, ended) if kept is not None else []
        choices = self.choices(y, v)
        fits: list[tuple[Any, Array, Array]] = []
        alone = self.unique()
        # what comes back at once is decided by forces that a short look cannot tell from rounding
        for reach in np.array((1e-6, 1e-8, 1e-4) if self.still < 3 else (1e-4, 1e-3, 1e-5)) * span:
            total = math.prod(len(c) for c in choices)
            if total > MOST:
                raise NoEvidenceError(f"{total} sets of modes")
            for modes in itertools.product(*choices):
                found = self.fits(t, y, modes, reach, [len(c) > 1 for c in choices])
                if found is not None:
                    fits.append((modes, *found))
                    if alone:
                        break
            if fits:
                break
        if not fits:
            raise NoEvidenceError("no set of modes fits")
        modes, y, _ = self.chosen(self.driven(fits) if smooth and starting else fits, stays, ended, kept)
        if len(broken) > 1 and any(modes[i] == 0 for i in broken):
            raise NoEvidenceError("several static peaks that a jump of the load passes")
        self.set(modes)
        self.lock()
        return y

    def choices(self, y: Array, v: Array) -> list[list[Any]]:
        """Possible modes of every unit."""
        s, small = self.s, self.small()
        q, _ = self.qv(y)
        out: list[list[Any]] = []
        for d in s.dry:
            slip = float(d.row @ v)
            on = [m for m in d.members if m.on]
            if not on:
                out.append([2])
            elif abs(slip) > small:
                out.append([1 if slip > 0 else -1])
            else:
                barred = {-1 if m.scale > 0 else 1 for m in on if m.one_way}
                endless = any(m.dog or m.locked for m in on)
                out.append([0] if endless else [0, *(x for x in (1, -1) if x not in barred)])
        for stop in s.stops:
            gap, rate = float(stop.row @ q) - stop.bound, float(stop.row @ v)
            touching = abs(gap) <= 1e-10 * max(1.0, abs(stop.bound)) and abs(rate) <= small
            out.append([0, 1] if touching else [1])
        for g in s.lossy:
            w = float(g.ra @ v)
            _, _, tau1, tau2 = g.values(abs(w))
            sides = (1, 0, 2) if tau1 < tau2 else (1, 0)
            if abs(w) <= small:
                out.append([(0, 0), *((sign, side) for sign in (1, -1) for side in sides)])
            else:
                out.append([(1 if w > 0 else -1, side) for side in sides])
        return out

    def set(self, modes: tuple[Any, ...]) -> None:
        """Modes of all units."""
        for unit, mode in zip([*self.s.dry, *self.s.stops, *self.s.lossy], modes, strict=True):
            unit.mode = mode

    def lock(self) -> None:
        """Teeth of synchronizers go in where the cone sticks."""
        for d in self.s.dry:
            for m in d.members:
                if m.teeth is not None and m.on and d.mode == 0 and m.teeth(self.s.context) > 0:
                    m.locked = True

    def fits(
        self, t: float, y: Array, modes: tuple[Any, ...], reach: float, asked: list[bool]
    ) -> tuple[Array, Array] | None:
        """The projected state and its accelerations, if the modes that are asked for hold for that long."""
        self.set(modes)
        self.s.context.t = t
        y = self.project(t, y)
        first = self.d(t, y)
        acceleration = first[self.d.cut[1] : self.d.cut[2]]
        size = max(self.force(t, y), 1e-300)
        if self.hopeless(t, y, acceleration, size, asked):
            return None
        half = y + reach / 2 * first
        second = self.d(t + reach / 2, half)
        third = self.d(t + reach / 2, y + reach / 2 * second)
        fourth = self.d(t + reach, y + reach * third)
        later = y + reach / 6 * (first + 2 * second + 2 * third + fourth)
        margins = self.d.evaluate(t + reach, later, margins=True)[1]
        units = margins[len(self.s.sw.value) + 2 * len(self.s.iwan) :]
        size = max(self.force(t + reach, later), size)
        at, asked = 0, asked.copy()
        for d in self.s.dry:
            slip, high, low = units[at : at + 3]
            at += 3
            if not asked.pop(0):
                continue
            if d.mode == 0 and min(high, low) < -1e-9 * size:
                return None
            if abs(d.mode) == 1 and slip <= 1e-15 * self.speed:
                return None
        for stop in self.s.stops:
            gap, push = units[at : at + 2]
            at += 2
            if not asked.pop(0):
                continue
            if (stop.mode == 0 and push < -1e-9 * size) or (stop.mode == 1 and gap < -1e-13):
                return None
        for g in self.s.lossy:
            turn, drive, high, low = units[at : at + 4]
            at += 4
            if not asked.pop(0):
                continue
            if g.mode[0] == 0 and min(high, low) < -1e-9 * size:
                return None
            if g.mode[0] and min(drive, high) < -1e-9 * size:
                return None
            begins = abs(float(g.ra @ self.qv(y)[1])) <= self.small()  # what turns may come to rest within that time
            if g.mode[0] and begins and turn <= 1e-15 * self.speed:
                return None
        return y, acceleration

    def hopeless(self, t: float, y: Array, acceleration: Array, size: float, asked: list[bool]) -> bool:
        """Whether a set fails at once and by far, before it is looked at ahead."""
        margins = self.d.evaluate(t, y, margins=True)[1]
        units = margins[len(self.s.sw.value) + 2 * len(self.s.iwan) :]
        a = self.s.Ur @ acceleration
        light = float(
            np.abs(np.diag(self.s.Minv)).max(initial=0.0)
        )  # loads that cancel, and those of before, leave rounding
        rate = -max(1e-6 * float(np.abs(a).max(initial=0.0)), max(1e-10 * size, 1e-13 * self.most) * light, 1e-300)
        at = 0
        for asks, d in zip(asked, self.s.dry, strict=False):
            _, high, low = units[at : at + 3]
            at += 3
            if asks and (min(high, low) < -1e-5 * size or (abs(d.mode) == 1 and d.mode * float(d.row @ a) < rate)):
                return True
        for asks, stop in zip(asked[len(self.s.dry) :], self.s.stops, strict=False):
            push = units[at + 1]
            at += 2
            if asks and (push < -1e-5 * size or (stop.mode == 1 and float(stop.row @ a) < rate)):
                return True
        for asks, g in zip(asked[len(self.s.dry) + len(self.s.stops) :], self.s.lossy, strict=False):
            _, drive, high, low = units[at : at + 4]
            at += 4
            if asks and (
                min(high, low, drive) < -1e-5 * size or (g.mode[0] and g.mode[0] * float(g.ra @ a) < 0 > rate)
            ):
                w = g.mode[0] * float(g.ra @ self.qv(y)[1])
                if min(high, low, drive) < -1e-5 * size or (w <= self.small() and g.mode[0] * float(g.ra @ a) < rate):
                    return True
        return False

    def unique(self) -> bool:
        """Whether theory leaves no second motion: what sticks holds no more than what slides, and no gear loses."""
        members = [m for d in self.s.dry for m in d.members if m.on and not m.dog and not m.locked]
        return not self.s.lossy and not any(self.has_peak(m) for m in members)

    def force(self, t: float, y: Array) -> float:
        """A size of the forces, for rounding; where all of them vanish at once, that of those that there were."""
        size = self.d.load(t, y)
        self.most = max(self.most, size)
        return max(size, 1e-7 * self.most)

    def project(self, t: float, y: Array, moved: bool = True) -> Array:
        """Speeds without slip along what is active, and without that of rounding along what begins to slide.

        moved: what ties ask for over time counts.
        """
        s, small = self.s, self.small()
        q, v = self.qv(y)
        if s.nonlinear:  # ties read the time and the states of now
            self.d.coordinates(t, y)
        losses = [self.d._losses(g, float(g.ra @ v)) for g in s.lossy]
        G, _, _ = self.d.active(q, v, losses)
        begins = [d.row for d in s.dry if abs(d.mode) == 1 and abs(float(d.row @ v)) <= small]
        begins += [g.ra for g in s.lossy if g.mode[0] and abs(float(g.ra @ v)) <= small]
        if begins:
            G = np.vstack([G, *begins])
        if not len(G):
            return y
        slip, first = G @ v, len(G) - len(begins) - len(s.nonlinear)
        for i, n in enumerate(s.nonlinear if moved else (), first):
            slip[i] -= n.rate(q, v, s.context)[1]
        if not np.abs(slip).max() > 0:
            return y
        MG = s.Minv @ G.T
        try:
            return self.with_v(y, v - MG @ np.linalg.lstsq(G @ MG, slip, rcond=1e-11)[0])
        except np.linalg.LinAlgError:
            raise NoEvidenceError("locks that share a load") from None

    def kept(self, t: float, y: Array) -> list[Any]:
        """Of every unit the mode that it has and that it has not come to the end of; None for others."""
        margins = self.d.evaluate(t, y, margins=True)[1]
        units = margins[len(self.s.sw.value) + 2 * len(self.s.iwan) :]
        size, at, out = self.force(t, y), 0, []
        for d in self.s.dry:
            out.append(0 if d.mode == 0 and min(units[at + 1 : at + 3]) > 1e-7 * size else None)
            at += 3
        at += 2 * len(self.s.stops)
        out += [None] * len(self.s.stops)
        for g in self.s.lossy:
            out.append(g.mode if min(units[at + 1 : at + 4]) > 1e-7 * size else None)
            at += 4
        return out

    def broken(self, t: float, y: Array, ended: list[int]) -> list[int]:
        """Units that hold more than they slide with, and less than is asked of them now, or would be if what has come to slip
        no more held too: which of several lets go first, and what that leaves to the others, is told by the load on its way.
        """
        modes = [d.mode for d in self.s.dry]
        for i in ended:
            self.s.dry[i].mode = 0
        margins = self.d.evaluate(t, y, margins=True)[1]
        units, size = margins[len(self.s.sw.value) + 2 * len(self.s.iwan) :], self.force(t, y)
        for d, mode in zip(self.s.dry, modes, strict=True):
            d.mode = mode
        return [
            i
            for i, d in enumerate(self.s.dry)
            if d.mode == 0 and min(units[3 * i + 1 : 3 * i + 3]) < -1e-7 * size and any(map(self.has_peak, d.members))
        ]

    def stays(self, y: Array, kept: list[Any]) -> list[Any]:
        """The same where only what holds more than it slides with is kept, and what has come to slip no more is to stick.

        As a slip comes to an end its friction goes through all that the unit can hold: at the first force at which it
        slips no more it sticks. On the way whatever has no peak of its own holds or lets go as that force asks.
        """
        _, v = self.qv(y)
        out = list(kept)
        for i, d in enumerate(self.s.dry):
            if abs(d.mode) == 1 and abs(float(d.row @ v)) <= self.small():
                out[i] = 0
            elif not any(self.has_peak(m) for m in d.members if m.on):
                out[i] = None
        return out

    def ended(self, y: Array) -> list[int]:
        """Units that have come to slip no more.

        One of them sticks, whatever lets go for it, if that is a motion: its peak lasts as long as it sticks. Where all slip
        on, their peaks last for no time, and what is kept is kept.
        """
        v = self.qv(y)[1]
        return [i for i, d in enumerate(self.s.dry) if abs(d.mode) == 1 and abs(float(d.row @ v)) <= self.small()]

    def has_peak(self, member: Any) -> bool:
        """Whether it holds more than it slides with."""
        c = self.s.context
        return bool(-member.limits(c)[0] > member.sliding(c, 0.0) * (1 + 1e-12))

    def driven(self, fits: list[tuple[Any, Array, Array]]) -> list[tuple[Any, Array, Array]]:
        """At a start: a drives every gear of which both sides may hold, if that is a motion; else all that fit."""
        gears = slice(len(self.s.dry) + len(self.s.stops), None)

        def first(modes: tuple[Any, ...], y: Array) -> bool:
            v = self.qv(y)[1]
            losses = [g.values(abs(float(g.ra @ v))) for g in self.s.lossy]
            return all(m in ((0, 0), (m[0], 1)) or x[2] <= x[3] for m, x in zip(modes[gears], losses, strict=True))

        return [x for x in fits if first(x[0], x[1])] or fits

    def chosen(
        self, fits: list[tuple[Any, Array, Array]], stays: list[Any] | None, ended: list[int], kept: list[Any] | None
    ) -> tuple[Any, Array, Array]:
        """Of several sets that which sticks most; where that is not clear, of those that keep what is to be kept.

        That and the rule of what has ended may contradict each other: how far each is from its peak on the way would tell,
        which is not asked.
        """
        found = self._most(fits)
        if found is None and stays is not None and kept is not None:
            found = self._most(self._with(fits, stays))
            if found is None:
                stuck = [x for x in fits if any(x[0][i] == 0 for i in ended)]
                last = [x for x in (self._most(stuck), self._most(self._with(fits, kept))) if x is not None]
                if last and all(x[0] == last[0][0] for x in last):
                    found = last[0]
        if found is None:
            raise NoEvidenceError("several sets of modes fit")
        return found

    @staticmethod
    def _with(fits: list[tuple[Any, Array, Array]], given: list[Any]) -> list[tuple[Any, Array, Array]]:
        return [x for x in fits if all(k in (None, m) for k, m in zip(given, x[0], strict=True))]

    def _most(self, fits: list[tuple[Any, Array, Array]]) -> tuple[Any, Array, Array] | None:
        if not fits:
            return None
        best = max(fits, key=lambda x: self.stuck(x[0]))
        size = max(float(np.abs(best[2]).max(initial=0.0)), 1e-300)
        for other in fits:
            if np.abs(other[2] - best[2]).max(initial=0.0) <= 1e-7 * size:
                continue
            if not set(self.held(other[0])) < set(self.held(best[0])):
                return None
        return best

    def held(self, modes: tuple[Any, ...]) -> list[int]:
        """Units that stick or turn not; closed stops count as open ones."""
        n, m = len(self.s.dry), len(self.s.stops)
        out = [i for i in range(n) if modes[i] == 0]
        return out + [i for i in range(n + m, len(modes)) if modes[i] == (0, 0)]

    def stuck(self, modes: tuple[Any, ...]) -> int:
        """How many stick."""
        return len(self.held(modes))
