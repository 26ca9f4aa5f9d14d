"""Planetary gear sets with compliant or rigid meshes, composed of meshes and bodies."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import cos, isfinite, pi, sin
from typing import Any, cast

from gearblocks.blocks.bodies import Inertia
from gearblocks.blocks.effects import MeshLaw, ToothFriction
from gearblocks.blocks.gears import teeth_problems
from gearblocks.blocks.meshes import GearMesh
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Parts
from gearblocks.language.fields import Flange, effect, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Value
from gearblocks.language.watches import Watch


class PlanetaryGear(Block):
    """Sun, ring, carrier and planets with their inertias: a composite of GearMesh and Inertia.

            |===|---o ring
            |(o)|---o carrier        (o) planets, with their inertia
            |===|---o sun

    Parts: planet[i], sun_mesh[i], ring_mesh[i], i = 1, 2, ..., so that paths read `gear.sun_mesh[1].force`; and
    carrier_mass where planet_mass is given: the planets' mass on the carrier, at the orbit radius
    m (z_sun + z_planet)/(2 cos(beta)). Inertias of sun, ring and carrier themselves are connected from outside. Every
    angle is absolute; planet_inertia is about the planet's own axis.

    Planet i stands at the carrier angle psi_i: evenly from 0, or planet_angles. The mesh cycles of the planets follow
    from the tooth counts (Parker and Lin 2004, J. Mech. Des. 126, 365-370, doi 10.1115/1.1667892):
        sun mesh   theta = z_sun (phi_sun - phi_c) - z_sun psi_i
        ring mesh  theta = z_planet (phi_planet - phi_c) - z_ring psi_i + 2 pi ring_phase
    so that theta grows as its first gear turns forward about the carrier (in the ring mesh that of the planet). For laws
    driven by a frequency the sun turns forward about the carrier: the ring mesh then has - theta. ring_phase [cycles]: the
    ring mesh against the sun mesh of one planet; left out, both count from contact at the pitch point of teeth half a
    pitch thick: 1/2 for an even number of planet teeth, 0 for an odd one.

    sun_mesh and ring_mesh: gb.MeshLaw(k=..., ...); left out, that mesh is rigid. The flank of their friction is meant as
    the sun sees it ("drive": the sun turns forward and drives); the other flank of the planets drives the ring.

    Example:
        rig = gb.Drivetrain("reduction stage")
        law = gb.MeshLaw(k=3e8, damping_ratio=0.05)
        gear = gb.PlanetaryGear(
            z_sun=42, z_planet=18, z_ring=78, module="2 mm", pressure_angle="20 deg", planet_inertia=1e-4,
            sun_mesh=law, ring_mesh=law,
        )
        stage, motor, load = rig.add("gear", gear), rig.add("motor", gb.Inertia(J=1e-3)), rig.add("load", gb.Inertia(J=0.01))
        rig.connect(motor.b, stage.sun)
        rig.connect(stage.ring, rig.add("case", gb.Fixed()).flange)
        rig.connect(stage.carrier, load.a)
    """

    sun, ring, carrier = Flange("sun"), Flange("ring gear"), Flange("planet carrier")
    z_sun: int = exact("tooth number of the sun")
    z_planet: int = exact("tooth number of a planet")
    z_ring: int = exact("tooth number of the ring, z_sun + 2 z_planet")
    planets: int = option("number of planets", default=3)
    planet_angles: tuple[float, ...] | None = option("carrier angles of the planets", "rad", default=None, many=True)
    module: Value = param("normal module", "m", gt=0, usual=0.1)
    pressure_angle: Value = param("normal pressure angle", "rad", ge=0, lt=1.5)
    helix_angle: Value | None = param("helix angle", "rad", default=None, gt=-1.5, lt=1.5)
    planet_inertia: Value = param("inertia of one planet about its own axis", "kg m2", ge=0, symbol="J_p")
    planet_mass: Value | None = param("mass of one planet", "kg", default=None, ge=0, symbol="m_p")
    ring_phase: float | None = option("ring mesh against sun mesh, in mesh cycles", default=None)
    sun_mesh: MeshLaw | None = effect("law of the sun's meshes", default=None)
    ring_mesh: MeshLaw | None = effect("law of the ring's meshes", default=None)
    heat: HeatPort | None = HEAT

    # -- what is wrong ------------------------------------------------------------------------------------------------

    def problems(self) -> Iterator[str]:
        """Teeth that do not fit, planets that cannot be assembled, and what the meshes find wrong."""
        counts = (self.z_sun, self.z_planet, self.z_ring)
        if any(int(z) != z or z <= 0 for z in counts):
            yield f"z_sun, z_planet, z_ring = {counts!r} must be whole numbers > 0"
            return
        if type(self.planets) is not int or self.planets < 1:
            yield f"planets = {self.planets!r} must be a whole number >= 1"
            return
        if self.z_ring != self.z_sun + 2 * self.z_planet:
            yield f"z_ring = {self.z_ring} must be z_sun + 2 z_planet = {self.z_sun + 2 * self.z_planet}"
        wrong_angles = list(self._angle_problems())
        yield from wrong_angles
        if not wrong_angles:
            yield from self._assembly_problems()
        phase = self.ring_phase
        if phase is not None and (type(phase) not in (int, float) or not isfinite(phase)):
            yield f"ring_phase = {phase!r} cycles must be a number"
        for name, mesh in (("sun_mesh", self._mesh("sun_mesh", 0.0)), ("ring_mesh", self._mesh("ring_mesh", 0.0))):
            if not any(teeth_problems(mesh)):
                yield from (f"{name}: {problem}" for problem in mesh.problems())
                parts = (
                    getattr(mesh, field)
                    for field in ("stiffness_variation", "backlash", "transmission_error", "friction")
                )
                yield from (f"{name}: {problem}" for part in parts if part is not None for problem in part.problems())

    def _angle_problems(self) -> Iterator[str]:
        angles = self.planet_angles
        if angles is None:
            return
        if not isinstance(angles, tuple) or not all(type(a) in (int, float) and isfinite(a) for a in angles):
            yield f"planet_angles = {angles!r:.80} must be a row of numbers in rad"
        elif len(angles) != self.planets:
            yield f"planet_angles has {len(angles)} angles for {self.planets} planets; give one of each"

    def _assembly_problems(self) -> Iterator[str]:
        """Each planet needs (z_sun + z_ring) psi / 2 pi whole, and room beside its neighbours."""
        both = self.z_sun + self.z_ring
        for i, place in enumerate(self._places(), 1):
            steps = float((place - self._places()[0]) * both)
            if abs(steps - round(steps)) > 1e-9 * both:
                near = round(steps) / both
                yield (
                    f"planet {i} at {360 * float(place):.6g} degrees cannot be assembled: (z_sun + z_ring) = {both} teeth make "
                    f"{steps:.6g} pitches up to there, which must be whole; the nearest place is {360 * near:.9g} degrees "
                    f"from planet 1"
                )
                return
        cycles = sorted(float(p) % 1 for p in self._places())
        gaps = [b - a for a, b in zip(cycles, [*cycles[1:], cycles[0] + 1], strict=True)]
        if self.planets > 1 and (self.z_sun + self.z_planet) * sin(pi * min(min(gaps), 0.5)) < self.z_planet + 2:
            yield (
                f"neighbouring planets {360 * min(gaps):.6g} degrees apart would touch: their centres are "
                f"{(self.z_sun + self.z_planet) * sin(pi * min(gaps)):.4g} modules apart, their tips need {self.z_planet + 2}"
            )

    # -- composition --------------------------------------------------------------------------------------------------

    def _places(self) -> list[Any]:
        """Carrier angles of the planets in turns; exact where they stand evenly."""
        if self.planet_angles is not None:
            return [a / (2 * pi) for a in self.planet_angles]
        return [Fraction(i, self.planets) for i in range(self.planets)]

    def mesh_phases(self) -> tuple[list[float], list[float]]:
        """Phases in cycles, within [0, 1), of the sun's and the ring's meshes, planet by planet."""
        own = self.ring_phase if self.ring_phase is not None else Fraction(1 - self.z_planet % 2, 2)
        sun = [float(-self.z_sun * place % 1) for place in self._places()]
        return sun, [float((own - self.z_ring * place) % 1) for place in self._places()]

    def _mesh(self, name: str, cycles: float) -> GearMesh:
        """One mesh; cycles: its phase."""
        law = self.sun_mesh if name == "sun_mesh" else self.ring_mesh
        first, second = (self.z_sun, self.z_planet) if name == "sun_mesh" else (self.z_planet, self.z_ring)
        values = {} if not isinstance(law, MeshLaw) else law.shifted(2 * pi * cycles).values()
        if name == "ring_mesh" and isinstance(values.get("friction"), ToothFriction):
            other = {"drive": "coast", "coast": "drive"}
            values["friction"] = values["friction"].changed(flank=other.get((flank := values["friction"].flank), flank))
        return GearMesh(
            teeth=(first, second), external=name == "sun_mesh", module=self.module, pressure_angle=self.pressure_angle,
            helix_angle=self.helix_angle, heat=self.heat if isinstance(law, MeshLaw) else None, **values,
        )  # fmt: skip

    def parts(self) -> Parts:
        """The meshes, the planets, and the mass of these on the carrier."""
        blocks: dict[str, Block] = {}
        suns, rings = self.mesh_phases()
        shafts: dict[str, list[tuple[str, str]]] = {"sun": [], "ring": [], "carrier": []}
        links = []
        if self.planet_mass is not None:
            blocks["carrier_mass"] = Inertia(J=self._orbital_inertia())
            shafts["carrier"].append(("carrier_mass", "a"))
        for i, (sun, ring) in enumerate(zip(suns, rings, strict=True), 1):
            names = f"planet[{i}]", f"sun_mesh[{i}]", f"ring_mesh[{i}]"
            blocks[names[0]] = Inertia(J=self.planet_inertia)
            blocks[names[1]], blocks[names[2]] = self._mesh("sun_mesh", sun), self._mesh("ring_mesh", self._seen(ring))
            shafts["sun"].append((names[1], "pinion"))
            shafts["ring"].append((names[2], "wheel"))
            shafts["carrier"] += [(name, "carrier") for name in names[1:]]
            links.append(((names[1], "wheel"), (names[0], "a")))
            links.append(((names[0], "b"), (names[2], "pinion")))
        for ends in shafts.values():
            links += [(ends[0], end) for end in ends[1:]]
        return Parts(blocks, tuple(links), {name: ends[0] for name, ends in shafts.items()})

    def _seen(self, cycles: float) -> float:
        """The phase of a ring mesh: the other way round where a frequency drives it, as time does."""
        driven = (
            []
            if self.ring_mesh is None
            else [getattr(v, "driven_by", "angle") for v in self.ring_mesh.values().values()]
        )
        return cycles if all(d == "angle" for d in driven) else -cycles % 1

    def _orbital_inertia(self) -> Any:
        """planets m a^2."""
        assert self.planet_mass is not None
        teeth = int(self.z_sun) + int(self.z_planet)
        helix = 0.0 if self.helix_angle is None else self.helix_angle
        slant = cos(helix) if isinstance(helix, (int, float)) else _cos(helix)
        module: Any = self.module
        mass: Any = self.planet_mass
        radius = module * teeth / (2 * slant)
        return self.planets * mass * radius * radius

    def physics(self, s: Any) -> Iterator[Contribution]:  # noqa: ARG002  its parts have the physics
        """None of its own."""
        return iter(())

    # -- effects: those of the meshes, once for all planets --------------------------------------------------------------

    def effects(self) -> dict[str, Any]:
        """The effects of the sun's and the ring's meshes, such as "sun_mesh.backlash", and their heat port."""
        return ({} if self.heat is None else {"heat": self.heat}) | {
            f"{name}.{inner}": value
            for name in ("sun_mesh", "ring_mesh")
            if getattr(self, name) is not None
            for inner, value in self._mesh(name, 0.0).effects().items()
            if inner != "heat"
        }

    def gives_way(self, flange: str) -> tuple[str, float] | None:
        """The compliance of the sun's or of the ring's meshes, all planets together."""
        name, gear = {"sun": ("sun_mesh", "pinion"), "ring": ("ring_mesh", "wheel")}.get(flange, ("", ""))
        found = self._mesh(name, 0.0).gives_way(gear) if name else None
        return None if found is None else (f"{name}.{found[0]}", self.planets * found[1])

    def would_show(self, effect: str) -> Iterator[Watch]:
        """What the meshes of every planet show."""
        mesh, _, inner = effect.partition(".")
        for watch in self._mesh(mesh, 0.0).would_show(inner):
            for i in range(1, self.planets + 1):
                yield Watch(f"{mesh}[{i}].{watch.output}", watch.words, watch.limit)

    def without_effect(self, name: str) -> Block:
        """Without an effect of all sun or ring meshes, or without their heat port."""
        if name == "heat":
            return cast("Block", self.changed(heat=None))
        mesh, _, inner = name.partition(".")
        left = self._mesh(mesh, 0.0).without_effect(inner)
        kept = {field for field in MeshLaw.fields if getattr(left, field) is not None}
        own = getattr(self, mesh).values()
        law = MeshLaw(**{field: value for field, value in own.items() if field in kept})
        changed = self.changed(**{mesh: law if left.is_compliant else None})  # type: ignore[attr-defined]
        assert isinstance(changed, Block)
        return changed


def _cos(angle: Any) -> Any:
    from gearblocks.language.functions import cos as cosine

    return cosine(angle)
