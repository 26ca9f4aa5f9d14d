"""The label of a steady motion: period m, not periodic, or undecided. Two step sizes must agree on it.

The traps: few steps per turn give wrong periods, a short transient looks like chaos, and slow decay like a long period. So
a period counts only where the points of a period lie far apart against the error of repetition, and "not periodic" only
where neighbouring motions separate for certain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearblocks.drivetrain import simulate
from gearblocks.library import Model

Array = NDArray[np.float64]

STATE = ("x1", "x2", "x3", "v1", "v2", "v3")
LONGEST = 16
REPEATS = 1e-7  # relative; two orders above what the points still move in the slowest decay after the transient
APART = 100.0  # by how much the points of one period must exceed the error of repetition


@dataclass(frozen=True, slots=True)
class Label:
    """The word for a motion and the reason for it."""

    label: str
    evidence: str


@dataclass(frozen=True, slots=True)
class _Seen:
    """What one step size shows: the period (0: none), the error of repetition, the nearest other return."""

    period: int
    error: float
    apart: float


def period_label(model: Model, speed: float, *, transient: int = 600, keep: int = 96) -> Label:
    """Label of the motion at `speed` [rad/s] after `transient` turns, from `keep` points, with 250 and 500 steps a turn."""
    steps = (250, 500)
    coarse, fine = (_seen(_points(model, speed, n, transient, keep)) for n in steps)
    words = f"{steps[0]} and {steps[1]} steps a turn"
    if coarse.period != fine.period:
        return Label("undecided", f"{words} disagree: {_word(coarse)} and {_word(fine)}")
    if fine.period:
        apart = f"; other returns miss by {fine.apart:.0e}" if fine.period > 1 else ""
        return Label(f"period {fine.period}", f"{words} agree; points repeat within {fine.error:.0e} of their size{apart}")
    rates = [_exponent(model, speed, n, transient) for n in steps]
    if any(mean < 3.0 * doubt for mean, doubt in rates):
        return Label("undecided", f"{words}: no period up to {LONGEST}, but neighbours do not surely separate")
    mean, doubt = rates[1]
    growth = f"neighbours separate as exp({mean:.2f} ± {doubt:.2f} a turn)"
    return Label("not periodic", f"{words} agree; no period up to {LONGEST} (nearest return {fine.error:.0e}); {growth}")


def _word(seen: _Seen) -> str:
    return f"period {seen.period}" if seen.period else "no period"


def _points(model: Model, speed: float, steps: int, transient: int, keep: int) -> Array:
    """The state once per turn, after the transient."""
    turn = 2.0 * math.pi / speed
    t = turn * np.arange(transient, transient + keep)
    run = simulate(
        model, t=t, method="dp8", step=turn / steps, rtol=1e-10, parameters={"speed": speed}, outputs=STATE
    )
    return np.column_stack([run[name] for name in STATE])


def _seen(points: Array) -> _Seen:
    """The smallest period whose repetition is small, and small against all shorter returns."""
    scale = np.abs(points).max(axis=0)
    misses = [float(np.max(np.abs(points[m:] - points[:-m]) / scale)) for m in range(1, LONGEST + 1)]
    for m, miss in enumerate(misses, 1):
        if miss < REPEATS:
            shorter = min(misses[: m - 1], default=math.inf)
            return _Seen(m if shorter > APART * miss else 0, miss, shorter)
    return _Seen(0, min(misses), min(misses))


def _exponent(model: Model, speed: float, steps: int, transient: int, *, pieces: int = 24, turns: int = 30) -> tuple[float, float]:
    """Mean growth of a small deviation per turn (logarithm) and its standard error, over pieces of a long motion.

    Each piece starts on the motion, at the same phase, once as it is and once with one speed changed by a billionth.
    """
    turn = 2.0 * math.pi / speed
    names = [start.name for start in model.program.starts]
    t = turn * np.arange(transient, transient + pieces * turns, turns)
    common = {"method": "dp8", "step": turn / steps, "rtol": 1e-10, "parameters": {"speed": speed}}
    on_motion = simulate(model, t=t, outputs=names, **common)
    inside = turn * np.arange(5, turns + 1)  # the first turns align the deviation with its fastest growth
    growth = []
    for piece in range(pieces):
        start = {name: float(on_motion[name][piece]) for name in names}
        first = next(name for name in names if name.endswith(".w"))
        moved = start | {first: start[first] * (1.0 + 1e-9) + 1e-9}
        one, other = (simulate(model, t=inside, initial=i, outputs=STATE, **common) for i in (start, moved))
        away = np.log(np.max([np.abs(one[n] - other[n]) / np.abs(one[n]).max() for n in STATE], axis=0))
        growth.append(float(np.polyfit(np.arange(len(away)), away, 1)[0]))
    return float(np.mean(growth)), float(np.std(growth, ddof=1) / math.sqrt(pieces))
