"""Outputs by groups: as a plain tuple of names, units and words would be, in memory for a fraction of them."""

import pickle

import pytest

import gearblocks as gb
from gearblocks.codegen.output_list import OutputGroup, OutputList, Quantity
from gearblocks.codegen.program import Program

TURNING, SLIDING = Quantity("tau", "N m", "torque"), Quantity("f", "N", "force")
EVERY = (
    Quantity("a.tau", "N m", "torque"), Quantity("b.f", "N", "force"), Quantity("c.tau", "N m", "torque"),
    Quantity("d.tau", "N m", "torque"), Quantity("slip", "rad", "relative coordinate"),
)  # fmt: skip


@pytest.fixture
def outputs():
    single = Quantity("", "rad", "relative coordinate")
    return OutputList([
        OutputGroup(("a", "b", "c"), TURNING, SLIDING, bytes([0, 1, 0])),
        OutputGroup(("d",), TURNING, SLIDING),
        OutputGroup(("slip",), single, single),
    ])  # fmt: skip


def test_a_list_of_groups_is_read_like_a_tuple(outputs):
    assert tuple(outputs) == EVERY and len(outputs) == 5
    assert [outputs[i] for i in range(-5, 5)] == [*EVERY, *EVERY]
    assert outputs[1:4] == EVERY[1:4] and outputs[::-2] == EVERY[::-2] and EVERY[3] in outputs
    assert [*outputs.names()] == [q.name for q in EVERY] and [*outputs.units()] == [q.unit for q in EVERY]
    for beyond in (5, -6):
        with pytest.raises(IndexError):
            outputs[beyond]


def test_equal_lists_need_not_have_equal_groups(outputs):
    assert OutputList.of(EVERY) == outputs == pickle.loads(pickle.dumps(outputs))
    assert OutputList.of(EVERY[1:]) != outputs and OutputList.of([]) == OutputList([]) and len(OutputList([])) == 0
    assert "5 outputs: a.tau, b.f, c.tau, ..." in repr(outputs)


def test_sliders_and_shafts_of_one_batch_keep_their_own_names_and_units():
    rig = gb.Drivetrain("both")
    rig.chain(rig.add("disc", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=3.0)), rig.add("end", gb.Inertia(J=2.0)))
    rig.chain(rig.add("sled", gb.Mass(m=1.0)), rig.add("spring", gb.Shaft(k=3.0)), rig.add("stone", gb.Mass(m=2.0)))
    program = gb.build(rig).program
    group = next(g for g in program.outputs.groups if g.turning.name == "torque")
    assert group.owners == ("shaft", "spring") and [*group.slides] == [0, 1]
    units = program.output_units
    assert units["shaft.torque"] == "N m" and units["spring.torque"] == "N"
    assert units["shaft.a.phi"] == "rad" and units["spring.a.s"] == "m" and "spring.a.phi" not in units
    assert [*units] == [q.name for q in program.outputs] and [*units.values()] == [q.unit for q in program.outputs]
    assert Program.from_bytes(program.to_bytes()).outputs == program.outputs
