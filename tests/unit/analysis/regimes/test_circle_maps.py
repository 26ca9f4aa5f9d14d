"""States of blocks that go on without end: maps of a circle, told as numbers that laws read by where on it they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

SECTION = gb.stroboscopic("drive")


class Circle(gb.Block):
    """x -> x + turn (ahead - bend/(2 pi) sin(2 pi x/turn)), once per period of the drive (Arnold 1961)."""

    drive: float = gb.param("frequency", "rad/s")
    ahead: float = gb.param("part of a turn")
    bend: float = gb.param("nonlinearity")
    turn: float = gb.param("a turn")
    x = gb.State("state", start=0.3)

    def physics(self, s: Any) -> Any:
        on = gb.piecewise((1, gb.sin(s.drive * s.time - 1) >= 0), (0, True))
        bent = s.bend / (2 * np.pi) * gb.sin(2 * np.pi * s.x / s.turn)
        yield gb.Hold(s.x, s.x + s.turn * (s.ahead - bent), on)
        yield gb.Shows("x", s.x)


def _train(ahead: float, bend: float, turn: float = 1.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("circle")
    rig.add("map", Circle(drive=gb.Parameter("drive", 1.0, "rad/s"), ahead=ahead, bend=bend, turn=turn))
    return rig


def _known(ahead: float, bend: float, count: int = 200_000) -> tuple[float, float]:
    """Turns a step, and the exponent, by iteration: below bend = 1 the map is a diffeomorphism, and no exponent positive."""
    x = np.float64(0.3)
    for _ in range(1000):
        x += ahead - bend / (2 * np.pi) * np.sin(2 * np.pi * x)
    begun, grown = x, 0.0
    for _ in range(count):
        grown += np.log(abs(1 - bend * np.cos(2 * np.pi * x)))
        x += ahead - bend / (2 * np.pi) * np.sin(2 * np.pi * x)
    return float(x - begun) / count, grown / count


@pytest.mark.parametrize("turn", [1.0, 2 * np.pi])
def test_one_that_never_comes_back_is_quasi_periodic_at_its_rotation_number(turn: float) -> None:
    rotation, exponent = _known(0.618, 0.5)
    assert abs(exponent) < 1e-4  # it is none: a negative one were a period
    found = gb.classify(_train(0.618, 0.5, turn), SECTION)
    assert found.label == "quasi-periodic" and found.exponents is not None, found.evidence
    told = float(found.evidence[0].split("frequency, ")[1].split(" ")[0])
    assert min(told, 1 - told) == pytest.approx(min(rotation, 1 - rotation), abs=1e-5)


@pytest.mark.parametrize(("ahead", "bend", "period", "turns"), [(1.0, 0.5, 1, 1), (0.5, 0.9, 2, 1), (2.0, 0.3, 1, 2)])
def test_a_locked_one_goes_on_by_its_turns(ahead: float, bend: float, period: int, turns: int) -> None:
    rotation, exponent = _known(ahead, bend, 1000)
    found = gb.classify(_train(ahead, bend), SECTION)
    assert found.label == f"period {period}" and found.orbit is not None, found.evidence
    assert f"goes on by turns: map by +{turns}" in found.evidence[0] and rotation == pytest.approx(turns / period)
    assert np.log(abs(found.orbit.multipliers[0])) / period == pytest.approx(exponent, abs=1e-6)


@pytest.mark.parametrize("transient", [300, 3000])
def test_a_turn_that_is_not_found_gives_no_exponents(transient: int) -> None:
    # far out a difference of 1e-4 of the state is a part of a turn: the one that is locked, at -0.69, had +0.033 +- 0.002
    for ahead in (1.0, 0.618):
        found = gb.classify(_train(ahead, 0.5, 0.7123456), SECTION, transient=transient)
        assert found.label == "unresolved" and "map.x goes on" in found.evidence[0], found.evidence


def test_exponents_far_out_are_refused_and_those_near_the_start_are_right() -> None:
    train = _train(1.0, 0.5, 0.7123456)
    with pytest.raises(gb.SimulationError, match=r"map\.x goes on, to .* so far.*a shorter transient"):
        gb.lyapunov(train, SECTION)  # it was +0.033 +- 0.002
    near = gb.lyapunov(train, SECTION, periods=40, transient=0)
    assert near.values[0] * near.period == pytest.approx(_known(1.0, 0.5, 1000)[1], abs=2e-3)


def test_an_angle_that_is_read_at_two_incommensurable_waves_gives_no_exponents() -> None:
    # x' = 1.9 + sin x/2 + sin(sqrt(2) x)/2 but for a little inertia: a flow of one angle, with the exponent 0
    rig, x = gb.Drivetrain("rotor"), gb.sense("disc.phi")
    drive = gb.Parameter("drive", 1.0, "rad/s")
    tau = 1.9 + 0.5 * gb.sin(x) + 0.5 * gb.sin(2**0.5 * x) + 0 * drive
    rig.chain(
        rig.add("source", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=0.1)), rig.add("damper", gb.Damper(c=1.0)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    found = gb.classify(rig, SECTION)
    assert found.label == "unresolved" and "disc.phi goes on" in found.evidence[0], found.evidence
