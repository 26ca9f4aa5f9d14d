"""The matrix of implicit methods against differences of the right-hand side: springs, meshes, loops, gears."""

from __future__ import annotations

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.cli.scripts import make
from gearblocks.train.handles import FlangeHandle

# -- laws -------------------------------------------------------------------------------------------------------------


def between(*links: gb.Block, ends: tuple[gb.Block, ...] = ()) -> gb.Drivetrain:
    """Inertias with these links in between, and blocks at the end of the chain."""
    rig = gb.Drivetrain("chain")
    parts = [rig.add("disc0", gb.Inertia(J=1.5))]
    for i, link in enumerate(links):
        parts += [rig.add(f"link{i}", link), rig.add(f"disc{i + 1}", gb.Inertia(J=1.0 + 0.5 * i))]
    parts += [rig.add(f"end{i}", end) for i, end in enumerate(ends)]
    rig.chain(*parts)
    return rig


def test_the_shipped_spline_coupling(check):
    assert check(make("spline_coupling"), angle=1e-3, speed=0.1).is_tree


@pytest.mark.long
def test_a_long_chain_to_the_ground_is_eliminated_from_both_ends(check):
    links = [gb.Shaft(k=100.0 + i, c=0.1 * i) if i % 2 else gb.Lash(k=50.0, half_gap=0.3, c=0.2) for i in range(40)]
    pattern = check(between(*links, ends=(gb.Shaft(k=3.0, c=1.0), gb.Fixed())))
    assert pattern.is_tree
    assert pattern.order[:4] == (0, 40, 1, 39)


@pytest.mark.long
def test_damping_ratios_clipped_dampers_and_loads(check):
    mesh = gb.GearMesh(
        teeth=(20, 33), external=True, r_base=(0.2, 0.33), k=300.0, damping_ratio=0.1,
        backlash=gb.Backlash(half_gap=0.05), contact_damping="clipped",
        stiffness_variation=gb.Fourier(cos=(0.2,), sin=(0.1,), driven_by=3.0),
        transmission_error=gb.Harmonic(cos=(0.02,), driven_by=gb.Input("speed", unit="rad/s") * 2),
    )  # fmt: skip
    pushing = gb.Lash(k=40.0, half_gap=0.2, damping_ratio=0.2, contact_damping="clipped_force")
    check(between(gb.Shaft(k=50.0, damping_ratio=0.1), mesh, pushing, ends=(gb.SpeedLoad(coeffs=(1.0, 2.0, 3.0)),)))


@pytest.mark.long
def test_a_mesh_over_the_angle_with_a_carrier_that_turns(check):
    rig = gb.Drivetrain("epicyclic")
    bodies = [rig.add(n, gb.Inertia(J=j)) for n, j in (("sun", 1.0), ("planet", 0.5), ("arm", 2.0), ("ring", 3.0))]
    sun, planet, arm, ring = bodies
    wave = gb.Fourier(cos=(0.2, 0.1), sin=(0.05,))
    gap = gb.Backlash(half_gap=0.01)
    inner = gb.GearMesh(
        teeth=(20, 30), external=True, r_base=(0.2, 0.3), k=200.0, c=1.0, stiffness_variation=wave, backlash=gap,
        transmission_error=gb.Harmonic(cos=(0.01,)), contact_damping="always",
    )  # fmt: skip
    outer = gb.GearMesh(teeth=(30, 80), external=False, r_base=(0.3, 0.8), k=150.0, c=2.0, stiffness_variation=wave)
    for name, mesh, one, other in (("inner", inner, sun, planet), ("outer", outer, planet, ring)):
        added = rig.add(name, mesh)
        rig.connect(added.pinion, one.a)
        rig.connect(added.wheel, other.a)
        rig.connect(added.carrier, arm.a)
    check(rig, angle=0.03)  # so that the phase of the teeth, 40 times the angle, moves little in a difference


@pytest.mark.long
@pytest.mark.parametrize(
    "external", [pytest.param(False, id="internal", marks=pytest.mark.long), pytest.param(True, id="external")]
)
def test_non_circular_pairs_with_a_stiffness_over_the_angle(check, external):
    laws = (gb.RatioLaw.ellipse(0.3), gb.RatioLaw.segments(0.0887, 0.8143, 4.19))
    stiff = 20 + 5 * gb.cos(2 * gb.driver_angle)
    moves = 0.3 + gb.sin(gb.time)
    gears = [gb.NonCircularGear(law=law, external=external, k=stiff, c=1.0, phase=moves) for law in laws]
    check(between(*gears), angle=0.3)


@pytest.mark.long
def test_springs_over_tables_and_expressions(check):
    table = gb.Table([-3.0, -1.0, 0.5, 2.0, 4.0], [-5.0, -1.0, 0.2, 3.0, 9.0], kind="cubic")
    law = 3 * gb.twist + 2 * gb.twist**3 + sp.sin(gb.twist)
    stiff = gb.Shaft(k=10 + gb.sin(2 * gb.time) + gb.Input("k"))
    check(between(gb.Shaft(torque=table, c=1.0), gb.Shaft(torque=law), stiff))


# -- loops and ratios -------------------------------------------------------------------------------------------------


def test_loops_fold_their_deflections_onto_the_coordinates(check):
    rig = between(gb.Shaft(k=10.0), gb.Shaft(k=20.0, c=0.3), gb.Lash(k=15.0, half_gap=0.2, c=0.1))
    handles = [FlangeHandle(rig, f"disc{i}", "a") for i in range(4)]
    for i, (a, b) in enumerate(((0, 2), (1, 3), (0, 3), (0, 3))):
        cross = rig.add(f"cross{i}", gb.Shaft(k=5.0 + i, c=0.2))
        rig.connect(cross.a, handles[a])
        rig.connect(cross.b, handles[b])
    pattern = check(rig)
    assert not pattern.is_tree


def test_ideal_gears_bring_their_ratios_in(check):
    rig = gb.Drivetrain("ratios")
    a, b, c, d = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abcd", (1.0, 0.3, 2.0, 0.7), strict=True))
    gear, other = (
        rig.add("gear", gb.IdealGear(teeth=(21, 44), external=True)),
        rig.add("other", gb.IdealGear(ratio=2.5)),
    )
    one, two = rig.add("one", gb.Shaft(k=30.0, c=0.5)), rig.add("two", gb.Lash(k=20.0, half_gap=0.1))
    rig.chain(a, gear, b, one, c, other, d)
    rig.connect(two.a, d.b)
    rig.connect(two.b, a.a)
    check(rig)


@pytest.mark.long
def test_a_spring_between_two_shafts_of_one_gear_and_a_spring_elsewhere(check):
    """Both ends of `across` turn with the same group, at different speeds; the entry is one number on the diagonal."""
    rig = gb.Drivetrain("across")
    a, b, c = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abc", (1.0, 0.3, 2.0), strict=True))
    gear, across, on = (
        rig.add("gear", gb.IdealGear(ratio=3.0)),
        rig.add("across", gb.Shaft(k=30.0, c=0.5)),
        rig.add("on", gb.Shaft(k=20.0, c=0.4)),
    )
    rig.chain(a, gear, b, on, c)
    rig.connect(across.a, a.a)
    rig.connect(across.b, b.a)
    check(rig)
