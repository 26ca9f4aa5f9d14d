"""Accelerations on frozen modes, and the margins that tell when a mode ends.

    M a = f + B l,    G a = gamma        G: rows of what is stuck, closed or tied; B: the directions in which they push

B differs from G' for gears with losses alone.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tests.random.reference.heat import heat_of_gears
from tests.random.reference.rubbing import merge
from tests.random.reference.sharing import Sharing
from tests.random.reference.switches import NoEvidenceError, is_zero
from tests.random.reference.system import Array, Dry, Lossy, Stop, System, derivative

NONE = math.inf  # margin of what is not asked


class Dynamics:
    """The right-hand side of a system: y = (qr, q1, vr, p, s)."""

    def __init__(self, system: System) -> None:
        self.s = s = system
        merge(s)
        for stop in s.stops:
            stop.row = stop.row @ s.N
        for gear in s.lossy:
            gear.ra, gear.rb = gear.ra @ s.N, gear.rb @ s.N
        speeds = [signal if kind == "speed" else derivative(signal) for signal, kind in s.prescribed.values()]
        self.drives = [s.compile(signal) for signal in speeds]
        self.pulls = [s.compile(derivative(signal)) for signal in speeds]
        self.driven_from = [s.compile(signal if kind == "angle" else 0.0) for signal, kind in s.prescribed.values()]
        self.nr, self.n1, self.np = s.Ur.shape[1], s.Z1.shape[1], s.P.shape[1]
        self.cut = np.cumsum([self.nr, self.n1, self.nr, self.np, s.extra]).tolist()
        self.cache: dict[Any, tuple[Array, Array, Array, Array | None]] = {}
        self.regular: set[Any] = set()
        self.RT = np.vstack([s.R, s.torque_rows]).T
        self.KC = np.hstack([s.K, s.C])
        self.RR = np.ascontiguousarray(s.R.T)
        self.signals = [signal for _, signal, _ in s.torques]
        self.constant = not s.nonlinear
        self.varying = [i for i, g in enumerate(s.lossy) if g.values(0.0) != g.values(1e3)]
        self.teeth = {id(m): k for m, k in getattr(s, "synchronizers", [])}
        self.lost: list[
            tuple[int, float]
        ] = []  # states of heat and what friction and gears lose, of the last evaluation
        self.plain = not (s.dry or s.stops or s.lossy or s.nonlinear)

    # -- one evaluation -----------------------------------------------------------------------------------------------

    def __call__(self, t: float, y: Array) -> Array:
        """y'; NaN where a trial state lies beyond the numbers, so that the step is tried again shorter."""
        try:
            return self.evaluate(t, y)[0]
        except ArithmeticError:
            return np.full(len(y), math.nan)

    def split(self, y: Array) -> list[Array]:
        """qr, q1, vr, p, s."""
        a, b, c, d, _ = self.cut
        return [y[:a], y[a:b], y[b:c], y[c:d], y[d:]]

    def coordinates(self, t: float, y: Array) -> tuple[Array, Array, Array, Array]:
        """q, v (without the part of Z2), rates of q1, and forces of springs and given torques."""
        s, c = self.s, self.s.context
        if not s.has_massless:
            q, v, force = self._read(t, y)
            values = [signal(c) for signal in self.signals]
            return q, v, np.zeros(0), force + s.C @ v + (s.torque_rows.T @ np.array(values) if values else 0.0)
        qr, q1, vr, p, extra = self.split(y)
        c.t, c.s = t, extra.tolist()
        q, v = s.Ur @ qr, s.Ur @ vr
        wp = np.array([d(c) for d in self.drives])
        c.X, c.V = (s.R @ q + s.RP @ p).tolist(), (s.R @ v + s.RP @ wp).tolist()
        for command in s.commands:
            command(c)
        push = s.torque_rows.T @ np.array([f(c) for f in self.signals]) if s.torques else np.zeros(len(q))
        q = q + s.Z1 @ q1
        if s.Z2.shape[1]:
            q = q + s.Z2 @ (s.K22 @ (s.Z2.T @ (push - s.K @ q - s.KP @ p)))
        elastic = push - s.K @ q - s.KP @ p
        if self.n1:
            v1 = s.C11 @ (s.Z1.T @ (elastic - s.C @ v - s.CP @ wp))
            return q, v + s.Z1 @ v1, v1, elastic - s.CP @ wp
        return q, v, np.zeros(0), elastic - s.CP @ wp

    def load(self, t: float, y: Array) -> float:
        """A size of the forces of springs, dampers, given torques and laws, for rounding."""
        _, v, _, given = self.coordinates(t, y)
        f = [0.0] * (self.RT.shape[1] + self.s.extra)
        for law in self.s.laws:
            law(self.s.context, f)
        laws = self.s.R.T @ np.array(f[: len(self.s.R)]) if len(self.s.R) else np.zeros(1)
        return sum(float(np.abs(x).max(initial=0.0)) for x in (given, self.s.C @ v, laws))

    def _read(self, t: float, y: Array) -> tuple[Array, Array, Array]:
        """q, v and the forces of springs and dampers where every direction has inertia; signals read this state from now on."""
        s, c, n = self.s, self.s.context, self.nr
        c.t, both = t, y[: 2 * n]
        q, v, XV = both[:n], both[n:], both.reshape(2, n) @ self.RR
        force = -(self.KC @ both)
        if s.extra:
            c.s = y[self.cut[3] :].tolist()
        if self.np:
            p, wp = y[self.cut[2] : self.cut[3]], np.array([d(c) for d in self.drives])
            XV = XV + np.array([s.RP @ p, s.RP @ wp])
            force = force - s.KP @ p - s.CP @ wp
        c.X, c.V = XV.tolist()
        for command in s.commands:
            command(c)
        return q, v, force

    def evaluate(self, t: float, y: Array, margins: bool = False) -> tuple[Array, list[float]]:
        """y' and, where asked, the margins."""
        s, c, rows = self.s, self.s.context, len(self.s.R)
        f = [0.0] * (self.RT.shape[1] + s.extra)
        if s.has_massless:
            q, v, v1, given = self.coordinates(t, y)
            force = given - s.C @ v
        else:
            q, v, force = self._read(t, y)
            for i, signal in enumerate(self.signals, rows):
                f[i] = signal(c)
        for law in s.laws:
            law(c, f)
        if self.np:
            force = force - s.MP @ np.array([a(c) for a in self.pulls])
        if self.RT.shape[1]:
            force = force + self.RT @ np.array(f[: self.RT.shape[1]])
        if self.plain:
            a, values = s.Minv @ force, []
        else:
            a, values = self._constrained(force, q, v, margins)
        if s.after:
            c.A = (s.R @ a).tolist()
            for law in s.after:
                law(c, f)
        for k, power in self.lost:
            f[-1 - k] += power
        rates = [v, a] if not s.has_massless else [y[self.cut[1] : self.cut[2]], v1, s.Ur.T @ a]
        if self.np:
            rates.append(np.array([d(c) for d in self.drives]))
        if s.extra:
            rates.append(np.array(f[: -1 - s.extra : -1]))
        dy = np.concatenate(rates)
        if not margins:
            return dy, values
        return dy, s.sw.margins() + [m for u in s.iwan for m in u.margins()] + values

    def margins(self, t: float, y: Array) -> list[float]:
        """The margins alone: where switches are all there is, no acceleration is needed."""
        s = self.s
        if not self.plain or s.has_massless:
            return self.evaluate(t, y, margins=True)[1]
        self._read(t, y)
        for signal in self.signals:
            signal(s.context)
        f = [0.0] * (self.RT.shape[1] + s.extra)
        for law in s.laws:
            law(s.context, f)
        for pull in self.pulls:
            pull(s.context)
        return s.sw.margins() + [m for u in s.iwan for m in u.margins()]

    # -- constraints --------------------------------------------------------------------------------------------------

    def _constrained(self, f: Array, q: Array, v: Array, margins: bool) -> tuple[Array, list[float]]:
        s, c = self.s, self.s.context
        numbers: list[Any] = []
        sliding = []
        self.lost = []
        for d in s.dry:
            f, more = self._rub(d, f, v)
            sliding.append(more)
        losses = [self._losses(g, float(g.ra @ v)) for g in s.lossy]
        for g, loss in zip(s.lossy, losses, strict=True):
            if g.mode[0]:
                f = f - g.ratio * loss[1] * g.rb
        key = (tuple([d.mode for d in s.dry]), tuple([x.mode for x in s.stops]), tuple([g.mode for g in s.lossy]))
        found = self.cache.get(key) if self.constant and not self.varying else None
        gamma = None
        if found is None:
            G, B, gamma = self.active(q, v, losses)
            found = self._solver(G, B, key)
        G, MB, W, null = found
        a = s.Minv @ f
        if len(G):
            wanted = -(G @ a) if gamma is None else gamma - G @ a
            numbers = (W @ wanted).tolist()
            a = a + MB @ np.array(numbers)
        if any(g.heat >= 0 for g in s.lossy):
            self.lost += heat_of_gears(s, v, numbers, losses)
        if not margins:
            return a, []
        if null is not None and gamma is not None and np.abs(G @ a - gamma).max() > 1e-8 * np.abs(wanted).max():
            return a, [-math.inf] * (
                3 * len(s.dry) + 2 * len(s.stops) + 4 * len(s.lossy)
            )  # no motion keeps all of them
        values = self._margins(q, v, numbers, sliding, losses, c)
        return a, values if null is None else self._shared(values, np.array(numbers), null)

    def active(self, q: Array, v: Array, losses: list[tuple[float, float]]) -> tuple[Array, Array, Array]:
        """G, B, gamma of what is active, in the order dry, stops, lossy gears, nonlinear ties."""
        s = self.s
        G, B, gamma = [], [], []
        for d in s.dry:
            if d.mode == 0:
                G.append(d.row)
                B.append(d.row)
                gamma.append(0.0)
        for stop in s.stops:
            if stop.mode == 0:
                G.append(stop.row)
                B.append(stop.row)
                gamma.append(0.0)
        for g, loss in zip(s.lossy, losses, strict=True):
            if g.mode[0]:
                G.append(g.ra - g.ratio * g.rb)
                B.append(g.ratio * g.rb if g.mode[1] == 2 else -g.ra + g.ratio * (1 - loss[0]) * g.rb)
                gamma.append(0.0)
            else:  # both sides stand: what enters at a, and what leaves at b without the ratio
                G += [g.ra, g.ratio * g.rb]
                B += [-g.ra, g.ratio * g.rb]
                gamma += [0.0, 0.0]
        for n in s.nonlinear:
            row, _, pull = n.rate(q, v, s.context)
            G.append(row)
            B.append(row)
            gamma.append(pull)
        n = len(q)
        return np.array(G).reshape(-1, n), np.array(B).reshape(-1, n), np.array(gamma)

    def _solver(self, G: Array, B: Array, key: Any) -> tuple[Array, Array, Array, Array | None]:
        MB = self.s.Minv @ B.T
        W = G @ MB
        if key in self.regular:  # since the last event; rows that turn with the angles hardly change that
            return G, MB, np.linalg.inv(W), None
        found = self.cache[key] = self._looked_at(G, MB, W)
        if found[3] is None:
            self.regular.add(key)
        return found

    def _looked_at(self, G: Array, MB: Array, W: Array) -> tuple[Array, Array, Array, Array | None]:
        if not len(G):
            return G, MB, W, None
        if not (high := np.abs(W).max(axis=1)).all():
            raise NoEvidenceError("a lock on what cannot move")
        scale = np.sqrt(high)
        if np.linalg.cond(W / np.outer(scale, scale)) < 1e10:
            return G, MB, np.linalg.inv(W), None
        W = W / np.outer(scale, scale)
        _, sizes, V = np.linalg.svd(W)
        free = sizes < 1e-10 * sizes.max()
        moves = np.abs(MB @ (null := (V[free] / scale).T)).max() > 1e-8 * (np.abs(MB) @ np.abs(null)).max()
        if free.sum() > 4 or moves:  # beside what loses by its load, how they share it tells the motion
            raise NoEvidenceError("locks that share a load")
        return G, MB, np.linalg.pinv(W, rcond=1e-10) / np.outer(scale, scale), null

    def _shared(self, values: list[float], numbers: Array, null: Array) -> list[float]:
        """More loads than the motion needs: the margin is how much room there is to share them within all bounds."""
        s, at = self.s, 0
        sharing = Sharing(numbers, null)
        places: list[int] = []
        for i, d in enumerate(s.dry):
            if d.mode == 0:
                low, high = self.limits(d)
                if sharing.bounded(at, low, high):
                    places += [3 * i + 1, 3 * i + 2]
                at += 1
        base = 3 * len(s.dry)
        for i, stop in enumerate(s.stops):
            if stop.mode == 0:
                if sharing.bounded(at, 0.0, math.inf):
                    places.append(base + 2 * i + 1)
                at += 1
        base += 2 * len(s.stops)
        for i, g in enumerate(s.lossy):
            if g.mode[0]:
                at += 1
                continue
            if sharing.gear(at, *g.values(0.0)):
                places += [base + 4 * i + 2, base + 4 * i + 3]
            at += 2
        if not places:
            return values
        room = sharing.room()
        for place in places:  # of all of them, as some may have no other mode
            values[place] = room
        return values

    def _rub(self, d: Dry, f: Array, v: Array) -> tuple[Array, float]:
        """Adds the sliding forces; every member's engagement and sliding law are looked at, so that switches stay fresh."""
        c, slip = self.s.context, float(d.row @ v)
        total = 0.0
        for m in d.members:
            self.engage(m)
            size = m.sliding(c, m.scale * slip if d.mode else 0.0)
            if m.on and not m.dog and d.mode in (1, -1):
                total -= d.mode * abs(m.scale) * size
                if m.heat >= 0:
                    self.lost.append((m.heat, abs(m.scale * slip) * size))
        return (f + total * d.row if total else f), slip

    def engage(self, m: Any) -> None:
        """Whether a friction element is pressed, by its frozen switch."""
        c, sw = self.s.context, self.s.sw
        pressed = m.switch < 0 or not sw(m.switch, -m.engaged(c))
        if m.teeth is not None:
            asked = not sw(self.teeth[id(m)], -m.teeth(c))
            m.locked = m.locked and asked
        m.on = pressed or m.locked

    def limits(self, d: Dry) -> tuple[float, float]:
        """Bounds of the group's force along its row."""
        low, high = 0.0, 0.0
        for m in d.members:
            if not m.on:
                continue
            a, b = (-math.inf, math.inf) if m.locked else m.limits(self.s.context)
            low += min(m.scale * a, m.scale * b)
            high += max(m.scale * a, m.scale * b)
        return low, high

    def _losses(self, g: Lossy, w: float) -> tuple[float, float]:
        """loss = first tau_a + second, in the gear's mode."""
        one, two, tau1, tau2 = g.values(abs(w) if g.mode[0] else 0.0)
        if g.mode[1] == 2:
            return 0.0, 0.0
        return (1 - one, g.mode[0] * tau1) if g.mode[1] else (1 - 1 / two, g.mode[0] * tau2)

    def _margins(
        self, q: Array, v: Array, numbers: list[float], slips: list[float], losses: list[Any], c: Any
    ) -> list[float]:
        s, at, out = self.s, 0, []
        for d, slip in zip(s.dry, slips, strict=True):
            low, high = self.limits(d)
            if d.mode == 0:
                out += [NONE, high - numbers[at], numbers[at] - low]
                at += 1
            else:
                out += [d.mode * slip if abs(d.mode) == 1 else NONE, NONE, NONE]
        for stop in s.stops:
            if stop.mode == 0:
                out += [NONE, numbers[at]]
                at += 1
            else:
                out += [float(stop.row @ q) - stop.bound, NONE]
        for g in s.lossy:
            tau = numbers[at]
            at += 1
            if g.mode[0]:
                w = float(g.ra @ v)
                out += [g.mode[0] * w, *self._side(g, w, tau)]
            else:
                high, low = self._rests(g, tau, numbers[at])
                at += 1
                out += [NONE, NONE, high, low]
        return out

    def _side(self, g: Lossy, w: float, force: float) -> list[float]:
        """Whether the side that is assumed to drive does; of a self-locking gear that b pushes on, a is pushed on as well."""
        sign, side = g.mode
        _, two, tau1, tau2 = g.values(abs(w))
        if side == 2:  # what leaves, between both bearing torques
            return [tau2 + sign * force, -tau1 - sign * force, NONE]
        return [sign * force if side else -math.copysign(1.0, two) * sign * force, NONE, NONE]

    def _rests(self, g: Lossy, tau: float, out: float) -> tuple[float, float]:
        """Room of a gear at rest before it turns forward, and backward, by what leaves; where both sides hold, a drives."""
        one, two, tau1, tau2 = g.values(0.0)
        if two < 0 or tau1 > tau2:
            ahead = (out + tau1) / one if out + tau1 >= 0 else two * (out + tau2)
            back = (out - tau1) / one if out - tau1 <= 0 else two * (out - tau2)
            return ahead - tau, tau - back
        loss = tau - out
        high = (1 - one) * tau + tau1 if tau >= 0 else (1 - 1 / two) * tau + tau2
        low = (1 - one) * tau - tau1 if tau <= 0 else (1 - 1 / two) * tau - tau2
        return high - loss, loss - low

    # -- results ----------------------------------------------------------------------------------------------------------

    def motion(self, t: float, y: Array, bodies: list[int]) -> tuple[Array, Array]:
        """Angles and speeds of nodes; NaN for a speed that only its rate of balance would give."""
        s = self.s
        q, v, _, _ = self.coordinates(t, y)
        p = y[self.cut[2] : self.cut[3]]
        wp = np.array([d(s.context) for d in self.drives])
        angles, speeds = s.N @ q + s.P @ p, s.N @ v + s.P @ wp
        for i in range(len(angles)):
            if s.Z2.shape[1] and not is_zero(s.N[i] @ s.Z2):
                speeds[i] = math.nan
        return angles[bodies], speeds[bodies]


__all__ = ["NONE", "Dynamics", "Stop"]
