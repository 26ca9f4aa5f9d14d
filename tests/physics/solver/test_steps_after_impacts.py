"""A step that follows an impact is another motion's than those before it, in the same modes: it is looked into."""

import pytest

import gearblocks as gb

# method, tolerance, start speed [rad/s], stiffness [N/m], restitution: the worst of 400 at random where it was not
CASES = [
    ("dp8", 6.733722573400659e-09, -9.01876309298504, 10061.976683237726, 0.7997731393334582),
    ("auto", 1.4150860643657788e-09, -11.658707160417226, 12355.34845255939, 0.5999021430276754),
    ("dp8", 1.4369365892944585e-08, -11.859694513255306, 31534.534350465732, 0.43198076698557053),
    ("dp8", 1.3572025269843628e-07, -8.521492700987288, 76545.99359436409, 0.5252244102116783),
]


def _rig():
    """Two bodies with a smooth gap between, and a third one across a rigid gap: free flights, long steps, short contacts."""
    rig = gb.Drivetrain("flights")
    play = gb.Backlash(half_gap=1.5e-4, law="smooth", width=4.51e-5)
    spline = gb.SplineCoupling(
        teeth=6, radius=0.02, k=gb.Parameter("stiff", 1e4), backlash=play, contact_damping="always"
    )  # fmt: skip
    hit = gb.HuntCrossley(restitution=gb.Parameter("kept", 0.5))
    rig.chain(
        rig.add("one", gb.Inertia(J=0.0473, w0=gb.Parameter("fast", -8.0))),
        rig.add("spline", spline),
        rig.add("two", gb.Inertia(J=0.159)),
        rig.add("gap", gb.Lash(k=1e4, half_gap=0.0592, contact_damping=hit)),
        rig.add("three", gb.Inertia(J=0.0498)),
    )
    return rig.without("gap.compliance")


@pytest.mark.parametrize(("method", "rtol", "fast", "stiff", "kept"), CASES)
def test_the_ledger_closes(method, rtol, fast, stiff, kept):
    given = {"fast": fast, "stiff": stiff, "kept": kept}
    run = gb.simulate(_rig(), t_end=1.0, method=method, rtol=rtol, parameters=given)
    assert sum(e.kind == "impact" for e in run.events) > 4
    assert abs(run.energy.residual) < 10 * rtol
