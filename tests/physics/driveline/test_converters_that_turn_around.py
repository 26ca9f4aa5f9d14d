"""A torque converter whose impeller swings: where it turns around, the speed ratio goes through its whole table within the
rounding of the time, and all of that asks for no step. Against DOP853 on the equations written out."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

CAPACITY, RATIO = ([0.0, 0.8, 1.0], [2e-3, 1.5e-3, 1e-4]), ([0.0, 0.85, 1.0, 1.2], [1.9, 1.0, 0.98, 0.0])
J_I, J_T, K, W_I, T_END = 0.0118, 0.5, 2000.0, -18.3, 0.3


@cache
def _right(w_t: float) -> np.ndarray:
    def rates(t: float, y: np.ndarray) -> list[float]:
        phi, w_i, w_t = y
        nu = w_t * w_i / (w_i * w_i + 1e-12)
        taken = np.interp(nu, *CAPACITY) * w_i * abs(w_i)
        return [w_i, (-K * phi - taken) / J_I, np.interp(nu, *RATIO) * taken / J_T]

    return solve_ivp(rates, (0, T_END), [0, W_I, w_t], "DOP853", rtol=1e-12, atol=1e-12, max_step=1e-3).y[:, -1]


@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-9), ("dp8", 1e-8), ("rodas", 1e-7), ("auto", 1e-6)])
@pytest.mark.parametrize("w_t", [3.0, -3.0, 0.5])
@pytest.mark.few(1)
def test_the_impeller_swings_on_a_spring(w_t: float, method: str, rtol: float) -> None:
    rig = gb.Drivetrain("swing")
    impeller, turbine = rig.add("impeller", gb.Inertia(J=J_I, w0=W_I)), rig.add("turbine", gb.Inertia(J=J_T, w0=w_t))
    spring, ground = rig.add("spring", gb.Shaft(k=K)), rig.add("ground", gb.Fixed())
    converter = rig.add("converter", gb.TorqueConverter(capacity=gb.Table(*CAPACITY), ratio=gb.Table(*RATIO)))
    rig.chain(ground, spring, impeller)
    rig.connect(impeller.b, converter.impeller)
    rig.connect(turbine.a, converter.turbine)
    run = gb.simulate(rig, t_end=T_END, method=method, rtol=rtol)
    off = np.abs(np.array([run["impeller.w"][-1], run["turbine.w"][-1]]) - _right(w_t)[1:])
    assert off.max() <= 20 * rtol * abs(W_I)
