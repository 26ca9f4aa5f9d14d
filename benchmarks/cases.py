"""The numbers of the benchmark problems, in one place for blocks and hand-written peers alike (SI, radians)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from models import planetary_backlash, stiff_chain

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class P1:
    """Four discs, two shafts, a spline mesh with backlash; the mesh stiffness and the torque are driven by time."""

    J: tuple[float, float, float, float] = (5e-3, 2e-4, 2e-4, 1e-2)
    k_shaft: float = 1e5
    zeta: float = 0.05
    radius: float = 0.025
    k_mesh: float = 245e6
    ripple: float = 0.3
    half_gap: float = 20e-6
    torque: float = 2600.0
    swing: float = 0.1
    w: float = 4.2e4

    @property
    def c_shafts(self) -> tuple[float, float]:
        """Damping of the left and the right shaft from the damping ratio on the inertias beside, N m s/rad."""
        j1, j2, j3, j4 = self.J
        left = 2 * self.zeta * math.sqrt(self.k_shaft / (1 / j1 + 1 / j2))
        right = 2 * self.zeta * math.sqrt(self.k_shaft / (1 / j3 + 1 / j4))
        return left, right

    @property
    def c_mesh(self) -> float:
        """Mesh damping along the line of action, N s/m."""
        _, j2, j3, _ = self.J
        return 2 * self.zeta * math.sqrt(self.k_mesh * (j2 * j3 / (j2 + j3)) / self.radius**2)

    @property
    def start(self) -> Array:
        """Static equilibrium at the mean stiffness: twists phi_i - phi_(i+1), four speeds, one zero."""
        shaft = self.torque / self.k_shaft
        mesh = (self.half_gap + self.torque / (self.radius * self.k_mesh)) / self.radius
        return np.array([shaft, mesh, shaft, 0.0, 0.0, 0.0, 0.0, 0.0])

    @property
    def angles(self) -> tuple[float, float, float, float]:
        """Start angles of the discs with the last one at zero."""
        left, mesh, right = self.start[:3]
        return float(left + mesh + right), float(mesh + right), float(right), 0.0

    @property
    def scale(self) -> Array:
        """Smallest magnitudes that count in an error weight: static twists; gap times frequency for the speeds."""
        speed = 0.1 * self.half_gap / self.radius * self.w
        return np.array([*self.start[:3], speed, speed, speed, speed, 1.0])

    @property
    def sides(self) -> Array:
        """Contact sides at the start."""
        return np.ones(1)

    def relative(self, y: Array) -> Array:
        """The relative coordinates from states in rows."""
        return y[:, :3]

    def packed(self) -> Array:
        """The members of `problem` in c/p1.c."""
        r = self.radius
        inverse = [1 / j for j in self.J]
        return np.array(
            [
                self.half_gap / r,
                *inverse,
                self.k_shaft,
                *self.c_shafts,
                self.k_mesh * r * r,
                self.ripple,
                self.c_mesh * r * r,
                self.torque,
                self.swing,
                self.w,
            ]
        )


@dataclass(frozen=True)
class P2:
    """One gear pair without dimensions: x'' + 2 zeta x' + (1 + eps cos w t) g(x) = Fm + Fah w^2 cos w t."""

    zeta: float = 0.05
    eps: float = 0.2
    load: float = 0.1
    swing: float = 0.05
    w: float = 0.9
    half_gap: float = 1.0
    x0: float = 1.1
    periods: int = 100

    @property
    def period(self) -> float:
        """Period of the excitation."""
        return 2 * math.pi / self.w

    @property
    def start(self) -> Array:
        """Deflection and its rate."""
        return np.array([self.x0, 0.0])

    @property
    def scale(self) -> Array:
        """Smallest magnitudes that count in an error weight."""
        return np.array([1.0, 0.1])

    @property
    def sides(self) -> Array:
        """Contact sides at the start."""
        return np.ones(1)

    def relative(self, y: Array) -> Array:
        """The relative coordinates from states in rows."""
        return y[:, :1]

    def packed(self) -> Array:
        """The members of `problem` in c/p2.c."""
        return np.array([self.half_gap, 2 * self.zeta, self.eps, self.load, self.swing * self.w**2, self.w])


@dataclass(frozen=True)
class P3(planetary_backlash.Numbers):
    """The planetary set of `models/planetary_backlash.py`, and what the hand-written peers need."""

    @property
    def start(self) -> Array:
        """Static equilibrium at the mean stiffness: four deflections of the sun meshes, u = r_sun (phi_s - phi_c) +
        r_ring (phi_r - phi_c), phi_r; speeds of sun, carrier, ring, planets; three zeros. A ring mesh deflects by the
        one of the sun mesh less u.
        """
        sun, ring = self.deflections
        return np.array([sun, sun, sun, sun, sun - ring, self.angles[1], *[0.0] * 10])

    @property
    def sides(self) -> Array:
        """Contact sides at the start: sun meshes drive, ring meshes coast."""
        return np.repeat([1.0, -1.0], 4)

    @property
    def scale(self) -> Array:
        """Smallest magnitudes that count in an error weight: static values; gap times frequency for the speeds."""
        speed = 0.1 * self.half_gap / self.r_planet * self.w
        return np.array([*np.abs(self.start[:6]), *[speed] * 7, 1.0, 1.0, 1.0])

    def relative(self, y: Array) -> Array:
        """Deflections of the sun and the ring meshes and the twist of the ring, from states in rows."""
        return np.column_stack([y[:, :4], y[:, :4] - y[:, 4:5], y[:, 5]])

    def packed(self) -> Array:
        """The members of `problem` in c/p3.c."""
        sun, ring = self.phases
        waves = [f(phase) for phase in (*sun, *ring) for f in (math.cos, math.sin)]
        inverse = [1 / j for j in (self.j_sun, self.j_carrier, self.j_ring, self.j_planet)]
        stiff = [self.k_sun, self.k_ring, *self.c_meshes, self.ripple, self.k_ground, self.c_ground]
        load = [self.torque, self.torque * (1 + self.r_ring / self.r_sun), self.swing, self.w]
        return np.array(
            [self.half_gap, self.r_sun, self.r_planet, self.r_ring, *inverse, *stiff, *load, *waves[::2], *waves[1::2]]
        )


@dataclass(frozen=True)
class P4(stiff_chain.Numbers):
    """The chain of `models/stiff_chain.py`, and what the hand-written peers need."""

    t_end: float = 0.1

    @property
    def start(self) -> Array:
        """Twists, then speeds."""
        return np.array(self.twists + [0.0] * self.n)

    @property
    def scale(self) -> Array:
        """Smallest magnitudes that count in an error weight."""
        return np.array(self.twists + [self.twists[0] * self.w] * self.n)

    @property
    def sides(self) -> Array:
        """Contact sides at the start."""
        return np.ones(self.n // 2 - 1)

    def relative(self, y: Array) -> Array:
        """The relative coordinates from states in rows."""
        return y[:, : self.n]

    def packed(self) -> Array:
        """The members of `problem` in c/p4.c."""
        return np.array(
            [
                self.half_gap,
                self.j_heavy,
                self.j_light,
                self.k_shaft,
                self.c_shaft,
                self.k_mesh,
                self.c_mesh,
                self.torque,
                self.swing,
                self.w,
                float(self.n),
            ]
        )


Problem = P1 | P2 | P3 | P4
"""Any of them."""
