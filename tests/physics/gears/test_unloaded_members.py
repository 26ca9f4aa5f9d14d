"""Unloaded members behind gears and frictions that hold, while a torque rises: what moves them is rounding alone.

Closed form: as long as they hold nothing moves; from then on the train has one degree of freedom for the sun, and the carrier
and the ring, which nothing loads, divide its acceleration by their inertias.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

FIRST, SECOND, CARRIER, RING, TEETH = 0.0636, 0.5, 0.123, 0.258, 2.5
PEAK, PULSE = 100.0, 4.4
DRIVING, BEARING, RATIO = 0.433, 1.84, 1.5


def _unloaded(rig: gb.Drivetrain, first: Any) -> float:
    """A planetary gear whose sun is there; the inertia that the sun has of it."""
    carrier, ring = rig.add("carrier", gb.Inertia(J=CARRIER)), rig.add("ring", gb.Inertia(J=RING))
    planet = rig.add("planet", gb.IdealPlanetary(ratio=TEETH))
    rig.connect(first.b, planet.sun)
    rig.connect(carrier.a, planet.carrier)
    rig.connect(ring.a, planet.ring)
    return 1.0 / ((1.0 + TEETH) ** 2 / CARRIER + TEETH**2 / RING)


def _gear(rig: gb.Drivetrain, first: Any) -> tuple[float, float]:
    """A lossy gear with bearings and a body behind it: the torque that it holds, the inertia of what moves then."""
    second = rig.add("second", gb.Inertia(J=SECOND))
    gear = rig.add("gear", gb.LossyGear(ratio=RATIO, efficiency=(DRIVING, 0.82), bearing=(BEARING, BEARING)))
    rig.connect(first.a, gear.a)
    rig.connect(gear.b, second.a)
    return BEARING / DRIVING, SECOND / RATIO**2 / DRIVING


def _brake(rig: gb.Drivetrain, first: Any) -> tuple[float, float]:
    """A gear without losses and a brake behind it."""
    second = rig.add("second", gb.Inertia(J=SECOND))
    gear, brake = rig.add("gear", gb.IdealGear(ratio=RATIO)), rig.add("brake", gb.Brake(capacity=6.0))
    rig.connect(first.a, gear.a)
    rig.connect(gear.b, second.a)
    rig.connect(brake.a, second.b)
    return 6.0 / RATIO, SECOND / RATIO**2


def _drive(rig: gb.Drivetrain, first: Any, behind: bool) -> tuple[float, float]:
    """The torque, on the first body or behind another lossy gear: its part that comes to the first, inertia there."""
    torque = rig.add("torque", gb.Torque(tau=PEAK * gb.sin(PULSE * gb.time)))
    if not behind:
        rig.connect(torque.flange, first.a)
        return 1.0, 0.0
    motor = rig.add("motor", gb.Inertia(J=0.2))
    gear = rig.add("entry", gb.LossyGear(ratio=-2.0, efficiency=(0.776, 0.9)))
    rig.connect(torque.flange, motor.a)
    rig.connect(motor.b, gear.a)
    rig.connect(gear.b, first.a)
    return -2.0 * 0.776, 0.2 * 4.0 * 0.776


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize("hold", [_gear, _brake])
@pytest.mark.few(1)
def test_they_rest_until_what_holds_them_lets_go(hold: Any, behind: bool, method: str, rtol: float) -> None:
    rig = gb.Drivetrain("unloaded members")
    first = rig.add("first", gb.Inertia(J=FIRST))
    part, more = _drive(rig, first, behind)
    planet = _unloaded(rig, first)
    held, inertia = hold(rig, first)
    t = np.linspace(0.0, 0.05, 26)
    run = gb.simulate(rig, t=t, method=method, rtol=rtol)
    begin = np.arcsin(held / abs(part) / PEAK) / PULSE
    pushed = PEAK * abs(part) * (np.cos(PULSE * begin) - np.cos(PULSE * t)) / PULSE - held * (t - begin)
    speed = np.where(t > begin, pushed, 0.0) * np.sign(part) / (FIRST + more + planet + inertia)
    largest = np.abs(speed).max()
    assert run["first.w"] == pytest.approx(speed, abs=30 * rtol * largest)
    assert run["carrier.w"] == pytest.approx((1.0 + TEETH) * planet / CARRIER * speed, abs=30 * rtol * largest)
    assert run["ring.w"] == pytest.approx(-TEETH * planet / RING * speed, abs=30 * rtol * largest)
    assert np.abs(run["ring.w"][t <= begin]).max() < 1e-14
    assert run.stats.steps < 1000


@pytest.mark.long
@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-4), ("dp8", 1e-6), ("rodas", 1e-9)])
@pytest.mark.parametrize("spring", [False, True])
@pytest.mark.parametrize("gears", [1, 2, 3])
def test_the_energy_of_what_rests_is_rounding(gears: int, spring: bool, method: str, rtol: float) -> None:
    """Rows of gears that hold, behind them a body on a damped spring: powers of speeds that are rounding ask for no steps."""
    rig = gb.Drivetrain("unloaded members")
    first = rig.add("first", gb.Inertia(J=FIRST))
    _unloaded(rig, first)
    last = first
    for number in range(gears):
        body = rig.add(f"body{number}", gb.Inertia(J=0.1))
        rests = (0.0581, 0.0581) if number == 0 else None
        gear = rig.add(f"gear{number}", gb.LossyGear(ratio=2.5, efficiency=(0.6, 0.984), bearing=rests))
        rig.connect(last.a if number == 0 else last.b, gear.a)
        rig.connect(gear.b, body.a)
        last = body
    if spring:
        shaft, other = rig.add("shaft", gb.Shaft(k=115.0, c=0.478)), rig.add("other", gb.Inertia(J=2.0))
        rig.connect(last.b, shaft.a)
        rig.connect(shaft.b, other.a)
    rig.connect(rig.add("torque", gb.Torque(tau=0.278 * gb.sin(4.35 * gb.time))).flange, first.b)
    run = gb.simulate(rig, t_end=0.004, method=method, rtol=rtol)
    assert all(np.abs(run[f"{name}.w"]).max() < 1e-15 for name in ("first", "carrier", "ring", "body0"))
    assert run.stats.steps < 1000
