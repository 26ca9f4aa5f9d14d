"""Which effects go together, and that leaving one out is not the same as setting a number to 0."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import gearblocks as gb
from gearblocks.analysis.scenes.variants import elements, gone, members, parts, without


def _chain() -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(
        rig.add("disc", gb.Inertia(J=0.1)), rig.add("shaft1", gb.Shaft(k=5.0, c=0.1)), rig.add("hub", gb.Inertia(J=0.1)),
        rig.add("shaft2", gb.Shaft(k=5.0, c=0.1)), rig.add("end", gb.Inertia(J=0.1)),
    )  # fmt: skip
    rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=1.0, viscous=0.1)).a, rig["end"].b)
    return rig


def test_alike_effects_are_one_part_and_all_of_an_element_another() -> None:
    names = {part.name for part in parts(_chain())}
    assert names == {"shaft*.compliance", "shaft*.damping", "bearing.coulomb", "bearing.viscous"}
    whole = {part.name: part.effects for part in elements(_chain())}
    assert whole == {"bearing.*": {"bearing.coulomb", "bearing.viscous"}}  # of shafts compliance takes all along


def test_members_of_a_part_are_single_effects_with_what_rests_on_them() -> None:
    part = next(part for part in parts(_chain()) if part.name == "shaft*.compliance")
    assert [one.effects for one in members(_chain(), part)] == [
        {"shaft1.compliance", "shaft1.damping"}, {"shaft2.compliance", "shaft2.damping"},
    ]  # fmt: skip


def test_what_is_said_to_go_goes(discs: Callable[..., gb.Drivetrain]) -> None:
    for rig in (_chain(), discs()):
        for part in (*parts(rig), *elements(rig)):
            left = without(rig, part.effects)
            assert (
                set(left.effects()) == set(rig.effects()) - part.effects == set(rig.effects()) - gone(rig, part.effects)
            )


def test_a_gap_of_zero_with_clipped_damping_is_not_the_absence_of_the_gap() -> None:
    # which is why no effect is judged by setting a number to 0
    rig = gb.Drivetrain("swinging")
    disc, wall = rig.add("disc", gb.Inertia(J=1.0, phi0=1.0)), rig.add("wall", gb.Fixed())
    rig.chain(disc, rig.add("lash", gb.Lash(k=1.0, half_gap=0.1, c=0.2)), wall)
    asked = gb.peak("disc.phi", after=5.0)
    zero = asked.of(gb.simulate(rig.set({"lash.half_gap": 0.0}), t_end=8.0))
    absent = asked.of(gb.simulate(rig.without("lash.backlash"), t_end=8.0, watch=False))
    assert abs(zero / absent - 1) > 0.01
    assert absent == pytest.approx(math.exp(-0.2 * math.pi / math.sqrt(0.99)), rel=1e-5)  # a period, linear
