"""What blocks declare about effects that were left out, and about what excites a train."""

import pytest

import gearblocks as gb
from gearblocks.language.watches import Excitation


def _seen(block: gb.Block, effect: str) -> list[tuple[str, float | None]]:
    return [(w.output, w.limit) for w in block.would_show(effect)]


def test_a_sliders_torque_and_its_spring_tell_the_twist_at_which_it_slips() -> None:
    plain = gb.Shaft(k=2e3, hysteresis=gb.Hysteresis(friction=1.5))
    sprung = gb.Shaft(k=2e3, hysteresis=gb.Hysteresis(friction=1.5, stiffness=500.0))
    parts = gb.Shaft(k=2e3, J=0.1, segments=2, hysteresis=gb.Hysteresis(friction=1.5))
    assert _seen(plain, "hysteresis") == [("torque", 1.5)]
    assert _seen(sprung, "hysteresis") == [("twist", 3e-3)]
    assert _seen(parts, "hysteresis") == [("spring[1].torque", 1.5), ("spring[2].torque", 1.5)]
    assert _seen(plain, "damping") == []


def test_every_planet_shows_the_backlash_of_its_meshes() -> None:
    law = gb.MeshLaw(k=3e8, c=1e3, backlash=gb.Backlash(half_gap=2e-5))
    gear = gb.PlanetaryGear(
        z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=0.35, planet_inertia=1e-4, sun_mesh=law
    )
    assert _seen(gear, "sun_mesh.backlash") == [(f"sun_mesh[{i}].force", None) for i in (1, 2, 3)]


def test_waves_over_time_excite_at_their_frequencies() -> None:
    speed = gb.Parameter("speed", 50.0, "rad/s")
    wave = 1 + gb.sin(3 * speed * gb.time + 0.2) * gb.cos(20 * gb.time) + gb.sin(gb.time**2)
    found = sorted(x.frequency for x in gb.Torque(tau=wave).excitations())
    assert found == pytest.approx([20.0, 150.0])


def test_orders_of_the_mesh_follow_from_its_teeth() -> None:
    error = gb.Harmonic(cos=(1e-6, 1e-6)), gb.Harmonic(sin=(2e-5,), driven_by="300 rpm")
    mesh = gb.GearMesh(teeth=(23, 41), external=True, module=3e-3, pressure_angle=0.35, k=2e8, transmission_error=error)
    found = set(mesh.excitations())
    assert Excitation("the mesh", order=46.0, flange="pinion", against="carrier") in found
    assert {round(x.frequency, 6) for x in found if x.frequency} == {round(gb.rpm(300), 6)}
    assert not list(gb.GearMesh(teeth=(23, 41), external=True).excitations())
