"""Loads that are switched on, grow or fade beside the drive: a motion is what it is behind them, and none is a drive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
PERIOD = 2 * np.pi


def _until(periods: float, before: Any, later: Any) -> Any:
    return gb.piecewise((before, gb.time < periods * PERIOD), (later, True))


def _ramp(drive: Any, x: Any, v: Any) -> Any:
    share = _until(100, gb.time / (100 * PERIOD), 1.0)
    return share + (1 + share) * gb.cos(drive * gb.time)


def _step(drive: Any, x: Any, v: Any) -> Any:
    return _until(200, gb.cos(drive * gb.time), 1 + 2 * gb.cos(drive * gb.time))


BEHIND = 0.5 + 2 / (1 + 0.1**2)
"""x'' + 0.1 x' + 2 x = 1 + 2 cos t: x at the section."""


@pytest.mark.parametrize("torque", [_ramp, _step])
def test_an_orbit_is_that_of_what_acts_behind_a_ramp_or_a_step(oscillator: Oscillator, torque: Any) -> None:
    model = gb.build(oscillator(torque, k=2.0, c=0.1))
    found = gb.classify(model, SECTION)
    assert found.label == "period 1" and found.orbit is not None, found.evidence
    for orbit in (found.orbit, gb.periodic_orbit(model, SECTION)):
        assert orbit.exponents == pytest.approx([-0.05, -0.05], abs=1e-8)
        start = orbit.starts[0]
        run = gb.simulate(model, t=start.t[0] + PERIOD * np.arange(4), initial=start, rtol=1e-10)
        assert start.t[0] >= 200 * PERIOD and run["disc.phi"] == pytest.approx(BEHIND, abs=1e-8)
    exponents = gb.lyapunov(model, SECTION, periods=40)
    assert exponents.orbit is not None and exponents.values == pytest.approx([-0.05, -0.05], abs=1e-8)


def test_a_motion_that_is_irregular_before_a_load_is_taken_away_is_periodic(oscillator: Oscillator) -> None:
    rig = oscillator(
        lambda drive, x, v: _until(200, 7.5, 1.0) * gb.cos(drive * gb.time) - x**3, k=1e-12
    )  # Ueda's oscillator
    found = gb.classify(rig, SECTION)
    other = gb.periodic_orbit(
        oscillator(lambda drive, x, v: gb.cos(drive * gb.time) - x**3, k=1e-12), SECTION, transient=0,
        initial={"disc.phi": abs(found.orbit.points[0, 0]) if found.orbit else 0.0},
    )  # fmt: skip
    assert found.label == "period 1" and found.orbit is not None, found.evidence
    assert np.abs(found.orbit.multipliers) == pytest.approx(np.abs(other.multipliers), abs=1e-6)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (lambda: 1e-3 * gb.time, "goes on growing"),
        (lambda: 1e-6 * gb.time, "goes on growing"),
        (lambda: gb.exp(-gb.time / 500), "still changing after 400 periods"),
        (lambda: gb.tanh(gb.time / 1e4), "still changing after 400 periods"),
    ],
)
def test_what_grows_or_fades_is_no_second_frequency(oscillator: Oscillator, load: Any, words: str) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + load(), k=2.0, c=0.1)
    found = gb.classify(rig, SECTION)
    assert found.label == "unresolved" and words in found.evidence[0], found.evidence
    with pytest.raises(gb.SimulationError, match=words.partition(" after")[0]):
        gb.periodic_orbit(rig, SECTION)


def test_what_fades_has_faded_after_a_longer_transient(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.exp(-gb.time / 500), k=2.0, c=0.1)
    found = gb.classify(rig, SECTION, transient=3000)
    assert found.label == "period 1", found.evidence


def test_an_orbit_repeats_with_all_drives(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 2), k=2.0, c=0.1)
    with pytest.raises(gb.ParameterError, match="periods = 1 must be a multiple of 2"):
        gb.periodic_orbit(rig, SECTION)
    assert gb.periodic_orbit(rig, SECTION, periods=2, transient=301).periods == 2
    other = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(2**0.5 * drive * gb.time), k=2.0, c=0.1)
    with pytest.raises(gb.SimulationError, match="do not repeat together within 128 periods"):
        gb.periodic_orbit(other, SECTION)


def test_a_branch_is_refused_where_other_things_act_at_the_begin(oscillator: Oscillator) -> None:
    rig = oscillator(_ramp, k=2.0, c=0.1)
    with pytest.raises(gb.SimulationError, match="is not what acts later"):
        gb.continue_orbit(rig, "drive", (1.0, 1.1), section=SECTION, of="disc.phi")


def test_jacobians_are_those_of_the_time_that_is_looked_at(oscillator: Oscillator) -> None:
    # a spring that is a hundred thousand times as stiff from t = 100 periods on: steps follow it
    from gearblocks.analysis.regimes.sizes import settled
    from gearblocks.analysis.regimes.strobe import strobe

    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) - _until(100, 0.0, 1e5) * x, k=1.0, c=0.1)
    seen = settled(strobe(gb.build(rig), SECTION, None, None, 1e-9), None, 300).seen
    assert seen.max_step == pytest.approx(2 / np.sqrt(1e5 + 1), rel=1e-3)
