"""The law of a kind: what its energies leave unexplained."""

import dataclasses
from typing import get_args

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.contributions import Contribution
from gearblocks.laws.checks import KINDS
from gearblocks.laws.derivation import derive
from gearblocks.laws.law import COORDINATES, LOCATED, PARTS, RATIOS, READ, STAGE, Law

MESH = {"teeth": (23, 41), "r_base": (0.03, 0.03 * 41 / 23), "external": True, "k": 2e8, "c": 300.0}
TEETH = {
    "teeth": (23, 73), "external": False, "module": 3e-3, "pressure_angle": 0.35, "stiffness": "iso6336",
    "face_width": 0.02, "profile_shift": (0.2, 0.1),
}  # fmt: skip
GAP = gb.Backlash(half_gap=3e-5)
PASSIVE = {
    "shaft": gb.Shaft(k=1e4, c=1.0),
    "nonlinear shaft": gb.Shaft(torque=100 * gb.twist + 1e4 * gb.twist**3, c=1.0),
    "damper": gb.Damper(c=1.0),
    "speed load": gb.SpeedLoad(coeffs=(1.0, 2.0, 3.0)),
    "mesh over the angle": gb.GearMesh(
        **MESH, stiffness_variation=gb.Fourier(cos=(0.2,)), transmission_error=gb.Harmonic(sin=(1e-6,)), backlash=GAP
    ),
    **{
        f"lash, {choice}": gb.Lash(k=1e3, half_gap=0.1, c=2.0, contact_damping=choice)
        for choice in ("clipped", "clipped_force", "always")
    },
    "polynomial gap": gb.GearMesh(
        **MESH, contact_damping="always", backlash=gb.Backlash(half_gap=3e-5, law="polynomial", degree=9)
    ),
    "smooth gap": gb.GearMesh(**MESH, backlash=gb.Backlash(half_gap=3e-5, law="smooth", width=1e-6)),
    "a gap of every tooth": gb.SplineCoupling(
        teeth=3, radius=0.03, k=1e8, c=10.0, backlash=gb.Backlash(gaps=(1e-5, 3e-5, 2e-5))
    ),
    "clutch": gb.Clutch(mu=gb.Table([0, 1], [0.5, 0.4]), force_max=3.0, engagement=gb.time),
    "bearing": gb.BearingFriction(coulomb=1.0, viscous=0.1, stribeck=gb.Stribeck(rise=0.3, speed=2.0)),
    "one way clutch": gb.OneWayClutch(mu=0.5, force_max=3.0, engagement=gb.time),
    "synchroniser": gb.Synchronizer(capacity=gb.time, engaged=gb.time),
    "stops": gb.HardStop(lower=-1.0, upper=1.0, restitution=0.5),
    "rolling vehicle": gb.Vehicle(mass=1e3, wheel_radius=0.3, drag_area=0.7, rolling=0.01),
    "dry slider": gb.Shaft(k=1e3, hysteresis=gb.Hysteresis(friction=1.0)),
    "slider and spring": gb.Shaft(k=1e3, c=1.0, hysteresis=gb.Hysteresis(friction=1.0, stiffness=1e2)),
    "impacts": gb.Lash(k=1e3, half_gap=0.1, contact_damping=gb.HuntCrossley(restitution=0.5)),
    **{
        f"tooth friction, {flank}, {transition}": gb.GearMesh(
            **TEETH, backlash=GAP, c=300.0, friction=gb.ToothFriction(mu=0.1, flank=flank, transition=transition)
        )
        for flank in ("drive", "coast")
        for transition in (None, 0.1)
    },
}


class Leaky(gb.Block):
    """A damper that claims to lose half of what it takes."""

    a, b = gb.Flange("left"), gb.Flange("right")
    c: float = gb.param("damping", "N m s/rad")

    def physics(self, s):
        rate = s.b.w - s.a.w
        yield gb.Force(s.b.phi - s.a.phi, s.c * rate)
        yield gb.Energy(loss=s.c * rate**2 / 2)


def _law(block):
    return derive(block, frozenset(name for name, flange in type(block).flanges.items() if flange.ground))


@pytest.mark.parametrize("block", PASSIVE.values(), ids=PASSIVE.keys())
def test_a_passive_block_supplies_nothing(block):
    assert _law(block).supplied is None


@pytest.mark.parametrize(
    "block",
    [
        Leaky(c=1.0),
        gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=500.0)),
        gb.Torque(tau=1.0),
        gb.GearMesh(**MESH, friction=gb.ToothFriction(mu=0.1, direction="square_wave", wave=gb.sin(gb.time))),
    ],
    ids=["wrong loss", "parametric", "source", "square wave"],
)
def test_what_the_energies_do_not_explain_is_supplied(block):
    assert _law(block).supplied is not None


@pytest.mark.parametrize("driven_by", ["angle", 500.0])
def test_a_mesh_on_a_turning_carrier_knows_its_deflection_without_absolute_angles(driven_by):
    # they cancel in the deflection; left in, they are integrated and drown it after many turns
    mesh = gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=driven_by), backlash=GAP)
    law = derive(mesh, frozenset())

    def absolute(expr):
        return [x for x in expr.free_symbols if law.pool.slots[x].role == "phi"]

    assert not absolute(law.switches[0].surface)  # the gap
    if driven_by != "angle":
        assert not any(absolute(x) for x in (*law.forces.values(), *law.torques.values(), law.stored, law.loss))


# -- the traversal of a law -------------------------------------------------------------------------------------------


def test_every_kind_of_contribution_has_one_check():
    assert set(KINDS) == set(get_args(Contribution))


def test_every_member_of_a_law_that_holds_expressions_is_a_part_of_its_traversal():
    walked = {part.member for part in PARTS.values()}
    assert {x.name for x in dataclasses.fields(Law)} - walked == {"pool", "coordinates", "replaced"}


@pytest.mark.parametrize("block", PASSIVE.values(), ids=PASSIVE.keys())
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
    assert law.expressions(RATIOS) == [c for k in law.sticks.values() for c in k.push.values()]
    assert set(law.expressions(STAGE)) >= {*law.torques.values(), *law.rates.values(), law.loss}
    assert not any({READ, LOCATED} <= set(part.roles) for part in PARTS.values())
    assert len(law.expressions(COORDINATES)) < len(law.expressions())
