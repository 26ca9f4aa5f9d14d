"""Break-aways between looks where friction holds what lossy gears pass on: a load above that for a short part of a step."""

import math
import random

import pytest

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")
LOAD = gb.Torque(tau=gb.Parameter("size", 1.0) * gb.sin(gb.time))


def _train(parts, chain, order):
    """Parts by name, one after the other; those without a second flange beside the part before."""
    rig, names = gb.Drivetrain("lossy"), list(parts)
    order.shuffle(names)
    made = {name: rig.add(name, parts[name]) for name in names}
    flange = made["load"].flange
    for name in chain:
        rig.connect(flange, made[name].a)
        flange = made[name].b if hasattr(made[name], "b") else flange
    return rig


def _body(inertia):
    return gb.Inertia(J=inertia)


def worm(order):
    """A gear that locks itself, a bearing behind it: 2 N m / (5 0.6)."""
    parts = {"load": LOAD, "m": _body(0.01), "gear": gb.LossyGear(ratio=5.0, efficiency=(0.6, -0.3)), "s": _body(0.3)}
    return _train(parts | {"held": gb.BearingFriction(coulomb=2.0)}, ("m", "gear", "s", "held"), order), 2.0 / 3.0


def mild(order):
    """A gear that both sides drive, mirrored."""
    parts = {"load": LOAD, "m": _body(0.1), "gear": gb.LossyGear(ratio=-4.0, efficiency=(0.8, 0.75)), "s": _body(0.02)}
    return _train(parts | {"held": gb.Brake(capacity=1.6)}, ("m", "gear", "s", "held"), order), 0.5


def both_sides(order):
    """Friction in front of the gear and behind it."""
    parts = {"load": LOAD, "m": _body(0.01), "first": gb.BearingFriction(coulomb=0.3)}
    parts |= {"gear": gb.LossyGear(ratio=5.0, efficiency=(0.6, -0.3)), "s": _body(0.3), "held": gb.Brake(capacity=3.0)}
    return _train(parts, ("m", "first", "gear", "s", "held"), order), 1.3


def two_gears(order):
    """Two gears in a row, friction behind each: (1.5 + 0.8 / (2 0.8)) / (5 0.5)."""
    parts = {"load": LOAD, "m": _body(0.01), "gear": gb.LossyGear(ratio=5.0, efficiency=(0.5, 0.4)), "s": _body(0.3)}
    parts |= {"first": gb.BearingFriction(coulomb=1.5), "slow": gb.LossyGear(ratio=2.0, efficiency=(0.8, 0.7))}
    parts |= {"o": _body(0.1), "held": gb.Brake(capacity=0.8)}
    return _train(parts, ("m", "gear", "s", "first", "slow", "o", "held"), order), 0.8


def behind_a_shaft(order):
    """The load comes through a shaft and its inertia onto the gear."""
    parts = {"load": LOAD, "m": _body(1e-4), "shaft": gb.Shaft(k=2000.0, c=1.0), "n": _body(0.01)}
    parts |= {"gear": gb.LossyGear(ratio=5.0, efficiency=(0.6, -0.3)), "s": _body(0.3), "held": gb.Brake(capacity=2.0)}
    return _train(parts, ("m", "shaft", "n", "gear", "s", "held"), order), 2.0 / 3.0


def behind_a_light_body(order):
    """A worm whose load would move its own body a lot faster than the bounds behind it could."""
    parts = {"load": LOAD, "m": _body(1e-4), "gear": gb.LossyGear(ratio=5.0, efficiency=(0.6, -0.3)), "s": _body(30.0)}
    return _train(parts | {"held": gb.BearingFriction(coulomb=2.0)}, ("m", "gear", "s", "held"), order), 2.0 / 3.0


LONG = [pytest.param(held, marks=pytest.mark.long) for held in (mild, behind_a_shaft)]


@pytest.mark.parametrize("held", [worm, both_sides, two_gears, behind_a_light_body, *LONG])
def test_a_load_that_just_exceeds_what_is_held_behind_a_lossy_gear_lets_go_when_it_does(held):
    # what is held in front of a gear is that behind it over ratio and efficiency; a shaft passes it on as well as rtol
    draw = random.Random(3)
    rig, most = held(draw)
    model = gb.build(rig)
    for _ in range(12):
        share = 1.0 + 10.0 ** draw.uniform(-4.0, -2.0)
        method, rtol = draw.choice(METHODS), draw.choice((1e-4, 1e-6, 1e-8))
        run = gb.simulate(model, t_end=3.0, parameters={"size": share * most}, method=method, rtol=rtol)
        away = [e.t for e in run.events if e.component == "held" and e.before == 0 and e.t > 0.0]
        late = 1e-6 + (rtol if held is behind_a_shaft else 0.0)
        assert away and abs(away[0] - math.asin(1.0 / share)) < late / math.sqrt(share - 1.0), (share, rtol, away)


@pytest.mark.parametrize("held", [worm, both_sides, two_gears, LONG[0]])
def test_a_load_that_stays_below_lets_nothing_go(held):
    rig, most = held(random.Random(4))
    run = gb.simulate(rig, t_end=20.0, parameters={"size": most * (1 - 1e-6)}, rtol=1e-6)
    assert all(e.component != "held" or e.t == 0.0 for e in run.events) and abs(run["s.phi"]).max() < 1e-6
