"""What a brake holds through a ratio that varies is at rest, and all behind it: nothing of it moves in implicit steps."""

import numpy as np
import pytest

import gearblocks as gb

LOAD, HOLDS = 0.9, 0.3


def _rig(pair):
    """A load that rises presses a body through play without width; a brake holds it through a pair of varying ratio; behind it
    a body hangs on a shaft whose law has its corner where it is."""
    rig = gb.Drivetrain(pair)
    pressed, held = rig.add("pressed", gb.Inertia(J=0.4)), rig.add("held", gb.Inertia(J=0.1))
    behind, last = rig.add("behind", gb.Inertia(J=0.12)), rig.add("last", gb.Inertia(J=0.3))
    lash, brake = rig.add("lash", gb.Lash(k=12.5, half_gap=0.0)), rig.add("brake", gb.Brake(capacity=HOLDS))
    table = gb.Table([-0.3, 0.0, 0.3], [-90.0, 0.0, 45.0], kind="cubic")
    shaft = rig.add("shaft", gb.Shaft(torque=table, c=1.0))
    load = rig.add("load", gb.Torque(tau=gb.Table([0.0, 1.0], [0.0, LOAD])))
    if pair == "joint":
        between = rig.add("pair", gb.UniversalJoint(angle=0.4))
    else:
        between = rig.add(
            "pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.1, order=1), external=pair == "external")
        )
    rig.connect(pressed.a, load.flange)
    rig.connect(pressed.b, lash.a)
    rig.connect(lash.b, held.a, shaft.a, between.a)
    rig.connect(shaft.b, behind.a)
    rig.chain(
        behind, rig.add("second", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.2, order=1), external=False)), last
    )
    rig.connect(between.b, rig.add("far", gb.Inertia(J=0.05)).a, brake.a)
    return rig


@pytest.mark.parametrize("pair", ["external", "internal", "joint"])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
@pytest.mark.few(1)
def test_nothing_moves_until_the_brake_gives_way(pair, rtol):
    run = gb.simulate(_rig(pair), t_end=0.6, method="rodas", rtol=rtol)
    right = gb.simulate(_rig(pair), t_end=0.6, method="dp8", rtol=1e-11)
    gives_way = next(e.t for e in right.events if e.component == "brake")
    assert next(e.t for e in run.events if e.component == "brake") == pytest.approx(gives_way, rel=20 * rtol)
    assert 0.1 < gives_way < 0.6
    before = run.t < 0.99 * gives_way
    for name in ("held", "far", "behind", "last"):
        assert not np.any(run[f"{name}.w"][before])
    assert len(run.events) < 20
    assert run["held.w"][-1] == pytest.approx(right["held.w"][-1], rel=1e3 * rtol)
