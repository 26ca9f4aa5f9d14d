"""Four examples of the Modelica Standard Library's rotational mechanics, composed anew from blocks.

Modelica.Mechanics.Rotational.Examples (Modelica Association, BSD-3-Clause): First, FirstGrounded, ElasticBearing and
RollingWheel, with the numbers of that library and its names of components, so that its published results can be laid
beside a run. Our `flange.tau` is what a block does to the flange, the library's is the opposite.
"""

from __future__ import annotations

import math

import gearblocks as gb


def build() -> gb.Drivetrain:
    """First: two geared inertias, a damper, a spring and a third inertia; gear and drive stand on a named ground."""
    return _first("First", named_ground=True)


def first_grounded() -> gb.Drivetrain:
    """FirstGrounded: the same, with the housings of gear and drive left open, which means the ground."""
    return _first("FirstGrounded", named_ground=False)


def _first(name: str, *, named_ground: bool) -> gb.Drivetrain:
    """A sine of 10 N m at 5 Hz on 0.1 kg m2, a gear of 10 : 1, 2 kg m2 with 10 N m s/rad to ground, a spring, 2 kg m2."""
    rig = gb.Drivetrain(name)
    drive = rig.add("torque", gb.Torque(tau=10 * gb.sin(2 * math.pi * 5 * gb.time)))
    inertia1, inertia2, inertia3 = (
        rig.add(f"inertia{i}", gb.Inertia(J=J, phi0=0.0, w0=0.0)) for i, J in enumerate((0.1, 2.0, 2.0), 1)
    )
    gear = rig.add("idealGear", gb.IdealGear(ratio=10))
    spring = rig.add("spring", gb.Shaft(k=1.0e4))
    rig.chain(drive, inertia1, gear, inertia2, spring, inertia3)
    damper, fixed = rig.add("damper", gb.Damper(c=10.0)), rig.add("fixed", gb.Fixed())
    rig.chain(inertia2, damper, fixed)
    if named_ground:
        rig.connect(fixed.flange, gear.housing, drive.housing)
    return rig


def elastic_bearing() -> gb.Drivetrain:
    """ElasticBearing: a gear of 3 : 1 whose housing is an inertia on a spring and a damper; a torque that ramps up.

    The housing of 5 kg m2 on 1e5 N m/rad swings at 142 rad/s and takes what the two shafts do not balance.
    """
    rig = gb.Drivetrain("ElasticBearing")
    drive = rig.add("torque", gb.Torque(tau=gb.piecewise((20 * gb.time, gb.time < 5.0), (100, True))))
    shaft = rig.add("shaft", gb.Inertia(J=1.0, phi0=0.0, w0=0.0))
    gear = rig.add("idealGear", gb.IdealGear(ratio=3))
    spring = rig.add("spring", gb.Shaft(k=1.0e3))
    load = rig.add("load", gb.Inertia(J=50.0, phi0=0.0, w0=0.0))
    housing = rig.add("housing", gb.Inertia(J=5.0, phi0=0.0, w0=0.0))
    bearing = rig.add("springDamper", gb.Shaft(k=1.0e5, c=5.0))
    rig.chain(drive, shaft, gear, spring, load)
    rig.chain(rig.add("fixed", gb.Fixed()), bearing, housing)
    rig.connect(gear.housing, housing.b)
    return rig


def rolling_wheel() -> gb.Drivetrain:
    """RollingWheel: a wheel of 1 kg m2 and 1 m rolls a mass of 1 kg against a drag of 10 N at 5 m/s; closed form.

    10 N m from 0.1 s on: w = 5 tanh(t - 0.1) rad/s, phi = 5 ln cosh(t - 0.1) rad.
    """
    rig = gb.Drivetrain("RollingWheel")
    drive = rig.add("torqueStep", gb.Torque(tau=gb.piecewise((0, gb.time < 0.1), (10, True))))
    inertia = rig.add("inertia", gb.Inertia(J=1.0, phi0=0.0, w0=0.0))
    wheel = rig.add("idealRollingWheel", gb.Rack(radius=1))
    mass = rig.add("mass", gb.Mass(m=1.0))
    drag = rig.add("quadraticSpeedDependentForce", gb.SpeedLoad(coeffs=(0.0, 0.0, 10.0 / 5.0**2)))
    rig.chain(drive, inertia, wheel, mass, drag)
    return rig
