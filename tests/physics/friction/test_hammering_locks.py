"""Bodies that locks hold together, hammering in two rigid stops at once until all of it rests: what is left of a flight, a few
roundings of an angle, strikes one stop, makes a lock slip and opens the other by it.

Closed form: a load that presses the row against its stop ends all motion there; no bounce gives energy.
"""

import numpy as np
import pytest

import gearblocks as gb

METHODS = [("auto", 1e-6), ("dp8", 1e-7), ("dp5", 1e-6), ("rodas", 1e-8), ("dp8", 1e-10)]
GAP = 0.05


def _row(inertias, capacities, restitutions, load, drive):
    """a |stop, clutch to b, brake to c, rigid gap to d; b is driven to the stop, d loaded."""
    rig = gb.Drivetrain("row")
    a, b, c, d = (rig.add(n, gb.Inertia(J=J)) for n, J in zip("abcd", inertias, strict=True))
    clutch, brake = (
        rig.add("clutch", gb.Clutch(capacity=capacities[0])),
        rig.add("brake", gb.Brake(capacity=capacities[1], peak=2.0)),
    )
    stop = rig.add("stop", gb.HardStop(restitution=restitutions[0], upper=GAP))
    contact = gb.HuntCrossley(restitution=restitutions[1])
    gap = rig.add("gap", gb.Lash(k=1e3, half_gap=0.02, contact_damping=contact))
    loaded, driven = rig.add("loaded", gb.Torque(tau=load)), rig.add("driven", gb.Torque(tau=drive))
    rig.connect(a.a, clutch.a, stop.a)
    rig.connect(b.a, clutch.b, brake.a, driven.flange)
    rig.connect(c.a, brake.housing, gap.a)
    rig.connect(d.a, gap.b, loaded.flange)
    return rig.without("gap.compliance")


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.parametrize(
    ("inertias", "capacities", "restitutions", "load", "drive"),
    [
        ((0.058, 0.456, 0.432, 1.425), (13.74, 3.12), (0.41, 0.76), -0.592, 2.55),
        ((0.024, 0.033, 0.011, 0.029), (8.68, 3.41), (0.83, 0.52), -0.849, 1.4),
    ],
)
@pytest.mark.few(3)
def test_hammering_in_two_stops_ends_in_rest(inertias, capacities, restitutions, load, drive, method, rtol):
    rig = _row(inertias, capacities, restitutions, load, drive)
    run = gb.simulate(rig, t=[0.0, 1.9, 2.0], method=method, rtol=rtol)
    assert len(run.events) < 3000
    for body in "abcd":
        assert np.abs(run[f"{body}.w"][1:]).max() < 1e-12
    assert run["a.phi"][1:] == pytest.approx([GAP, GAP], abs=1e-9)
    assert run["c.phi"][-1] - run["d.phi"][-1] == pytest.approx(0.02, abs=1e-9)
    assert run.energy.residual < 1e-9
