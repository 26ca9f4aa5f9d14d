"""Planetary sets whose stiffness varies over their angles and whose teeth have errors, for tests of printed equations."""

import gearblocks as gb

_TEETH = {"z_sun": 42, "z_planet": 18, "z_ring": 78, "module": "2 mm", "pressure_angle": "20 deg"}


def _table(a):
    return gb.Profile(table=gb.Table([0.0, 0.4, 1.0], [a, -a, a], "cubic", periodic=True))


LAWS = {
    "waves": (gb.Fourier(cos=(0.15, 0.05), sin=(0.0, 0.02)), gb.Harmonic(sin=("4 um",))),
    "tables": (_table(0.1), _table(2e-6)),
    "errors": (None, (gb.Harmonic(cos=("4 um",), phase=0.3), gb.Harmonic(cos=("2 um",)))),
}


def planets(kind, nested=False):
    """A planetary set whose stiffness varies and whose teeth have errors."""
    variation, error = LAWS[kind]
    law = gb.MeshLaw(k=3e8, damping_ratio=0.05, stiffness_variation=variation, transmission_error=error)
    rig = gb.Drivetrain("planets")
    gear = gb.PlanetaryGear(**_TEETH, planet_inertia=1e-4, sun_mesh=law, ring_mesh=law)
    if nested:
        inner = gb.Drivetrain("stage")
        whole = inner.add("gear", gear)
        for flange in ("sun", "carrier", "ring"):
            inner.expose(flange, getattr(whole, flange))
        gear = inner
    stage, motor, load = (
        rig.add("stage", gear),
        rig.add("motor", gb.Inertia(J=1e-3)),
        rig.add("load", gb.Inertia(J=1e-2)),
    )
    rig.connect(rig.add("drive", gb.Torque(tau=50.0)).flange, motor.a)
    rig.connect(motor.b, stage.sun)
    rig.connect(stage.ring, rig.add("case", gb.Fixed()).flange)
    rig.connect(stage.carrier, load.a)
    return rig
