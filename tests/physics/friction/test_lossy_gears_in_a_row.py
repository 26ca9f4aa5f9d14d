"""Lossy gears one behind the other with nothing between: all turn with the motor, each loses of what the next one asks for.

By hand: what enters a gear is (u + tau)/eta1 where it drives and eta2 (u + tau) where it is driven, u what leaves in its own
frame; the motor stands while its torque lies between what would enter in either direction.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

J, LOAD, K, C, DRAG = 1.0, 2.0, 400.0, 2.0, 0.5
TIMES = np.linspace(0.0, 6.0, 301)
GEARS = {
    "two": ((1.5, 0.95, 0.9, 0.1), (2.0, 0.92, 0.88, 0.2)),
    "two that turn back": ((-1.5, 0.9, 0.85, 0.3), (-0.5, 0.8, 0.7, 0.2)),
    "three": ((1.5, 0.95, 0.9, 0.1), (2.0, 0.92, 0.88, 0.2), (-0.8, 0.97, 0.96, 0.05)),
    "two without bearing torques": ((1.5, 0.95, 0.9, 0.0), (2.0, 0.92, 0.88, 0.0)),
}


def torque(t: float) -> float:
    return 12.0 * np.sin(2.0 * t)


def in_a_row(gears: tuple[tuple[float, ...], ...]) -> gb.Drivetrain:
    """A motor, gears with nothing between, a shaft, a load."""
    rig = gb.Drivetrain("gears in a row")
    motor, load = rig.add("motor", gb.Inertia(J=J, w0=2.0)), rig.add("load", gb.Inertia(J=LOAD))
    parts = [
        rig.add(f"gear{i}", gb.LossyGear(ratio=r, efficiency=(eta1, eta2), bearing=(tau, tau)))
        for i, (r, eta1, eta2, tau) in enumerate(gears)
    ]
    drive = rig.add("drive", gb.Torque(tau=12.0 * gb.sin(2.0 * gb.time)))
    drag = rig.add("drag", gb.SpeedLoad(coeffs=(0.0, DRAG, 0.0)))
    rig.chain(drive, motor, *parts, rig.add("shaft", gb.Shaft(k=K, c=C)), load, drag)
    return rig


def by_hand(gears: tuple[tuple[float, ...], ...]) -> tuple[np.ndarray, np.ndarray]:
    """Speeds of motor and load, one phase of sliding or rest after the other."""
    whole = float(np.prod([g[0] for g in gears]))

    def enters(y: np.ndarray, direction: float) -> float:
        u = K * (y[0] / whole - y[2]) + C * (y[1] / whole - y[3])
        for ratio, eta1, eta2, tau in reversed(gears):
            ahead = direction * np.prod([np.sign(g[0]) for g in gears[: gears.index((ratio, eta1, eta2, tau))]])
            moved = ahead * u / ratio + tau
            u = ahead * (moved / eta1 if moved >= 0 else eta2 * moved)
        return float(u)

    def rates(t: float, y: np.ndarray, mode: float) -> list[float]:
        shaft = K * (y[0] / whole - y[2]) + C * (y[1] / whole - y[3])
        alpha = (torque(t) - enters(y, mode)) / J if mode else 0.0
        return [y[1], alpha, y[3], (shaft - DRAG * y[3]) / LOAD]

    def ends(t: float, y: np.ndarray, mode: float) -> float:
        if mode:
            return mode * y[1]
        return min(enters(y, 1.0) - torque(t), torque(t) - enters(y, -1.0))

    ends.terminal, ends.direction = True, -1  # type: ignore[attr-defined]
    t, y, mode, out = 0.0, np.array([0.0, 2.0, 0.0, 0.0]), 1.0, np.full((4, len(TIMES)), np.nan)
    while t < TIMES[-1]:
        part = solve_ivp(
            rates,
            (t, TIMES[-1]),
            y,
            "DOP853",
            dense_output=True,
            events=ends,
            args=(mode,),
            rtol=1e-11,
            atol=1e-12,
            max_step=0.01,
        )
        inside = (t <= TIMES) & (part.t[-1] >= TIMES)
        out[:, inside] = part.sol(TIMES[inside])
        t, y = float(part.t[-1]), part.y[:, -1]
        if part.status != 1:
            break
        if mode:
            y[1] = 0.0
        before = mode
        mode = 1.0 if torque(t) >= enters(y, 1.0) - 1e-9 else -1.0 if torque(t) <= enters(y, -1.0) + 1e-9 else 0.0
        if before and mode == before:
            mode = 0.0
        t += 1e-13
    return out[1], out[3]


@pytest.mark.parametrize("method", ["auto", "rodas"])
@pytest.mark.parametrize("name", GEARS)
def test_each_gear_takes_its_loss_of_what_the_next_one_asks_for(name: str, method: str) -> None:
    motor, load = by_hand(GEARS[name])
    run = gb.simulate(in_a_row(GEARS[name]), t=TIMES, method=method, rtol=1e-9)
    np.testing.assert_allclose(run["motor.w"], motor, atol=1e-6)
    np.testing.assert_allclose(run["load.w"], load, atol=1e-6)
    assert run.energy.residual < 1e-7
    assert [e for e in run.events if e.component == "gear0"]  # it comes to rest, or turns back


def test_between_gaps_nothing_tells_their_losses_apart_and_a_tiny_inertia_that_is_not_stiff_does() -> None:
    def between(J_mid: float) -> gb.Drivetrain:
        rig = gb.Drivetrain("gears between gaps")
        motor, load = rig.add("motor", gb.Inertia(J=J, w0=2.0)), rig.add("load", gb.Inertia(J=LOAD))
        gap = {"k": K, "c": C, "half_gap": 0.02, "contact_damping": "always"}
        one, two = (gb.LossyGear(ratio=r, efficiency=(0.95, 0.9), bearing=(0.1, 0.1)) for r in (1.5, 2.0))
        middle = [rig.add("middle", gb.Inertia(J=J_mid))] if J_mid else []
        rig.chain(
            rig.add("drive", gb.Torque(tau=10.0 * gb.sin(5.0 * gb.time))), motor, rig.add("gap", gb.Lash(**gap)),
            rig.add("one", one), *middle, rig.add("two", two), rig.add("other_gap", gb.Lash(**gap)), load,
        )  # fmt: skip
        return rig

    with pytest.raises(
        gb.ModelError, match=r"'two': several elements that can stick .* put an Inertia there; 1e-6 of that"
    ):
        gb.build(between(0.0))
    coarse, fine = (gb.simulate(between(x), t=TIMES, rtol=1e-8) for x in (1e-4, 1e-6))
    assert np.abs(coarse["load.w"] - fine["load.w"]).max() < 1e-3
    assert fine.stats.steps < 3000
