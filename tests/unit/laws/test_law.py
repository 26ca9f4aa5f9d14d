"""The traversal of a law: every member that holds expressions, in one order, by name or by role."""

import dataclasses
from typing import get_args

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.contributions import Contribution
from gearblocks.laws.checks import KINDS
from gearblocks.laws.derivation import derive
from gearblocks.laws.law import COORDINATES, LOCATED, PARTS, RATIOS, READ, STAGE, Law

BLOCKS = [
    gb.Inertia(J=1.0),
    gb.Shaft(k=100.0, c=1.0),
    gb.Clutch(capacity=5.0),
    gb.HardStop(upper=0.2, restitution=0.5),
    gb.LossyGear(ratio=3, efficiency=(0.9, 0.8)),
    gb.DCMotor(R=1.0, L=0.1, k=0.5, u=gb.Input("u")),
    gb.GearMesh(
        teeth=(23, 41), r_base=(0.03, 0.03 * 41 / 23), external=True, k=2e8, c=300.0,
        stiffness_variation=gb.Fourier(cos=(0.2,)), backlash=gb.Backlash(half_gap=3e-5),
    ),
]  # fmt: skip


def _law(block):
    return derive(block, frozenset())


def test_every_kind_of_contribution_has_one_check():
    assert set(KINDS) == set(get_args(Contribution))


def test_every_member_of_a_law_that_holds_expressions_is_a_part_of_its_traversal():
    walked = {part.member for part in PARTS.values()}
    assert {x.name for x in dataclasses.fields(Law)} - walked == {
        "pool",
        "coordinates",
        "replaced",
        "invertible",
        "heat",
        "inverse_speeds",
    }


@pytest.mark.parametrize("block", BLOCKS, ids=lambda b: type(b).__name__)
def test_a_law_is_as_it_was_where_nothing_is_replaced_and_without_symbols_where_all_is(block):
    law = _law(block)
    before = [str(e) for e in law.expressions()]
    assert [str(e) for e in law.map(lambda e: e).expressions()] == before
    nothing = law.map(lambda _: sp.Integer(0))
    assert not any(e.free_symbols for e in nothing.expressions()) and len(nothing.expressions()) == len(before)
    assert [str(e) for e in law.expressions()] == before  # the law itself stays


def test_parts_are_asked_for_by_name_or_role_and_come_in_the_order_of_the_traversal():
    law = _law(gb.Clutch(mu=gb.Table([0, 1], [0.5, 0.4]), force_max=3.0, engagement=gb.time))
    assert law.expressions("rates") == list(law.rates.values())
    assert law.expressions("rates", "torques") == [*law.torques.values(), *law.rates.values()]
    assert law.expressions(RATIOS) == [c for k in law.constraints.values() for c in k.row.values()]
    assert set(law.expressions(STAGE)) >= {*law.torques.values(), *law.rates.values(), law.loss}
    assert not any({READ, LOCATED} <= set(part.roles) for part in PARTS.values())
    assert len(law.expressions(COORDINATES)) < len(law.expressions())
