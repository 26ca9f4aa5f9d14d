"""Rows of bodies with lossy gears between them, through all reversals, against an independent reference.

Given the acceleration, the torques follow body by body from the far end; the sum that is left at the first body grows with
the acceleration, and its root is the motion. scipy integrates from stop to stop and from break-away to break-away.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gearblocks as gb

Rows = tuple[tuple[float, float, float, float, float], ...]


@dataclass(frozen=True)
class Gear:
    """ratio, and rows of (abs(w_a), eta1, eta2, tau1, tau2)."""

    ratio: float
    rows: Rows
    block: gb.Block | None = None

    def entering(self, direction: float, leaving: float, speed: float) -> tuple[float, float]:
        """What enters at a for what leaves at b, and its slope."""
        w, *columns = np.array(self.rows).T
        eta1, eta2, tau1, tau2 = (np.interp(abs(speed), w, c) for c in columns)
        u = direction * leaving
        if u + tau1 >= 0:
            return direction * (u + tau1) / eta1, 1 / eta1
        return (direction * (u + tau2) * eta2, eta2) if u + tau2 < 0 else (0.0, 0.0)


@dataclass(frozen=True)
class Row:
    """inertias; gears between them; by body: torque over time; dry friction, linear drag."""

    inertias: tuple[float, ...]
    gears: tuple[Gear, ...]
    torques: dict[int, tuple[float, float]] = field(default_factory=dict)  # amplitude, angular frequency of a sine
    dry: dict[int, float] = field(default_factory=dict)
    drag: dict[int, float] = field(default_factory=dict)
    w0: float = 0.0

    def train(self) -> gb.Drivetrain:
        """The same for gearblocks: bodies body0, body1, ..., gears gear0, ..."""
        rig = gb.Drivetrain("row")
        bodies, w = [], self.w0
        for i, inertia in enumerate(self.inertias):
            bodies.append(rig.add(f"body{i}", gb.Inertia(J=inertia, w0=w)))
            w /= self.gears[i].ratio if i < len(self.gears) else 1.0
        for i, gear in enumerate(self.gears):
            block = gear.block or gb.LossyGear(ratio=gear.ratio, loss_table=gear.rows)
            rig.chain(bodies[i], rig.add(f"gear{i}", block), bodies[i + 1])
        for i, (size, frequency) in self.torques.items():
            rig.chain(rig.add(f"torque{i}", gb.Torque(tau=size * gb.sin(frequency * gb.time))), bodies[i])
        for i, size in self.dry.items():
            rig.chain(bodies[i], rig.add(f"bearing{i}", gb.BearingFriction(coulomb=size)))
        for i, c in self.drag.items():
            rig.chain(bodies[i], rig.add(f"drag{i}", gb.Damper(c=c)), rig.add(f"ground{i}", gb.Fixed()))
        return rig

    def left(self, t: float, speed: float, direction: float, alpha: float) -> tuple[float, float]:
        """Torque that the first body lacks at an acceleration of its own, turning in a direction; and its slope."""
        ratios = np.cumprod([1.0, *(g.ratio for g in self.gears)])
        need, slope = 0.0, 0.0
        for i in reversed(range(len(self.inertias))):
            way = direction * np.sign(ratios[i])
            size, frequency = self.torques.get(i, (0.0, 0.0))
            if i + 1 < len(self.inertias):
                gear = self.gears[i]
                entering, gain = gear.entering(way, need / gear.ratio, speed / ratios[i])
                need, slope = entering, gain * slope / gear.ratio
            need += self.inertias[i] * alpha / ratios[i] + self.drag.get(i, 0.0) * speed / ratios[i]
            need += way * self.dry.get(i, 0.0) - size * np.sin(frequency * t)
            slope += self.inertias[i] / ratios[i]
        return need, slope

    def alpha(self, t: float, speed: float, direction: float) -> float:
        """The acceleration of the first body: Newton steps over the pieces."""
        alpha = 0.0
        for _ in range(50):
            value, slope = self.left(t, speed, direction, alpha)
            if abs(value) <= 1e-14 * max(1.0, abs(slope * alpha)):
                break
            alpha -= value / slope
        return alpha

    def speeds(self, at: np.ndarray) -> tuple[np.ndarray, list[float]]:
        """Speed of the first body at these times, and the times at which it stops or starts."""
        found, changes = np.zeros(len(at)), []
        t, speed, direction = 0.0, self.w0, float(np.sign(self.w0))
        while t < at[-1]:
            if direction == 0.0:
                t, direction = self._break_away(t, at[-1])
            else:
                sol = _slide(self, t, speed, direction, at)
                inside = (at >= t) & (at <= sol.t[-1])
                found[inside] = sol.sol(at[inside])[0]
                t, speed = sol.t[-1], 0.0
                direction = self._goes_on(t)
            changes.append(t)
        return found, changes[:-1]

    def _goes_on(self, t: float) -> float:
        """The direction in which it moves on from rest, or 0."""
        forward, backward = (self.left(t, 0.0, d, 0.0)[0] for d in (1.0, -1.0))
        return 1.0 if forward < -1e-9 else -1.0 if backward > 1e-9 else 0.0

    def _break_away(self, t: float, end: float) -> tuple[float, float]:
        grid = np.linspace(t, end, 2000)
        for a, b in pairwise(grid):
            for d in (1.0, -1.0):

                def lack(x: float, d: float = d) -> float:
                    return d * self.left(x, 0.0, d, 0.0)[0]

                if lack(b) < 0.0:
                    return (brentq(lack, a, b, xtol=1e-14) if lack(a) > 0.0 else a), d
        return end, 0.0


def _slide(row: Row, t: float, speed: float, direction: float, at: np.ndarray) -> Any:
    def stops(_t: float, y: np.ndarray) -> float:
        return direction * y[0]

    stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]

    def rate(x: float, y: np.ndarray) -> list[float]:
        return [row.alpha(x, y[0], direction)]

    return solve_ivp(
        rate, (t, at[-1]), [speed], "DOP853", rtol=1e-11, atol=1e-12, max_step=2e-3, events=stops, dense_output=True
    )


WORM = gb.Worm(ratio=20.0, lead_angle=0.1, friction=0.05)
ROWS = {
    "worm, gear with a table, sticking load": Row(
        (0.01, 1.0, 1.0),
        (Gear(20.0, ((0.0, *WORM.efficiency(), 0.0, 0.0),), WORM),
         Gear(2.0, ((0.0, 0.9, 0.8, 0.05, 0.05), (10.0, 0.95, 0.9, 0.1, 0.1)))),
        {0: (5.0, 6.0)}, {2: 0.1},
    ),
    "bearing that sticks beside a": Row((0.1, 1.0), (Gear(2.0, ((0.0, 0.9, 0.8, 0.0, 0.0),)),), {0: (5.0, 6.0)}, {0: 4.0}),
    "bearing that sticks beside b": Row((0.1, 1.0), (Gear(-2.0, ((0.0, 0.9, 0.8, 0.0, 0.0),)),), {0: (5.0, 6.0)}, {1: 4.9}),
    "bearing losses with a gap": Row(
        (0.1, 1.0, 0.3),
        (Gear(-2.0, ((0.0, 0.9, 0.8, 0.1, 0.3),)), Gear(0.5, ((0.0, 0.8, 0.6, 0.0, 0.2),))),
        {0: (5.0, 6.0), 2: (3.0, 11.0)}, {1: 0.4}, {2: 0.1}, 3.0,
    ),
    "self-locking, driven from both sides": Row(
        (0.05, 1.0), (Gear(10.0, ((0.0, 0.4, -0.3, 0.0, 0.0),)),), {0: (3.0, 6.0), 1: (20.0, 15.0)}, {}, {1: 0.1}
    ),
    "no losses": Row((0.2, 1.0), (Gear(-3.0, ((0.0, 1.0, 1.0, 0.0, 0.0),)),), {0: (5.0, 6.0)}, {1: 2.0}, {}, 1.0),
}  # fmt: skip
AT = np.linspace(0.0, 1.2, 61)


LONG = ("bearing that sticks beside b", "no losses")


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in ROWS])
def test_a_row_of_lossy_gears_turns_back_as_its_losses_say_with_every_method(name: str) -> None:
    row = ROWS[name]
    rig, (true, changes) = row.train(), row.speeds(AT)
    for method, rtol in (("dp5", 1e-4), ("dp8", 1e-9), ("rodas", 1e-6), ("auto", 1e-5)):
        run = gb.simulate(rig, t=AT, method=method, rtol=rtol)
        assert run["body0.w"] == pytest.approx(true, abs=20 * rtol * np.abs(true).max()), method
        assert run.energy.residual < 30 * rtol
        times = sorted({round(e.t, 3) for e in run.events if e.t > 1e-6})  # how it begins is no change
        assert times == pytest.approx(sorted({round(t, 3) for t in changes if t > 1e-6}), abs=2e-3), method


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.few(1)
def test_a_lossy_gear_beside_a_stuck_bearing_is_stuck_as_long_as_it(place: int) -> None:
    """Which of the two holds the load the motion does not tell; that both do, their modes say."""
    row = ROWS["bearing that sticks beside a" if place == 0 else "bearing that sticks beside b"]
    run = gb.simulate(row.train(), t_end=1.2)
    rests = (run["body0.w"] == 0.0) & ~np.isin(run.t, [e.t for e in run.events])
    assert rests.sum() > 5
    assert (run["gear0.mode"][rests] == 0.0).all() and (run[f"bearing{place}.mode"][rests] == 0.0).all()
    assert max(np.unique([e.t for e in run.events], return_counts=True)[1]) == 2


HOLDS = {
    "a brake beside a": (gb.LossyGear(ratio=3.0, efficiency=(0.7, 0.6)), gb.Brake(capacity=2.2), 0),
    "a clutch to the ground beside b": (
        gb.LossyGear(ratio=0.5, loss_table=((0.0, 0.95, 0.9, 0.0, 0.0), (5.0, 0.8, 0.7, 0.1, 0.1))), gb.Clutch(capacity=1.1), 1,
    ),
    "a dry load beside the wheel of a worm": (WORM, gb.SpeedLoad(coeffs=(8.0, 0.0, 0.0)), 1),
    "a bearing with a peak beside a": (
        gb.LossyGear(ratio=-1.5, efficiency=(0.8, 0.8), bearing=(0.2, 0.1)), gb.BearingFriction(coulomb=2.0, peak=1.4), 0,
    ),
}  # fmt: skip


@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-4), ("dp8", 1e-9), ("rodas", 1e-6), ("auto", 1e-6)])
@pytest.mark.parametrize("name", HOLDS)
@pytest.mark.few(4)
def test_whatever_holds_its_shaft_a_lossy_gear_rests_in_its_mode_and_changes_it_once(
    name: str, method: str, rtol: float
) -> None:
    gear, hold, place = HOLDS[name]
    rig = gb.Drivetrain("held")
    bodies = [rig.add(f"body{i}", gb.Inertia(J=J)) for i, J in enumerate((0.1, 1.0))]
    rig.chain(rig.add("torque", gb.Torque(tau=5 * gb.sin(6 * gb.time))), bodies[0], rig.add("gear", gear), bodies[1])
    held = rig.add("hold", hold)
    rig.connect(bodies[place].b, held.flange if isinstance(hold, gb.SpeedLoad) else held.a)
    if isinstance(hold, gb.Clutch):
        rig.connect(held.b, rig.add("ground", gb.Fixed()).flange)
    run = gb.simulate(rig, t_end=2.0, method=method, rtol=rtol)
    times = [e.t for e in run.events]
    rests = (run["body0.w"] == 0.0) & ~np.isin(run.t, times)
    (mode,) = (name for name in run.names if name.startswith("gear.") and name.endswith(".mode"))
    assert rests.any() and (run[mode][rests] == 0.0).all()
    assert "hold.mode" not in run.names or (run["hold.mode"][rests] == 0.0).all()
    assert max(np.unique(times, return_counts=True)[1]) <= 3


@pytest.mark.long
def test_eight_lossy_gears_in_a_row_turn_back_together() -> None:
    losses = [(0.9, 0.8, 0.02, 0.02), (0.8, 0.7, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0), (0.95, 0.9, 0.02, 0.05)]
    gears = tuple(Gear(ratio, ((0.0, *losses[i % 4]),)) for i, ratio in enumerate((2, -0.5, 3, -1, 0.3, 1.5, -2, 0.7)))
    row = Row((0.1,) * 9, gears, {0: (4.0, 9.0), 8: (0.7, 23.0)}, {4: 0.05})
    true, _ = row.speeds(AT[:31])
    run = gb.simulate(row.train(), t=AT[:31], rtol=1e-8)
    assert run["body0.w"] == pytest.approx(true, abs=1e-6 * np.abs(true).max())
