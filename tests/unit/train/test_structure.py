"""Blocks of one kind have one structure, and what differs in more than numbers is of another kind."""

from functools import cached_property

import pytest

import gearblocks as gb
from gearblocks.language.heat import heat_port
from gearblocks.train.structure import kinds_of, structure_of
from gearblocks.train.values import numbers_of, value_problems


def test_blocks_that_differ_in_numbers_alone_are_of_one_kind():
    one, other, third = gb.Shaft(k=1.0, c=0.5), gb.Shaft(k=2, c=0.7), gb.Shaft(k="3 N m/rad", c=1.0)
    kinds = kinds_of([one, other, one, third])
    assert kinds[0] is kinds[2]
    assert len({kind.digest for kind in kinds}) == 1
    assert {kind.structure for kind in kinds} == {structure_of(one)}


def test_what_is_there_and_what_is_zero_tell_kinds_apart():
    blocks = [
        gb.Inertia(J=1.0), gb.Inertia(J=0.0), gb.Inertia(J=1.0, phi0=0.1), gb.Fixed(), gb.Shaft(k=1.0),
        gb.Shaft(rigid=True), gb.Shaft(k=1.0, c=1.0), gb.Shaft(k=1.0, J=1.0),
    ]  # fmt: skip
    kinds = kinds_of(blocks)
    assert len(set(kinds)) == len(blocks)
    assert kinds[0].structure == kinds[1].structure  # one law,
    assert kinds[0].digest != kinds[1].digest  # two programs


def test_parts_are_compared_by_their_kind_and_leaves_by_identity():
    k = gb.Parameter("k", 5.0)
    gap, other = gb.Backlash(half_gap=1e-5), gb.Backlash(half_gap=2e-5)
    blocks = [gb.Shaft(k=k), gb.Shaft(k=k, c=1.0), gb.Shaft(k=k), gb.Shaft(k=gb.Parameter("k2", 5.0))]
    one, _, same, apart = kinds_of(blocks)
    assert one is same
    assert one is not apart
    assert one.leaves == (k,)
    mesh = {"teeth": (20, 40), "external": True, "module": 2e-3, "pressure_angle": 0.35, "k": 1e8}
    meshes = [gb.GearMesh(**mesh, backlash=b) for b in (gap, other, None)]
    meshes.append(gb.GearMesh(**mesh | {"teeth": (20, 41)}, backlash=gap))
    kinds = kinds_of(meshes)
    assert kinds[0] is kinds[1]
    assert len(set(kinds)) == 3


def test_numbers_effects_and_states_of_a_kind_are_those_of_its_blocks():
    blocks = [
        gb.Shaft(k=1.0, c=0.5), gb.Shaft(k=2.0, c=0.7), gb.Inertia(J="3 g m2"), gb.Lash(k=1.0, c=2.0, half_gap=1e-3),
        gb.Clutch(capacity=1.0), gb.Clutch(capacity=3.0, heat=gb.HeatPort(T=300.0)),
    ]  # fmt: skip
    for block, kind in zip(blocks, kinds_of(blocks), strict=True):
        assert list(kind.numbers(block)) == list(numbers_of(block, ""))
        assert set(kind.effects(block)) == set(block.effects())
    heat = kinds_of(blocks)[-1]
    assert "heat.given" in dict(heat.states)


class Keeps(gb.Inertia):
    """A block that keeps what it has worked out."""

    @cached_property
    def kept(self) -> float:
        return 2.0 * self.J


def test_a_block_that_keeps_what_it_has_worked_out_joins_a_train_and_takes_other_numbers() -> None:
    block = Keeps(J=1.0)
    assert block.kept == 2.0
    rig = gb.Drivetrain("keeps")
    rig.connect(rig.add("body", block).a, rig.add("load", gb.Torque(tau=3.0)).flange)
    assert gb.simulate(rig, t_end=1.0, parameters={"body.J": 2.0})["body.w"][-1] == pytest.approx(1.5)
    with pytest.raises(gb.ModelError, match="J"):
        gb.Drivetrain("keeps").add("body", block.changed(J=-1.0))


def test_what_a_block_has_worked_out_is_no_part_of_what_it_is() -> None:
    fresh, block = Keeps(J=1.0), Keeps(J=1.0)
    assert block.kept == 2.0
    block.__dict__["rows"] = [1, 2]  # as a cached_property does; not hashable
    block.__dict__["load"] = gb.HeatPort(T=-1.0)
    assert block == fresh
    assert hash(block) == hash(fresh)
    assert heat_port(block) is None
    assert not value_problems("body", block)


def test_what_a_block_keeps_for_itself_tells_no_kind() -> None:
    plain, keeps = gb.Inertia(J=1.0), gb.Inertia(J=2.0)
    keeps.__dict__["kept"] = 3.0  # as functools.cached_property does
    first, second = kinds_of([plain, keeps])
    assert first.is_plain and second.is_plain
