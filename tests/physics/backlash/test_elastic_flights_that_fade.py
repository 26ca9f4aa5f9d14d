"""Stops that take nothing, and bodies whose flights between them fade: more and more impacts, in closed form."""

import math

import numpy as np
import pytest

import gearblocks as gb

J, DRAG, LOAD, START = 0.5, 2.0, 5.0, 3.0


def _rig(restitution=1.0, start=START, load=LOAD, drag=DRAG, fast=None, flanks=False):
    """A body at a stop (or beside a rigid flank), pressed by a constant torque, in a drag that is linear in its speed."""
    rig = gb.Drivetrain("fading")
    body = rig.add("body", gb.Inertia(J=J, w0=start, phi0=1.0 if flanks else 0.0))
    if flanks:
        hit = gb.HuntCrossley(restitution=restitution)
        stop = rig.add("stop", gb.Lash(k=1.0, half_gap=1.0, contact_damping=hit))
        rig.connect(stop.b, rig.add("ground", gb.Fixed()).flange)
    else:
        stop = rig.add("stop", gb.HardStop(upper=0.0, restitution=restitution))
    rig.connect(stop.a, body.a)
    rig.connect(rig.add("drag", gb.SpeedLoad(coeffs=(0.0, drag, 0.0))).flange, body.a)
    rig.connect(rig.add("load", gb.Torque(tau=load)).flange, body.b)
    if fast is not None:
        rig.add("fast", gb.Inertia(J=1.0, w0=fast))
    return rig.without("stop.compliance") if flanks else rig


def _impacts(run):
    return [e for e in run.events if e.kind == "impact"]


@pytest.mark.parametrize("method", ["dp8", "rodas", "auto"])
@pytest.mark.parametrize(("rtol", "start"), [(1e-3, 3.0), (1e-3, 7.0), (1e-3, 2.0)])
@pytest.mark.few(1)
def test_impacts_that_drag_makes_lower_end_where_the_tolerance_tells_them_no_more(method, rtol, start):
    """v falls as exp(-D t / 3 J) (low flights: 4/3 of v^2/g of drag each), 2 v / g apart; until v = rtol v0."""
    rate, push = DRAG / (3 * J), LOAD / J
    run = gb.simulate(_rig(start=start), t_end=12.0, method=method, rtol=rtol)
    impacts = _impacts(run)
    assert -impacts[-1].before == pytest.approx(rtol * start, rel=1e-2)
    assert len(impacts) == pytest.approx(push / (2 * rate * rtol * start), rel=1e-2)
    half = impacts[len(impacts) // 2]  # v is 1/N of what it was
    assert impacts[-1].t - half.t == pytest.approx(math.log(half.before / impacts[-1].before) / rate, rel=1e-2)
    assert (run["body.w"][-1], run["stop.contact"][-1]) == (0.0, 1.0)
    assert abs(run["body.phi"][-1]) <= 1e-12
    assert abs(run.energy.residual) < 10 * rtol


@pytest.mark.parametrize(
    ("rtol", "start", "drag", "flanks"),
    [
        (1e-4, 3.0, DRAG, False),
        (1e-6, 3.0, DRAG, True),
        (1e-8, 3.0, DRAG, False),
        pytest.param(1e-10, 3.0, DRAG, False, marks=pytest.mark.long),
        pytest.param(1e-9, 9.0, DRAG, False, marks=pytest.mark.long),
        pytest.param(1e-10, 3.0, DRAG, True, marks=pytest.mark.long),
    ],
)
def test_impacts_that_are_too_many_end_where_their_energy_is_less_than_the_tolerance(rtol, start, drag, flanks):
    """v = LOAD / (2 rate N J) after N of them. From 2e3 on N rtol v0 may pass as rest, but no more than sqrt(rtol) v0, and
    a height of rtol times the largest angle: w0/a - push/a^2 ln(1 + a w0/push) with a = D/J, or the gap."""
    rate, push, a = drag / (3 * J), LOAD / J, drag / J
    height = 1.0 if flanks else start / a - push / a**2 * math.log1p(a * start / push)
    size = push / (2 * rate)
    run = gb.simulate(_rig(start=start, drag=drag, flanks=flanks), t_end=20.0 / rate, method="dp5", rtol=rtol)
    impacts = _impacts(run)
    least = (rtol * min(start**2, 2 * push * height)) ** 0.5
    assert len(impacts) == pytest.approx(max(2e3, size / least), rel=2e-2)
    assert -impacts[-1].before == pytest.approx(size / len(impacts), rel=2e-2)
    assert (run["body.w"][-1], abs(run["stop.contact"][-1])) == (0.0, 1.0)
    assert abs(run["body.phi"][-1] - run["body.phi"][0]) <= 1e-12
    assert abs(run.energy.residual) < 10 * rtol


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_what_rested_so_leaves_its_stop_when_its_load_turns(method):
    """Long after the last impact: from 6 s on, from rest, J w' = -LOAD sin(pi (t - 6 s)/12 s) - DRAG w."""
    run = gb.simulate(_rig(load=LOAD * gb.cos(gb.time * math.pi / 12)), t=[5.9, 6.0, 7.0], method=method, rtol=1e-3)
    turn, a = math.pi / 12, DRAG / J
    shape = (a * math.sin(turn) - turn * math.cos(turn) + turn * math.exp(-a)) / (a**2 + turn**2)
    assert run["body.w"][0] == 0.0
    assert run["body.w"][-1] == pytest.approx(-LOAD / J * shape, rel=1e-2)


def test_impacts_that_fade_no_more_go_on_below_what_may_pass_as_rest():
    """The drag ends where v is 200 times its tolerance: flights of 2 v J / LOAD, as many as that is long."""
    rig = _rig(drag=0.0)
    drag = rig.add("fades", gb.Torque(tau=-DRAG * gb.sense("body.w") * gb.piecewise((1.0, gb.time < 4.6), (0.0, True))))
    rig.connect(drag.flange, rig["body"].a)
    impacts = _impacts(gb.simulate(rig, t_end=10.0, rtol=1e-5))
    v = next(e.after for e in impacts if e.t > 4.65)
    assert 1e-3 * START < v < 3e-3 * START
    assert len([e for e in impacts if e.t > 4.65]) == pytest.approx((10.0 - 4.65) * LOAD / (2 * v * J), rel=1e-2)
    assert impacts[-1].after == pytest.approx(v, rel=1e-3)


@pytest.mark.parametrize("fast", [None, 100.0])
@pytest.mark.parametrize("start", [1e-6, 1e-3])
@pytest.mark.few(2)
def test_low_impacts_that_lose_nothing_go_on(start, fast):
    """A size of its own, beside what turns 10^8 times as fast: flights of 2 v J / LOAD, as high as the first."""
    flight = 2 * start * J / LOAD
    run = gb.simulate(_rig(start=start, drag=0.0, fast=fast), t_end=500.5 * flight, rtol=1e-6)
    assert len(_impacts(run)) == 501
    assert np.max(np.abs([e.after - start for e in _impacts(run)])) < 1e-6 * start


@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_sides_that_have_hardly_moved_rest_by_the_tolerance_of_the_train(method):
    """Pressed ever harder they fly higher than they ever were, 1e-13 of a turn, and 1e7 times a second."""
    rig = gb.Drivetrain("hardly moved")
    fast, light = rig.add("fast", gb.Inertia(J=1.0, w0=-25.5)), rig.add("light", gb.Inertia(J=0.262))
    heavy, lash = rig.add("heavy", gb.Inertia(J=1.18)), rig.add("lash", gb.Lash(k=61.4, half_gap=0.00104, c=1.43))
    waves = {
        "stiffness_variation": gb.Fourier(cos=(0.381,), driven_by="angle"),
        "transmission_error": gb.Harmonic(cos=(0.000406,), driven_by="angle"),
        "backlash": gb.Backlash(half_gap=0.00468),
    }
    teeth = {"teeth": (23, 31), "r_base": (0.1, 3.1 / 23), "external": True, "contact_damping": "always"}
    mesh = rig.add("mesh", gb.GearMesh(**teeth, k=68800.0, c=207.0, **waves))
    stop = rig.add("stop", gb.HardStop(restitution=1.0, upper=0.0))
    rig.connect(fast.a, lash.a)
    rig.connect(light.a, lash.b)
    rig.connect(light.b, mesh.pinion)
    rig.connect(heavy.a, mesh.wheel, stop.a, rig.add("load", gb.Torque(tau=-3.76 * gb.time)).flange)
    run = gb.simulate(rig, t_end=0.3, method=method)
    assert len(_impacts(run)) < 20000
