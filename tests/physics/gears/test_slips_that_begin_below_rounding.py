"""Gears that let go so softly that their slip is rounding of the speeds for a while: what its samples scatter by tells nothing
of what it does between them, and shortens no step.

Independent: another method.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 0.045, 10)


def _train() -> gb.Drivetrain:
    """Two trees of lossy gears that a spline, a freewheel and a planetary set pull at (found by the campaign)."""
    rig = gb.Drivetrain("soft slips")
    inertias = (0.0268, 2.79, 0.0485, 0.321, 0.123, 1.27, 0.444, 1.96, 0.187, 0.0462, 0.5, 0.19, 0.119)
    starts = {1: 0.0, 2: 0.0, 5: 0.0, 9: 1.2, 12: -4.0}
    j = {i: rig.add(f"j{i}", gb.Inertia(J=J, w0=starts.get(i))) for i, J in enumerate(inertias, 1)}
    losses = (
        (2.5, (0.775, 0.775), 0.0),
        (0.25, (0.536, 0.525), 0.0268),
        (1.0, (0.659, 0.959), 0.0343),
        (3.0, (0.921, 0.921), 0.0),
        (1.5, (0.612, 0.612), 0.0),
    )
    lossy = {
        i: rig.add(f"lossy{i}", gb.LossyGear(ratio=ratio, efficiency=eta, bearing=(rest, rest)))
        for i, (ratio, eta, rest) in enumerate(losses, 1)
    }
    freewheel, gear = rig.add("freewheel", gb.Freewheel()), rig.add("gear", gb.IdealGear(ratio=1.0))
    drag = gb.Table([0.0, 6.52, 30.0], [0.444, 0.622, 0.888])
    bearing = rig.add("bearing", gb.BearingFriction(torque=drag, peak=1.2))
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.103, order=1), external=True))
    gap = gb.Backlash(half_gap=8.08e-05)
    coupling = gb.SplineCoupling(teeth=6, radius=0.02, k=4.38e6, c=17500.0, backlash=gap, contact_damping="always")
    spline, planetary = rig.add("spline", coupling), rig.add("planetary", gb.IdealPlanetary(ratio=3.0))
    load = rig.add("load", gb.SpeedLoad(coeffs=(3.64, 2.12, 0.0137)))
    fading = rig.add("fading", gb.Torque(tau=3.16 * gb.exp(-1.5 * gb.time)))
    drive = rig.add("drive", gb.Torque(tau=6.92))
    rig.connect(j[1].a, freewheel.b)
    rig.connect(j[1].b, lossy[2].a)
    rig.connect(j[2].a, freewheel.a, lossy[1].a)
    rig.connect(j[2].b, gear.a, spline.a)
    rig.connect(j[3].a, lossy[1].b, lossy[3].a)
    rig.connect(j[3].b, lossy[4].a, planetary.ring)
    rig.connect(j[4].a, lossy[2].b, bearing.a)
    rig.connect(j[4].b, pair.a, load.flange)
    rig.connect(j[5].a, bearing.housing)
    rig.connect(j[6].a, lossy[3].b)
    rig.connect(j[7].a, pair.b)
    rig.connect(j[8].a, gear.b)
    rig.connect(j[9].a, spline.b)
    rig.connect(j[10].a, lossy[4].b, lossy[5].a)
    rig.connect(j[10].b, fading.flange)
    rig.connect(j[11].a, lossy[5].b)
    rig.connect(j[12].a, planetary.carrier)
    rig.connect(j[12].b, drive.flange)
    rig.connect(j[13].a, planetary.sun)
    return rig


def test_they_take_no_steps_of_their_own() -> None:
    rig = _train()
    run, other = (gb.simulate(rig, t=T, method=method, rtol=1e-8) for method in ("dp5", "dp8"))
    assert run.stats.steps < 200 and run.stats.rhs_calls < 4000
    for name in ("j3.w", "j9.w", "j13.w"):
        assert run[name] == pytest.approx(other[name], abs=1e-6 * float(np.max(np.abs(other[name])))), name
