"""Planetary sets composed of compliant meshes: statics, kinematics, phases, assembly."""

from fractions import Fraction

import numpy as np
import pytest

import gearblocks as gb

A, M = np.deg2rad(20), 2e-3
ZS, ZP, ZR = 24, 15, 54
LAW = gb.MeshLaw(k=2e8, damping_ratio=0.05)


def _gear(z=(ZS, ZP, ZR), law=LAW, **fields):
    fields = {"sun_mesh": law, "ring_mesh": law, "planet_inertia": 1e-5, **fields}
    return gb.PlanetaryGear(z_sun=z[0], z_planet=z[1], z_ring=z[2], module=M, pressure_angle=A, **fields)


def _rig(gear, free=False):
    """Sun driven, arm loaded, ring held (or free)."""
    rig = gb.Drivetrain("set")
    set_ = rig.add("gear", gear)
    sun, arm = rig.add("sun", gb.Inertia(J=2e-5)), rig.add("arm", gb.Inertia(J=1e-3))
    ring = rig.add("ring", gb.Inertia(J=2e-3)) if free else rig.add("ground", gb.Fixed())
    rig.connect(sun.a, set_.sun)
    rig.connect(arm.a, set_.carrier)
    rig.connect(ring.a if free else ring.flange, set_.ring)
    if not free:
        total = 1 + gear.z_ring / gear.z_sun
        rig.connect(rig.add("drive", gb.Torque(tau=10.0)).flange, sun.b)
        rig.connect(rig.add("load", gb.Torque(tau=-10.0 * total)).flange, arm.b)
    return rig


@pytest.mark.parametrize(
    "planets", [1, pytest.param(2, marks=pytest.mark.long), 3, pytest.param(6, marks=pytest.mark.long)]
)
@pytest.mark.few(1)
def test_planets_share_the_load_and_the_ring_takes_the_reaction(planets):
    run = gb.simulate(
        _rig(_gear(z=(30, 15, 60) if planets > 3 else (ZS, ZP, ZR), planets=planets)), t=[0.3], rtol=1e-10
    )
    zs, zr = (30, 60) if planets > 3 else (ZS, ZR)
    force = 10.0 / (M * zs * np.cos(A) / 2) / planets
    for i in range(1, planets + 1):
        assert run[f"gear.sun_mesh[{i}].force"][0] == pytest.approx(force, rel=1e-6)  # settled within 0.3 s
        assert run[f"gear.ring_mesh[{i}].force"][0] == pytest.approx(-force, rel=1e-6)
    assert run["ground.torque"][0] == pytest.approx(10.0 * zr / zs, rel=1e-6)


@pytest.mark.long
def test_a_stiff_set_turns_with_the_ratio_of_its_teeth():
    rig = _rig(_gear()).set({"drive.tau": 12.0})
    run = gb.simulate(rig, t=[0.5], rtol=1e-9)
    sun, arm = run["sun.w"][0], run["arm.w"][0]
    assert sun > 10
    assert sun / arm == pytest.approx(1 + ZR / ZS, rel=1e-4)  # meshes still swing a little
    planet = run["gear.planet[1].w"][0]
    assert (planet - arm) / (sun - arm) == pytest.approx(-ZS / ZP, rel=1e-4)


@pytest.mark.long
def test_the_mass_of_the_planets_turns_with_the_carrier():
    orbit = M * (ZS + ZP) / 2
    heavy = gb.simulate(_rig(_gear(planet_mass=0.3)), t=[0.01], rtol=1e-9)
    arm = _rig(_gear()).set({"arm.J": 1e-3 + 3 * 0.3 * orbit**2})
    light = gb.simulate(arm, t=[0.01], rtol=1e-9)
    assert heavy["arm.phi"][0] == pytest.approx(light["arm.phi"][0], rel=1e-12)
    helical = _gear(planet_mass=0.3, helix_angle=0.3).parts().blocks["carrier_mass"].J
    assert helical == pytest.approx(3 * 0.3 * (orbit / np.cos(0.3)) ** 2, rel=1e-15)


def test_phases_follow_from_the_tooth_counts():
    """Parker and Lin: gamma_sn = z_s psi_n / 2 pi behind; the ring has -z_r psi_n / 2 pi, all modulo 1."""
    sun, ring = _gear(z=(25, 14, 53), planets=3).mesh_phases()
    assert sun == pytest.approx([0, float(Fraction(-25, 3) % 1), float(Fraction(-50, 3) % 1)])
    assert ring == pytest.approx(
        [0.5, float((Fraction(1, 2) - Fraction(53, 3)) % 1), float((Fraction(1, 2) - Fraction(106, 3)) % 1)]
    )
    assert _gear(planets=3).mesh_phases() == ([0.0] * 3, [0.0] * 3)  # all in phase; 15 planet teeth: an odd number
    assert _gear(ring_phase=0.25).mesh_phases()[1] == [0.25] * 3
    uneven = 2 * np.pi * np.array([0, 26, 53]) / 78
    sun, _ = _gear(planet_angles=tuple(uneven)).mesh_phases()
    assert sun == pytest.approx([0.0, -ZS * 26 / 78 % 1, -ZS * 53 / 78 % 1], abs=1e-12)


@pytest.mark.long
def test_the_meshes_of_later_planets_pass_through_their_cycle_in_the_order_of_their_places():
    """The tooth of the sun that is at planet 1 now comes to planet 2 when the sun has turned by psi_2 about the carrier."""
    law = LAW.changed(stiffness_variation=gb.Fourier(cos=(0.2,), sin=(0.1,)))
    rig = _rig(_gear(z=(25, 14, 53), law=law), free=True)
    turn = 0.7
    wheel = {f"gear.planet[{i}].phi": -25 / 14 * turn for i in (1, 2, 3)}
    now = gb.simulate(rig, t=[0.0], initial={"sun.phi": turn, "ring.phi": -25 / 53 * turn, **wheel})
    later = turn + 2 * np.pi / 3
    wheel = {f"gear.planet[{i}].phi": -25 / 14 * later for i in (1, 2, 3)}
    then = gb.simulate(rig, t=[0.0], initial={"sun.phi": later, "ring.phi": -25 / 53 * later, **wheel})
    k = "gear.sun_mesh[{}].stiffness"
    assert then[k.format(2)][0] == pytest.approx(now[k.format(1)][0], rel=1e-12)
    assert then[k.format(3)][0] == pytest.approx(now[k.format(2)][0], rel=1e-12)
    assert then[k.format(1)][0] != pytest.approx(now[k.format(1)][0], rel=1e-3)
    # a tooth of the ring comes to planet 2 when the ring has turned by psi_2 about the carrier
    k = "gear.ring_mesh[{}].stiffness"
    later = turn - 53 / 25 * 2 * np.pi / 3
    wheel = {f"gear.planet[{i}].phi": -25 / 14 * later for i in (1, 2, 3)}
    then = gb.simulate(rig, t=[0.0], initial={"sun.phi": later, "ring.phi": -25 / 53 * later, **wheel})
    assert then[k.format(2)][0] == pytest.approx(now[k.format(1)][0], rel=1e-12)


@pytest.mark.long
def test_phases_driven_by_a_frequency_agree_with_those_of_the_angle():
    """The same set in the same turn: by angle, and by the mesh frequency with the sun turning forward."""
    z, w = (25, 14, 53), 30.0
    wave = {"cos": (0.2,), "sin": ()}
    by_angle = _rig(_gear(z=z, law=LAW.changed(stiffness_variation=gb.Fourier(**wave))), free=True)
    by_time = _rig(_gear(z=z, law=LAW.changed(stiffness_variation=gb.Fourier(**wave, driven_by=25 * w))), free=True)
    t = 0.0123
    planets = {f"gear.planet[{i}].phi": -25 / 14 * w * t for i in (1, 2, 3)}
    angles = {"sun.phi": w * t, "ring.phi": -25 / 53 * w * t, **planets}
    one = gb.simulate(by_angle, t=[t], t_start=t, initial=angles)
    other = gb.simulate(by_time, t=[t], t_start=t, initial=angles)
    for mesh in ("sun_mesh", "ring_mesh"):
        for i in (1, 2, 3):
            name = f"gear.{mesh}[{i}].stiffness"
            assert one[name][0] == pytest.approx(other[name][0], rel=1e-10), name


@pytest.mark.long
def test_a_free_set_keeps_energy_and_angular_momentum():
    law = gb.MeshLaw(k=2e7, stiffness_variation=gb.Fourier(cos=(0.3,)), backlash=gb.Backlash(half_gap=1e-5))
    rig = _rig(_gear(z=(25, 14, 53), law=law, planet_mass=0.1), free=True)
    t = np.linspace(0, 0.02, 101)
    run = gb.simulate(rig, t=t, rtol=1e-11, initial={"sun.w": 50.0, "arm.w": 10.0, "ring.w": -3.0})
    bodies = ["sun", "arm", "ring", "gear.carrier_mass", *(f"gear.planet[{i}]" for i in (1, 2, 3))]
    energy = sum(run[f"{name}.kinetic_energy"] for name in bodies)
    assert np.ptp(energy) > 1e-3 * energy[0]
    assert run.energy.supplied == {}
    assert run.energy.residual < 1e-10  # 10 rtol
    assert run.energy.end == pytest.approx(run.energy.start, rel=1e-9)  # a hundred steps and more at 1e-11


@pytest.mark.long
def test_friction_loses_as_much_forwards_as_backwards():
    lost = []
    for sign, flank in ((1.0, "drive"), (-1.0, "coast")):
        gear = _gear(law=LAW.changed(friction=gb.ToothFriction(mu=0.05, flank=flank, transition=0.01)))
        rig = _rig(gear).set({"drive.tau": sign * 10.0, "load.tau": -sign * 10.0 * (1 + ZR / ZS)})
        sun, arm = sign * 100.0, sign * 100.0 / (1 + ZR / ZS)
        planets = {f"gear.planet[{i}].w": arm - ZS / ZP * (sun - arm) for i in (1, 2, 3)}
        run = gb.simulate(rig, t=[0.02], rtol=1e-9, initial={"sun.w": sun, "arm.w": arm, **planets})
        assert set(run.energy.supplied) == {"drive", "load"}
        lost.append(sum(run.energy.dissipated.values()))
    assert lost[0] == pytest.approx(lost[1], rel=1e-6)
    assert lost[0] > 0.1


@pytest.mark.parametrize(("fields", "words"), [
    ({"z": (24, 15, 55)}, "z_ring = 55 must be z_sun + 2 z_planet = 54"),
    ({"z": (24, 15.5, 55)}, "must be whole numbers > 0"),
    ({"planets": 5}, "planet 2 at 72 degrees cannot be assembled: (z_sun + z_ring) = 78 teeth make 15.6 pitches"),
    ({"planets": 0}, "planets = 0 must be a whole number >= 1"),
    ({"z": (12, 30, 72), "planets": 6}, "neighbouring planets 60 degrees apart would touch"),
    ({"planet_angles": (0.0, 2.0, 4.0)}, "the nearest place is 115.384615 degrees"),
    ({"planet_angles": (0.0, 2.0)}, "planet_angles has 2 angles for 3 planets"),
    ({"planet_angles": (0.0, float("nan"), 1.0)}, "must be a row of numbers in rad"),
    ({"law": gb.MeshLaw(damping_ratio=0.1)}, "sun_mesh: damping needs compliance"),
    ({"law": gb.MeshLaw(k=1e8, backlash=gb.Backlash(half_gap=1.0, law="x"))}, "ring_mesh: backlash.law = 'x'"),
    ({"law": gb.MeshLaw(k=-1.0)}, "sun_mesh.k = -1.0 N/m must be > 0"),
    ({"law": {"k": 1e8}}, "must be an effect object"),
    ({"planet_inertia": -1.0}, "planet_inertia = -1.0 kg m2 must be >= 0"),
    ({"ring_phase": "x"}, "ring_phase = 'x' cycles must be a number"),
])  # fmt: skip
@pytest.mark.few(3)
def test_a_set_that_cannot_exist_is_refused_with_the_reason(fields, words):
    with pytest.raises(gb.ModelError) as caught:
        _rig(_gear(**fields))
    assert words in str(caught.value), str(caught.value)


@pytest.mark.long
def test_uneven_places_that_fit_are_accepted():
    places = tuple(2 * np.pi * np.array([0, 26, 53]) / 78)
    run = gb.simulate(_rig(_gear(planet_angles=places)), t=[1e-3])
    assert run["sun.phi"][0] > 0


@pytest.mark.long
def test_effects_of_a_set_are_named_by_mesh_and_can_be_taken_away():
    law = LAW.changed(backlash=gb.Backlash(half_gap=1e-5), friction=gb.ToothFriction(mu=0.05))
    rig = _rig(_gear(law=law))
    assert "gear.sun_mesh.backlash" in rig.effects()
    without = rig.without("*.friction", "gear.ring_mesh.backlash")
    assert set(without.effects()) == {
        "gear.sun_mesh.compliance", "gear.sun_mesh.damping", "gear.sun_mesh.backlash",
        "gear.ring_mesh.compliance", "gear.ring_mesh.damping",
    }  # fmt: skip
    only = rig.only("gear.sun_mesh.backlash")
    assert set(only.effects()) == {"gear.sun_mesh.compliance", "gear.sun_mesh.backlash"}
    assert only["gear"].ring_mesh is None


@pytest.mark.long
def test_a_set_is_changed_by_paths_and_survives_a_file(tmp_path):
    law = LAW.changed(backlash=gb.Backlash(half_gap=1e-5), stiffness_variation=gb.Fourier(cos=(0.1,), phase=0.3))
    rig = _rig(_gear(law=law, planet_mass=0.1)).set({"gear.sun_mesh.backlash.half_gap": 2e-5})
    assert rig["gear"].sun_mesh.backlash.half_gap == 2e-5
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["gear"] == rig["gear"]
    model = gb.build(rig)
    run = gb.simulate(model, t=[0.0], parameters={"gear.sun_mesh[2].k": 1e8})
    assert run["gear.sun_mesh[2].stiffness"][0] == pytest.approx(run["gear.sun_mesh[1].stiffness"][0] / 2, rel=0.2)
