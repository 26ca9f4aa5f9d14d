"""Motions that are carried over from value to value: phases and time go on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.carried import carried
from gearblocks.analysis.regimes.strobe import Strobe, strobe

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
PERIOD = 2 * np.pi


def _ramp(drive: Any, x: Any, v: Any) -> Any:
    return gb.minimum(gb.time / (12 * PERIOD), 1) * 0.6 * gb.cos(drive * gb.time) - x**3


@pytest.mark.parametrize(
    "torque",
    [
        lambda drive, x, v: gb.cos(drive * gb.time),
        lambda drive, x, v: gb.cos(drive * gb.time / 2),
        lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 3),
        lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(2**0.5 * gb.time),
        _ramp,
        lambda drive, x, v: gb.cos(drive * gb.time / 2) + gb.piecewise((5, gb.time < 20), (0, True)),
        lambda drive, x, v: gb.cos(drive * gb.time) + 1e-2 * gb.time,
    ],
)
def test_values_that_are_all_but_one_are_one_run(oscillator: Oscillator, torque: Any) -> None:
    model = gb.build(oscillator(torque, k=2.0, c=0.01))
    values = 1.0 + 1e-13 * np.arange(3)

    def at(value: float) -> Strobe:
        return strobe(model, SECTION, {"drive": value}, None, 1e-10)

    found = [motion.states for motion in carried(at, values, None, 5, on=True)]
    whole = at(1.0).follow(at(1.0).start(None), 30).states
    # each begins at a step of its own: some rtol, beside sizes of up to 5
    assert np.vstack(found) == pytest.approx(whole, abs=1e-7)
    again = [motion.states for motion in carried(at, values, None, 5, on=False)]
    assert np.vstack(again[3:]) == pytest.approx(whole[:15], abs=1e-7)  # down begins at the start, and at the time 0


def test_what_is_known_of_a_way_is_gone_on_from(oscillator: Oscillator) -> None:
    model = gb.build(oscillator(_ramp, k=0.4, c=0.1))

    def at(value: float) -> Strobe:
        return strobe(model, SECTION, {"drive": value}, None, 1e-8)

    values = np.linspace(0.9, 1.5, 4)
    whole = [*carried(at, values, None, 7, on=True)]
    known = {(one.direction, one.number): one.states[-1] for one in whole[:3]}
    rest = [*carried(at, values, None, 7, on=True, known=known)]
    assert len(rest) == 5
    for one, other in zip(rest, whole[3:], strict=True):
        assert (one.states == other.states).all() and one.passed == other.passed


def test_a_load_that_is_ramped_up_keeps_the_hysteresis_of_a_sweep(oscillator: Oscillator) -> None:
    def steady(drive: Any, x: Any, v: Any) -> Any:
        return 0.6 * gb.cos(drive * gb.time) - x**3

    values = np.linspace(1.2, 2.4, 9)
    ask: dict[str, Any] = {"of": "disc.phi", "transient": 60, "keep": 8, "within": 0.01}
    found, known = (
        gb.speed_sweep(oscillator(torque, k=0.4, c=0.1), "drive", values, **ask) for torque in (_ramp, steady)
    )
    # a ramp at the begin of every value let the large motion go: the jump up lay at 1.28
    assert len(known.jumps) == 2
    for jump, other in zip(found.jumps, known.jumps, strict=True):
        assert jump[1:3] == pytest.approx(other[1:3], rel=0.02) and jump[0] == other[0]
    assert found.rms == pytest.approx(known.rms, rel=1e-3)


def test_labels_of_a_carried_diagram_are_those_of_a_load_that_repeats_later(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 2), k=2.0, c=0.1)
    found = gb.bifurcation(
        rig, "drive", [1.0, 1.1, 1.2], section=SECTION, of="disc.phi", transient=200, keep=65, labels="full", threads=1
    )
    assert found.labels == (("period 2",) * 3,) * 2
    # x'' + 0.1 x' + 2 x = cos w t + cos w t/2, at even and odd points of the section
    w = np.array([1.0, 1.1, 1.2])
    whole, half = (1 / (2 - u**2 + 0.1j * u) for u in (w, w / 2))
    for number, points in enumerate(found.points[0]):
        expected = [(whole + half)[number].real, (whole - half)[number].real]
        assert [points.max(), points.min()] == pytest.approx(expected, abs=1e-6)
        assert set(np.abs(points[:, None] - expected).argmin(axis=1)) == {0, 1}
