"""Angles that prescribed ones are read from are never defined by what is behind these, in whatever order forms come."""

from itertools import permutations

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.assembly.angle_wrapping import find_wrapped_angles
from gearblocks.assembly.assemble import assemble
from gearblocks.train.graph import flatten


def _train(order: tuple[str, ...]) -> gb.Drivetrain:
    """A universal joint drives a planetary carrier; shafts lead from its sun back to the joint's driving side."""
    rig = gb.Drivetrain("loop through a joint")
    one, carrier = rig.add("one", gb.Inertia(J=2.0, w0=3.0)), rig.add("carrier", gb.Inertia(J=0.5))
    ring, sun = rig.add("ring", gb.Inertia(J=0.3, w0=-1.0)), rig.add("sun", gb.Inertia(J=1.6))
    back, side = rig.add("back", gb.Inertia(J=0.7, w0=7.0)), rig.add("side", gb.Inertia(J=0.05))
    planetary = rig.add("planetary", gb.IdealPlanetary(ratio=2.0))
    rig.chain(one, rig.add("joint", gb.UniversalJoint(angle=0.3)), carrier)
    rig.connect(carrier.b, planetary.carrier)
    rig.connect(ring.a, planetary.ring)
    rig.connect(sun.a, planetary.sun)
    ends = {"sun_back": (sun, back), "sun_side": (sun, side), "back_one": (back, one), "ring_side": (ring, side)}
    for name in order:
        rig.chain(ends[name][0], rig.add(name, gb.Shaft(k=100.0, c=0.1)), ends[name][1])
    return rig


ORDERS = list(permutations(("sun_back", "sun_side", "back_one", "ring_side")))


@pytest.mark.parametrize("order", ORDERS, ids="-".join)
@pytest.mark.few(6)
def test_no_definition_of_an_angle_goes_round_through_a_prescribed_one(order: tuple[str, ...]) -> None:
    assembly = assemble(flatten(_train(order).tree()))
    known = set(assembly.angles)
    for group, _ in assembly.definitions:
        sources = {f.group: f.sources for f in assembly.dependent_groups}.get(group)
        row = dict(assembly.definitions)[group]
        read = set(sources) if sources is not None and not hasattr(row, "groups") else set(row.groups)
        assert read <= known
        known.add(group)
    find_wrapped_angles(assembly, ())


@pytest.mark.long
def test_the_order_of_such_shafts_does_not_change_the_motion() -> None:
    t = np.linspace(0.0, 1.0, 21)
    runs = [gb.simulate(_train(order), t=t, rtol=1e-10) for order in (ORDERS[0], ORDERS[-1])]
    for name in ("one.w", "ring.w", "side.w"):
        assert np.abs(runs[0][name] - runs[1][name]).max() < 1e-8 * np.abs(runs[0][name]).max()
