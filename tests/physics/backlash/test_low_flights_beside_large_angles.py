"""Bodies that leave their stop and are back before they are farther from it than the tolerance of an angle, which other
bodies make large: in closed form."""

import pytest

import gearblocks as gb

J = 0.2


def _rig(pull, press, restitution):
    """J w' = -pull t + press t^2 from rest at a stop: back at 2 pull/press. Beside it a body turns in a wide gap, unloaded."""
    rig = gb.Drivetrain("low flight")
    body = rig.add("body", gb.Inertia(J=J))
    rig.connect(rig.add("stop", gb.HardStop(upper=0.0, restitution=restitution)).a, body.a)
    rig.connect(rig.add("load", gb.Torque(tau=-pull * gb.time + press * gb.time**2)).flange, body.b)
    wide = rig.add("wide", gb.Lash(k=1e3, half_gap=100.0))
    rig.connect(body.a, wide.a)
    rig.connect(wide.b, rig.add("other", gb.Inertia(J=1.0, w0=10.0)).a)
    return rig


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9])
@pytest.mark.parametrize(("method", "rtol"), [("dp8", 1e-6), ("rodas", 1e-6), ("auto", 1e-4)])
@pytest.mark.parametrize(("pull", "press"), [(1e-2, 1e2), (1.0, 1e4)])
@pytest.mark.few(1)
def test_a_flight_below_the_tolerance_ends_at_its_stop(pull, press, method, rtol, restitution):
    """w there is 2 pull^3 / (3 J press^2); missed, the body was far behind its stop before anything was seen."""
    back, w = 2 * pull / press, 2 * pull**3 / (3 * J * press**2)
    run = gb.simulate(_rig(pull, press, restitution), t_end=1.4 * back, method=method, rtol=rtol)
    first = run.events[0]
    assert (first.component, first.kind) == ("stop.upper", "impact")
    assert first.t == pytest.approx(back, rel=1e-9)
    assert first.before == pytest.approx(-w, rel=1e-6)
    assert first.after == pytest.approx(restitution * w, rel=1e-6)
    assert max(run["body.phi"]) <= 1e-12 * J
