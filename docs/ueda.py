"""The largest exponent of Ueda's oscillator, x'' + 0.05 x' + x^3 = 7.5 cos t, by three programs that share nothing, with
standard errors from many runs of their own; and how far single runs scatter, by their length.

    python docs/ueda.py        # two minutes

In print it is 0.1034 1/s (Sprott 2003, Chaos and Time-Series Analysis, A.4.5); 0.0999 is listed, too
(sites.google.com/view/lyapunov-spectrum: one run by Runge and Kutta's method with a step of 0.001, whose length is not given).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gearblocks as gb

Array = NDArray[np.float64]

DAMPING, FORCE, PERIOD = 0.05, 7.5, 2 * np.pi
PRINTED, LISTED = 0.1034, 0.0999
SKIPPED = 50  # periods, before growth is counted


class Told(NamedTuple):
    """Mean of the exponent [1/s] over runs that share nothing, and its standard error."""

    value: float
    error: float

    def off(self, other: float) -> float:
        """How many standard errors it is off."""
        return abs(self.value - other) / self.error


def oscillator() -> gb.Drivetrain:
    """As a drivetrain: a disc, with the spring and the damping in its torque."""
    rig, drive = gb.Drivetrain("Ueda"), gb.Parameter("drive", 1.0, "rad/s")
    tau = FORCE * gb.cos(drive * gb.time) - gb.sense("disc.phi") ** 3
    rig.chain(
        rig.add("source", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=1.0)), rig.add("damper", gb.Damper(c=DAMPING)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    return rig


def by_gearblocks(runs: int, periods: int) -> Array:
    """Of each run, from starts at random."""
    model, rng = gb.build(oscillator()), np.random.default_rng(1)
    return np.array([
        gb.lyapunov(
            model, gb.stroboscopic("drive"), periods=periods, count=1, transient=SKIPPED,
            initial={"disc.phi": rng.uniform(-3, 3), "disc.w": rng.uniform(-3, 3)},
        ).values[0]
        for _ in range(runs)
    ])  # fmt: skip


def _rates(t: float, y: Array) -> Array:
    """Of many motions, and of a difference beside each (variational equation)."""
    x, v, dx, dv = y.reshape(4, -1)
    return np.concatenate([v, FORCE * np.cos(t) - DAMPING * v - x**3, dv, -DAMPING * dv - 3 * x**2 * dx])


def _grown(step: Callable[[Array], Array], runs: int, periods: int, seed: int) -> Array:
    """Of each run, from the growth of the difference in each period; step: a period later."""
    y, total = np.random.default_rng(seed).uniform(-3.0, 3.0, 4 * runs), np.zeros(runs)
    for period in range(SKIPPED + periods):
        y = step(y)
        size = np.hypot(*y.reshape(4, -1)[2:])
        y.reshape(4, -1)[2:] /= size
        total += np.log(size) * (period >= SKIPPED)
    found: Array = total / (periods * PERIOD)
    return found


def by_scipy(runs: int, periods: int) -> Array:
    """By DOP853."""
    return _grown(
        lambda y: solve_ivp(_rates, (0, PERIOD), y, "DOP853", rtol=1e-8, atol=1e-10).y[:, -1], runs, periods, 2
    )


def by_fixed_steps(runs: int, periods: int, steps: int = 600) -> Array:
    """By Runge and Kutta's method of order 4."""
    h = PERIOD / steps

    def period(y: Array) -> Array:
        for i in range(steps):
            t = i * h
            k1 = _rates(t, y)
            k2 = _rates(t + h / 2, y + h / 2 * k1)
            k3 = _rates(t + h / 2, y + h / 2 * k2)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + _rates(t + h, y + h * k3))
        return y

    return _grown(period, runs, periods, 3)


def told(values: Array) -> Told:
    """Of runs that share nothing."""
    return Told(float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))))


def report(gearblocks: Sequence[int] = (24, 10000), others: Sequence[int] = (2000, 200)) -> list[str]:
    """Lines; each program with so many runs of so many periods."""
    found = {
        f"gearblocks, {gearblocks[0]} runs of {gearblocks[1]} periods": by_gearblocks(*gearblocks),
        f"scipy's DOP853, {others[0]} runs of {others[1]} periods": by_scipy(*others),
        f"Runge and Kutta, 600 steps a period, {others[0]} runs of {others[1]} periods": by_fixed_steps(*others),
    }
    lines = []
    for name, values in found.items():
        one = told(values)
        off = f"{one.off(PRINTED):.1f} errors off {PRINTED}, {one.off(LISTED):.1f} off {LISTED}"
        lines.append(f"{one.value:.5f} +- {one.error:.5f} 1/s  {name}: {off}")
    scatter = float(next(iter(found.values())).std(ddof=1)) * np.sqrt(gearblocks[1])
    for periods in (300, 1600, 10000, 20000):
        lines.append(
            f"a single run of {periods} periods scatters by {scatter / np.sqrt(periods):.4f}: {LISTED} is "
            f"{abs(PRINTED - LISTED) * np.sqrt(periods) / scatter:.1f} of that off {PRINTED}"
        )
    return lines


if __name__ == "__main__":
    for line in report():
        print(line)
