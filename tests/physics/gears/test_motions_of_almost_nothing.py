"""Motions that come out of nothing and go to nothing, through magnitudes without digits, beside gears and clutches."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

T = gb.time
METHODS = ("auto", "dp5", "dp8", "rodas")
HALVES = {
    "lossy gear": lambda: gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8)),
    "gear without losses": lambda: gb.LossyGear(ratio=2.0, efficiency=(1.0, 1.0)),
    "self-locking gear": lambda: gb.LossyGear(ratio=2.0, efficiency=(0.6, 0.3)),
    "loss table": lambda: gb.LossyGear(ratio=2.0, loss_table=((0.0, 0.9, 0.8, 0.0, 0.0), (10.0, 0.8, 0.7, 0.0, 0.0))),
    "freewheel": gb.Freewheel,
    "clutch that fades": lambda: gb.Clutch(capacity=gb.exp(-T)),
}


def _swings(element: gb.Block, *behind: gb.Block) -> gb.Drivetrain:
    """A body on a damped spring, and another one behind the element."""
    rig = gb.Drivetrain("fades")
    parts = [gb.Fixed(), gb.Shaft(k=100.0, c=3.0), gb.Inertia(J=1.0, w0=1.0), element, gb.Inertia(J=1.0), *behind]
    rig.chain(
        *(
            rig.add(name, part)
            for name, part in zip(("ground", "spring", "a", "e", "b", "s", "c", "f", "d"), parts, strict=False)
        )
    )
    return rig


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.long] * (x != "lossy gear")) for x in HALVES])
def test_what_swings_for_thousands_of_periods_comes_to_rest(name: str) -> None:
    """It fades by e in some two seconds: after 3000 s it is far below the smallest number there is."""
    model = gb.build(_swings(HALVES[name]()))
    for method in METHODS:
        run = gb.simulate(model, t=[0.0, 3000.0], method=method, rtol=1e-6)
        assert abs(run["a.w"][-1]) < 10 * 1e-6, method
        assert run.stats.steps < 2e4, method


def test_two_lossy_gears_in_a_row_come_to_rest() -> None:
    behind = (
        gb.Shaft(k=50.0, c=2.0),
        gb.Inertia(J=1.0),
        gb.LossyGear(ratio=-0.5, efficiency=(0.7, 0.9)),
        gb.Inertia(J=0.3),
    )
    model = gb.build(_swings(HALVES["lossy gear"](), *behind))
    for method, rtol in (("auto", 1e-4), ("dp8", 1e-4), ("dp8", 1e-6), ("rodas", 1e-8)):
        run = gb.simulate(model, t=[0.0, 3000.0], method=method, rtol=rtol)
        assert abs(run["d.w"][-1]) < 10 * rtol, (method, rtol)


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_moves_a_lossy_gear_from_rest(method: str) -> None:
    """J = 2 in, 1 out, i = 2, 0.9 forward: w = int tau dt/(2 + 1/(4 0.9)); the first load is 1e-320 N m."""
    rig = gb.Drivetrain("pulse")
    pulse = gb.Torque(tau=100 * gb.exp(-(((T - 1.3) / 0.01) ** 2)))
    parts = (pulse, gb.Inertia(J=2.0), HALVES["lossy gear"](), gb.Inertia(J=1.0))
    rig.chain(*(rig.add(name, part) for name, part in zip("pagb", parts, strict=True)))
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(rig, t=[0.0, 2.0], method=method, rtol=rtol)
        assert run["a.w"][-1] == pytest.approx(np.sqrt(np.pi) / (2 + 1 / 3.6), rel=10 * rtol)


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_moves_two_lossy_gears_that_a_shaft_joins(method: str) -> None:
    """Which side the second one is on is told from loads that are followed. Right: by "rodas" in steps of at most 1 ms."""
    gears = (gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.7)), gb.LossyGear(ratio=10.0, efficiency=(0.6, 0.3)))
    bodies = (gb.Inertia(J=1.0), gb.Inertia(J=0.1), gb.Inertia(J=0.2), gb.Inertia(J=3.0))
    pulse, shaft = gb.Torque(tau=30 * gb.exp(-(((T - 1.0) / 0.03) ** 2))), gb.Shaft(k=300.0, c=1.0)
    parts = (pulse, bodies[0], gears[0], bodies[1], shaft, bodies[2], gears[1], bodies[3])
    rig = gb.Drivetrain("two")
    rig.chain(*(rig.add(name, part) for name, part in zip("pagbschd", parts, strict=True)))
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(rig, t=[0.0, 2.0], method=method, rtol=rtol)
        assert run["a.w"][-1] == pytest.approx(1.3191889937535, rel=10 * rtol)


def test_a_load_that_has_faded_over_the_angle_asks_for_no_short_steps() -> None:
    """How fast the laws answer is found in directions whose products had underflowed: 1e-9 s a step by "dp8"."""
    rig, phi = gb.Drivetrain("hill"), gb.sense("a.phi")
    parts = {
        "load": gb.Torque(tau=50 * gb.exp(-(((phi - 2.0) / 0.01) ** 2))),
        "a": gb.Inertia(J=1.0, w0=1.0),
        "clutch": gb.Clutch(capacity=5 * gb.exp(-(((T - 1.0) / 0.03) ** 2))),
        "b": gb.Inertia(J=1.0, w0=1.0),
    }
    rig.chain(*(rig.add(name, part) for name, part in parts.items()))
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(rig, t=[0.0, 4.0], method="dp8", rtol=rtol)
        assert run["a.w"][-1] == pytest.approx(np.sqrt(1 + np.sqrt(np.pi)), rel=10 * rtol)
        assert run.stats.steps < 200
