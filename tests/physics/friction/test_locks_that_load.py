"""A rising torque on what a friction holds, beside gears that nothing else moves: all that moves them is what rounding
leaves of two forces that cancel. They have no scale but that rounding, and the step control must not resolve it."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

J1, J2, J3 = 1.0, 1.0, 0.2
HELD = 1.0
# What rises, the same as numbers, its integral, and when it is as large as the friction holds.
RISES: dict[str, tuple[Any, Callable[[float], float], float]] = {
    "linear": (20 * gb.time, lambda t: 10 * t**2, 0.05),
    "late": (
        gb.piecewise((30 * (gb.time - 0.03), gb.time > 0.03), (0.0, True)),
        lambda t: 15 * max(t - 0.03, 0.0) ** 2,
        0.03 + 1 / 30,
    ),
    "table": (gb.Table([0.0, 0.1], [0.0, 2.0]), lambda t: 10 * t**2, 0.05),
}


# Gears that tie three shafts, their flanges, and g of g1 w1 + g2 w2 + g3 w3 = 0.
GEARS: dict[str, tuple[gb.Block, tuple[str, str, str], tuple[float, float, float]]] = {
    "differential": (gb.Differential(ratio=1), ("left", "carrier", "right"), (1.0, -2.0, 1.0)),
    "planetary": (gb.IdealPlanetary(ratio=2.0), ("sun", "carrier", "ring"), (1.0, -3.0, 2.0)),
}


def _share(g1: float, g2: float, g3: float) -> tuple[float, float]:
    """What J2 and J3, which only the force of the gears moves, add to J1, and w2 / w1."""
    compliance = g2**2 / J2 + g3**2 / J3
    return g1**2 / compliance, -g1 * g2 / J2 / compliance


@pytest.mark.parametrize("method", ["auto", "dp5"])
@pytest.mark.parametrize("gears", sorted(GEARS))
@pytest.mark.parametrize(
    "rise", [pytest.param(name, marks=[pytest.mark.long] * (name == "linear")) for name in sorted(RISES)]
)
@pytest.mark.few(1)
def test_gears_beside_a_friction_that_is_loaded(rise: str, gears: str, method: str) -> None:
    """All rests until the torque is what the friction holds; its excess moves all three, in closed form."""
    torque, impulse, breaks = RISES[rise]
    rig = gb.Drivetrain("a friction that is loaded")
    first, second, third = (rig.add(f"j{i + 1}", gb.Inertia(J=J)) for i, J in enumerate((J1, J2, J3)))
    block, flanges, factors = GEARS[gears]
    ties, (added, ratio) = rig.add("gears", block), _share(*factors)
    for body, flange in zip((first, second, third), flanges, strict=True):
        rig.connect(body.a, getattr(ties, flange))
    bearing = rig.add("bearing", gb.BearingFriction(coulomb=HELD))
    motor = rig.add("motor", gb.Torque(tau=torque))
    rig.connect(first.b, bearing.a, motor.flange)
    end = 0.1
    run = gb.simulate(rig, t_end=end, method=method)
    held = np.asarray(run.t) < breaks - 1e-6
    for body in ("j1", "j2", "j3"):
        assert np.abs(np.asarray(run[f"{body}.w"])[held]).max() < 1e-12
    speed = (impulse(end) - impulse(breaks) - HELD * (end - breaks)) / (J1 + added)
    assert math.isclose(run["j1.w"][-1], speed, rel_tol=1e-5)
    assert math.isclose(run["j2.w"][-1], ratio * speed, rel_tol=1e-5)
    assert run.stats.steps < 300


@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize(
    ("inertias", "ratio", "late"),
    [
        ((1.0, 1.0, 0.2), 2.0, 0.03),  # as above
        pytest.param((0.3107, 0.0986, 0.0014), 3.38, 0.005, marks=pytest.mark.long),
        ((0.1132, 0.011, 0.0368), 2.27, 0.016),
    ],
)
def test_energies_that_rounding_alone_exchanges_do_not_shorten_steps(
    inertias: tuple[float, ...], ratio: float, late: float, method: str
) -> None:
    """The sun is held, planets' carrier and ring are free and without any scale of speed: closed form behind the break."""
    rig = gb.Drivetrain("free planets")
    sun, carrier, ring = (rig.add(name, gb.Inertia(J=J)) for name, J in zip("scr", inertias, strict=True))
    gears, slope = rig.add("gears", gb.IdealPlanetary(ratio=ratio)), 30.0
    for body, flange in ((sun, gears.sun), (carrier, gears.carrier), (ring, gears.ring)):
        rig.connect(body.a, flange)
    torque = gb.piecewise((slope * (gb.time - late), gb.time > late), (0.0, True))
    rig.connect(
        sun.b, rig.add("bearing", gb.BearingFriction(coulomb=HELD)).a, rig.add("m", gb.Torque(tau=torque)).flange
    )
    compliance = (1 + ratio) ** 2 / inertias[1] + ratio**2 / inertias[2]
    breaks, end = late + HELD / slope, late + 1.5 * HELD / slope
    speed = slope * (end - breaks) ** 2 / 2 / (inertias[0] + 1 / compliance)
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
        assert run["s.w"][-1] == pytest.approx(speed, rel=10 * rtol), rtol
        assert run.stats.steps < 300, rtol
