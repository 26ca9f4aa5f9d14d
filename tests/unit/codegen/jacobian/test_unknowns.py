"""Unknowns beside the states: rigid constraints and shafts without inertia in the matrix of implicit methods."""

from __future__ import annotations

import pytest

import gearblocks as gb


@pytest.mark.long
def test_a_planetary_between_three_springs(check_whole):
    rig = gb.Drivetrain("planetary")
    planetary = rig.add("planetary", gb.IdealPlanetary(ratio=2.5))
    ends = [rig.add(f"end{i}", gb.Inertia(J=1.0 + i)) for i in range(3)]
    near = [rig.add(f"near{i}", gb.Inertia(J=0.3 + 0.1 * i)) for i in range(3)]
    for i, flange in enumerate((planetary.sun, planetary.carrier, planetary.ring)):
        rig.chain(ends[i], rig.add(f"shaft{i}", gb.Shaft(k=20.0 + i, c=0.3)), near[i])
        rig.connect(near[i].b, flange)
    across = rig.add("across", gb.Lash(k=9.0, half_gap=0.1, c=0.2))
    rig.connect(across.a, ends[0].a)
    rig.connect(across.b, near[2].a)
    load = rig.add("load", gb.Torque(tau=-0.4 * gb.sense("near0.w") * gb.sense("near2.w")))
    rig.connect(load.flange, near[1].a)
    assert check_whole(rig)[1] == 0


def test_shafts_without_inertia_that_are_damped_are_unknowns_besides(check_whole):
    rig = gb.Drivetrain("damped")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
    one, two, three = (rig.add(f"s{i}", gb.Shaft(k=20.0 + i, c=0.3 * i)) for i in range(3))
    rig.chain(a, one, two, three, b)
    assert check_whole(rig)[1] == 2


def test_shafts_without_inertia_between_springs_are_in_balance_at_all_times(check_whole):
    rig = gb.Drivetrain("springs alone")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
    links = [
        gb.Shaft(k=20.0),
        gb.Shaft(torque=30 * gb.twist + 5 * gb.twist**3),
        gb.Shaft(k=9.0),
        gb.Shaft(k=4.0, c=0.2),
    ]
    rig.chain(a, *(rig.add(f"s{i}", link) for i, link in enumerate(links)), b)
    assert check_whole(rig)[1] == 3
