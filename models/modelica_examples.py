"""Eight examples of the Modelica Standard Library's rotational mechanics, composed anew from blocks.

Modelica.Mechanics.Rotational.Examples (Modelica Association, BSD-3-Clause): First, FirstGrounded, ElasticBearing,
RollingWheel, CoupledClutches, OneWayClutch, SimpleGearShift and LossyGearDemo1, with the numbers of that library and its
names of components, so that its published results can be laid beside a run. Our `flange.tau` is what a block does to
the flange, the library's is the opposite.
"""

from __future__ import annotations

import math
from typing import Any

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


def coupled_clutches() -> gb.Drivetrain:
    """CoupledClutches: four inertias in a row, three clutches between; the second and third close at 0.4 and 0.9 s.

    The force on the first one is a cosine that ends at 1.25 s, while a sine of 10 N m at 5 Hz makes it slip and stick.
    """
    rig = gb.Drivetrain("CoupledClutches")
    drive = rig.add("torque", gb.Torque(tau=10 * gb.sin(2 * math.pi * 5 * gb.time)))
    inertias = [rig.add(f"J{i}", gb.Inertia(J=1.0, phi0=0.0, w0=10.0 if i == 1 else 0.0)) for i in (1, 2, 3, 4)]
    forces = (gb.cos(2 * math.pi * 0.2 * gb.time), _step(0.4), _step(0.9))
    clutches = [
        rig.add(f"clutch{i}", gb.Clutch(mu=0.5, force_max=20.0, peak=1.1, engagement=force))
        for i, force in enumerate(forces, 1)
    ]
    first, second, third, last = inertias
    rig.chain(drive, first, clutches[0], second, clutches[1], third, clutches[2], last)
    return rig


def one_way_clutch() -> gb.Drivetrain:
    """OneWayClutch: two inertias that may turn forward against each other; the clutch rubs at times besides."""
    rig = gb.Drivetrain("OneWayClutch")
    drive = rig.add("torque", gb.Torque(tau=10 * gb.sin(2 * math.pi * 3 * gb.time)))
    begin = rig.add("inertiaIn", gb.Inertia(J=1.0, phi0=0.0, w0=-0.5))
    pressed = _step(0.3) - _step(0.95) + _step(1.6)
    clutch = rig.add("oneWayClutch", gb.OneWayClutch(mu=0.5, force_max=3.0, peak=25.0, engagement=pressed))
    rig.chain(drive, begin, clutch, rig.add("inertiaOut", gb.Inertia(J=1.0, phi0=0.0, w0=0.0)))
    return rig


def simple_gear_shift() -> gb.Drivetrain:
    """SimpleGearShift: a planetary set from 2.5 : 1 (ring braked) to direct drive (ring clutched to the engine)."""
    rig = gb.Drivetrain("SimpleGearShift")
    torque = rig.add("torque", gb.Torque(tau=20 * _step(0.5)))
    engine = rig.add("engine", gb.Inertia(J=1.0, phi0=0.0, w0=0.0))
    load = rig.add("load", gb.Inertia(J=10.0, phi0=0.0, w0=0.0))
    drag = rig.add("loadTorque", gb.SpeedLoad(coeffs=(0.0, 0.0, 20.0 / 10.471975511966**2)))
    planetary = rig.add("planetary", gb.IdealPlanetary(ratio=1.5))
    shifted = gb.Table([2.0, 2.1], [0.0, 1.0])
    clutch = rig.add("clutch", gb.Clutch(mu=0.5, geometry=2.0, force_max=100.0, engagement=shifted))
    brake = rig.add("brake", gb.Brake(mu=0.5, geometry=2.0, force_max=100.0, engagement=1 - shifted))
    rig.chain(torque, engine)
    rig.connect(engine.b, planetary.sun, clutch.a)
    rig.connect(clutch.b, planetary.ring, brake.a)
    rig.connect(planetary.carrier, load.a)
    rig.chain(load, drag)
    return rig


def lossy_gear() -> gb.Drivetrain:
    """LossyGearDemo1: a gear of 2 : 1 that loses half of the power, whichever way it flows, and sticks at rest."""
    rig = gb.Drivetrain("LossyGearDemo1")
    drive = rig.add("torque1", gb.Torque(tau=10 * gb.sin(2 * math.pi * gb.time)))
    load = rig.add("torque2", gb.Torque(tau=2.5 * gb.time - 10))
    inertias = [rig.add(f"Inertia{i}", gb.Inertia(J=J, phi0=0.0, w0=0.0)) for i, J in ((1, 1.0), (2, 1.5))]
    gear = rig.add("gear", gb.LossyGear(ratio=2, efficiency=(0.5, 0.5)))
    rig.chain(drive, inertias[0], gear, inertias[1], load)
    return rig


def _step(at: float) -> Any:
    """0 before the time `at` [s], 1 after."""
    return gb.piecewise((0, gb.time < at), (1, True))
