"""Trains without a mistake: type checkers say nothing about them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import sympy as sp  # type: ignore[import-untyped]

import fmu_export
import gearblocks as gb


class Motor(gb.Block):
    """A motor with a resistance."""

    shaft = gb.Flange("output shaft")
    R: float = gb.param("resistance", "ohm", gt=0)
    u: Any = gb.signal("voltage", "V")
    i = gb.State("current", "A")

    def physics(self, s: Any) -> Iterator[Any]:
        yield gb.Acts(s.shaft, s.i)
        yield gb.Rate(s.i, s.u - s.R * s.i)
        yield gb.Shows("torque", s.i, "N m")


rig = gb.Drivetrain("rig")
disc, motor = rig.add("disc", gb.Inertia(J=1)), rig.add("motor", gb.Inertia(J=gb.Parameter("J", 1.0), w0="100 rpm"))
pair = gb.GearMesh(
    teeth=(20, 30),
    external=True,
    module="3 mm",
    pressure_angle=0.35,
    k="100 MN/m",
    backlash=gb.Backlash(half_gap=1e-5),
    stiffness_variation=gb.Fourier(cos=(0.1, gb.Parameter("second", 0.1))),
    contact_damping=gb.HuntCrossley(restitution=0.9),
)
mesh = rig.add("mesh", pair)
clutch = rig.add("clutch", gb.Clutch(capacity=gb.Table([0, 1], [0, 80])))
drive = rig.add("drive", gb.Torque(tau=gb.Input("u") + 2 * gb.sin(gb.time) + gb.sense("disc.w")))
own = rig.add("own", Motor(R=1.0, u=gb.time))
rig.connect(drive.flange, motor.a, own.shaft)
rig.chain(motor, mesh, disc)
rig.chain(rig["disc"], clutch)
print(mesh.k, mesh.flanges, rig["mesh"].k, rig["mesh"].pinion)

inner = gb.Drivetrain("stage")
inner.expose("input", inner.add("body", gb.Inertia(J=1.0)).a)
stage = rig.add("stage", inner)
rig.connect(stage.input, clutch.b)

symbol: Any = gb.time
for torque in (sp.sin(3 * symbol), np.sin(gb.time), np.float64(3.0), gb.exp(gb.time) * gb.Parameter("x", 3.0)):
    changed = rig.set({"drive": gb.Torque(tau=torque), "mesh.k": 2e8})
gb.Torque(tau=sp.sin(3 * symbol))
gb.Shaft(k="3 N m/rad", c=None)
gb.PlanetaryGear(z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=0.35, planet_inertia=1e-4)

model = gb.build(rig)
run = gb.simulate(rig, t_end=0.01, rtol=1e-8, parameters={"mesh.k": "150 MN/m"}, inputs={"u": gb.Table([0, 1], [0, 1])})
again = gb.simulate(model, t=[0.01, 0.02], initial=run, outputs=("mesh.*", "disc.w"))
print(run["disc.w"].max(), run.stats, rig.outputs("mesh.*").names, rig.parameters()[0].unit)
fmu_export.export(rig, "rig.fmu")
