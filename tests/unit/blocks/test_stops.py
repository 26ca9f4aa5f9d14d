"""A stop in a chain of parts."""

import gearblocks as gb
from gearblocks.train.graph import GROUND


def test_a_chain_passes_through_a_stop_and_ends_on_the_ground_with_one() -> None:
    rig = gb.Drivetrain("rig")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(a, rig.add("stop", gb.HardStop(lower=0.0, restitution=0.0)), b)
    nodes = {c.path: c.nodes for c in rig.train().components}
    assert nodes["stop"] == (nodes["a"][1], nodes["b"][0])
    alone = gb.Drivetrain("alone")
    alone.chain(alone.add("a", gb.Inertia(J=1.0)), alone.add("stop", gb.HardStop(lower=0.0, restitution=0.0)))
    assert alone.train().components[1].nodes[1] == GROUND
