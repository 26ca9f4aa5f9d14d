"""Capacities that jump over a speed slide along it as torques do: a governor that brakes harder above a speed holds it."""

import numpy as np
import pytest

import gearblocks as gb

LIMIT, LESS, MORE, LOAD = 3.0, 0.5, 5.0, 2.0


def _governed(element, ground=True, order=1):
    """A torque of 2 N m on 1 kg m2, from rest; an element of 0.5 N m that is one of 5 N m above 3 rad/s."""
    rig = gb.Drivetrain("governor")
    parts = [("load", gb.Torque(tau=LOAD)), ("m", gb.Inertia(J=1.0)), ("rub", element), ("drag", gb.Damper(c=0.25))]
    parts += [("n", gb.Inertia(J=0.5)), ("wall", gb.Fixed())]
    part = {name: rig.add(name, block) for name, block in parts[::order]}
    rig.chain(part["load"], part["m"])
    rig.connect(part["m"].b, part["rub"].a)
    if ground:
        rig.chain(part["n"], part["drag"], part["wall"])
    else:
        rig.connect(part["rub"].b, part["n"].a)
        rig.chain(part["n"], part["drag"], part["wall"])
    return rig


JUMPS = gb.piecewise((MORE, gb.sense("m.w") > LIMIT), (LESS, True))
ELEMENTS = {
    "capacity": gb.Brake(capacity=JUMPS),
    "engagement": gb.Brake(mu=0.5, force_max=10.0, engagement=JUMPS / 5.0),
}


@pytest.mark.parametrize("name", ["capacity", "engagement"])
@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.few(1)
def test_a_brake_that_is_stronger_above_a_speed_holds_it(name, order):
    # 1.5 rad/s2 up to 2 s, then 2 N m at 3 rad/s for 2 s
    for method in ("auto", "dp5", "dp8", "rodas"):
        run = gb.simulate(_governed(ELEMENTS[name], order=order), t_end=4.0, method=method)
        assert abs(run["m.w"][-1] - LIMIT) < 1e-11 and abs(run["m.phi"][-1] - 9.0) < 1e-10
        assert abs(run["rub.torque"][-1] - LOAD) < 1e-11 and abs(run["rub.loss_power"][-1] - LOAD * LIMIT) < 1e-11
        assert run.energy.residual < 1e-12 and sum(run.energy.supplied.values()) == pytest.approx(LOAD * 9.0, rel=1e-11)


@pytest.mark.long
def test_a_clutch_that_is_stronger_above_a_speed_holds_it_and_drives_what_is_behind_it():
    # once it slides 2 N m come through: v' = (2 - v/4)/0.5 behind it, from what 0.5 N m have made of it by 2 s
    run = gb.simulate(_governed(gb.Clutch(capacity=JUMPS), ground=False), t_end=2.5, rtol=1e-8)
    begun = 2.0 * (1 - np.exp(-1.0))
    assert abs(run["m.w"][-1] - LIMIT) < 1e-10
    assert run["n.w"][-1] == pytest.approx(8.0 + (begun - 8.0) * np.exp(-0.25), rel=1e-7)
    assert run.energy.residual < 1e-7


@pytest.mark.long
def test_it_goes_on_where_the_load_is_no_longer_between_both_sides():
    # from 3 s on the load falls below what the weaker side brakes: 2 - 1.5 (t - 3) - 0.5 = 0 at 4 s
    rig = _governed(ELEMENTS["capacity"]).set({"load.tau": gb.Table([3.0, 5.0], [LOAD, LOAD - 3.0])})
    run = gb.simulate(rig, t_end=4.5, rtol=1e-9)
    assert run["m.w"][-1] == pytest.approx(LIMIT - 1.5 * 0.5**2 / 2, rel=1e-9)
    assert run.events[-1].t == pytest.approx(4.0, abs=1e-9)
