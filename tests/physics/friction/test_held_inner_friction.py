"""Inner friction of a shaft that a clutch beside it holds: its slip is rounding, which no look at its sign resolves.

Independent: held, the train has the two linear equations of motion of a body on a spring and a planetary set, by scipy.
"""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

DRIVE, SIDE, ONE, TWO, STIFFNESS, END = 0.35, 1.42, 0.0264, 0.5, 91.0, 0.5


def _tau(t: Any) -> Any:
    return 2 * (np if isinstance(t, float) else gb).cos(16 * t)


def _train(ratio: float | None, capacity: Any) -> gb.Drivetrain:
    """drive on a planetary set (without a ratio: a differential) with `side` and `one`; clutch and shaft from `one` to
    `two`, which a spring holds."""
    rig = gb.Drivetrain("held inner friction")
    drive, side, one, two = (
        rig.add(name, gb.Inertia(J=J, **{} if name == "one" else {"w0": 0.0}))
        for name, J in (("drive", DRIVE), ("side", SIDE), ("one", ONE), ("two", TWO))
    )
    if ratio is None:
        pair = rig.add("pair", gb.Differential())
        rig.connect(drive.a, pair.carrier)
        rig.connect(side.a, pair.right)
        rig.connect(one.a, pair.left)
    else:
        gear = rig.add("gear", gb.IdealPlanetary(ratio=ratio))
        rig.connect(drive.a, gear.carrier)
        rig.connect(side.a, gear.ring)
        rig.connect(one.a, gear.sun)
    inner = gb.Hysteresis(friction=0.5, stiffness=2.51)
    shaft, clutch = (
        rig.add("shaft", gb.Shaft(k=2.51, hysteresis=inner)),
        rig.add("clutch", gb.Clutch(capacity=capacity)),
    )
    rig.connect(one.b, shaft.a, clutch.a)
    rig.connect(two.a, shaft.b, clutch.b)
    rig.chain(rig.add("torque", gb.Torque(tau=_tau(gb.time))), drive)
    rig.chain(two, rig.add("spring", gb.Shaft(k=STIFFNESS)), rig.add("wall", gb.Fixed()))
    return rig


def _held(ratio: float | None, end: float) -> np.ndarray:
    """Angles and speeds of `drive` and of what the clutch holds together."""
    r = 1.0 if ratio is None else ratio
    g = np.array([(1 + r) / r, -1 / r])
    mobility = np.linalg.inv(np.diag([DRIVE, ONE + TWO]) + SIDE * np.outer(g, g))

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[2:], mobility @ np.array([_tau(float(t)), -STIFFNESS * y[1]])])

    return solve_ivp(rates, (0, end), np.zeros(4), method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]


@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize("ratio", [0.5, 2.5, None])
@pytest.mark.few(1)
def test_what_a_clutch_holds_moves_as_one(ratio: float | None, method: str) -> None:
    rtol = 1e-7
    run = gb.simulate(_train(ratio, 200.0), t_end=END, method=method, rtol=rtol)
    right = _held(ratio, END)
    assert [run["drive.w"][-1], run["two.w"][-1]] == pytest.approx(right[2:], rel=100 * rtol)
    assert np.abs(run["shaft.twist"]).max() < 1e-12
    assert run.energy.dissipated["shaft"] < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("ratio", [0.5, 2.5, None])
def test_it_slips_from_the_instant_at_which_the_clutch_lets_go(ratio: float | None) -> None:
    """A clutch that opens at once: the shaft holds what its springs and its slider are wound by from there on."""
    opens, rtol = 0.25, 1e-8
    capacity = gb.piecewise((200.0, gb.time < opens), (0.0, True))
    run = gb.simulate(_train(ratio, capacity), t=[opens, END], method="dp8", rtol=rtol)
    r = 1.0 if ratio is None else ratio
    g = np.array([(1 + r) / r, -1 / r, 0.0])  # of `side` with drive, one, two
    mobility = np.linalg.inv(np.diag([DRIVE, ONE, TWO]) + SIDE * np.outer(g, g))

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        rate = y[5] - y[4]
        torque = 2.51 * (y[2] - y[1]) + y[6]
        slips = abs(y[6]) >= 0.5 and y[6] * rate > 0
        force = np.array([_tau(float(t)), torque, -torque - STIFFNESS * y[2]])
        return np.concatenate([y[3:6], mobility @ force, [0.0 if slips else 2.51 * rate]])

    start = _held(ratio, opens)
    y0 = np.array([start[0], start[1], start[1], start[2], start[3], start[3], 0.0])
    right = solve_ivp(rates, (opens, END), y0, method="DOP853", rtol=1e-10, atol=1e-13, max_step=2e-4).y[:, -1]
    found = [run["drive.w"][-1], run["one.w"][-1], run["two.w"][-1]]
    assert found == pytest.approx(right[3:6], abs=1e-5 * np.abs(right[3:6]).max())  # the slider jumps inside its steps
    assert abs(run["shaft.twist"][-1]) > 1e-3
