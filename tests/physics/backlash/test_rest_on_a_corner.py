"""A body at rest exactly on the corner of its contact, whose angle follows from coordinates that move: rounding is no impact.

Closed form: nothing reaches the body until a gap beside it closes; with the damping of Hunt and Crossley, whose factor is
one over the speed of approach, a speed of rounding would make a contact of infinite damping there.
"""

import numpy as np
import pytest

import gearblocks as gb

HIT = gb.HuntCrossley(restitution=0.3)


def _lash(rig, body):
    rest = rig.add("rest", gb.Lash(k=1330.0, half_gap=0.0, contact_damping=HIT))
    rig.connect(body.b, rest.a)
    ground = rig.add("ground", gb.Fixed())
    rig.connect(rest.b, ground.flange)
    return ground.flange


def _one_sided(rig, body):
    """Two bodies that touch."""
    rest, beyond = (
        rig.add("rest", gb.Lash(k=900.0, half_gap=0.0, contact_damping=HIT)),
        rig.add("beyond", gb.Inertia(J=3.0)),
    )
    rig.connect(body.b, rest.a)
    rig.connect(rest.b, beyond.a)
    return beyond.b


def _spline(rig, body):
    rest = rig.add(
        "rest", gb.SplineCoupling(teeth=3, radius=0.1, k=1e6, backlash=gb.Backlash(half_gap=0.0), contact_damping=HIT)
    )
    rig.connect(body.b, rest.a)
    ground = rig.add("ground", gb.Fixed())
    rig.connect(rest.b, ground.flange)
    return ground.flange


def _rig(rest, ratio, w):
    rig = gb.Drivetrain("corner")
    body, moving = rig.add("body", gb.Inertia(J=0.09)), rig.add("moving", gb.Inertia(J=0.2, w0=w))
    mesh = rig.add(
        "mesh",
        gb.GearMesh(
            teeth=(23, round(23 * ratio)), r_base=(0.1, 0.1 * round(23 * ratio) / 23), k=2000.0, external=True,
            backlash=gb.Backlash(half_gap=0.002), contact_damping=HIT,
        ),
    )  # fmt: skip
    rig.connect(body.a, mesh.pinion)
    far = rig.add("far", gb.Lash(k=10.0, half_gap=1.0))  # with it the deflection of `rest` closes a loop
    rig.connect(moving.a, mesh.wheel, far.a)
    beyond = rest(rig, body)
    rig.connect(far.b, beyond)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("rest", [_lash, _one_sided, _spline])
@pytest.mark.parametrize(
    ("ratio", "w"), [(31 / 23, 1.49), pytest.param(2.0, -0.37, marks=pytest.mark.long), (1.0, 7.3)]
)
@pytest.mark.few(1)
def test_what_nothing_reaches_stays_on_its_corner(rest, ratio, w, method):
    meets = 0.002 / (0.1 * round(23 * ratio) / 23 * abs(w))
    rig = _rig(rest, ratio, w)
    run = gb.simulate(rig, t=np.linspace(0.0, 0.99 * meets, 7), method=method, rtol=1e-9)
    assert not run.events
    assert np.abs(run["body.phi"]).max() < 1e-15
    assert np.abs(run["rest.a.tau"]).max() < 1e-10
    assert run["moving.w"] == pytest.approx(np.full(7, w), rel=1e-14)


@pytest.mark.parametrize("method", ["dp5", "rodas"])
@pytest.mark.parametrize(("ratio", "w"), [(31 / 23, 1.49), (2.0, -0.37)])
def test_the_impact_that_comes_is_that_of_a_body_at_rest(ratio, w, method):
    """The first contact of the mesh alone: as without anything behind the body, as long as that is soft."""
    meets = 0.002 / (0.1 * round(23 * ratio) / 23 * abs(w))
    run = gb.simulate(_rig(_lash, ratio, w), t_end=1.01 * meets, method=method, rtol=1e-9)
    assert [e.component for e in run.events][:1] == ["mesh"]
    assert run.events[0].t == pytest.approx(meets, rel=1e-12)


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("power", [2, pytest.param(3, marks=pytest.mark.long), 4])
@pytest.mark.few(1)
def test_a_soft_rise_leaves_a_corner_without_an_impact(power, beside, method):
    """J phi'' = -c t^n - k phi from rest on the corner: damping begins once the sides have parted, so there is none."""
    J, k, c, end = 0.1, 1330.0, 50.0, 0.02  # over before the motion turns
    rig = gb.Drivetrain("soft rise")
    body = rig.add("body", gb.Inertia(J=J))
    _lash(rig, body)
    rig.connect(rig.add("load", gb.Torque(tau=-c * gb.time**power)).flange, body.a)
    if beside:  # what moves already gives slow speeds no scale
        one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=1.0))
        rig.chain(one, rig.add("shaft", gb.Shaft(k=10.0)), two)
    run = gb.simulate(rig, t=[0.0, end], method=method, rtol=1e-9)
    w2, term, exact = k / J, -c / J * end ** (power + 2) / ((power + 1) * (power + 2)), 0.0
    for i in range(30):  # the series of the solution
        exact += term
        term *= -w2 * end**2 / ((power + 2 * i + 3) * (power + 2 * i + 4))
    assert run["body.phi"][-1] == pytest.approx(exact, rel=1e-6)
    assert not run.events
