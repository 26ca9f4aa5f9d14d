"""Draws what the laboratory finds into docs/pictures/: a sweep and a branch of a gear pair, basins of an oscillator, the
diagram, the exponents and the lines of the spline coupling, orders of a run-up.

python docs/draw_regimes.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import gearblocks as gb
from gearblocks.cli import scripts

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


def run_up() -> gb.Drivetrain:
    """A pair of 23 and 41 teeth whose pinion is sped up from 20 rad/s by 8 rad/s2, through the resonance of the mesh at 97."""
    rig = gb.Drivetrain("run-up")
    mesh = gb.GearMesh(
        teeth=(23, 41), external=True, module=3e-3, k=1.5e7, damping_ratio=0.03, pressure_angle=np.deg2rad(20),
        stiffness_variation=gb.Fourier(cos=(0.15, 0.05)),
    )  # fmt: skip
    rig.chain(
        rig.add("drive", gb.Speed(w=20.0 + 8.0 * gb.time)), rig.add("pinion", gb.Inertia(J=2e-4)), rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=0.01)), rig.add("load", gb.Torque(tau=60.0)),
    )  # fmt: skip
    return rig


def spline() -> None:
    """Pictures of the spline coupling, set S."""
    model, section = gb.build(scripts.load(scripts.shipped()["spline_coupling"]).build(300.0)), gb.stroboscopic("speed")
    speeds = np.linspace(300.0, 1100.0, 1000)
    diagram = gb.bifurcation(
        model, "speed", gb.rpm(speeds), section=section, of="spline.deflection", keep=60, longest=16
    )
    diagram.plot(PICTURES / "regimes_diagram.png")
    chaos = gb.lyapunov(model, section, periods=4000, parameters={"speed": gb.rpm(1080)})
    chaos.plot(PICTURES / "regimes_exponents.png")
    lines = gb.spectrum(model, section=section, of="spline.force", parameters={"speed": gb.rpm(360)})
    lines.plot(PICTURES / "regimes_lines.png")


if __name__ == "__main__":
    spline()
    run = gb.simulate(run_up(), t_end=18.0, rtol=1e-7, initial="rolling", max_step=1e-3)
    gb.orders(run, "mesh.force", "pinion.w", highest=60.0, revolutions=8).plot(PICTURES / "regimes_orders.png")
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
