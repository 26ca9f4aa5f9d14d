"""The first step after an event has other laws than those that were looked at before: what it does inside is looked at too."""

import pytest
import sympy as sp

import gearblocks as gb


def _rig(k, e):
    """A body flies into a flank; what it pushes closes the flank of a pair of ellipses in the middle of the first step."""
    rig = gb.Drivetrain("new modes")
    one, two = rig.add("one", gb.Inertia(J=0.1)), rig.add("two", gb.Inertia(J=1.0))
    body = rig.add("body", gb.Inertia(J=1.0, w0=-10.0))
    law, gap = gb.RatioLaw.ellipse(e=e, order=1), gb.Backlash(half_gap=0.1)
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=False, k=1.0, backlash=gap))
    flank = rig.add("flank", gb.Lash(k=k, half_gap=0.25))
    rig.connect(one.a, pair.a)
    rig.connect(one.b, rig.add("load", gb.Torque(tau=sp.exp(-3.0 * gb.time))).flange)
    rig.connect(two.a, pair.b)
    rig.connect(two.b, flank.a)
    rig.connect(body.a, flank.b)
    return rig


@pytest.mark.parametrize("rtol", [1e-6, 1e-4])
@pytest.mark.parametrize(("k", "e"), [(100.0, 0.1), (100.0, 0.3), (150.0, 0.1), (200.0, 0.1), (200.0, 0.2)])
@pytest.mark.few(1)
def test_a_step_that_an_event_cuts_is_as_right_inside_as_at_its_end(k, e, rtol):
    """The ledger closes, and the motion is that of many short steps of another method."""
    run = gb.simulate(_rig(k, e), t=[0.0, 0.1, 0.25], method="dp8", rtol=rtol)
    fine = gb.simulate(_rig(k, e), t=[0.0, 0.1, 0.25], method="dp5", rtol=1e-10)
    assert run.energy.residual <= 10 * rtol
    for name in ("one.w", "two.w", "body.w"):
        assert run[name] == pytest.approx(fine[name], abs=10 * rtol * 10.0)
