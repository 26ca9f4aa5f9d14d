"""A spur pair with measured teeth: one run, then its forces and errors over the speed.

measured_teeth.csv holds stiffness and transmission error over one mesh cycle, as a test rig or a contact analysis gives them.
Writes pair.png, spectrum.png, speeds.csv and speeds.png into the folder in which it is started.
"""

from pathlib import Path

import numpy as np

import gearblocks as gb

TEETH = 23, 41
cycle, stiffness, error = np.loadtxt(
    Path(__file__).with_name("measured_teeth.csv"), delimiter=",", skiprows=1, unpack=True
)
mean = stiffness[:-1].mean()  # the last point is the first of the next cycle

speed = gb.Parameter("speed", 3000, "rpm")  # every number that holds it follows when it is changed
rig = gb.Drivetrain("spur pair with measured teeth")
mesh = gb.GearMesh(
    teeth=TEETH,
    module="3 mm",
    pressure_angle="20 deg",
    external=True,
    k=f"{mean} N/um",
    damping_ratio=0.05,
    stiffness_variation=gb.Table(cycle, stiffness / mean - 1.0, periodic=True),
    transmission_error=gb.Table(cycle, error * 1e-6, kind="cubic", periodic=True),
    backlash=gb.Backlash(half_gap="30 um"),
)
rig.chain(
    rig.add("drive", gb.Torque(tau=20.0)),
    rig.add("motor", gb.Inertia(J=0.02, w0=speed)),
    rig.add("shaft", gb.Shaft(k=2e4, c=3.0)),
    rig.add("pinion", gb.Inertia(J=2e-4, w0=speed)),
    rig.add("mesh", mesh),
    rig.add("wheel", gb.Inertia(J=0.05, w0=-speed * TEETH[0] / TEETH[1])),
    rig.add("load", gb.Torque(tau=20.0 * TEETH[1] / TEETH[0])),  # the wheel turns backwards: plus opposes it
)
print(rig.describe())

run = gb.simulate(rig, t_end=0.1, initial="static")  # begins loaded, without a jolt
print(run.stats, run.energy, run.extremes("mesh.force"), sep="\n")
run.between(0.09, 0.1).plot("mesh.force", "mesh.dynamic_transmission_error", path="pair.png")
run.spectrum("mesh.force").plot(path="spectrum.png")

study = gb.sweep(
    rig,
    {"speed": np.linspace(500, 9000, 69)},
    quantity=[gb.peak("mesh.force", after=0.1), gb.rms("mesh.dynamic_transmission_error", after=0.1)],
    t_end=0.2,
    initial="static",
)
print(study)
study.to_csv("speeds.csv")
study.plot("peak(mesh.force, after=0.1)", path="speeds.png")
