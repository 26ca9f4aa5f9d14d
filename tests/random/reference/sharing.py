"""Loads that the motion leaves open: can locks and gears at rest share them within their bounds, and with how much room?

    l = l0 + null x;  room = max over x of the smallest margin, >= 0 where there is a way to share

Bounds of friction are linear in l; a gear with losses at rest has f-(tau) <= tau - out <= f+(tau) with one corner at tau = 0.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from tests.random.reference.switches import NoEvidenceError

Array = NDArray[np.float64]


class Sharing:
    """Margins as linear functions of x; of gears one set for either sign of what enters."""

    def __init__(self, numbers: Array, null: Array) -> None:
        self.l0, self.null = numbers, null
        self.lines: list[tuple[Array, float]] = []  # margin = a x + b
        self.gears: list[list[list[tuple[Array, float]]]] = []

    def _free(self, *places: int) -> bool:
        return bool(max(np.abs(self.null[i]).max() for i in places) > 1e-8 * np.abs(self.null).max())

    def bounded(self, i: int, low: float, high: float) -> bool:
        """low <= l[i] <= high; False where l[i] is known."""
        if not self._free(i):
            return False
        if np.isfinite(low):
            self.lines.append((self.null[i], self.l0[i] - low))
        if np.isfinite(high):
            self.lines.append((-self.null[i], high - self.l0[i]))
        return True

    def gear(self, i: int, eta1: float, eta2: float, tau1: float, tau2: float) -> bool:
        """Of l[i], what enters, and l[i + 1], what leaves; False where both are known."""
        if not self._free(i, i + 1):
            return False
        n, t, o = self.null, self.l0[i], self.l0[i + 1]
        if eta2 < 0:
            self.gears.append([_locking(n[i], t, n[i + 1], o, sign, eta1, eta2, tau1, tau2) for sign in (1, -1)])
            return True
        loss, lost = n[i] - n[i + 1], t - o
        cases = []
        for sign in (1, -1):
            up, high = (1 - eta1, tau1) if sign > 0 else (1 - 1 / eta2, tau2)
            down, low = (1 - 1 / eta2, -tau2) if sign > 0 else (1 - eta1, -tau1)
            cases.append([
                (sign * n[i], sign * t), (up * n[i] - loss, up * t + high - lost), (loss - down * n[i], lost - down * t - low),
            ])  # fmt: skip
        self.gears.append(cases)
        return True

    def room(self) -> float:
        """The best smallest margin over all signs."""
        best = -np.inf
        for choice in itertools.product(*self.gears):
            lines = self.lines + [line for case in choice for line in case]
            best = max(best, _largest(np.array([a for a, _ in lines]), np.array([b for _, b in lines])))
        return float(best)


def _locking(
    n: Array, t: float, m: Array, o: float, sign: int, eta1: float, eta2: float, tau1: float, tau2: float
) -> list[tuple[Array, float]]:
    """Lines of a self-locking gear, which holds by what leaves, m x + o, of one sign (without bearing torques between both)."""
    if tau1 or tau2:
        raise NoEvidenceError("a self-locking gear with bearing torques that shares a load")
    up, down = (1 / eta1, eta2) if sign > 0 else (eta2, 1 / eta1)
    return [(sign * m, sign * o), (up * m - n, up * o - t), (n - down * m, t - down * o)]


def _largest(a: Array, b: Array) -> float:
    """max over x of min(a x + b); at most a large number."""
    top = 10.0 * (1.0 + float(np.abs(b).max()))
    if a.shape[1] == 1:
        return _largest_on_a_line(a[:, 0], b, top)
    n = a.shape[1]
    found = linprog(
        np.r_[np.zeros(n), -1.0], A_ub=np.c_[-a, np.ones(len(a))], b_ub=b, bounds=[(None, None)] * n + [(None, top)],
        method="highs",
    )  # fmt: skip
    return float(found.x[-1]) if found.status == 0 else -top


def _largest_on_a_line(a: Array, b: Array, top: float) -> float:
    steep = np.abs(a) > 1e-12 * max(float(np.abs(a).max()), 1e-300)
    flat = float(b[~steep].min()) if (~steep).any() else top
    i, j = np.triu_indices(len(a), 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.concatenate([(b[j] - b[i]) / (a[i] - a[j]), (top - b[steep]) / a[steep]])
    x = x[np.isfinite(x)]
    if not len(x):
        return min(flat, top)
    return min(float((np.outer(x, a) + b).min(axis=1).max()), flat, top)
