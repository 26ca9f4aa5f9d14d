"""Switches over a speed that friction holds as a state of its own: what the forces of springs leave of it is no reversal.

Closed form: a body on a spring to a shaft at rest swings as if the shaft were the ground.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas"]
SWINGING = {"one": (0.02, 0.4, 3.0), "two": (0.5, 33.0, -1.0), "three": (0.1, 2.4, 10.0), "four": (1.7, 200.0, 2.0)}


def _behind(tie: Any, name: str) -> tuple[gb.Drivetrain, Any, Any]:
    """Two bodies and a nonlinear relation of their angles, whose balance is solved with rounding."""
    rig = gb.Drivetrain(name)
    held, far = rig.add("held", gb.Inertia(J=0.8)), rig.add("far", gb.Inertia(J=0.1))
    gear = rig.add("gear", tie)
    rig.connect(held.a, gear.a)
    rig.connect(gear.b, far.a)
    return rig, held, far


def _load() -> tuple[gb.Drivetrain, Any, Any]:
    ellipse = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.415, order=1), external=False)
    rig, held, far = _behind(ellipse, "load with a dry part")
    rig.connect(held.a, rig.add("load", gb.SpeedLoad(coeffs=(300.0, 1.0, 0.01))).flange)
    return rig, held, far


def _car() -> tuple[gb.Drivetrain, Any, Any]:
    rig, held, far = _behind(gb.UniversalJoint(angle=0.7), "vehicle behind a joint")
    rig.connect(held.a, rig.add("car", gb.Vehicle(mass=3000.0, wheel_radius=0.3, drag_area=0.7, rolling=0.03)).flange)
    return rig, held, far


def _condition() -> tuple[gb.Drivetrain, Any, Any]:
    ellipse = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3, order=2), external=True)
    rig, held, far = _behind(ellipse, "condition on the difference of two held speeds")
    other = rig.add("other", gb.Inertia(J=0.3))
    rig.connect(far.a, rig.add("brake", gb.Brake(capacity=300.0)).a)
    rig.connect(other.a, rig.add("bearing", gb.BearingFriction(coulomb=5.0)).a)
    either = gb.piecewise((-0.5, gb.sense("held.w") - 3 * gb.sense("other.w") > 0), (0.5, True))
    rig.connect(other.b, rig.add("torque", gb.Torque(tau=either)).flange)
    return rig, held, far


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("train", [_load, pytest.param(_car, marks=pytest.mark.long), _condition])
@pytest.mark.few(1)
def test_forces_beside_a_held_speed_are_no_reversal(
    train: Callable[[], tuple[gb.Drivetrain, Any, Any]], method: str
) -> None:
    rig, held, far = train()
    rig.connect(held.b, _swinging(rig, "one"), _swinging(rig, "two"))
    rig.connect(far.b, _swinging(rig, "three"), _swinging(rig, "four"))
    t = np.linspace(0.0, 3.0, 31)
    run = gb.simulate(rig, t=t, method=method, rtol=1e-7)
    assert run.events == ()
    assert np.max(np.abs(run["held.w"])) < 1e-13
    for name, (J, k, w0) in SWINGING.items():
        assert run[f"{name}.w"] == pytest.approx(w0 * np.cos(np.sqrt(k / J) * t), abs=1e-5 * abs(w0))


def _swinging(rig: gb.Drivetrain, name: str) -> Any:
    """A body on a spring; the flange of the spring's other end."""
    J, k, w0 = SWINGING[name]
    shaft = rig.add(f"{name}_shaft", gb.Shaft(k=k))
    rig.connect(rig.add(name, gb.Inertia(J=J, w0=w0)).a, shaft.b)
    return shaft.a


@pytest.mark.long
@pytest.mark.parametrize("train", [_load, pytest.param(_car, marks=pytest.mark.long), _condition])
def test_no_event_is_lost_beside_the_noise_of_a_held_speed(train: Callable[[], tuple[gb.Drivetrain, Any, Any]]) -> None:
    """A brake on a free body lets go whenever its capacity falls to zero, at t = pi/rate, 3 pi/rate, ..."""
    rate = 9.57
    rig, held, far = train()
    rig.connect(held.b, _swinging(rig, "one"), _swinging(rig, "two"))
    rig.connect(far.b, _swinging(rig, "three"), _swinging(rig, "four"))
    free = rig.add("free", gb.Inertia(J=1.0, w0=50.0))
    rig.connect(free.a, rig.add("pulsing", gb.Brake(capacity=1.04 * gb.sin(rate * gb.time))).a)
    run = gb.simulate(rig, t_end=3.0, method="rodas", rtol=1e-7)
    times = [e.t for e in run.events if e.component.startswith("pulsing") and e.after == 2.0]
    assert times == pytest.approx([k * np.pi / rate for k in (1, 3, 5, 7, 9)], abs=1e-9)
