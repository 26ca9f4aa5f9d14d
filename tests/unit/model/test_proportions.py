"""Numbers that another unit was meant for are asked about by rig.describe(), and usual ones are not."""

from __future__ import annotations

import re
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.model.plausibility import implausible

PAIR: dict[str, Any] = {"teeth": (23, 41), "module": 3e-3, "pressure_angle": 0.35, "external": True, "k": 2e8}
USUAL: dict[str, Any] = {
    "k": 2e8, "damping_ratio": 0.05, "c": 3e3, "backlash": gb.Backlash(half_gap="50 um"),
    "transmission_error": gb.Harmonic(sin=("3 um",)), "stiffness_variation": gb.Fourier(cos=(0.3,)),
}  # fmt: skip

pytestmark = pytest.mark.filterwarnings("ignore::gearblocks.errors.GearblocksWarning")


def _cycle(*y: float) -> gb.Table:
    return gb.Table([0.0, 0.5, 1.0], y, periodic=True)


def _asked(*blocks: gb.Block) -> list[str]:
    rig = gb.Drivetrain("rig")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return list(implausible(rig.tree()))


def _pair(block: gb.Block) -> list[str]:
    return _asked(gb.Inertia(J=0.02), block, gb.Inertia(J=0.05))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"backlash": gb.Backlash(half_gap=30.0)}, "b1.backlash.half_gap = 30 m: the teeth would pass each other with more "
         "than their module, 0.003 m; 30 um is written as '30 um'"),
        ({"backlash": gb.Backlash(half_gap="5 mm")}, "half_gap = 0.005 m: the teeth .* are some um"),
        ({"transmission_error": gb.Harmonic(sin=(5.0,))}, r"transmission_error.sin\[0\] = 5 m: .*; 5 um is written as '5 um'"),
        ({"transmission_error": (gb.Harmonic(cos=(2e-6,)), gb.Harmonic(cos=(20.0,), driven_by=9.0))}, r"second.cos.0. = 20 m"),
        ({"transmission_error": _cycle(3.0, -3.0, 3.0)}, "error.table comes to 3 m, more than the module, 0.003 m"),
        ({"stiffness_variation": _cycle(2e8, 1e8, 2e8)}, r"table comes to 2e\+08: its values are relative to k"),
        ({"k": 200.0}, "b1.k = 200 N/m is softer than teeth of plastic .*; 200 N/um is written as '200 N/um'"),
        ({"damping_ratio": 5.0}, "b1.damping_ratio = 5 is 5 times critical damping; 5 % is written as '5 %'"),
        ({"c": 1e9}, r"b1.c = 1e\+09 N s/m: unloaded teeth come back within c/k = 5 s"),
    ],
)  # fmt: skip
def test_numbers_of_a_pair_that_another_unit_was_meant_for_are_asked_about(more: dict[str, Any], words: str) -> None:
    asked = [x for x in _pair(gb.GearMesh(**(PAIR | more))) if re.search(words, x)]
    assert len(asked) == 1
    assert _pair(gb.GearMesh(**(PAIR | {name: USUAL[name] for name in more}))) == []


def test_parts_of_planetary_sets_and_splines_are_asked_about_too() -> None:
    law = gb.MeshLaw(k=100.0, transmission_error=gb.Harmonic(cos=(4.0,)))
    (one, two) = list(implausible(_planetary(law).tree()))
    assert one.startswith("gear.sun_mesh.k = 100 N/m is softer")
    assert two.startswith("gear.sun_mesh.transmission_error.cos[0] = 4 m: the teeth would deviate")
    assert list(implausible(_planetary(gb.MeshLaw(k=1e8)).tree())) == []
    spline = gb.SplineCoupling(teeth=24, radius=0.02, k=5e8, damping_ratio=4.0, backlash=gb.Backlash(half_gap=20.0))
    assert {x.split(" =")[0] for x in _pair(spline)} == {"b1.damping_ratio", "b1.backlash.half_gap"}


def _planetary(law: gb.MeshLaw) -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.add("gear", gb.PlanetaryGear(z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=0.35, planet_inertia=1e-4,
                                     sun_mesh=law))  # fmt: skip
    return rig


def test_a_ring_with_fewer_teeth_than_its_pinion_is_asked_about() -> None:
    for kind in (gb.GearMesh, gb.IdealGear):
        fields = PAIR if kind is gb.GearMesh else {}
        inside = _pair(kind(**(fields | {"teeth": (41, 23), "external": False})))
        assert len(inside) == (kind is gb.GearMesh)  # without a mesh it is but a ratio
        assert all("b1.teeth = (41, 23) of an internal pair" in x for x in inside)
    assert _pair(gb.GearMesh(**(PAIR | {"teeth": (23, 41), "external": False}))) == []
    assert _pair(gb.GearMesh(**(PAIR | {"teeth": (41, 23)}))) == []


def test_speeds_in_rpm_typed_as_rad_s_are_asked_about() -> None:
    spring = gb.Shaft(k=1e4)
    (words,) = _asked(gb.Inertia(J=1.0, w0=3e4), spring, gb.Inertia(J=1.0))
    assert words == "b0.w0 = 30000 rad/s is 286479 rpm; 30000 rpm is written as '30000 rpm'"
    (words,) = _asked(gb.Speed(w=-2e4), spring, gb.Inertia(J=1.0))
    assert words.startswith("b0.w = -20000 rad/s is -190986 rpm")
    assert _asked(gb.Inertia(J=1.0, w0="120000 rpm"), spring, gb.Inertia(J=1.0)) == []  # a turbine of a turbocharger


def test_an_inertia_beside_which_nothing_counts_is_asked_about_and_a_wind_turbine_is_not() -> None:
    spring = gb.Shaft(k=1e4)
    (words,) = _asked(gb.Inertia(J=2e5), spring, gb.Inertia(J=0.02))
    assert words.startswith("b0.J = 200000 kg m2 is 1e+07 times b2.J, the next largest inertia")
    assert _asked(gb.Inertia(J=3.6e7), gb.Shaft(k=8e8), gb.IdealGear(ratio=97.0), gb.Inertia(J=534.0)) == []
    assert _asked(gb.Inertia(J=0.1), spring, gb.Inertia(J=1e-8)) == []  # a small one is none to ask about


def test_models_without_dimensions_take_any_number() -> None:
    plain = {"teeth": (23, 41), "external": True, "r_base": (23.0, 41.0), "k": 1.0, "c": 5.0}
    pair = gb.GearMesh(**plain, backlash=gb.Backlash(half_gap=1.0), transmission_error=gb.Harmonic(sin=(2.0,)))
    assert _pair(pair) == []
    overdamped = gb.Shaft(k=1e4, damping_ratio=1.5)  # of no teeth: a coupling of rubber
    assert _pair(overdamped) == []
