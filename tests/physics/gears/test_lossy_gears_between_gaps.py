"""Lossy gears and clutches without inertia beside gaps whose damping is clipped, the default.

Where the gear breaks away, or both gaps press at their clip, the balance of its torques has no pivot: modes change
together, or the speed is the one at which the springs stay in proportion. Independent: small inertias there, three of
them, extrapolated in powers of their root, as a body flies through its gap for a time like that.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 1.0, 21)
SIZES = (4e-7, 2e-7, 1e-7)

BETWEEN = {
    "both at their clip": (
        (0.455, -7.92, 0.119, 0.91), (30.9, 3.85, 5.8, 1.4), ({"lower": -0.0134}, 1105.0, 6.75),
        (1.31, (0.633, 0.872), 1.74), ({"half_gap": 0.0154}, 788.0, 3.66),
    ),
    "clip and friction let go at once": (
        (0.557, 6.54, 0.5, 0.38), (13.8, 9.86, 3.6, 1.58), ({"half_gap": 0.0105}, 1381.0, 6.14),
        (2.25, (0.649, 0.636), 0.61), ({"half_gap": 0.0364}, 595.0, 5.16),
    ),
    "just after the start": (
        (0.185, 4.55, 0.501, -4.02), (38.2, 6.22, 0.0, 1.66), ({"half_gap": 0.0081}, 1640.0, 5.48),
        (1.94, (0.745, 0.797), 1.28), ({"half_gap": 0.0034}, 1433.0, 14.75),
    ),
    "three modes change at once": (
        (0.314, 7.24, 0.212, 3.35), (24.3, 5.01, 4.9, 1.46), ({"half_gap": 0.0439}, 1821.0, 12.93),
        (0.9, (0.785, 0.603), 0.35), ({"half_gap": 0.0275}, 1119.0, 4.76),
    ),
}  # fmt: skip
"""J, w0, J, w0 of the bodies; torque, frequency and phase of the drive, drag of the load; gap, k and c; ratio, efficiencies,
bearing torque; gap, k and c. None: a damped shaft in its place."""

BESIDE_A_SHAFT = {
    "bearing": (
        (0.489, -9.04, 0.496, 0.98), (23.6, 3.16, 2.8, 0.49), ({"half_gap": 0.0229}, 1882.0, 7.78),
        (-0.53, (0.625, 0.943), 0.39), ({}, 566.0, 3.96),
    ),
    "no bearing": (
        (0.3, -6.0, 0.4, 1.0), (25.0, 7.0, 1.0, 0.8), ({"half_gap": 0.02}, 900.0, 6.0),
        (1.7, (0.7, 0.8), None), ({}, 700.0, 3.0),
    ),
}  # fmt: skip


def _rig(values: Any, inertia: float = 0.0, element: gb.Block | None = None) -> gb.Drivetrain:
    (J1, w1, J2, w2), (size, frequency, phase, drag), first, (ratio, efficiency, tau), second = values
    rig = gb.Drivetrain("between gaps")
    one, other = rig.add("one", gb.Inertia(J=J1, w0=w1)), rig.add("other", gb.Inertia(J=J2, w0=w2))
    rig.connect(rig.add("drive", gb.Torque(tau=size * gb.sin(frequency * gb.time + phase))).flange, one.a)
    rig.connect(rig.add("load", gb.Torque(tau=-drag * gb.sense("other.w"))).flange, other.a)
    before, behind = (gb.Lash(k=k, c=c, **ends) if ends else gb.Shaft(k=k, c=c) for ends, k, c in (first, second))
    losses = {"efficiency": efficiency} | ({} if tau is None else {"bearing": (tau, tau)})
    gear = rig.add("gear", element or gb.LossyGear(ratio=ratio, **losses))
    rig.chain(one, rig.add("first", before), gear, rig.add("second", behind), other)
    for name, at in (("at_a", gear.a), ("at_b", gear.b)) if inertia else ():
        rig.connect(at, rig.add(name, gb.Inertia(J=inertia)).a)
    return rig


def _limit(values: Any, body: str) -> np.ndarray:
    """Of vanishing inertias: a + b J^(1/2) + c J."""
    sizes = np.array(SIZES) / SIZES[-1]
    runs = np.stack([gb.simulate(_rig(values, J), t=T, rtol=1e-9)[body] for J in SIZES])
    return np.linalg.solve(np.stack([sizes**0, sizes**0.5, sizes], 1), runs)[0]


@pytest.mark.parametrize("name", [
    pytest.param(n, marks=() if n == "three modes change at once" else pytest.mark.long) for n in BETWEEN
])  # fmt: skip
def test_a_lossy_gear_between_two_gaps_is_the_limit_of_a_vanishing_inertia(name: str) -> None:
    run = gb.simulate(_rig(BETWEEN[name]), t=T, rtol=1e-9)
    assert run.energy.residual < 1e-8
    for body in ("one.w", "other.w"):  # the inertias themselves change the motion by up to 3e-4
        assert np.abs(run[body] - _limit(BETWEEN[name], body)).max() < 1e-5 * np.abs(run[body]).max()


@pytest.mark.parametrize("name", [
    pytest.param(n, marks=() if n == "no bearing" else pytest.mark.long) for n in BESIDE_A_SHAFT
])  # fmt: skip
def test_a_lossy_gear_between_a_gap_and_a_shaft_is_the_limit_of_a_vanishing_inertia(name: str) -> None:
    run = gb.simulate(_rig(BESIDE_A_SHAFT[name]), t=T, rtol=1e-9)
    assert run.energy.residual < 1e-8
    for body in ("one.w", "other.w"):
        assert np.abs(run[body] - _limit(BESIDE_A_SHAFT[name], body)).max() < 1e-6 * np.abs(run[body]).max()


def test_a_clutch_between_open_gaps_is_refused_by_name() -> None:
    """Nothing tells how fast it turns as a whole."""
    rig = _rig(BETWEEN["both at their clip"], element=gb.Clutch(capacity=5.0))
    with pytest.raises(gb.SimulationError, match=r"'gear': nothing tells how fast its side a turns.*always.*Inertia"):
        gb.simulate(rig, t_end=0.1)


def test_both_springs_at_their_clip_stay_in_proportion() -> None:
    """By hand: T_1 = 2 k_1 g_1 enters the gear and T_2 = 2 k_2 g_2 leaves it, T_1 = (i T_2 + tau)/eta."""
    run = gb.simulate(_rig(BETWEEN["both at their clip"]), t_end=1.0, rtol=1e-9)
    entering, leaving = run["gear.torque_a"], run["gear.torque"]
    sizes = [
        2 * k * np.maximum(np.maximum(x - upper, lower - x), 0.0)
        for x, k, lower, upper in (
            (run["first.twist"], 1105.0, -0.0134, np.inf), (run["second.twist"], 788.0, -0.0154, 0.0154),
        )
    ]  # fmt: skip
    at_clip = [np.abs(np.abs(tau) - s) <= 1e-7 * s for tau, s in zip((entering, leaving), sizes, strict=True)]
    both = at_clip[0] & at_clip[1] & (sizes[0] > 0.1) & (sizes[1] > 0.1)
    assert both.sum() > 3
    assert (run["gear.mode"][both] != 0).all()
