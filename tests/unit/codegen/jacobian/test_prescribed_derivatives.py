"""Prescribed motions in the matrix of implicit methods."""

from __future__ import annotations

import gearblocks as gb


def test_prescribed_speeds_and_angles_leave_no_unknown(check_whole):
    rig = gb.Drivetrain("driven")
    a, b, c = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abc", (1.0, 2.0, 3.0), strict=True))
    one, two = rig.add("one", gb.Shaft(k=20.0, c=0.5)), rig.add("two", gb.Lash(k=30.0, half_gap=0.1, c=0.1))
    speed, angle = rig.add("speed", gb.Speed(w=gb.sin(gb.time))), rig.add("angle", gb.Angle(phi=gb.cos(2 * gb.time)))
    rig.chain(speed, a, one, b, two, c)
    back = rig.add("back", gb.Shaft(k=7.0, c=0.2))
    rig.connect(angle.flange, c.b, back.a)
    rig.connect(back.b, b.a)
    assert check_whole(rig)[1:] == (0, 1)


def test_motions_behind_filters_follow_the_states_of_their_blocks(check_whole):
    rig = gb.Drivetrain("filtered")
    a, b, c, d = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abcd", (1.0, 2.0, 3.0, 0.5), strict=True))
    one, two, three = (rig.add(f"s{i}", gb.Shaft(k=20.0 + i, c=0.5 * i)) for i in range(3))
    speed = rig.add("speed", gb.Speed(w=gb.Input("w", unit="rad/s"), filter=3.0))
    angle = rig.add("angle", gb.Angle(phi=gb.Input("phi", unit="rad"), filter=2.0))
    gear, planetary = rig.add("gear", gb.IdealGear(ratio=-2.5)), rig.add("planetary", gb.IdealPlanetary(ratio=2.0))
    rig.chain(speed, a, gear, rig.add("e", gb.Inertia(J=0.4)), one, b, two, c)
    rig.connect(angle.flange, c.b, planetary.sun)
    rig.connect(planetary.carrier, b.b)
    rig.connect(planetary.ring, d.a, three.a)
    rig.connect(three.b, a.a)
    assert check_whole(rig)[1] == 0
