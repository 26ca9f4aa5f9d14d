"""Break-aways between looks where several stuck elements hold one load: it leaves all of them for a short part of a step."""

import math
import random

import numpy as np
import pytest

import gearblocks as gb
from tests.physics.friction.test_missed_break_away import slides_from


def _train(parts, links, order=None):
    """Parts by name and connections "a.flange b.flange ...", in another order with an order."""
    rig = gb.Drivetrain("several")
    names = list(parts)
    if order is not None:
        order.shuffle(names)
        order.shuffle(links)
    handles = {name: rig.add(name, parts[name]) for name in names}
    for link in links:
        rig.connect(*(getattr(handles[name], flange) for name, flange in (end.split(".") for end in link.split())))
    return rig


LOAD = gb.Torque(tau=gb.Parameter("size", 2.0) * gb.sin(gb.time))


def two_brakes(order=None):
    """A brake and a bearing on one shaft."""
    parts = {"load": LOAD, "m": gb.Inertia(J=1.0), "one": gb.Brake(capacity=1.0)}
    parts["two"] = gb.BearingFriction(coulomb=1.0)
    return _train(parts, ["load.flange m.a", "m.b one.a two.a"], order)


def two_clutches(order=None):
    """Two clutches side by side in front of a shaft that a brake holds."""
    parts = {"load": LOAD, "m": gb.Inertia(J=1.0), "one": gb.Clutch(capacity=0.5), "two": gb.Clutch(capacity=1.5)}
    parts |= {"n": gb.Inertia(J=0.3), "held": gb.Brake(capacity=9.0)}
    return _train(parts, ["load.flange m.a", "m.b one.a two.a", "one.b two.b n.a", "n.b held.a"], order)


def behind_a_gear(order=None):
    """A brake, and two more behind a gear."""
    parts = {"load": LOAD, "m": gb.Inertia(J=0.5), "one": gb.Brake(capacity=1.0), "gear": gb.IdealGear(ratio=2.0)}
    parts |= {"n": gb.Inertia(J=2.0), "two": gb.Brake(capacity=0.8), "three": gb.BearingFriction(coulomb=1.2)}
    return _train(parts, ["load.flange m.a", "m.b one.a gear.a", "gear.b n.a", "n.b two.a three.a"], order)


HELD = (two_brakes, two_clutches, behind_a_gear)
METHODS = ("auto", "dp5", "dp8", "rodas")


@pytest.mark.parametrize("held", HELD)
@pytest.mark.few(1)
def test_a_load_that_just_exceeds_what_several_hold_lets_go_when_it_does(held):
    # each holds 2 N m in all; of a step of 1 s and more the load is above that for 0.02 to 0.3 s
    model = gb.build(held())
    draw = random.Random(1)
    for _ in range(12):
        size = 2.0 * (1.0 + 10.0 ** draw.uniform(-4.0, -2.0))
        method, rtol = draw.choice(METHODS), draw.choice((1e-4, 1e-6, 1e-9))
        run = gb.simulate(model, t_end=4.0, parameters={"size": size}, method=method, rtol=rtol)
        away = [e.t for e in run.events if e.before == 0 and e.t > 0.0]
        assert away and abs(away[0] - math.asin(2.0 / size)) < 1e-6 * math.sqrt(2.0 / (size - 2.0))


@pytest.mark.parametrize("held", HELD)
@pytest.mark.few(1)
def test_what_lets_go_slides_as_far_as_its_load_says_in_any_order_of_parts(held):
    size = 2.005
    tau = lambda t: size * np.sin(t)  # noqa: E731
    start, rest, angle = slides_from(lambda t: tau(t) - 2.0, lambda t: 2.0, tau, (1.3, math.pi / 2), math.pi / 2 + 0.3)
    for order in (None, random.Random(2)):
        for rtol in (1e-4, 1e-7):
            run = gb.simulate(held(order), t_end=3.0, parameters={"size": size}, rtol=rtol)
            times = [e.t for e in run.events if e.t > 0.0]
            # a split is told from none at 1e-10 of the load, which grows by 0.14 N m/s here
            assert abs(times[0] - start) < 1e-8 and abs(times[-1] - rest) < 10 * rtol * (rest - start) + 1e-8
            assert abs(run["m.phi"][-1] - angle) < 10 * rtol * angle


def test_what_several_hold_all_the_time_makes_no_event():
    for held in HELD:
        run = gb.simulate(held(), t_end=30.0, parameters={"size": 2.0 * (1 - 1e-6)}, rtol=1e-6)
        assert all(e.t == 0.0 for e in run.events) and (run["m.phi"] == 0.0).all()
