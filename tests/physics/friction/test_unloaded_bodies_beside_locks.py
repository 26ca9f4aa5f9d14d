"""Bodies that nothing loads, beside locks that carry everything: they move by the rounding of these forces alone, and the
side of the law of a load there tells nothing.

Closed form: friction holds the driven body until its torque is what it holds, a clutch holds the next one to it, and all
beyond is at rest.
"""

import itertools

import numpy as np
import pytest

import gearblocks as gb

BODIES = {"driven": 1.0, "next": 0.348, "carrier": 1.0, "left": 0.309, "ring": 0.988, "sun": 0.261}


def _rig(shaft: bool, fades: bool) -> gb.Drivetrain:
    rig = gb.Drivetrain("held")
    j = {name: rig.add(name, gb.Inertia(J=J)) for name, J in BODIES.items()}
    capacity = gb.Table([0.0, 0.2, 0.3], [1.05, 1.05, 0.0]) if fades else 1.05
    clutch = rig.add("clutch", gb.Clutch(capacity=capacity))
    bearing, split = rig.add("bearing", gb.BearingFriction(coulomb=8.0)), rig.add("split", gb.Differential(ratio=1.0))
    load = rig.add("load", gb.SpeedLoad(coeffs=(0.0, 0.261, 0.02)))
    rig.connect(j["driven"].b, bearing.a, rig.add("drive", gb.Torque(tau=20.0 * gb.time)).flange)
    rig.connect(j["next"].a, clutch.b, split.right)
    rig.connect(j["carrier"].a, split.carrier)
    rig.connect(j["carrier"].b, load.flange)
    rig.connect(j["left"].a, split.left)
    planets = rig.add("planets", gb.IdealPlanetary(ratio=3.0))
    held = rig.add("held", gb.BearingFriction(coulomb=0.13, peak=1.2))
    rig.connect(j["driven"].a, clutch.a, planets.carrier)
    rig.connect(j["ring"].a, planets.ring)
    rig.connect(j["sun"].a, planets.sun, held.a)
    rig.chain(j["ring"], rig.add("spring", gb.Shaft(k=395.0)), rig.add("ground", gb.Fixed()))
    if shaft:
        rig.chain(j["next"], rig.add("shaft", gb.Shaft(k=44.9, c=0.0289)), rig.add("last", gb.Inertia(J=0.645)))
    return rig


@pytest.mark.parametrize(("shaft", "fades"), [(True, True), (True, False), (False, True)])
@pytest.mark.parametrize("method", ["rodas", "dp8"])
@pytest.mark.few(2)
def test_a_load_on_what_nothing_loads_does_not_flip_to_and_fro(shaft: bool, fades: bool, method: str) -> None:
    model = gb.build(_rig(shaft, fades))
    for rtol, t_end in itertools.product((1e-4, 1e-6, 1e-7, 1e-8, 1e-10), (0.29, 0.35, 0.38)):
        run = gb.simulate(model, t_end=t_end, method=method, rtol=rtol)
        assert max(np.max(np.abs(run[f"{name}.w"])) for name in BODIES) < 1e-12
        assert not [e for e in run.events if e.component == "load"] and run.stats.steps < 300
