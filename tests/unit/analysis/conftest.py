"""A small train with a clutch, to be studied."""

from __future__ import annotations

import pytest

import gearblocks as gb


def slipping() -> gb.Drivetrain:
    """A motor brings a load up through a clutch and a damped shaft; `gain` above 0 feeds what it does with its own speed."""
    rig = gb.Drivetrain("slipping clutch")
    motor, clutch = rig.add("motor", gb.Inertia(J=0.1, w0=50.0)), rig.add("clutch", gb.Clutch(capacity=8.0))
    hub = rig.add("hub", gb.Inertia(J=0.01))
    shaft, load = rig.add("shaft", gb.Shaft(k=200.0, c=0.2)), rig.add("load", gb.Inertia(J=0.3))
    gain = gb.Parameter("gain", 0.0, "N m s/rad")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", start=2.0, unit="N m")))
    rig.chain(drive, motor, clutch, hub, shaft, load)
    rig.connect(rig.add("feed", gb.Torque(tau=gain * gb.sense("load.w"))).flange, load.b)
    return rig


@pytest.fixture(scope="session")
def clutch_model() -> gb.Model:
    return gb.build(slipping())
