"""Loads from 0 on friction at a shaft without inertia, from rest: what is held has no scale but the rounding of its force.

Closed forms: nothing moves before the force bound is reached; behind a brake that lets go the shaft's torque is what is left.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("dp8", pytest.param("dp5", marks=pytest.mark.long), "rodas")
LATE = gb.piecewise((3.0 * (gb.time - 0.5), gb.time > 0.5), (0.0, True))
GEAR = gb.LossyGear(ratio=2.5, loss_table=((0.0, 0.893, 0.867, 1.94, 1.94), (14.2, 0.804, 0.78, 1.94, 1.94)))


def _on_the_shaft(tau: Any, hold: gb.Block, behind: gb.Block) -> gb.Drivetrain:
    """A torque on a shaft without inertia, which something holds; behind it a body."""
    rig = gb.Drivetrain("held without inertia")
    load, part, link = rig.add("load", gb.Torque(tau=tau)), rig.add("hold", hold), rig.add("link", behind)
    rig.connect(load.flange, part.a, link.a)
    rig.connect(link.b, rig.add("body", gb.Inertia(J=1.83)).a)
    return rig


def _behind_a_shaft(tau: Any, hold: gb.Block, ground: bool) -> gb.Drivetrain:
    """A torque on a body; behind a shaft a part whose friction holds, behind another one a body or the ground."""
    rig = gb.Drivetrain("held behind a shaft")
    body, far = rig.add("body", gb.Inertia(J=0.131)), rig.add("far", gb.Fixed() if ground else gb.Inertia(J=1.83))
    one, two = rig.add("one", gb.Shaft(k=2020.0, c=20.0)), rig.add("two", gb.Shaft(k=224.0, c=2.54))
    part = rig.add("part", hold)
    rig.connect(rig.add("load", gb.Torque(tau=tau)).flange, body.a)
    rig.connect(body.b, one.a)
    if isinstance(hold, gb.BearingFriction):
        rig.connect(one.b, part.a, two.a)
    else:
        rig.connect(one.b, part.b)
        rig.connect(part.a, two.a)
    rig.connect(two.b, far.flange if ground else far.a)
    return rig


HELD = {
    "ramp on a brake": _on_the_shaft(1.0 * gb.time, gb.Brake(capacity=1.13), gb.Shaft(k=58.0, c=0.2)),
    "late ramp beside a gap": _on_the_shaft(
        LATE, gb.Brake(capacity=4.0), gb.Lash(k=58.0, c=0.197, half_gap=0.0233, contact_damping="always")
    ),
    "late ramp beside a shaft": _on_the_shaft(LATE, gb.Brake(capacity=4.0), gb.Shaft(k=58.0, c=0.2)),
    "bearing torque of a gear": _behind_a_shaft(1.0 * gb.time, GEAR, ground=False),
    "soft start on a bearing": _behind_a_shaft(2.0 * (1 - gb.cos(gb.time)), gb.BearingFriction(coulomb=5.0), ground=False),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("train", HELD)
def test_what_is_held_stays_and_costs_no_steps(train: str, method: str) -> None:
    run = gb.simulate(HELD[train], t_end=1.0, method=method, rtol=1e-7)
    held = "body" if "held without inertia" in run.name else "far"
    rounding = 1e-15 * np.abs(run["load.torque"]).max() if method == "rodas" else 0.0  # of the torques in its matrix
    assert np.abs(run[f"{held}.w"]).max() <= rounding
    assert run.stats.steps + run.stats.rejected < 500
    assert run.energy.residual < 1e-6


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("slope", [3.09, 40.0, 1000.0])
@pytest.mark.few(1)
def test_a_brake_lets_go_when_the_ramp_reaches_it(slope: float, method: str) -> None:
    capacity, rtol = 1.13, 1e-7
    train = _on_the_shaft(slope * gb.time, gb.Brake(capacity=capacity), gb.Shaft(k=58.0, c=0.2))
    run = gb.simulate(train, t_end=1.0, method=method, rtol=rtol)
    begin = capacity / slope
    lets_go = next(e.t for e in run.events if e.component == "hold")
    assert lets_go == pytest.approx(begin, rel=10 * rtol)
    assert run["body.w"][-1] == pytest.approx(slope * (1.0 - begin) ** 2 / 2 / 1.83, rel=100 * rtol)
    assert run.stats.steps + run.stats.rejected < 400
