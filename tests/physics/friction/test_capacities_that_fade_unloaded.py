"""Capacities that fade to zero where nothing but rounding loads them, and where a load does, in closed form."""

import math

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas"]
K, SMALL, HELD, FAR = 150.0, 0.1, 2.0, 0.4
FROM, END, CAPACITY = 0.4, 0.6, 200.0


def _rig(torque, coupling, beside, load=0.0):
    """A swinging body on a shaft whose other end is held, and behind that a coupling whose capacity fades."""
    rig = gb.Drivetrain("fade")
    swings, held, far = (rig.add(n, gb.Inertia(J=J)) for n, J in (("swings", SMALL), ("held", HELD), ("far", FAR)))
    fading = rig.add("fading", coupling(capacity=gb.Table([0.0, FROM, END], [CAPACITY, CAPACITY, 0.0])))
    shaft = rig.add("shaft", gb.Shaft(k=K))
    rig.connect(held.a, fading.a, shaft.a)
    rig.connect(far.a, fading.b)
    rig.connect(far.b, rig.add("load", gb.Torque(tau=load)).flange)
    rig.connect(swings.a, shaft.b)
    rig.connect(swings.b, rig.add("drive", gb.Torque(tau=torque)).flange)
    rig.connect(held.b, rig.add("bearing", gb.BearingFriction(coulomb=6.0)).a)
    if beside == "freewheel":
        lock = rig.add("lock", gb.Freewheel())
        rig.connect(rig.add("ground", gb.Fixed()).flange, lock.a)
        rig.connect(lock.b, held.b)
    elif beside == "brake":
        rig.connect(held.b, rig.add("lock", gb.Brake(capacity=3.0)).a)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("beside", ["freewheel", "brake", "nothing"])
@pytest.mark.parametrize("coupling", [gb.OneWayClutch, gb.Clutch])
@pytest.mark.parametrize("torque", [0.481, -0.481, 0.9])
def test_what_nothing_loads_is_let_go_at_the_end_and_stays(torque, coupling, beside, method):
    """J w' = torque - k phi beside what is held; rounding of its force is less than any capacity but none."""
    run = gb.simulate(_rig(torque, coupling, beside), t=np.linspace(0.0, 1.0, 41), method=method, rtol=1e-8)
    rate = math.sqrt(K / SMALL)
    assert run["swings.w"] == pytest.approx(torque / (SMALL * rate) * np.sin(rate * run.t), abs=1e-6 * abs(torque))
    assert set(run["held.w"]) == set(run["far.w"]) == {0.0}
    assert {e.t for e in run.events if e.component == "fading"} <= {END}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("load", [1e-6, 1e-3, 2.0])
@pytest.mark.few(1)
def test_what_a_load_pulls_at_is_let_go_when_the_capacity_is_the_load(load, method):
    """t = END - (END - FROM) load / CAPACITY, and from there J w' = load - capacity."""
    run = gb.simulate(_rig(0.481, gb.Clutch, "freewheel", load), t=[0.0, END, 0.8], method=method, rtol=1e-8)
    fall = CAPACITY / (END - FROM)
    release = END - load / fall
    assert next(e.t for e in run.events if e.component == "fading") == pytest.approx(release, abs=1e-13)
    at_end = 0.5 * fall * (END - release) ** 2 / FAR
    assert run["far.w"][1] == pytest.approx(at_end, rel=1e-4, abs=1e-14)
    assert run["far.w"][2] == pytest.approx(at_end + load * (0.8 - END) / FAR, rel=1e-7)


PULSES = {
    "sine": 40.9 * sp.Abs(gb.sin(4.45 * gb.time)),
    "triangle": 11.0 * sp.Abs(gb.time - 0.7),
    "powers": gb.piecewise((8.0 * (0.3 - gb.time), gb.time < 0.3), (90.0 * (gb.time - 0.3) ** 3, True)),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("joint", ["clutch", "brake", "one-way"])
@pytest.mark.parametrize("capacity", PULSES)
@pytest.mark.few(1)
def test_a_capacity_that_touches_zero_moves_nothing_that_rests(capacity, joint, method):
    """Below zero by rounding where its corner was located, it drove what it joins at 1e-15 N m, and came back for ever."""
    rig = gb.Drivetrain("touches")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 1.02), ("two", 0.46), ("three", 0.0567)))
    blocks = {"clutch": gb.Clutch, "brake": gb.Brake, "one-way": gb.OneWayClutch}
    touches = rig.add("touches", blocks[joint](capacity=PULSES[capacity]))
    rig.connect(
        one.a,
        *([touches.b] if joint != "brake" else []),
        rig.add("car", gb.Vehicle(mass=0.7, wheel_radius=0.1, drag_area=2.0)).flange,
    )
    rig.connect(two.a, touches.a)
    gap = rig.add("gap", gb.Lash(k=20.2, half_gap=0.0, c=0.04, contact_damping="clipped"))
    rig.connect(two.b, gap.a)
    rig.connect(three.a, gap.b)
    run = gb.simulate(rig, t_end=3.0, method=method, rtol=1e-9)
    assert {x for name in ("one", "two", "three") for x in run[f"{name}.w"]} == {0.0}
    assert all(e.kind == "time" or e.t == 0.0 for e in run.events) and run.stats.steps < 100
