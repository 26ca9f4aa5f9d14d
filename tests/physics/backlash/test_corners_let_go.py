"""A friction lets go of a body that stands on the corner of a contact, after looks that found all at rest.

Closed form: contact begins with no approach speed, so that Hunt and Crossley's damping has none; two bodies and a spring under
what is left of a ramp from the friction on.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

FIRST, SECOND, K, GRIP, RATE = 0.4, 0.17, 292.0, 1.31, 20.0


def _bearing(rig: gb.Drivetrain, body: Any) -> None:
    rig.connect(rig.add("grip", gb.BearingFriction(coulomb=GRIP)).a, body.b)


def _brake(rig: gb.Drivetrain, body: Any) -> None:
    rig.connect(rig.add("grip", gb.Brake(capacity=GRIP)).a, body.b)


def _clutch(rig: gb.Drivetrain, body: Any) -> None:
    clutch = rig.add("grip", gb.Clutch(capacity=GRIP))
    rig.connect(clutch.a, body.b)
    rig.connect(clutch.b, rig.add("ground", gb.Fixed()).flange)


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("switches", [0, 3])
@pytest.mark.parametrize("hold", [_bearing, _brake, _clutch])
@pytest.mark.few(1)
def test_a_contact_on_its_corner_begins_with_the_motion(hold: Any, switches: int, method: str) -> None:
    rig = gb.Drivetrain("released on a corner")
    first, second = rig.add("first", gb.Inertia(J=FIRST)), rig.add("second", gb.Inertia(J=SECOND))
    lash = rig.add("lash", gb.Lash(k=K, half_gap=0.0, contact_damping=gb.HuntCrossley(restitution=0.219)))
    rig.chain(first, lash, second)
    hold(rig, first)
    rig.connect(rig.add("ramp", gb.Torque(tau=RATE * gb.time)).flange, first.b)
    # another body, which friction stops again and again: looks that find the corner at rest
    other, drag = rig.add("other", gb.Inertia(J=1.0)), rig.add("drag", gb.BearingFriction(coulomb=1.0))
    pulse = gb.piecewise(
        (0.0, gb.time > 0.06), *[(2.0 * (k % 2), gb.time > 0.01 * k) for k in range(5, 0, -1)], (0.0, True)
    )
    rig.connect(other.a, drag.a)
    rig.connect(rig.add("kicks", gb.Torque(tau=pulse if switches else 0.0)).flange, other.b)
    t = np.linspace(0.0, 0.2, 41)
    run = gb.simulate(rig, t=t, method=method, rtol=1e-8)
    s = np.maximum(t - GRIP / RATE, 0.0)
    pace = np.sqrt(K * (1 / FIRST + 1 / SECOND))
    closing = RATE / (FIRST * pace**2) * (1 - np.cos(pace * s))
    momentum = RATE * s**2 / 2
    speed = (momentum + SECOND * closing) / (FIRST + SECOND)
    assert run["first.w"] == pytest.approx(speed, abs=1e-6 * speed.max())
    assert run["second.w"] == pytest.approx(speed - closing, abs=1e-6 * speed.max())
    assert run.stats.steps < 1000
