"""Bodies that hammer to rest on a stop whose gap is no straight function of the coordinates: the last flights are no higher
than the rounding of the gap, and end.

Closed form: from rest at one angle to rest at another, the impacts lose what the constant torque gave.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

PHI0, LOWER, TAU = 0.9, -0.175, 40.0


def _joint(rig: gb.Drivetrain) -> tuple[Any, Any]:
    link = rig.add("link", gb.UniversalJoint(angle=0.46))
    return link.a, link.b


def _ellipse(rig: gb.Drivetrain) -> tuple[Any, Any]:
    link = rig.add("link", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3, order=1), external=False))
    return link.a, link.b


def _two_joints(rig: gb.Drivetrain) -> tuple[Any, Any]:
    first, last = rig.add("first", gb.UniversalJoint(angle=0.5)), rig.add("last", gb.UniversalJoint(angle=0.2))
    rig.connect(first.b, last.a)
    return first.a, last.b


@pytest.mark.parametrize("link", [_joint, _ellipse, pytest.param(_two_joints, marks=pytest.mark.long)])
@pytest.mark.parametrize(("method", "rtol"), [("auto", 1e-6), ("dp5", 1e-9), ("dp8", 1e-10), ("rodas", 1e-7)])
@pytest.mark.parametrize("restitution", [0.05, 0.4])
@pytest.mark.few(1)
def test_it_comes_to_rest(
    link: Callable[[gb.Drivetrain], tuple[Any, Any]], method: str, rtol: float, restitution: float
) -> None:
    rig = gb.Drivetrain("hammer")
    body, load = rig.add("body", gb.Inertia(J=0.3, phi0=PHI0)), rig.add("load", gb.Inertia(J=0.8))
    begins, ends = link(rig)
    rig.connect(body.b, begins)
    rig.connect(ends, load.a)
    rig.connect(rig.add("stop", gb.HardStop(lower=LOWER, restitution=restitution)).a, load.b)
    rig.connect(rig.add("push", gb.Torque(tau=-TAU)).flange, body.a)
    run = gb.simulate(rig, t=np.linspace(0, 1, 11), method=method, rtol=rtol)
    assert run["load.w"][-1] == 0.0
    assert math.isclose(run["load.phi"][-1], LOWER, abs_tol=1e-12)
    given = TAU * (PHI0 - run["body.phi"][-1])
    assert math.isclose(run.energy.dissipated["stop"], given, rel_tol=20 * rtol)
