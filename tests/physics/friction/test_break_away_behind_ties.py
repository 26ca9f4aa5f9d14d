"""What friction holds behind a tie lets go when its force reaches the bound, however short the steps are by then: a force
beyond its bound is no rounding because a short step hardly moves.

Closed form: until then the spline carries what it holds, and its torque is the bound when it lets go.
"""

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

ELLIPSE = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.5, order=2), external=True)
TIES = {"ellipse": ELLIPSE, "joint": gb.UniversalJoint(angle=0.5), "gear": gb.IdealGear(ratio=2.0)}
SPLINE = gb.SplineCoupling(teeth=4, radius=1.0, k=30000.0)
BOUND = 9.80665  # N m, of all of them
HOLDS = {
    "car": gb.Vehicle(mass=1.0, wheel_radius=1.0, drag_area=1.0, rolling=BOUND / 9.80665),
    "load": gb.SpeedLoad(coeffs=(BOUND, 0.0, 0.3)),
    "bearing": gb.BearingFriction(coulomb=BOUND, viscous=0.2),
}


def _rig(tie: Any, hold: Any, w0: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("held behind a tie")
    near, middle, far = (
        rig.add(n, gb.Inertia(J=1.0, **w)) for n, w in (("near", {"w0": w0}), ("middle", {}), ("far", {}))
    )
    shaft, pair, held = rig.add("spline", SPLINE), rig.add("pair", tie), rig.add("hold", hold)
    rig.connect(near.a, shaft.a)
    rig.connect(shaft.b, middle.a, pair.a)
    rig.connect(middle.b, held.a if isinstance(hold, gb.BearingFriction) else held.flange)
    rig.connect(pair.b, far.a)
    return rig


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("tie", ["ellipse", *(pytest.param(n, marks=pytest.mark.long) for n in ("joint", "gear"))])
@pytest.mark.parametrize("w0", [-5.0, 5.0])
def test_it_lets_go_where_the_torque_of_the_spline_is_the_bound(tie: str, hold: str, w0: float, method: str) -> None:
    run = gb.simulate(_rig(TIES[tie], HOLDS[hold], w0), t_end=0.01, method=method)
    first = next(e.t for e in run.events if e.component.startswith("hold"))
    at = int(np.searchsorted(run.t, first))
    assert run.t[at] == pytest.approx(first)
    assert abs(run["spline.b.tau"][at]) == pytest.approx(BOUND, rel=1e-5)
    assert abs(run["middle.w"][-1]) > 1e-3
    assert run.stats.steps + run.stats.rejected < 300
    assert run.energy.residual < 1e-5
