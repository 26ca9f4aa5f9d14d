"""Planetary set with four planets whose eight meshes have backlash and a stiffness that varies in time.

Sun driven, carrier loaded, ring on a stiff spring to ground. The numbers are a measuring stick, not a product: mesh
stiffness of 2e8 N/m against planets of 0.1 kg gives mesh modes of some 10 kHz, the mesh frequency of 6e4 rad/s lies
among them, and the meshes leave their contact in the first milliseconds.

The phases of the meshes are those of 21 teeth on the sun and 49 on the ring. Four equally spaced planets cannot be put
between such wheels ((21 + 49)/4 is no whole number), so the phases are given one by one; a set to be built takes them
from its tooth counts. Base radii stand in the ratio 3 : 2 : 7, as the teeth do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import gearblocks as gb


@dataclass(frozen=True)
class Numbers:
    """SI values of one set with four planets. c of a mesh: 0.1 sqrt(k J/r^2) with J, r of a planet."""

    r_sun: float = 0.03
    r_planet: float = 0.02
    r_ring: float = 0.07
    j_sun: float = 2e-4
    j_carrier: float = 5e-3
    j_ring: float = 8e-3
    j_planet: float = 4e-5
    k_sun: float = 2e8
    k_ring: float = 2.5e8
    ripple: float = 0.25
    half_gap: float = 20e-6
    k_ground: float = 5e6
    torque: float = 300.0
    swing: float = 0.1
    w: float = 6e4

    @property
    def c_meshes(self) -> tuple[float, float]:
        """Damping of a sun mesh and of a ring mesh along the line of action, N s/m."""
        mass = self.j_planet / self.r_planet**2
        return 0.1 * math.sqrt(self.k_sun * mass), 0.1 * math.sqrt(self.k_ring * mass)

    @property
    def c_ground(self) -> float:
        """Damping between ring and ground, N m s/rad."""
        return 0.1 * math.sqrt(self.k_ground * self.j_ring)

    @property
    def phases(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Phases of the sun meshes and of the ring meshes, rad."""
        turns = [(21 * i % 4, (49 * i + 1) % 4) for i in range(4)]
        return tuple(math.pi / 2 * a for a, _ in turns), tuple(math.pi / 2 * b for _, b in turns)

    @property
    def deflections(self) -> tuple[float, float]:
        """Static deflections of a sun mesh (drive side) and of a ring mesh (coast side) at the mean stiffness, m."""
        force = self.torque / (4 * self.r_sun)
        return self.half_gap + force / self.k_sun, -self.half_gap - force / self.k_ring

    @property
    def angles(self) -> tuple[float, float, float]:
        """Static angles of sun, ring and each planet at the mean stiffness, with the carrier at zero."""
        at_sun, at_ring = self.deflections
        ring = -self.r_ring / self.r_sun * self.torque / self.k_ground
        sun = (at_sun - at_ring - self.r_ring * ring) / self.r_sun
        return sun, ring, (at_sun - self.r_sun * sun) / self.r_planet


def build() -> gb.Drivetrain:
    """The set under 300 N m on the sun, +- 10 % with the mesh frequency; start: static at the mean stiffness."""
    return planetary(Numbers())


def settled() -> gb.Scene:
    """The set once it has settled: how much the force of a sun mesh swings, and its peak, to 1 %."""
    asked = gb.std("sun_mesh0.force", after=0.01), gb.peak("sun_mesh0.force", after=0.01)
    return gb.Scene(build(), t_end=0.02, quantity=asked, within=0.01, name="planetary set")


def planetary(n: Numbers) -> gb.Drivetrain:
    """Sun, ring, carrier and four planets, eight meshes on the carrier, the ring on its mount. `w` is a Parameter."""
    rig = gb.Drivetrain("planetary set, 4 planets")
    w = gb.Parameter("w", n.w, "rad/s")
    at_sun, at_ring, at_planet = n.angles

    def mesh(
        name: str, teeth: tuple[int, int], radii: tuple[float, float], k: float, c: float, phase: float
    ) -> gb.GearMesh:
        return gb.GearMesh(
            teeth=teeth, r_base=radii, external=name == "sun", k=k, c=c, backlash=gb.Backlash(half_gap=n.half_gap),
            stiffness_variation=gb.Fourier(cos=(n.ripple,), driven_by=w, phase=phase), contact_damping="always",
        )  # fmt: skip

    sun, ring = (
        rig.add("sun", gb.Inertia(J=n.j_sun, phi0=at_sun)),
        rig.add("ring", gb.Inertia(J=n.j_ring, phi0=at_ring)),
    )
    carrier = rig.add("carrier", gb.Inertia(J=n.j_carrier, phi0=0.0))
    inner, outer = (n.r_sun, n.r_planet), (n.r_planet, n.r_ring)
    for i, (at_inner, at_outer) in enumerate(zip(*n.phases, strict=True)):
        planet = rig.add(f"planet{i}", gb.Inertia(J=n.j_planet, phi0=at_planet))
        sun_mesh = rig.add(f"sun_mesh{i}", mesh("sun", (21, 14), inner, n.k_sun, n.c_meshes[0], at_inner))
        ring_mesh = rig.add(f"ring_mesh{i}", mesh("ring", (14, 49), outer, n.k_ring, n.c_meshes[1], at_outer))
        rig.chain(sun, sun_mesh, planet, ring_mesh, ring)
        rig.connect(carrier.a, sun_mesh.carrier, ring_mesh.carrier)
    drive = rig.add("drive", gb.Torque(tau=n.torque * (1 + n.swing * gb.cos(w * gb.time))))
    load = rig.add("load", gb.Torque(tau=-n.torque * (1 + n.r_ring / n.r_sun)))
    rig.connect(drive.flange, sun.b)
    rig.connect(load.flange, carrier.b)
    rig.chain(ring, rig.add("mount", gb.Shaft(k=n.k_ground, c=n.c_ground)), rig.add("ground", gb.Fixed()))
    return rig
