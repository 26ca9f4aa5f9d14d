"""Friction and what is given it: every mistaken field is named with its rule."""

from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb

TABLE = gb.Table([0.0, 1.0], [0.4, 0.3])


def _refused(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        gb.Drivetrain("rig").add("part", make())
    assert words in str(caught.value), str(caught.value)


def _mu(**changes: Any) -> Any:
    fields = {"mu": 0.4, "force_max": 10.0, "engagement": 1.0, **changes}
    return {name: value for name, value in fields.items() if value is not None}


@pytest.mark.parametrize("kind", [gb.Clutch, gb.Brake, gb.OneWayClutch, lambda **f: gb.Synchronizer(engaged=1.0, **f)])
@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({}, "what it can transmit is missing: give capacity, or mu, force_max and engagement"),
        ({"capacity": 1.0, "mu": 0.4}, "capacity and mu are both given"),
        (_mu(engagement=None), "mu, force_max: engagement missing"),
        (_mu(force_max=None, mu=None), "engagement: mu, force_max missing"),
        ({"capacity": -1.0}, "capacity = -1.0 N m must be >= 0"),
        ({"capacity": gb.Parameter("c", -1.0)}, "capacity = -1.0 N m (Parameter("),
        ({"capacity": float("nan")}, "capacity = nan N m must be a finite number"),
        ({"capacity": "5"}, "capacity = '5' is no number"),
        ({"capacity": 1.0, "geometry": 2.0}, "geometry = 2.0 goes with mu"),
        (_mu(mu=-0.1), "mu = -0.1 must be >= 0"),
        (_mu(force_max=-1.0), "force_max = -1.0 N must be >= 0"),
        (_mu(geometry=0.0), "geometry = 0.0 m must be > 0"),
        (_mu(peak=0.9), "peak = 0.9 must be >= 1"),
        (_mu(mu=gb.Table([0.0, 1.0], [0.4, -0.1])), "must be >= 0 everywhere"),
        (_mu(mu=gb.Table([0.0, 1.0, 1.2, 2.0], [5.0, 0.0, 1.0, 9.0], "cubic")), "must be >= 0 everywhere"),
        (_mu(mu=gb.Table([0.0, 1.0], [0.4, 0.4], "linear", True)), "must not be periodic"),
        (_mu(mu=2 * gb.twist), "contains gb.twist"),
    ],
)
def test_a_mistaken_friction_is_named(kind: Any, fields: dict[str, Any], words: str) -> None:
    _refused(lambda: kind(**fields), words)


@pytest.mark.parametrize(
    "fields",
    [
        {"capacity": 0.0},
        {"capacity": gb.Input("c", start=-1.0)},
        {"capacity": -1.0 * gb.time},
        _mu(engagement=-1.0),
        _mu(mu=TABLE, engagement=gb.sense("a.w")),
        _mu(mu=gb.Parameter("mu", 0.3), force_max=0.0),
    ],
)
def test_what_varies_may_fall_below_zero(fields: dict[str, Any]) -> None:
    gb.Drivetrain("rig").add("part", gb.Clutch(**fields))


def test_a_run_refuses_a_negative_capacity_too() -> None:
    rig = gb.Drivetrain("rig")
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("brake", gb.Brake(capacity=1.0)))
    with pytest.raises(gb.ParameterError, match=r"brake\.capacity"):
        gb.simulate(rig, t_end=1.0, parameters={"brake.capacity": -1.0})


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.BearingFriction(), "give either torque"),
        (lambda: gb.BearingFriction(coulomb=1.0, torque=TABLE), "give either torque"),
        (lambda: gb.BearingFriction(torque=1.0), "a constant torque is coulomb"),
        (lambda: gb.BearingFriction(torque=TABLE, viscous=1.0), "put them into the Table"),
        (lambda: gb.BearingFriction(torque=gb.Table([0, 1], [1, -1])), "torque = Table(2 points"),
        (lambda: gb.BearingFriction(coulomb=-1.0), "coulomb = -1.0 N m must be >= 0"),
        (lambda: gb.BearingFriction(coulomb=1.0, stribeck=0.3), "stribeck = 0.3 must be an effect object"),
        (lambda: gb.BearingFriction(coulomb=1.0, stribeck=gb.Stribeck(rise=1.0, speed=0.0)), "stribeck.speed = 0.0"),
        (lambda: gb.DogClutch(), "DogClutch needs engaged"),
        (lambda: gb.HardStop(restitution=0.5), "there is no stop: give lower, upper or both"),
        (lambda: gb.HardStop(lower=0.1, upper=0.1, restitution=0.5), "lower = 0.1 rad must be < upper = 0.1 rad"),
        (lambda: gb.HardStop(lower=0.1), "HardStop needs restitution"),
        (lambda: gb.HardStop(lower=0.1, restitution=1.1), "restitution = 1.1 must be <= 1"),
        (lambda: gb.HardStop(lower=0.1, restitution=-0.1), "restitution = -0.1 must be >= 0"),
        (lambda: gb.Shaft(k=1.0, hysteresis=0.1), "hysteresis = 0.1 must be an effect object"),
        (lambda: gb.Shaft(k=1.0, hysteresis=gb.Hysteresis(friction=0.0)), "hysteresis.friction = 0.0 N m must be > 0"),
        (lambda: gb.Shaft(rigid=True, hysteresis=gb.Hysteresis(friction=1.0)), "a rigid shaft has no hysteresis"),
        (lambda: gb.SpeedLoad(coeffs=(-1.0, 0.0, 0.0)), "coeffs[0] = -1.0"),
    ],
)
def test_a_mistaken_element_is_named(make: Callable[[], Any], words: str) -> None:
    _refused(make, words)
