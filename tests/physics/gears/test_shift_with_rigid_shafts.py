"""A shift under torque of a planetary gear whose teeth have backlash, once a compliant shaft beside it is rigid."""

from functools import cache

import numpy as np
import pytest

import gearblocks as gb

RATIO, ROAD, FINAL = 1 + 78 / 42, 12 / 0.31, 3.7
TABLE = ([0, 0.5, 0.7, 1.5], [400.0, 400.0, -20.0, -20.0]), ([0, 0.55, 0.9, 1.5], [-20.0, -20.0, 400.0, 400.0])


def _shift(*rigid):
    """Two speeds: a brake lets the ring go and a clutch takes sun and carrier together; `rigid` shafts are ties."""

    def shaft(name, k, **damping):
        return rig.add(name, gb.Shaft(rigid=True) if name in rigid else gb.Shaft(k=k, **damping))

    rig = gb.Drivetrain("two-speed shift")
    gap, ripple = gb.Backlash(half_gap=4e-5), gb.Fourier(cos=(0.15,))
    law = gb.MeshLaw(k=3e8, damping_ratio=0.03, backlash=gap, stiffness_variation=ripple)
    gear = rig.add("gear", gb.PlanetaryGear(z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=np.deg2rad(20),
                                            planet_inertia=2e-5, sun_mesh=law, ring_mesh=law))  # fmt: skip
    motor, drive = rig.add("motor", gb.Inertia(J=0.05, w0=ROAD * FINAL * RATIO)), rig.add("drive", gb.Torque(tau=90.0))
    sun, ring = rig.add("sun", gb.Inertia(J=5e-4, w0=ROAD * FINAL * RATIO)), rig.add("ring", gb.Inertia(J=4e-3))
    carrier = rig.add("carrier", gb.Inertia(J=6e-3, w0=ROAD * FINAL))
    rig.chain(drive, motor, shaft("input_shaft", 5e4, damping_ratio=0.02), sun)
    rig.connect(sun.b, gear.sun)
    rig.connect(gear.ring, ring.a)
    rig.connect(gear.carrier, carrier.a)
    brake, clutch = (gb.Table(*points)(gb.time) for points in TABLE)
    b1, c1 = rig.add("b1", gb.Brake(capacity=brake)), rig.add("c1", gb.Clutch(capacity=clutch))
    rig.connect(b1.a, ring.b)
    rig.connect(sun.b, c1.a)
    rig.connect(c1.b, carrier.b)
    wheels, car = (rig.add(n, gb.Inertia(J=J, w0=ROAD)) for n, J in (("wheels", 2.5), ("car", 1500 * 0.31**2)))
    half, tyre = shaft("half_shafts", 9000.0, c=90.0), shaft("tyre", 3e4, c=300.0)
    rig.chain(carrier, rig.add("final", gb.IdealGear(ratio=FINAL)), half, wheels, tyre, car)
    for name, at in (("bearing1", motor), ("bearing2", carrier)):
        rig.connect(rig.add(name, gb.BearingFriction(coulomb=0.3, viscous=5e-4)).a, at.b)
    return rig


@cache
def _built_rigid(name):
    run = gb.simulate(_shift(name), t_end=1.0, method="dp8", rtol=1e-8)
    return run["car.w"][-1], run["motor.w"][-1]


PAIRS = [(method, rtol) for method in ("dp5", "dp8", "rodas") for rtol in (1e-4, 1e-6, 1e-8)]


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "method", "rtol"),
    [("half_shafts", *pair) for pair in PAIRS]
    + [("tyre", "dp5", 1e-4), ("tyre", "rodas", 1e-6), ("input_shaft", "dp8", 1e-6)],
)
def test_a_shift_goes_through_as_in_the_train_that_was_built_rigid(name, method, rtol):
    run = gb.simulate(_shift().without(f"{name}.compliance"), t_end=1.0, watch=False, method=method, rtol=rtol)
    car, motor = _built_rigid(name)
    assert run["car.w"][-1] == pytest.approx(car, rel=1e-6)
    assert run["motor.w"][-1] == pytest.approx(motor, rel=2e-4)  # teeth that rattle magnify errors
    assert run.energy.residual <= 10 * rtol
