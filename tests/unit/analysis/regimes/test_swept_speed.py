"""Sweeps over a speed: responses, the state carried over, jumps and what is none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SPEEDS = np.linspace(0.4, 1.8, 15)


def _linear(oscillator: Oscillator) -> gb.Drivetrain:
    return oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=1.0, c=0.2)


@pytest.mark.long
def test_the_response_of_a_linear_train_is_that_of_its_equation_and_has_no_jump(oscillator: Oscillator) -> None:
    found = gb.speed_sweep(_linear(oscillator), "drive", SPEEDS, of="disc.phi", rtol=1e-10)
    amplitude = 1.0 / np.abs(1.0 - SPEEDS**2 + 0.2j * SPEEDS)  # 5 at the resonance, 1 beside: steep, no jump
    for i in range(2):
        # exp(-0.1 t) over 200 periods leaves nothing
        assert found.rms[i] == pytest.approx(amplitude / np.sqrt(2), rel=1e-8)
        assert found.peak_to_peak[i] == pytest.approx(2 * amplitude, rel=1e-8)
    assert found.mean == pytest.approx(np.zeros((2, 15)), abs=1e-8)
    assert found.jumps == () and found.messages == {} and found.misses.max() < 1e-8


def test_samples_stand_for_the_motion_where_they_are_asked_for(oscillator: Oscillator) -> None:
    rig = _linear(oscillator)
    found, sampled = (gb.speed_sweep(rig, "drive", [1.1], of="disc.phi", samples=n) for n in (None, 8))
    assert sampled.rms == pytest.approx(found.rms, rel=1e-6)
    run = gb.simulate(rig, t=2 * np.pi / 1.1 * (240 + np.arange(8) / 8), rtol=1e-10, parameters={"drive": 1.1})
    assert sampled.high[0, 0] == pytest.approx(run["disc.phi"].max(), rel=1e-6) != found.high[0, 0]


def test_a_hardening_spring_jumps_down_on_the_way_up_and_up_on_the_way_down(
    oscillator: Oscillator, tmp_path: Path
) -> None:
    rig = oscillator(lambda drive, x, v: 0.6 * gb.cos(drive * gb.time) - x**3, k=0.4, c=0.1)
    values = np.linspace(0.9, 3.0, 22)
    told: list[int] = []
    found = gb.speed_sweep(
        rig, "drive", values, of="disc.phi", transient=100, keep=8, progress=lambda n, total: told.append(n)
    )
    assert told == list(range(1, 45))
    up, down = found.jumps
    assert (up.direction, down.direction) == ("up", "down") and up.after < up.before and down.after > down.before
    for jump in found.jumps:
        assert abs(jump.first - jump.last) <= 1e-3 * jump.first
    assert down.first < down.last < up.last < up.first  # hysteresis between the two
    between = (values > down.last) & (values < up.last)
    apart = found.rms[0] > 2 * found.rms[1]
    assert (apart == between).all() and 3 < between.sum() < 20
    data = found.to_xarray()
    assert data["rms"].attrs["units"] == "rad" and data.sizes == {"direction": 2, "drive": 22}
    found.plot(tmp_path / "sweep.png")
    assert (tmp_path / "sweep.png").stat().st_size > 10_000 and "jumps: up at" in repr(found)


def test_a_speed_that_cannot_be_run_is_named_and_its_neighbours_are_there(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.piecewise((9 * v, drive > 1.5), (0, True)))
    found = gb.speed_sweep(rig, "drive", [1.4, 1.6], of="disc.phi")
    assert set(found.messages) == {("up", 1.6), ("down", 1.6)} and found.jumps == ()
    assert np.isnan(found.rms[:, 1]).all() and np.isfinite(found.rms[:, 0]).all()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"values": [2.0, 1.0]}, "must be finite and increase"),
        ({"keep": 0}, "keep = 0 must be a whole number >= 2"),
        ({"samples": 2}, "samples = 2 must be a whole number >= 8"),
        ({"within": 0.0}, "within = 0.0 must lie between 0 and 1"),
        ({"of": "disc.fi"}, r"disc\.fi"),
        ({"parameter": "drve"}, "drve"),
        ({"values": [-1.0, 1.0]}, "must be > 0"),
    ],
)
def test_what_cannot_be_swept_is_refused_by_name(oscillator: Oscillator, more: dict[str, Any], words: str) -> None:
    ask = {"parameter": "drive", "values": [1.0], "of": "disc.phi"} | more
    with pytest.raises(gb.GearblocksError, match=words):
        gb.speed_sweep(_linear(oscillator), ask.pop("parameter"), ask.pop("values"), **ask)
