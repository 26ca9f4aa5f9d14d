"""Draws what the laboratory finds into docs/pictures/: a sweep and a branch of a gear pair, basins of an oscillator.

python docs/draw_regimes.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import gearblocks as gb

PICTURES = Path(__file__).parent / "pictures"


def gear_pair() -> gb.Drivetrain:
    """A pair with backlash (Kahraman and Singh 1990), in half gaps: x'' + 0.1 x' + g(x) = 0.1 + 0.05 w^2 cos wt."""
    rig = gb.Drivetrain("gear pair")
    w = gb.Parameter("w", 0.5, "rad/s")
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.1 + 0.05 * w**2 * gb.cos(w * gb.time))),
        rig.add("mesh", gb.Inertia(J=1.0)),
        rig.add("teeth", gb.Lash(k=1.0, half_gap=1.0, c=0.1, contact_damping="always")),
        rig.add("ground", gb.Fixed()),
    )
    return rig


def two_wells() -> gb.Drivetrain:
    """x'' + 0.15 x' - x + x^3 = 0.1 cos t."""
    rig = gb.Drivetrain("two wells")
    drive = gb.Parameter("drive", 1.0, "rad/s")
    x = gb.sense("disc.phi")
    rig.chain(
        rig.add("source", gb.Torque(tau=0.1 * gb.cos(drive * gb.time) + 2 * x - x**3)),
        rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("spring", gb.Shaft(k=1.0, c=0.15)),
        rig.add("ground", gb.Fixed()),
    )
    return rig


if __name__ == "__main__":
    pair, of = gb.build(gear_pair()), "mesh.phi"
    swept = gb.speed_sweep(pair, "w", np.linspace(0.5, 1.2, 141), of=of, initial="static")
    swept.plot(PICTURES / "regimes_sweep.png")
    section = gb.stroboscopic("w")
    branch = gb.continue_orbit(pair, "w", [0.5, 1.2], section=section, of=of, initial="static")
    branch.plot(PICTURES / "regimes_branch.png")
    grid = {"disc.phi": np.linspace(-2.0, 2.0, 160), "disc.w": np.linspace(-1.5, 1.5, 120)}
    wells = gb.basins(
        two_wells(), grid, section=gb.stroboscopic("drive"), of=["disc.phi", "disc.w"], transient=60, labels="quick"
    )
    wells.plot(PICTURES / "regimes_basins.png")
