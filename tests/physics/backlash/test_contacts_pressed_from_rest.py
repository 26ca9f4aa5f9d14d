"""Contacts after Hunt and Crossley that nothing has struck: pressed from rest they have no approach speed, and no damping."""

import itertools

import pytest

import gearblocks as gb

HITS = gb.HuntCrossley(restitution=0.255)


def _rig(hits, mesh, base):
    """A body that lies at the ground (or at a base that moves as it does) until the flank of a soft play presses it there."""
    speed = 0.7 if base else 0.0
    rig = gb.Drivetrain("pressed from rest")
    drive, far = rig.add("drive", gb.Inertia(J=0.15, w0=2.0 + 3 * speed)), rig.add("far", gb.Inertia(J=0.0577))
    gear, soft = rig.add("gear", gb.IdealGear(ratio=3.0)), rig.add("soft", gb.Lash(k=6.06, half_gap=0.2, c=0.00163))
    body = rig.add("body", gb.Inertia(J=0.0296, w0=speed))
    wall = rig.add("wall", gb.Lash(k=7.02, half_gap=0.0, **({"contact_damping": HITS} if hits else {})))
    load = gb.Table([0.0, 0.0965, 0.322], [1.68, -1.68, 1.68], periodic=True)
    rig.connect(drive.a, gear.a)
    rig.connect(drive.b, rig.add("load", gb.Torque(tau=load)).flange)
    rig.connect(far.a, gear.b, soft.a)
    rig.connect(body.a, soft.b)
    rig.connect(body.b, wall.a)
    behind = rig.add("base", gb.Inertia(J=1e9, w0=speed)).a if base else rig.add("ground", gb.Fixed()).flange
    rig.connect(wall.b, behind)
    if mesh:
        teeth = gb.GearMesh(
            teeth=(23, 20), external=True, r_base=(0.05, 1 / 23), k=1e4, backlash=gb.Backlash(half_gap=0.0093)
        )
        rig.connect(far.b, rig.add("mesh", teeth).pinion)
        rig.connect(rig.add("free", gb.Inertia(J=0.0305, w0=-1.23)).a, rig["mesh"].wheel)
    return rig


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize("base", [False, pytest.param(True, marks=pytest.mark.long)])
def test_it_gives_way_as_its_spring_does_whatever_the_step_that_found_it(mesh, base):
    """1/v0 of a speed that only the place of the step has made held it like a wall, 1e-7 rad for 0.08."""
    wanted = gb.simulate(_rig(False, mesh, base), t_end=0.6, method="dp8", rtol=1e-10)["soft.torque"][-1]
    for method in ("dp5", "dp8", "rodas"):
        for rtol in (1e-5, 1e-6, 1e-7, 1e-9):
            run = gb.simulate(_rig(True, mesh, base), t_end=0.6, method=method, rtol=rtol)
            assert run["soft.torque"][-1] == pytest.approx(wanted, rel=max(300 * rtol, 1e-6)), (method, rtol)


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_what_falls_back_within_a_step_is_damped_as_ever(method):
    """Such a step begins on the corner of the contact too, but at the speed at which it ends: flights shorten by e."""
    rig = gb.Drivetrain("bounces")
    body, wall = (
        rig.add("body", gb.Inertia(J=1.0, w0=3.0)),
        rig.add("wall", gb.Lash(k=1e11, half_gap=1.0, contact_damping=HITS)),
    )
    rig.connect(body.a, wall.a, rig.add("load", gb.Torque(tau=5.0)).flange)
    rig.connect(wall.b, rig.add("ground", gb.Fixed()).flange)
    run = gb.simulate(rig, t_end=1.5, method=method, rtol=1e-8)
    at = [e.t for e in run.events if e.component == "wall"]
    flights = [back - off for off, back in zip(at[1:8:2], at[2:8:2], strict=False)]
    assert len(flights) == 3
    assert [b / a for a, b in itertools.pairwise(flights)] == pytest.approx([0.255, 0.255], rel=1e-3)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_a_contact_that_touches_begins_as_it_is_struck(way, method):
    # w gives its speed to a, and the contact without play gives half of it back, from whichever side it comes
    rig = gb.Drivetrain("touches")
    a, b, w = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=1.0)), rig.add("w", gb.Inertia(J=1.0, w0=way))
    contact = gb.HuntCrossley(restitution=0.5)
    lash = rig.add("lash", gb.Lash(k=500.0, half_gap=0.0, contact_damping=contact))
    stop = rig.add("stop", gb.HardStop(lower=-0.5, upper=0.5, restitution=1.0))
    rig.chain(a, lash, b)
    rig.connect(stop.a, a.a)
    rig.connect(stop.b, w.a)
    run = gb.simulate(rig, t_end=0.7, method=method, rtol=1e-8)
    parts = next(e.t for e in run.events if e.component == "lash" and e.t > 0.52)
    after = gb.simulate(rig, t=[0.0, parts + 1e-7], method=method, rtol=1e-8)
    assert after["b.w"][-1] - after["a.w"][-1] == pytest.approx(0.5 * way, rel=1e-6)
