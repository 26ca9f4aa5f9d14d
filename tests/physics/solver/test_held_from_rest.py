"""Starts from rest with a twist that friction holds behind a nonlinear relation: the twist has no scale but rounding.

Closed form: held, the train has one degree of freedom, and the work of a constant torque is its kinetic energy.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

TORQUE, FIRST, SECOND, THIRD, ANGLE = 1.13, 0.109, 2.0, 2.83, 0.5


def _train(tie: Any, hold: str) -> gb.Drivetrain:
    """A torque on one side of a tie, on the other two bodies with a spring and friction between them."""
    rig = gb.Drivetrain(f"held from rest by a {hold}")
    one, two, three = (
        rig.add(name, gb.Inertia(J=J)) for name, J in (("one", FIRST), ("two", SECOND), ("three", THIRD))
    )
    pair = rig.add("pair", tie)
    inner = {"hysteresis": gb.Hysteresis(friction=12.9)} if hold == "hysteresis" else {}
    shaft = rig.add("shaft", gb.Shaft(k=174.0, **inner))
    rig.connect(one.a, pair.a)
    rig.connect(rig.add("torque", gb.Torque(tau=TORQUE)).flange, one.b)
    rig.connect(pair.b, two.a)
    rig.connect(two.b, shaft.a)
    rig.connect(shaft.b, three.a)
    if hold == "clutch":
        clutch = rig.add("clutch", gb.Clutch(capacity=12.9))
        rig.connect(clutch.a, two.b)
        rig.connect(clutch.b, three.b)
    return rig


JOINT = gb.UniversalJoint(angle=ANGLE)
ELLIPSE = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.486, order=1), external=False)


@pytest.mark.parametrize("method", ["dp5", "dp8"])
@pytest.mark.parametrize(
    ("tie", "hold"),
    [
        pytest.param(JOINT, "hysteresis", marks=pytest.mark.long),
        pytest.param(JOINT, "clutch", marks=pytest.mark.long),
        (ELLIPSE, "hysteresis"),
    ],
)
def test_the_work_of_the_torque_becomes_speed(tie: Any, hold: str, method: str) -> None:
    rtol = 1e-6
    run = gb.simulate(_train(tie, hold), t=np.linspace(0.0, 1.0, 11), method=method, rtol=rtol)
    phi = run["one.phi"]
    ratio = np.cos(ANGLE) / (1 - np.sin(ANGLE) ** 2 * np.cos(phi) ** 2)  # of the universal joint
    if tie is ELLIPSE:
        ratio = run["two.w"][1:] / run["one.w"][1:]
        ratio = np.concatenate([ratio[:1], ratio])
    speed = np.sqrt(2 * TORQUE * phi / (FIRST + ratio**2 * (SECOND + THIRD)))
    if tie is JOINT:  # which of its yokes lies in the plane of the bend at the start is its own affair
        other = np.cos(ANGLE) / (1 - np.sin(ANGLE) ** 2 * np.sin(phi) ** 2)
        choice = np.sqrt(2 * TORQUE * phi / (FIRST + other**2 * (SECOND + THIRD)))
        speed = min((speed, choice), key=lambda w: float(np.abs(w - run["one.w"]).max()))
    assert run["one.w"] == pytest.approx(speed, rel=100 * rtol, abs=1e-12)
    assert run["three.w"] == pytest.approx(run["two.w"], rel=100 * rtol, abs=1e-12)
    assert np.max(np.abs(run["three.phi"] - run["two.phi"])) < 1e-9
    assert run.stats.steps < 1000
