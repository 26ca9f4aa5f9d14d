"""Phases of smooth motion by DOP853 at rtol 1e-11, between events that are bracketed by fine sampling."""

from __future__ import annotations

import math
from random import Random
from typing import Any

import numpy as np
from scipy.optimize import brentq

from tests.random.reference.dynamics import Dynamics
from tests.random.reference.modes import Modes
from tests.random.reference.steps import Piece, StepError, Steps
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array

MOST_EVENTS = 4000
MOST_STEPS = 60000
LOOKS = 6  # of a step at least, where a margin may come near 0
PHASE = 0.12  # rad of a wave between two looks
BEND = 5.0  # a margin this many times as large as what it bends by within a step does not reach 0
VERTICES = 6  # of parabolas, each through what the one before has told
KICKS = 10  # of a perturbed run, besides that of its start


class Integration:
    """One run of a system."""

    def __init__(
        self,
        dynamics: Dynamics,
        rtol: float,
        span: float,
        perturbation: float = 0.0,
        draw: int = 0,
        kicks: int = KICKS,
    ) -> None:
        self.d, self.modes, self.rtol, self.span = dynamics, Modes(dynamics), rtol, span
        self.scale = np.zeros(0)
        self.steps = 0
        self.perturbation = perturbation
        self.random = Random(f"kicks {dynamics.s.train.seed}" + f" {draw}" * (draw > 0))
        parts = [self.random.random() if draw else 0.53 for _ in range(kicks)]
        self.kicks = [span * (i + part) / kicks for i, part in enumerate(parts)] if perturbation else []
        self.alike, self.direction = draw > 0, np.zeros(0)  # of draws but the first all kicks go one way
        self.largest = np.zeros(0)  # of every state so far
        self.rises = np.zeros((0, 0))

    def run(self, y: Array, t: Array) -> tuple[Array, Array]:
        """Angles and speeds at the times t of all bodies, shape (bodies, len(t))."""
        d, s = self.d, self.d.s
        bodies = [s.index[p.node("a")] for p in s.train.bodies]
        angles, speeds = np.empty((len(bodies), len(t))), np.empty((len(bodies), len(t)))
        self.rises = np.empty((len(s.stores), len(t)))
        for _ in range(3):  # signals that read what others compute
            self.modes.begin(0.0, y)
        s.sw.fresh = False
        y = self.modes.decide(0.0, y, self.span, starting=True)
        now, done, events, still = 0.0, 0, 0, 0
        self.largest = np.abs(y)
        while done < len(t):
            if self.kicks and now >= self.kicks[0]:
                del self.kicks[0]
                y = self._kicked(now, y)
            until = self.kicks[0] if self.kicks else self.span
            if d.n1:  # stiff there: speeds follow from small differences, which the dense output does not keep
                until = min(until, float(t[min(done + (t[done] <= now), len(t) - 1)]))
            end, state, dense, which = self._phase(now, y, until)
            while done < len(t) and (t[done] < end or (t[done] <= end and which is None)):
                at = float(t[done])
                part = next((f for lo, hi, f in dense if lo <= at <= hi), None)
                value = state if at == end else (y if part is None else part(at))
                angles[:, done], speeds[:, done] = d.motion(at, value, bodies)
                self.rises[:, done] = s.rises(value[d.cut[3] :].tolist())
                done += 1
            if done >= len(t):
                break
            if which is None:
                now, y = end, state
                continue
            still = still + 1 if end - now <= 1e-13 * self.span else 0
            events += 1
            if events > MOST_EVENTS or still > 30:
                raise NoEvidenceError("events without end")
            self.modes.still = still
            now, y = end, self._event(end, state, which)
        return angles, speeds

    def _phase(self, now: float, y: Array, until: float) -> tuple[float, Array, list[Any], list[int] | None]:
        """Integrates until an event or the end."""
        dense: list[Any] = []
        solver = Steps(self.d, now, y, until, self.span / 100, self._allowed)
        before = None
        while solver.t < until:
            try:
                f = solver.step()
            except StepError:
                raise NoEvidenceError("the reference's step size fell to nothing") from None
            self.steps += 1
            if self.steps > MOST_STEPS:
                raise NoEvidenceError("too many steps")
            found, before = self._search(f, before)
            if found is not None:
                at, which = found
                dense.append((f.t_old, at, f))
                return at, f(at), dense, which
            dense.append((f.t_old, f.t, f))
            self.modes.note(solver.y)
            self.largest = np.maximum(self.largest, np.abs(solver.y))
        return until, solver.y, dense, None

    def _allowed(self, y: Array) -> Array:
        """Error of a step: a part of each state, and at its zeros of what angles, speeds and every other state have reached."""
        size, cut = np.maximum(self.largest, 1e-3), self.d.cut
        for i, j in ((0, cut[1]), (cut[1], cut[2])):
            if j > i:
                size[i:j] = size[i:j].max()
        return np.asarray(self.rtol * np.maximum(np.abs(y), 1e-2 * size))

    def _kicked(self, t: float, y: Array) -> Array:
        """Angles and speeds changed at random, relative to their largest values, within what is stuck and closed."""
        q, v = slice(0, self.d.cut[0]), slice(self.d.cut[1], self.d.cut[2])
        if not (self.alike and len(self.direction)):
            self.direction = np.array([self.random.uniform(-1, 1) for _ in y])
        change = self.perturbation * self.largest * self.direction
        turned, kicked = y.copy(), y.copy()
        turned[v] = change[q]  # a change of angles keeps the constraints as speeds do
        kicked[q] += self.modes.project(t, turned, moved=False)[v]
        kicked[v] += change[v]
        return self.modes.project(t, kicked)

    # -- events -------------------------------------------------------------------------------------------------------

    def _margins(self, t: float, y: Array) -> Array:
        values = np.array(self.d.margins(t, y))
        self._noted(values)
        return values

    def _noted(self, values: Array) -> None:
        """Keeps the largest value of every margin, for its rounding."""
        if len(self.scale) != len(values):
            self.scale = np.zeros(len(values))
        size = np.abs(values)
        size[~np.isfinite(size)] = 0.0
        self.scale = np.maximum(self.scale, size)

    def _search(self, f: Piece, first: Any) -> tuple[tuple[float, list[int]] | None, Any]:
        """The first event of a step, and the margins at its end; first: those at its begin, where they are known."""
        a, b = f.t_old, f.t
        waves = set(self.d.s.sw.phases)
        rate = sum(k * (1.0 if row < 0 else abs(self.d.s.context.V[row])) for row, k in waves)
        count = int(min(200, max(LOOKS, math.ceil((b - a) * rate / PHASE))))
        times = np.linspace(a, b, count + 1)
        if first is None:
            first = self._margins(a, f.y_old)
            jumped = self._negative(first)
            jumped = jumped[jumped < len(self.d.s.sw.value) + 2 * len(self.d.s.iwan)]
            if jumped.size:  # an impact has moved speeds over the limits of laws, perhaps for less than one look
                soon = a + min(1e-10 * self.span, 1e-3 * (b - a))  # what was located has left its surface by then
                jumped = np.intersect1d(jumped, self._negative(self._margins(soon, f(soon))))
            if jumped.size:
                return (a, jumped.tolist()), None
        if not len(first):
            return None, first
        if count == LOOKS:
            end = self._far(f, first)
            if end is not None:
                return None, end
        rows, looks = [first], f.many(times)
        for i in range(1, count + 1):
            rows.append(self._margins(float(times[i]), looks[i]))
            low = self._negative(rows[i])
            if low.size:
                found = self._locate(float(times[i - 1]), float(times[i]), f, rows[i - 1], low)
                return self._before(f, a, found, first) if i == 1 else found, None
            dip = (
                self._early(f, *times[:2], *rows) if i == 1 else self._dip(times[i - 2 : i + 1], rows[i - 2 : i + 1], f)
            )
            if dip is not None:
                return dip, None
        return None, rows[-1]

    def _far(self, f: Piece, first: Array) -> Array | None:
        """The margins at the end of a step along which all of them stay far from 0, by how much they bend; else None."""
        middle = self._margins(0.5 * (f.t_old + f.t), f.middle())
        end = self._margins(f.t, f.y)
        known = np.isfinite(first) & np.isfinite(middle) & np.isfinite(end)
        if not (known | (first == middle) & (middle == end)).all():
            return None
        low = np.minimum(np.minimum(first[known], middle[known]), end[known])
        bend = np.abs(first[known] - 2 * middle[known] + end[known])
        return end if bool((low > BEND * bend + 1e-6 * self.scale[known]).all()) else None

    def _negative(self, row: Array) -> Array:
        return np.flatnonzero(row < -self._rounding(len(row)))

    def _rounding(self, count: int) -> Array:
        """What a margin may differ from 0 by rounding."""
        s, gaps = self.d.s, count - 4 * len(self.d.s.lossy)
        size = 1e-11 * np.maximum(self.scale, self._least(count))
        if s.stops:  # gaps are exactly 0 after an impact, and the smallest bounces count
            places = slice(gaps - 2 * len(s.stops), gaps, 2)
            turned = self.modes.reach(self.largest)
            size[places] = 2e-15 * np.maximum(self.scale[places], 1e-3) + 2e-16 * turned
        return np.asarray(size)

    def _least(self, count: int) -> Array:
        """What has been nothing but rounding so far has no scale of its own: parts of the largest force and speed."""
        s, force, speed = self.d.s, 1e-2 * self.modes.most, 1e-4 * self.modes.speed
        units = [speed, force, force] * len(s.dry) + [0.0, force] * len(s.stops)
        units += [speed, force, force, force] * len(s.lossy)
        return np.array([0.0] * (count - len(units)) + units)

    def _dip(self, times: Any, rows: list[Array], f: Any) -> tuple[float, list[int]] | None:
        """A margin that may fall below zero and rise again between three looks: the vertex of its parabola."""
        r0, r1, r2 = rows
        with np.errstate(invalid="ignore"):
            lowest = (r1 <= r0) & (r1 <= r2) & np.isfinite(r0) & np.isfinite(r1) & np.isfinite(r2)
            near = r1 < 2.0 * np.maximum(r0 - r1, r2 - r1)
        for i in np.flatnonzero(lowest & near):
            at, values = self._lowest(i, tuple(times), (r0[i], r1[i], r2[i]), f)
            low = self._negative(values) if len(values) else values
            if low.size:
                left = float(times[0] if at <= times[1] else times[1])
                return self._locate(left, at, f, self._margins(left, f(left)), low)
        return None

    def _lowest(self, i: int, times: Any, looks: Any, f: Any) -> tuple[float, Array]:
        """The lowest place of margin i about the middle one of three looks, and all margins there: vertices of parabolas."""
        at, values = float(times[1]), np.zeros(0)
        for _ in range(VERTICES):
            (a, b, c), (ra, rb, rc) = times, looks
            bow = (rc - rb) / (c - b) - (rb - ra) / (b - a)
            slope = (rc - rb) / (c - b) * (b - a) + (rb - ra) / (b - a) * (c - b)
            if not bow > 0:
                break
            vertex = float(b - 0.5 * slope / bow)
            told = rb - 0.25 * slope**2 / (bow * (c - a))
            if not a < vertex < c or vertex == b:
                break
            at, values = vertex, self._margins(vertex, f(vertex))
            low = values[i]
            if low < 0 or low > 4 * abs(low - told) or self._negative(values).size:
                break
            if low < rb:
                times, looks = ((a, at, b), (ra, low, rb)) if at < b else ((b, at, c), (rb, low, rc))
            else:
                times, looks = ((at, b, c), (low, rb, rc)) if at < b else ((a, b, at), (ra, rb, low))
        return at, values

    def _early(self, f: Any, a: float, b: float, first: Array, second: Array) -> tuple[float, list[int]] | None:
        """A margin that falls as the step begins and is higher at its first look: the vertex of its parabola."""
        soon = a + 1e-4 * (b - a)
        if not soon > a:
            return None
        with np.errstate(invalid="ignore"):
            fall = (first - self._margins(soon, f(soon))) * ((b - a) / (soon - a))
            deep = (fall > first) & (second >= first) & np.isfinite(fall) & np.isfinite(second)
            deep &= first > self._rounding(len(first))
        for i in np.flatnonzero(deep):
            at = float(a + 0.5 * (b - a) * fall[i] / (second[i] - first[i] + fall[i]))
            low = self._negative(self._margins(at, f(at)))
            if low.size:
                return self._locate(a, at, f, first, low)
        return None

    def _before(self, f: Any, a: float, found: tuple[float, list[int]], first: Array) -> tuple[float, list[int]]:
        """What is found, or a margin that has fallen and risen again by then, as that of what bounces on another stop."""
        dip = self._early(f, a, found[0], first, self._margins(found[0], f(found[0])))
        return found if dip is None else dip

    def _locate(self, a: float, b: float, f: Any, before: Array, low: Array) -> tuple[float, list[int]]:
        """The first zero between a, where all is well, and b; looked at again at each zero for one that came before."""
        roots: dict[int, float] = {}
        for _ in range(20):
            for i in low.tolist():
                roots[i] = min(roots.get(i, b), self._zero(a, b, f, i, before[i]))
            b = min(roots.values())
            low = self._negative(self._margins(b, f(b)))
            low = np.array([i for i in low.tolist() if i not in roots or roots[i] > b + 1e-13 * self.span], dtype=int)
            if not low.size or b <= a:
                break
        return b, [i for i, at in roots.items() if at <= b + 1e-13 * self.span]

    def _zero(self, a: float, b: float, f: Any, i: int, before: float) -> float:
        tiny = float(self._rounding(len(self.scale))[i])
        if not before > tiny:  # it begins on its surface: it may leave it for a short while
            reach = b - a
            for _ in range(40):
                reach /= 2
                if self._one(a + reach, f, i) > tiny:
                    a += reach
                    break
            else:
                if not before > 0:
                    return self._leaves(a, b, f, i)
        if self._one(b, f, i) >= 0:
            return b
        return float(brentq(lambda x: self._one(float(x), f, i), a, b, xtol=1e-15 * self.span, rtol=8.9e-16))

    def _leaves(self, a: float, b: float, f: Any, i: int) -> float:
        """Where a margin that stays at 0 for a while (no load, nothing to hold) falls below; a where it does so at once."""
        low, high = a, b
        while high - low > 1e-14 * self.span:
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if i in self._negative(self._margins(middle, f(middle))):
                high = middle
            else:
                low = middle
        return low if low - a > 1e-9 * self.span else a

    def _one(self, t: float, f: Any, i: int) -> float:
        value = self._margins(t, f(t))[i]
        return float(value) if math.isfinite(value) else 1.0

    def _event(self, t: float, y: Array, which: list[int]) -> Array:
        s = self.d.s
        switches = len(s.sw.value)
        self.d.evaluate(t, y)
        for i in which:
            if i < switches:
                s.sw.flip(i)
            elif i < switches + 2 * len(s.iwan):
                unit = s.iwan[(i - switches) // 2]
                if unit.mode:
                    unit.mode = 0
                else:
                    unit.mode = 1 if (i - switches) % 2 == 0 else -1
            else:
                self._unit(i - switches - 2 * len(s.iwan))
        y = self._exact(t, y)
        self.d.evaluate(t, y)
        return self.modes.decide(t, y, self.span)

    def _unit(self, i: int) -> None:
        """Nothing but decisions follow from the margins of units."""

    def _exact(self, t: float, y: Array) -> Array:
        """The state as it is: events lie within rounding of their surface."""
        return y
