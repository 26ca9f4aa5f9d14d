"""Steps of DOP853 (Hairer, Norsett and Wanner) for systems of a few states, where the overhead of scipy's solver counts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from tests.random.reference.system import Array

Rhs = Callable[[float, Array], Array]
STAGES = 12
A = [np.ascontiguousarray(DOP853.A[i, :i]) for i in range(STAGES)]
C = [float(c) for c in DOP853.C[:STAGES]]
MORE = [np.ascontiguousarray(row[: STAGES + 1 + i]) for i, row in enumerate(DOP853.A_EXTRA)]
MORE_C = [float(c) for c in DOP853.C_EXTRA]
B, E3, E5, D = (np.asarray(x) for x in (DOP853.B, DOP853.E3, DOP853.E5, DOP853.D))
ERRORS = np.array([E5[: STAGES + 1], E3[: STAGES + 1]])


class StepError(Exception):
    """The step size fell to nothing."""


class Piece:
    """One step and its dense output, whose three stages are computed where somebody asks."""

    def __init__(self, rhs: Rhs, t_old: float, t: float, y_old: Array, y: Array, K: Array) -> None:
        self.rhs, self.t_old, self.t, self.y_old, self.y, self.K = rhs, t_old, t, y_old, y, K
        self.F: Any = None

    def __call__(self, t: float) -> Array:
        return self._at((t - self.t_old) / (self.t - self.t_old))

    def many(self, t: Array) -> Array:
        """States at several times, one a row."""
        return self._at(((t - self.t_old) / (self.t - self.t_old))[:, None])

    def _at(self, x: Any) -> Array:
        if self.F is None:
            self.F = self._dense()
        factors = (x, 1 - x)
        y = self.F[6] * x
        for i in range(1, 7):
            y = (y + self.F[6 - i]) * factors[i % 2]
        return np.asarray(self.y_old + y)

    def middle(self) -> Array:
        """The state halfway, by the cubic of both ends."""
        h = self.t - self.t_old
        return np.asarray(0.5 * (self.y_old + self.y) + h / 8 * (self.K[0] - self.K[STAGES]))

    def _dense(self) -> Array:
        K, h = self.K, self.t - self.t_old
        for i, row in enumerate(MORE, STAGES + 1):
            K[i] = self.rhs(self.t_old + MORE_C[i - STAGES - 1] * h, self.y_old + (row @ K[:i]) * h)
        F, delta = np.empty((7, len(self.y))), self.y - self.y_old
        F[0], F[1], F[2] = delta, h * K[0] - delta, 2 * delta - h * (K[STAGES] + K[0])
        F[3:] = h * (D @ K)
        return F


class Steps:
    """Steps from (t, y) to `until`; the error of each is held to scale(y) by the usual two estimates."""

    def __init__(
        self, rhs: Rhs, t: float, y: Array, until: float, longest: float, scale: Callable[[Array], Array]
    ) -> None:
        self.rhs, self.t, self.y, self.until, self.longest, self.scale = rhs, t, y, until, longest, scale
        self.K = np.empty((STAGES + 4, len(y)))
        self.f = rhs(t, y)
        self.h = self._first()

    def _first(self) -> float:
        """Hairer's guess of the first step."""
        s = self.scale(self.y)
        room = min(self.until - self.t, self.longest)
        d0, d1 = (math.sqrt(float(np.mean((x / s) ** 2))) if len(s) else 0.0 for x in (self.y, self.f))
        h0 = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, room)
        later = self.rhs(self.t + h0, self.y + h0 * self.f)
        d2 = math.sqrt(float(np.mean(((later - self.f) / s) ** 2))) / h0 if len(s) and h0 > 0 else 0.0
        top = max(d1, d2)
        h1 = max(1e-6, h0 * 1e-3) if not top > 1e-15 else (0.01 / top) ** 0.125
        return min(100 * h0, h1, room) if math.isfinite(h1) else h0

    def step(self) -> Piece:
        """The next step, as short as its error asks."""
        K, t, y, f, tried = self.K, self.t, self.y, self.f, False
        while True:
            h, least = min(self.h, self.longest), 10 * math.ulp(t)
            if tried and h < least:
                raise StepError
            new = t + max(h, least)
            if new >= self.until:
                new = self.until
            h = new - t
            K[0] = f
            for i in range(1, STAGES):
                K[i] = self.rhs(t + C[i] * h, y + (A[i] @ K[:i]) * h)
            y_new = y + h * (B @ K[:STAGES])
            f_new = K[STAGES] = self.rhs(new, y_new)
            error = self._error(h, np.maximum(self.scale(y), self.scale(y_new)))
            if error < 1:
                factor = 10.0 if error == 0 else min(10.0, 0.9 * error**-0.125)
                self.h = h * (min(1.0, factor) if tried else factor)
                break
            self.h, tried = h * (max(0.2, 0.9 * error**-0.125) if error > 0 and math.isfinite(error) else 0.2), True
        self.t, self.y, self.f = new, y_new, f_new
        return Piece(self.rhs, t, new, y, y_new, K.copy())

    def _error(self, h: float, scale: Array) -> float:
        n = len(scale)
        if not n:
            return 0.0
        five, three = ((ERRORS @ self.K[: STAGES + 1]) / scale).tolist()
        e5, e3 = sum(x * x for x in five), sum(x * x for x in three)
        if e5 == 0 and e3 == 0:
            return 0.0
        return abs(h) * e5 / math.sqrt((e5 + 0.01 * e3) * n)
