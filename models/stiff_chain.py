"""Stiff chain of many inertias, heavy and light in turn, tied by shafts and gapped couplings in turn.

The light inertias (1e-5 kg m2) against the couplings (1.5e6 N m/rad) swing at 3.9e5 rad/s with strong damping, while
the load asks for 20 Hz: an explicit method has to take some 6000 steps over 0.1 s for stability alone, whatever the
tolerance. `build` loads the couplings on one side only; `hits` lets the torque change its sign, so that the couplings
cross their gaps and hit both sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import gearblocks as gb


@dataclass(frozen=True)
class Numbers:
    """SI values. n: number of inertias, even; the last coupling is a shaft to ground."""

    n: int = 1000
    j_heavy: float = 1e-2
    j_light: float = 1e-5
    k_shaft: float = 1e4
    c_shaft: float = 1.0
    k_mesh: float = 1.5e6
    half_gap: float = 8e-4
    torque: float = 200.0
    swing: float = 0.5
    frequency: float = 20.0

    @property
    def c_mesh(self) -> float:
        """Damping of a gapped coupling, N m s/rad."""
        return 0.1 * math.sqrt(self.k_mesh * self.j_light)

    @property
    def w(self) -> float:
        """Frequency of the torque, rad/s."""
        return 2 * math.pi * self.frequency

    def is_mesh(self, i: int) -> bool:
        """Whether coupling i, behind inertia i, is one with a gap."""
        return i % 2 == 1 and i < self.n - 1

    @property
    def twists(self) -> list[float]:
        """Static twists phi_i - phi_(i+1) under the mean torque."""
        shaft, mesh = self.torque / self.k_shaft, self.half_gap + self.torque / self.k_mesh
        return [mesh if self.is_mesh(i) else shaft for i in range(self.n)]

    @property
    def angles(self) -> list[float]:
        """Static angles of the inertias; ground is at zero."""
        return list(accumulate(reversed(self.twists)))[::-1]


def build() -> gb.Drivetrain:
    """100 inertias, 200 N m (1 + 0.5 sin 2 pi 20 t) on the first: every coupling stays on its side."""
    return chain(Numbers(n=100))


def hits() -> gb.Drivetrain:
    """100 inertias, 200 N m (1 + 1.5 sin 2 pi 20 t): the couplings cross their gaps."""
    return chain(Numbers(n=100, swing=1.5))


def chain(p: Numbers) -> gb.Drivetrain:
    """The chain from its static equilibrium under the mean torque."""
    rig = gb.Drivetrain(f"stiff chain of {p.n}")
    links: list[Any] = [rig.add("drive", gb.Torque(tau=p.torque * (1 + p.swing * gb.sin(p.w * gb.time))))]
    for i, angle in enumerate(p.angles):
        links.append(rig.add(f"disc{i}", gb.Inertia(J=p.j_light if i % 2 else p.j_heavy, phi0=angle)))
        if p.is_mesh(i):
            link: Any = gb.Lash(k=p.k_mesh, c=p.c_mesh, half_gap=p.half_gap, contact_damping="always")
        else:
            link = gb.Shaft(k=p.k_shaft, c=p.c_shaft)
        links.append(rig.add(f"link{i}", link))
    rig.chain(*links, rig.add("ground", gb.Fixed()))
    return rig
