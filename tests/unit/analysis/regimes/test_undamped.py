"""Motions without damping: differences grow as time does beside a regular one, exponentially beside an irregular one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def _grown(
    rates: Callable[[float, Any], Any], start: tuple[float, float], period: float, counts: list[int]
) -> list[float]:
    """By how much a difference beside a motion grows in so many periods (scipy, variational equation by a small one)."""
    from scipy.integrate import solve_ivp

    at = [count * period for count in counts]
    runs = [
        solve_ivp(rates, (0, at[-1]), (start[0] + off, start[1]), "DOP853", t_eval=at, rtol=1e-12, atol=1e-14).y
        for off in (0.0, 1e-7)
    ]
    return (np.hypot(*(runs[1] - runs[0])) / 1e-7).tolist()


@pytest.mark.long
@pytest.mark.parametrize(("force", "w", "start"), [(0.05, 2.2, 0.3), (0.05, 2.2, 1.5), (0.3, 3.3, 2.0)])
def test_a_regular_motion_is_a_torus_though_differences_grow(
    oscillator: Oscillator, force: float, w: float, start: float
) -> None:
    # x'' + sin x = force cos w t
    grown = _grown(
        lambda t, y: (y[1], force * np.cos(w * t) - np.sin(y[0])), (start, 0.0), 2 * np.pi / w, [200, 400, 800]
    )
    assert grown[2] < 20 * max(grown[0], 5.0)  # as time does, and a few turns
    rig = oscillator(lambda drive, x, v: force * gb.cos(drive * gb.time) - gb.sin(x), k=1e-12, c=0.0, phi0=start)
    found = gb.classify(rig, SECTION, parameters={"drive": w})
    assert found.label == "quasi-periodic", (grown, found.evidence)


@pytest.mark.long
def test_an_irregular_one_is_chaotic(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: 1.5 * gb.cos(drive * gb.time) - gb.sin(x), k=1e-12, c=0.0, phi0=3.0)
    assert gb.classify(rig, SECTION).label == "chaotic"


def test_an_exponent_of_what_grows_as_time_does_is_within_its_error_of_nothing(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: 0.05 * gb.cos(drive * gb.time) - gb.sin(x), k=1e-12, c=0.0, phi0=0.3)
    found = gb.lyapunov(rig, SECTION, periods=4000, count=1, parameters={"drive": 2.2})
    assert abs(found.values[0]) <= 3 * found.errors[0] < 0.01
