"""Two-speed planetary with compliant meshes in a car: a brake opens while a clutch closes, and the driveline shudders.

First gear: the ring is held by brake b1. Second gear: clutch c1 joins sun and carrier, the set turns as one. From 0.5 to
0.9 s the one gives way to the other under full torque. The numbers are plausible, not a product.
"""

from __future__ import annotations

import gearblocks as gb

Z_SUN, Z_PLANET, Z_RING, FINAL = 42, 18, 78, 3.7
SPEED, WHEEL_RADIUS, MASS = 12.0, 0.31, 1500.0  # m/s, m, kg
TORQUE, CAPACITY = 90.0, 400.0  # N m


def build() -> gb.Drivetrain:
    """Motor, input shaft, planetary with six meshes (gap, varying stiffness), brake, clutch, half shafts, tyres, car."""
    rig = gb.Drivetrain("two-speed shift")
    ratio, w = 1 + Z_RING / Z_SUN, SPEED / WHEEL_RADIUS
    law = gb.MeshLaw(
        k=3e8,
        damping_ratio=0.03,
        backlash=gb.Backlash(half_gap="40 um"),
        stiffness_variation=gb.Fourier(cos=(0.15,)),
    )
    gear = rig.add(
        "gear",
        gb.PlanetaryGear(
            z_sun=Z_SUN, z_planet=Z_PLANET, z_ring=Z_RING, module=2e-3, pressure_angle="20 deg", planet_inertia=2e-5,
            sun_mesh=law, ring_mesh=law,
        ),
    )  # fmt: skip
    motor = rig.add("motor", gb.Inertia(J=0.05, w0=w * FINAL * ratio))
    sun = rig.add("sun", gb.Inertia(J=5e-4, w0=w * FINAL * ratio))
    ring = rig.add("ring", gb.Inertia(J=4e-3))
    carrier = rig.add("carrier", gb.Inertia(J=6e-3, w0=w * FINAL))
    input_shaft = rig.add("input_shaft", gb.Shaft(k=5e4, damping_ratio=0.02))
    rig.chain(rig.add("drive", gb.Torque(tau=TORQUE)), motor, input_shaft, sun)
    rig.connect(sun.b, gear.sun)
    rig.connect(gear.ring, ring.a)
    rig.connect(gear.carrier, carrier.a)
    opening = gb.Table([0, 0.5, 0.7, 1.5], [CAPACITY, CAPACITY, -20.0, -20.0])
    closing = gb.Table([0, 0.55, 0.9, 1.5], [-20.0, -20.0, CAPACITY, CAPACITY])
    b1 = rig.add("b1", gb.Brake(capacity=opening(gb.time)))
    c1 = rig.add("c1", gb.Clutch(capacity=closing(gb.time)))
    rig.connect(b1.a, ring.b)
    rig.connect(sun.b, c1.a)
    rig.connect(c1.b, carrier.b)
    final = rig.add("final", gb.IdealGear(ratio=FINAL))
    half_shafts, tyre = rig.add("half_shafts", gb.Shaft(k=9e3, c=90.0)), rig.add("tyre", gb.Shaft(k=3e4, c=300.0))
    wheels = rig.add("wheels", gb.Inertia(J=2.5, w0=w))
    car = rig.add("car", gb.Inertia(J=MASS * WHEEL_RADIUS**2, w0=w))
    rig.chain(carrier, final, half_shafts, wheels, tyre, car)
    for name, shaft in (("bearing1", motor), ("bearing2", carrier)):
        rig.connect(rig.add(name, gb.BearingFriction(coulomb=0.3, viscous=5e-4)).a, shaft.b)
    return rig


def shift() -> gb.Scene:
    """The shift: heat of the clutch, and how hard the half shafts are hit, to 1 %."""
    asked = gb.energy_lost("c1"), gb.peak("half_shafts.torque", after=0.45)
    return gb.Scene(build(), t_end=1.5, quantity=asked, within=0.01, name="shift")
