"""A branch of a condition counts where it holds: elsewhere it may be infinite, or have no value at all."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.special import sici

import gearblocks as gb

w, phi, t = gb.sense("disc.w"), gb.sense("disc.phi"), gb.time
POWER = math.sqrt(500.0)  # 10 N m up to 10 rad/s at 1 s, then 100 W for 2 s


def _after_half(run: gb.Trajectory) -> float:
    return math.sqrt(100.0 + 2 * math.log(run["disc.phi"][-1] / 0.5))


# torque on a disc of 1 kg m2, its speed at the start, and the one at 3 s in closed form
LAWS: dict[str, tuple[Any, float, float | Callable[[gb.Trajectory], float]]] = {
    "power limit as the smaller one": (gb.minimum(10.0, 100 / w), 0.0, POWER),
    "the same the other way round": (gb.minimum(100 / w, 10.0), 0.0, POWER),
    "the larger one": (-gb.maximum(-10.0, -100 / w), 0.0, POWER),
    "power limit by a condition": (gb.piecewise((10.0, w < 10.0), (100 / w, True)), 0.0, POWER),
    "inverse of the speed down to rest": (
        gb.piecewise((-1e2 * w, abs(w) < 1), (-1e2 / w, True)), 10.0, 0.0,
    ),
    "inverse of the time": (gb.piecewise((0.0, t < 1), (1 / t, True)), 10.0, 10 + math.log(3.0)),
    "logarithm": (gb.piecewise((0.0, t < 1), (gb.log(t), True)), 10.0, 10 + 3 * math.log(3.0) - 2),
    "root": (gb.piecewise((gb.sqrt(1 - t), t < 1), (0.0, True)), 10.0, 10 + 2 / 3),
    "sine over its argument": (
        gb.piecewise((1.0, abs(t - 1) < 1e-4), (gb.sin(t - 1) / (t - 1), True)), 10.0, 10 + sum(sici(x)[0] for x in (1, 2)),
    ),
    "inverse of the angle": (gb.piecewise((0.0, phi <= 0.5), (1 / phi, True)), 10.0, _after_half),
    "overflow": (gb.piecewise((1.0, phi < 1), (0.0, phi < 29.9), (gb.exp(-phi**3), True)), 10.0, math.sqrt(102.0)),
    "overflow upward": (gb.piecewise((gb.exp(phi**3), phi < 1), (0.0, True)), 10.0, math.sqrt(100 + 2 * 1.3419044179774198)),
    "one in another": (
        gb.piecewise((gb.piecewise((0.0, t < 1), (1 / (t - 0.5), True)), t < 2), (0.0, True)), 10.0, 10 + math.log(3.0),
    ),
    "many cases": (
        gb.piecewise(*((0.0 * k, t < k / 20) for k in range(1, 21)), (gb.log(t), t < 2), (0.0, True)), 10.0,
        10 + 2 * math.log(2.0) - 1,
    ),
}  # fmt: skip


def _disc(law: Any, w0: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("branches")
    rig.chain(rig.add("drive", gb.Torque(tau=law)), rig.add("disc", gb.Inertia(J=1.0, w0=w0)))
    return rig


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("method", ["auto", pytest.param("dp5", marks=pytest.mark.long), "rodas"])
@pytest.mark.few(6)
def test_a_branch_that_has_no_value_where_it_does_not_hold_does_no_harm(name: str, method: str) -> None:
    law, w0, wanted = LAWS[name]
    run = gb.simulate(_disc(law, w0), t_end=3.0, rtol=1e-9, method=method)
    end = wanted(run) if callable(wanted) else wanted
    assert run["disc.w"][-1] == pytest.approx(end, rel=2e-8, abs=1e-8)  # a root ends with a vertical slope
    assert run.energy.residual < 1e-7


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.few(1)
def test_it_does_none_without_location(name: str) -> None:
    law, w0, wanted = LAWS[name]
    run = gb.simulate(_disc(law, w0), t_end=3.0, method="dp5", rtol=1e-7, locate=False, max_step=0.01)
    end = wanted(run) if callable(wanted) else wanted
    assert run["disc.w"][-1] == pytest.approx(end, rel=1e-4, abs=1e-4)


def test_a_spring_that_hardens_by_the_inverse_of_its_twist() -> None:
    """k (1 - s/twist) twist beyond s: a gap in other words; a law over the twist, with a derivative for rodas."""
    law = gb.piecewise((0.0, abs(gb.twist) <= 0.1), (300.0 * (1 - 0.1 / abs(gb.twist)) * gb.twist, True))
    runs = []
    for element in (gb.Shaft(torque=law), gb.Lash(k=300.0, half_gap=0.1)):
        rig = gb.Drivetrain("hardening")
        rig.chain(rig.add("wall", gb.Fixed()), rig.add("spring", element), rig.add("disc", gb.Inertia(J=1.0, w0=2.0)))
        runs.append(gb.simulate(rig, t=np.linspace(0.0, 2.0, 41), rtol=1e-9, method="rodas"))
    assert np.abs(runs[0]["disc.phi"] - runs[1]["disc.phi"]).max() < 1e-8
