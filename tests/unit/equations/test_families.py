"""Alike parts printed once, by an index."""

import re
from dataclasses import replace

import pytest

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.equations.families import families, names_in
from tests.random.description import build
from tests.random.families import draw


def _bundle(stiffness, law=None):
    """Springs side by side between two discs, a disc and a spring on each of the second."""
    rig = gb.Drivetrain("bundle")
    hub = rig.add("hub", gb.Inertia(J=2.0))
    rig.connect(rig.add("drive", gb.Torque(tau=7.0)).flange, hub.a)
    for i, k in enumerate(stiffness):
        kind = gb.Shaft(k=k, c=0.1) if i != law else gb.Shaft(k=k)
        spring, disc = rig.add(f"spring_{i}", kind), rig.add(f"disc_{i}", gb.Inertia(J=0.5))
        rig.connect(hub.b, spring.a)
        rig.connect(spring.b, disc.a)
    return rig


@pytest.mark.long
def test_eight_meshes_are_printed_as_two():
    eq = scripts.make("planetary_backlash").equations()
    text, latex = str(eq), eq.latex()
    assert "J_sun φ_sun'' = -Σ_i r1_sun_mesh_i N_sun_mesh_i + 300 + 30 cos(w t)" in text
    assert "J_planet_i φ_planet_i'' = -r2_sun_mesh_i N_sun_mesh_i - r1_ring_mesh_i N_ring_mesh_i" in text
    assert text.count("(GearMesh)") == 2
    assert "sun_mesh_i (GearMesh), i = 0, ..., 3\n" in text
    assert "mesh0" not in text
    assert r"&= -\sum_{i=0}^{3} r_{1,\mathrm{sun\_mesh}\,i}\,N_{\mathrm{sun\_mesh}\,i}" in latex
    assert eq.html().count("<munderover>") == 4
    assert "x_sun_mesh2 = " in str(eq.element("sun_mesh2"))
    assert {"N_sun_mesh3", "φ_planet1"} <= {row[0] for row in eq.nomenclature()}


@pytest.mark.long
def test_values_that_differ_are_all_listed_and_long_lists_by_their_ends():
    text = str(_bundle([3.0, 4.0, 5.0]).equations())
    assert "J_hub φ_hub'' = τ_drive + Σ_i T_spring_i" in text
    assert "T_spring_i = k_spring_i θ_spring_i + c_spring_i θ_spring_i'" in text
    assert "3, 4, 5 N m/rad" in text
    (line,) = (x for x in text.splitlines() if x.split()[:1] == ["c_spring_i"])
    assert line.split()[-4:] == ["N", "m", "s/rad", "spring_<i>.c"]
    assert "1.0001, 2.0001, ...," in str(_bundle([i + 1.0001 for i in range(12)]).equations())


@pytest.mark.parametrize(("stiffness", "law"), [([3.0, 4.0], None), ([3.0, 4.0, 5.0], 1)], ids=["two", "other law"])
def test_what_is_not_alike_stays_apart(stiffness, law):
    text = str(_bundle(stiffness, law=law).equations())
    assert "T_spring_0 = k_spring_0 θ_spring_0" in text
    assert "T_spring_1 = k_spring_1 θ_spring_1" in text
    assert "spring_i (" not in text


_AT_TIMES = [gb.sin(gb.time) ** 2, gb.cos(gb.time) ** 2, gb.sin(gb.time) ** 2]
"""Signals of three parts: their symbols have the same names, and their laws differ."""


@pytest.mark.parametrize(
    ("part", "second"),
    [
        (lambda x: gb.Clutch(capacity=10.0 * x), "C_spring_1 = 10 (cos(t))²"),
        (lambda x: gb.DogClutch(engaged=x), "(cos(t))²"),
        (lambda x: gb.OneWayClutch(capacity=10.0 * x), "(cos(t))²"),
    ],
    ids=["clutches", "dog clutches", "one-way clutches"],
)
def test_laws_that_differ_though_their_symbols_do_not_are_printed_one_by_one(part, second):
    rig = gb.Drivetrain("bundle")
    hub = rig.add("hub", gb.Inertia(J=2.0))
    for i, x in enumerate(_AT_TIMES):
        spring, disc = rig.add(f"spring_{i}", part(x)), rig.add(f"disc_{i}", gb.Inertia(J=0.5))
        rig.chain(hub, spring, disc)
    text = str(rig.equations())
    assert second in text
    assert "spring_1 (" in text
    assert "spring_i (" not in text


def test_what_is_named_one_by_one_stands_so_in_the_nomenclature():
    """The discs of a row are alike by name, but each has other neighbours."""
    eq = scripts.make("modelica_examples:coupled_clutches").equations()
    shown = [line.split()[0] for line in str(eq.document().nomenclature).splitlines()[1:] if line[4] != " "]
    assert {"φ_J1", "φ_J4", "J_J2", "T_clutch3"} <= set(shown)
    assert not [symbol for symbol in shown if symbol.endswith("_i")]


@pytest.mark.parametrize("name", [n for n in scripts.shipped() if n != "stiff_chain"])
@pytest.mark.few(1)
def test_every_symbol_that_is_printed_is_in_the_nomenclature(name):
    for maker in scripts.makers(scripts.locate(name)[0]):
        _check(scripts.make(f"{name}:{maker.name}").equations().document())


def _check(document):
    known = {replace(name, dots=0) for name, _ in document.nomenclature.entries}
    words = {"t", "x", "a", "e", "H", "λ", "G", "M", "v", "f", "T", "π"}  # explained where they stand
    printed = {replace(n, dots=0) for section in document.sections for n in names_in(section.lines)}
    alike = {n for n in printed if any(replace(n, owner=o) in known for o in _of_any(n.owner))}  # T_0 where T_i is
    assert {n for n in printed - alike if (n.owner or n.letter not in words) and not n.is_of_a_case} <= known


def _of_any(owner):
    """Owners with each number in turn as an index."""
    return [owner[: m.start()] + " i" + owner[m.end() :] for m in re.finditer(r"_?\d+(?=$| )", owner)]


def _stops(uppers, lower=None):
    """Stops in a row between a disc and the ground, the first with a second side."""
    rig = gb.Drivetrain("stops")
    disc = rig.add("disc", gb.Inertia(J=2.0))
    for i, upper in enumerate(uppers, 1):
        stop = rig.add(f"stop{i}", gb.HardStop(lower=lower if i == 1 else None, upper=upper, restitution=0.5))
        rig.connect(disc.b if i > 1 else disc.a, stop.a)
    return rig


@pytest.mark.parametrize("lower", [None, -0.1])
def test_a_sum_has_its_symbol_in_the_nomenclature(lower):
    eq = _stops([0.1, 0.2, 0.3], lower).equations()
    _check(eq.document())
    assert "Σ_i T_stop_i_upper" in str(eq)


@pytest.mark.long
def test_terms_are_a_sum_though_parts_of_another_family_stand_in_them():
    """Bodies called j1, j2, ... are a family too, of which each mesh reads the same two."""
    rig = gb.Drivetrain("set")
    mesh = gb.MeshLaw(k=1e8, c=100.0, stiffness_variation=gb.Fourier(cos=(0.1,)))
    gear = gb.PlanetaryGear(
        z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=0.35, planet_inertia=1e-4,
        sun_mesh=mesh, ring_mesh=gb.MeshLaw(k=1e8, c=100.0),
    )  # fmt: skip
    stage, bodies = rig.add("set", gear), [rig.add(f"j{i}", gb.Inertia(J=0.1)) for i in range(1, 5)]
    rig.connect(bodies[0].a, stage.sun)
    rig.connect(bodies[1].a, stage.ring)
    rig.connect(bodies[2].a, stage.carrier)
    rig.chain(bodies[2], rig.add("shaft", gb.Shaft(k=1e3)), bodies[3])
    text = str(rig.equations())
    assert "J_j1 φ_j1'' = -Σ_i r1_sun_mesh_i N_sun_mesh_i" in text
    _check(rig.equations().document())


@pytest.mark.long
@pytest.mark.parametrize(("family", "seed"), [("contact", 7002), ("friction", 7001), ("wide", 7000), ("smooth", 7002)])
def test_every_symbol_of_trains_that_nobody_wrote_is_in_the_nomenclature(family, seed):
    _check(build(draw(family, seed), gb).equations().document())


def test_families_are_of_one_class_and_without_a_gap():
    found = families(
        {"a1": "Shaft", "a2": "Shaft", "a3": "Shaft", "b0": "Shaft", "b1": "Shaft", "b3": "Shaft", "7": "Shaft"}
    )
    assert {path: (m.stem, m.number, m.indices) for path, m in found.members.items()} == {
        f"a{i}": ("a", i, (1, 3)) for i in (1, 2, 3)
    }
    assert not families({"a1": "Shaft", "a2": "Damper", "a3": "Shaft", "a04": "Shaft"}).members
    assert set(families({f"sets[{i}]": "Lash" for i in range(3)}).feet) == {"sets0", "sets1", "sets2"}
