"""Independent runs of bodies under dry friction: modes by enumeration, scipy between the events."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

REST, ABSENT = 1e-9, 9


@dataclass
class Friction:
    """A force q against the slip g v. law(t, y, slip, d, stuck): by branch (c, {j: k}, c', {j: k'}): q = c + sum k q_j where
    c' + sum k' q_j >= 0, for the side d = 1 or -1; stuck: what it holds. sides: those that it may slide to; present: whether
    it is there at all (a stop that is touched)."""

    g: Sequence[float]
    law: Callable[..., list[tuple[float, dict[int, float], float, dict[int, float]]]]
    sides: tuple[int, ...] = (-1, 1)
    present: Callable[[float, Any], bool] = lambda _t, _y: True


def dry(
    capacity: Callable[[float, Any, float], float], peak: float = 1.0, sides: tuple[int, ...] = (-1, 1)
) -> Friction:
    """The law of Coulomb friction, to be given a slip."""

    def law(t: float, y: Any, slip: float, d: int, stuck: bool) -> Any:
        return [(d * capacity(t, y, slip) * (peak if stuck else 1.0), {}, 1.0, {})]

    return Friction((), law, sides)


@dataclass
class Bodies:
    """M v' = f(t, y) - G' q, y = (x, v, others); corners(t, y): whose signs stop a run; impact(y): in place."""

    M: Any
    f: Callable[[float, Any], Any]
    frictions: Sequence[Friction] = ()
    corners: Callable[[float, Any], Sequence[float]] = lambda _t, _y: ()
    others: Callable[..., Sequence[float]] = lambda *_: ()
    impact: Callable[[Any], None] = lambda _y: None

    def slips(self, y: Any) -> Any:
        n = len(self.M)
        return [float(np.dot(x.g, y[n : 2 * n])) for x in self.frictions]

    def solved(self, t: float, y: Any, modes: Any) -> tuple[Any, Any]:
        """Accelerations and friction forces in these modes, each (side, branch)."""
        n, k, slips = len(self.M), len(self.frictions), self.slips(y)
        A, b = np.zeros((n + k, n + k)), np.zeros(n + k)
        A[:n, :n], b[:n] = np.diag(self.M), self.f(t, y)
        for i, (x, (side, branch)) in enumerate(zip(self.frictions, modes, strict=True), n):
            A[:n, i] = x.g
            if side == 0:
                A[i, :n] = x.g
                continue
            A[i, i] = 1.0
            if side != ABSENT:
                b[i], gains = x.law(t, y, abs(slips[i - n]), side, False)[branch][:2]
                for j, gain in gains.items():
                    A[i, n + j] -= gain
        try:
            found = np.linalg.solve(A, b)
        except np.linalg.LinAlgError:  # what stands at a stop sticks there too
            found = np.linalg.lstsq(A, b, rcond=None)[0]
        return found[:n], found[n:]

    def margins(self, t: float, y: Any, modes: Any, *, begins: bool) -> list[float]:
        """What stays >= 0 while the modes hold; begins: slips of zero by their acceleration."""
        (a, q), slips, out = self.solved(t, y, modes), self.slips(y), []
        spare = 0.0 if begins else 1e-12

        def of(c: float, gains: dict[int, float]) -> float:
            return c + sum(gain * q[j] for j, gain in gains.items())

        for i, (x, (side, branch)) in enumerate(zip(self.frictions, modes, strict=True)):
            if side == 0:
                for d in x.sides:
                    branches = x.law(t, y, 0.0, d, True)
                    held = next((of(c, k) for c, k, c2, k2 in branches if of(c2, k2) >= -1e-12), of(*branches[0][:2]))
                    out.append(d * (held - q[i]) + spare)
            elif side != ABSENT:
                branches = x.law(t, y, abs(slips[i]), side, False)
                out += [of(*branches[branch][2:])] if len(branches) > 1 else []
                if not begins:
                    out.append(side * slips[i] + spare)
                elif abs(slips[i]) < REST:
                    out.append(side * float(np.dot(x.g, a)))
        return out

    def rate(self, t: float, y: Any, modes: Any) -> Any:
        n, (a, q) = len(self.M), self.solved(t, y, modes)
        return np.concatenate([y[n : 2 * n], a, self.others(t, y, q, self.slips(y), modes)])

    def modes(self, t: float, y: Any, h: float = 1e-7) -> Any:
        """Those that hold now and a moment later, most of them stuck."""
        choices = []
        for x, slip in zip(self.frictions, self.slips(y), strict=True):
            sides = [int(np.sign(slip))] if abs(slip) > REST else [0, *x.sides]
            sides = sides if x.present(t, y) else [ABSENT]
            some = [(s, len(x.law(t, y, abs(slip), s, False)) if s not in (0, ABSENT) else 1) for s in sides]
            choices.append([(s, branch) for s, number in some for branch in range(number)])
        found = []
        for modes in itertools.product(*choices):
            if min(self.margins(t, y, modes, begins=True), default=0.0) > -1e-9:
                later = min(self.margins(t + h, y + h * self.rate(t, y, modes), modes, begins=False), default=0.0)
                still = sum(side in (0, ABSENT) for side, _ in modes)
                found.append((later >= -1e-13, still if later >= -1e-13 else later, modes))
        return max(found)[2]

    def run(self, y0: Any, t: Any, jumps: Sequence[float] = (), max_step: float = np.inf) -> Any:
        """Rows of y at the times t; jumps: times at which f or a capacity does."""
        t, y, at, n = np.asarray(t, float), np.array(y0, float), float(t[0]), len(self.M)
        rows = np.empty((len(t), len(y)))
        while at < t[-1] - 1e-15:
            modes, until = self.modes(at, y), min(x for x in (*jumps, t[-1]) if x > at + 1e-14)
            side = np.sign(self.corners(at, y + 1e-9 * self.rate(at, y, modes)))

            def watched(time: float, state: Any, modes: Any = modes, side: Any = side) -> Any:
                corners = np.where(side == 0, 1.0, side * np.asarray(self.corners(time, state)))
                return [*self.margins(time, state, modes, begins=False), *corners]

            events = [
                lambda time, state, i=i, watched=watched: watched(time, state)[i] for i in range(len(watched(at, y)))
            ]
            for event in events:
                event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
            part = solve_ivp(
                lambda time, state, modes=modes: self.rate(time, state, modes), (at, until), y, "DOP853", dense_output=True,
                events=events or None, rtol=1e-12, atol=1e-14, max_step=max_step, first_step=min(1e-6, until - at),
            )  # fmt: skip
            inside = (t >= at) & (t <= part.t[-1])
            if inside.any():
                rows[inside] = part.sol(t[inside]).T
            at, y = float(part.t[-1]), part.y[:, -1].copy()
            self.impact(y)
            if G := [x.g for x, slip in zip(self.frictions, self.slips(y), strict=True) if abs(slip) < 1e-8]:
                V = np.array(G) / np.asarray(self.M)
                y[n : 2 * n] -= V.T @ np.linalg.lstsq(V @ np.array(G).T, np.array(G) @ y[n : 2 * n], rcond=None)[0]
        return rows


@pytest.fixture(scope="session")
def rubbing() -> Any:
    """Friction, dry and Bodies of this file."""
    return Friction, dry, Bodies
