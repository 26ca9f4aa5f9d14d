"""Motions whose kind shows late: periods that nearly repeat sooner, tori around orbits of several periods, and shooting where
there is no orbit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes import regime
from gearblocks.analysis.regimes.exponents import LyapunovExponents
from gearblocks.analysis.regimes.neutral import Neutral, neutral_directions
from gearblocks.analysis.regimes.orbit import shoot
from gearblocks.analysis.regimes.sizes import settled
from gearblocks.analysis.regimes.strobe import Strobe, strobe

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


@pytest.mark.long
def test_a_period_that_nearly_repeats_after_half_of_it_is_seen(oscillator: Oscillator) -> None:
    # Ueda's oscillator next to a doubling: period 32, whose points miss those 16 periods later by 6e-4 of their size
    rig = oscillator(lambda drive, x, v: 5.329478 * gb.cos(drive * gb.time) - x**3, k=1e-12)
    found = gb.classify(rig, SECTION, longest=4)
    assert found.label == "period 32", found.evidence


def test_a_torus_around_an_orbit_of_two_periods_is_one(oscillator: Oscillator) -> None:
    # x'' + 2 x = cos t + cos t/2, undamped, begun 0.05 beside the orbit: the largest line of its points is that of the orbit
    rig = oscillator(
        lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 2),
        k=2.0,
        c=0.0,
        phi0=1 + 1 / 1.75 + 0.05,
    )
    found = gb.classify(rig, SECTION)
    assert found.label == "quasi-periodic", found.evidence
    assert "0.414214 times" in found.evidence[0] or "0.414213 times" in found.evidence[0]  # sqrt(2) - 1


@pytest.mark.long
def test_a_torus_next_to_a_resonance_is_one_though_it_nearly_repeats(oscillator: Oscillator) -> None:
    # x'' + k x = cos t, undamped: its own vibration at 1.39967, next to 7/5, moves the points by 5e-4 in 5 periods
    k = 1.39967**2
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=k, c=0.0, phi0=1 / (k - 1) + 0.05)
    found = gb.classify(rig, SECTION)
    assert found.label == "quasi-periodic" and "0.39967 times" in found.evidence[0], found.evidence


def test_shooting_gives_up_where_it_comes_no_nearer(oscillator: Oscillator, monkeypatch: pytest.MonkeyPatch) -> None:
    # an oscillation of its own beside the drive: a torus, on which nothing repeats after 21 periods
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + (0.2 - 0.2 * x**2) * v, k=2.2, c=0.0, phi0=2.0)
    seen, y, *_ = settled(strobe(gb.build(rig), SECTION, None, None, 1e-9), None, 300)
    neutral, maps, own = neutral_directions(seen, y), [], Strobe.map

    def counted(self: Strobe, y: Any, periods: int, **options: Any) -> Any:
        maps.append(periods)
        return own(self, y, periods, **options)

    monkeypatch.setattr(Strobe, "map", counted)
    assert shoot(seen, y, 21, neutral) is None
    assert len(maps) <= 12  # six steps that bring nothing, and some before them


def test_a_motion_that_fades_within_the_error_of_its_exponent_is_periodic(
    oscillator: Oscillator, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Ueda's oscillator at period 12, where periods up to 8 are looked for unless the motion is known to be periodic; growth
    # that scatters by 1 a period hides its exponent of -0.01, and fades by e^5 in the later half: beside a torus it is bounded
    def hidden(seen: Strobe, y: Any, neutral: Neutral, after: int) -> LyapunovExponents:
        logs = np.random.default_rng(1).standard_normal((1000, 1))
        logs -= logs.reshape(2, 500, 1).mean(axis=1).repeat(500, axis=0) + 0.01
        return LyapunovExponents(logs, seen.period, (), "", y, after)

    monkeypatch.setattr(regime, "told_exponents", hidden)
    rig = oscillator(lambda drive, x, v: 5.318 * gb.cos(drive * gb.time) - x**3, k=1e-12)
    found = gb.classify(rig, SECTION, longest=1)
    assert found.label == "period 12", found.evidence
