"""One gear pair, two questions: an unloaded pair that rattles, a loaded one that whines.

A prescribed speed drives the pinion through a shaft; gap, varying mesh stiffness, transmission error and tooth friction in
the mesh; a bearing and a load on the wheel. The numbers are plausible, not a product.
"""

from __future__ import annotations

from typing import Any

import gearblocks as gb

Z_PINION, Z_WHEEL = 29, 37


def build() -> gb.Drivetrain:
    """The loaded pair at 1500 rpm."""
    w = gb.rpm(1500)
    return pair("whine", w, drive=w, load=150.0, damping_ratio=0.05)


def unloaded() -> gb.Drivetrain:
    """The pair at 900 rpm +- 3 %, twice per turn, as behind an engine; all but the bearing's drag is off."""
    w = gb.rpm(900)
    return pair("rattle", w, drive=w * (1 + 0.03 * gb.sin(2 * w * gb.time)), load=0.3, damping_ratio=0.04)


def rattle() -> gb.Scene:
    """How hard the teeth hammer: root mean square of the mesh force, to 5 %. The motion is irregular."""
    return gb.Scene(unloaded(), t_end=1.0, quantity=gb.rms("mesh.force", after=0.2), within=0.05, name="rattle")


def whine() -> gb.Scene:
    """What is heard: standard deviation of the dynamic transmission error once it has settled, to 1 %."""
    asked = gb.std("mesh.dynamic_transmission_error", after=0.32)
    return gb.Scene(build(), t_end=0.4, quantity=asked, within=0.01, initial="static", name="whine")


def pair(name: str, w: float, *, drive: Any, load: float, damping_ratio: float) -> gb.Drivetrain:
    """The pair at about w [rad/s]; drive: speed of the engine, load: torque on the wheel [N m], a Parameter."""
    rig = gb.Drivetrain(name)
    pinion = rig.add("pinion", gb.Inertia(J=8e-4, w0=w))
    wheel = rig.add("wheel", gb.Inertia(J=0.02, w0=-w * Z_PINION / Z_WHEEL))
    mesh = rig.add(
        "mesh",
        gb.GearMesh(
            teeth=(Z_PINION, Z_WHEEL),
            module=2.5e-3,
            pressure_angle="20 deg",
            external=True,
            k=2e8,
            damping_ratio=damping_ratio,
            stiffness_variation=gb.Fourier(cos=(0.2,)),
            backlash=gb.Backlash(half_gap="60 um"),
            transmission_error=gb.Harmonic(cos=(5e-6,)),
            friction=gb.ToothFriction(mu=0.06, transition=1e-3),
        ),
    )
    shaft = rig.add("shaft", gb.Shaft(k=3e4, damping_ratio=0.02))
    rig.chain(rig.add("engine", gb.Speed(w=drive)), shaft, pinion, mesh, wheel)
    rig.connect(rig.add("load", gb.Torque(tau=gb.Parameter("load", load, "N m"))).flange, wheel.b)
    rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=0.05, viscous=1e-3)).a, wheel.b)
    return rig
