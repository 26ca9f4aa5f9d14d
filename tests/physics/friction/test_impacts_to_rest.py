"""Impacts that stop every body at once: what is left of the speeds is rounding and tells no direction of sliding.

Closed form: a small load at bodies that a rigid stop without restitution has stopped, with locks and dry friction beside,
leaves them at rest where the stop is.
"""

from __future__ import annotations

from random import Random

import pytest

import gearblocks as gb

UPPER = 0.02


def behind_a_dog_clutch() -> gb.Drivetrain:
    rig = gb.Drivetrain("dog clutch, gear and stop")
    one, two, three = (rig.add(n, gb.Inertia(J=0.05, w0=w)) for n, w in (("one", 7.0), ("two", 7.0), ("three", None)))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, upper=UPPER))
    dog, gear = rig.add("dog", gb.DogClutch(engaged=1.0)), rig.add("gear", gb.IdealGear(ratio=3.7))
    brake, bearing = rig.add("brake", gb.Brake(capacity=0.3)), rig.add("bearing", gb.BearingFriction(coulomb=0.05))
    load = rig.add("load", gb.Torque(tau=0.03))
    rig.connect(one.a, stop.a, dog.a, load.flange)
    rig.connect(two.a, dog.b, gear.a, brake.a)
    rig.connect(three.a, gear.b, bearing.a)
    return rig


def behind_a_freewheel() -> gb.Drivetrain:
    rig = gb.Drivetrain("freewheel and stop")
    one, two = rig.add("one", gb.Inertia(J=0.05, w0=7.0)), rig.add("two", gb.Inertia(J=0.05, w0=7.0))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, upper=UPPER))
    wheel = rig.add("freewheel", gb.Freewheel())
    brake, bearing = rig.add("brake", gb.Brake(capacity=0.05)), rig.add("bearing", gb.BearingFriction(coulomb=0.4))
    load = rig.add("load", gb.Torque(tau=0.03))
    rig.connect(one.a, wheel.b, stop.a, brake.a, load.flange)
    rig.connect(two.a, wheel.a, bearing.a)
    return rig


def behind_a_planetary_set() -> gb.Drivetrain:
    rig = gb.Drivetrain("planetary set, dog clutch and stop")
    one, two = rig.add("one", gb.Inertia(J=0.05, w0=7.0)), rig.add("two", gb.Inertia(J=0.05, w0=7.0))
    three = rig.add("three", gb.Inertia(J=0.1))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, upper=UPPER))
    planetary, dog = rig.add("planetary", gb.IdealPlanetary(ratio=2.3)), rig.add("dog", gb.DogClutch(engaged=1.0))
    clutch, bearing = rig.add("clutch", gb.Clutch(capacity=0.2)), rig.add("bearing", gb.BearingFriction(coulomb=0.3))
    load = rig.add("load", gb.Torque(tau=0.03))
    rig.connect(one.a, planetary.sun, stop.a, dog.a, clutch.a, load.flange)
    rig.connect(two.a, planetary.ring, dog.b, bearing.a)
    rig.connect(three.a, planetary.carrier, clutch.b)
    return rig


@pytest.mark.parametrize(
    "train", [pytest.param(behind_a_dog_clutch, marks=pytest.mark.long), behind_a_freewheel, behind_a_planetary_set]
)
@pytest.mark.few(1)
def test_all_bodies_rest_at_the_stop(train: object) -> None:
    model, random = gb.build(train()), Random(1)  # type: ignore[operator]
    for _ in range(60):
        speed = random.uniform(5.0, 9.0)
        values = {
            "one.J": random.uniform(0.01, 1.0),
            "two.J": random.uniform(0.01, 1.0),
            "one.w0": speed,
            "two.w0": speed,
        }
        run = gb.simulate(model, t_end=0.05, parameters={**values, "load.tau": random.choice((0.03, -0.03))})
        assert run["one.phi"][-1] == pytest.approx(UPPER, rel=1e-9), values
        assert max(abs(run[f"{n}.w"][-1]) for n in ("one", "two", "three") if f"{n}.w" in run) == 0.0, values
        assert len(run.events) <= 8, values  # the impact, and what comes to rest with it, once
