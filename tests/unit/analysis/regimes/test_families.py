"""Orbits that lie side by side: what is stuck for good, and what swings by itself once in the section's time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def _circle(own: float) -> Callable[[Any, Any, Any], Any]:
    """x'' + own^2 x = 0.3 (1 - x^2 - (x'/own)^2) x', but for the spring: x = sin(own t + a) for every a."""
    return lambda drive, x, v: 0.3 * (1 - x**2 - (v / own) ** 2) * v + 0 * drive


@pytest.mark.few(2)
@pytest.mark.parametrize(("own", "period"), [(1.0, 1), (0.5, 2), (2.0, 1), (2 / 3, 3)])
def test_a_motion_that_swings_by_itself_as_often_as_the_section_repeats(
    oscillator: Oscillator, own: float, period: int
) -> None:
    found = gb.classify(oscillator(_circle(own), k=own**2, c=0.0, phi0=0.4), SECTION)
    assert found.label == f"period {period}" and found.orbit is not None, found.evidence
    assert "beside it repeat as it does" in found.evidence[-1] and "family of orbits" in found.evidence[0]
    # d/dx' is -0.6 (x'/own)^2 on the circle, -0.3 on the mean
    assert found.orbit.multipliers == pytest.approx([np.exp(-0.3 * 2 * np.pi * period)], rel=1e-6)


@pytest.mark.few(1)
@pytest.mark.parametrize("off", [1e-6, 1e-9, 1e-12])
def test_one_that_is_a_little_faster_does_not_repeat(oscillator: Oscillator, off: float) -> None:
    own = 1.0 + off
    found = gb.classify(oscillator(_circle(own), k=own**2, c=0.0, phi0=0.4), SECTION)
    assert found.label == "unresolved", found.evidence


def _stuck(spring: float, torque: Callable[[Any, Any, Any], Any] | None = None) -> gb.Drivetrain:
    """A disc that slides at first, and is stuck for good wherever it comes to rest; torque: of another one beside it."""
    rig, drive = gb.Drivetrain("stuck"), gb.Parameter("drive", 1.0, "rad/s")
    disc = rig.add("disc", gb.Inertia(J=1.0, w0=3.0))
    rig.chain(rig.add("source", gb.Torque(tau=0.5 * gb.cos(drive * gb.time))), disc)
    rig.connect(rig.add("brake", gb.Brake(capacity=2.0)).a, disc.b)
    if spring:
        rig.chain(disc, rig.add("spring", gb.Shaft(k=spring)), rig.add("ground", gb.Fixed()))
    if torque is not None:
        tau = torque(drive, gb.sense("other.phi"), gb.sense("other.w"))
        rig.chain(rig.add("push", gb.Torque(tau=tau)), rig.add("other", gb.Inertia(J=1.0, phi0=0.1)))
    return rig


@pytest.mark.parametrize("spring", [0.0, 1.0])
def test_a_disc_that_is_stuck_for_good_is_at_rest(spring: float) -> None:
    run = gb.simulate(_stuck(spring), t=[100.0, 200.0, 500.0])
    assert (run["disc.w"] == 0.0).all() and np.ptp(run["disc.phi"]) == 0.0  # the truth
    found = gb.classify(_stuck(spring), SECTION)
    assert found.label == "period 1" and found.orbit is not None, found.evidence
    assert found.orbit.multipliers == pytest.approx([0.0], abs=1e-12)
    assert ("along a family of orbits" in found.orbit.neutral) is bool(spring)


def test_what_moves_beside_a_stuck_disc_has_its_own_period_and_multipliers() -> None:
    well, slow = (
        lambda drive, x, v: 0.1 * gb.cos(drive * gb.time) - 0.2 * v + x - x**3,
        lambda drive, x, v: gb.cos(0.8 * drive * gb.time) - 0.2 * v - x,
    )
    for torque, period in ((well, 1), (slow, 5)):
        found = gb.classify(_stuck(1.0, torque), SECTION)
        assert found.label == f"period {period}" and found.orbit is not None, found.evidence
        # a pair that turns, of exp(-c t/2), and what is stuck
        sizes = [np.exp(-0.1 * 2 * np.pi * period)] * 2 + [0.0]
        assert np.abs(found.orbit.multipliers) == pytest.approx(sizes, abs=1e-8)


@pytest.mark.long
@pytest.mark.parametrize(
    ("label", "torque"),
    [
        ("quasi-periodic", lambda drive, x, v: 0.05 * gb.cos(drive * gb.time) + (0.2 - 0.2 * x**2) * v - 2.2 * x),
        ("chaotic", lambda drive, x, v: 7.5 * gb.cos(drive * gb.time) - 0.05 * v - x**3),
    ],
)
def test_what_moves_beside_a_stuck_disc_has_its_own_label(label: str, torque: Any) -> None:
    found = gb.classify(_stuck(1.0, torque), SECTION)
    assert found.label == label, found.evidence


def test_a_rest_that_is_left_as_time_does_is_no_family(oscillator: Oscillator) -> None:
    # x'' + x' = s x^3, multiplier 1 at x = 0: for s = 1 whatever lies beside leaves it, for s = -1 it falls as 1/sqrt(2 t)
    for s in (1, -1):
        rig = oscillator(lambda drive, x, v, s=s: 0.0 * drive + s * x**3, k=1e-15, c=1.0, phi0=1e-4 if s > 0 else 1.0)
        found = gb.classify(rig, SECTION)
        assert found.label == "unresolved", found.evidence
