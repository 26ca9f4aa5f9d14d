"""The first long trial after a break-away ends where the train never comes: what it tells of the noise of locks is forgotten.

By hand, integrated by scipy: a body that breaks away under a ramp and is wound against a spring that hardens, whose other end
is held for good. It keeps sliding, since the ramp is faster than what it swings by.
"""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import gearblocks as gb

J, K, C, FRICTION, PEAK = 0.0286, 15.1, 0.0327, 0.0233, 1.1


def _bearing(rig, body):
    rig.connect(rig.add("lock", gb.BearingFriction(coulomb=1e4)).a, body.b)


def _brake(rig, body):
    rig.connect(rig.add("lock", gb.Brake(capacity=1e4)).a, body.b)


def _freewheel(rig, body):
    lock = rig.add("lock", gb.Freewheel())
    rig.connect(lock.a, body.b)
    rig.connect(lock.b, rig.add("ground", gb.Fixed()).flange)


def _rig(hardening, rate, hold):
    rig = gb.Drivetrain("ramp")
    held, body = rig.add("held", gb.Inertia(J=0.5)), rig.add("body", gb.Inertia(J=J))
    shaft = rig.add("shaft", gb.Shaft(torque=K * gb.twist + hardening * gb.twist**3, c=C))
    rig.chain(held, shaft, body)
    rig.connect(rig.add("drive", gb.Torque(tau=rate * gb.time)).flange, body.b)
    rig.connect(rig.add("grip", gb.BearingFriction(coulomb=FRICTION, peak=PEAK)).a, body.b)
    hold(rig, held)
    return rig


def _wound(hardening, rate, t):
    def rates(time, y):
        return [y[1], (rate * time - FRICTION - K * y[0] - hardening * y[0] ** 3 - C * y[1]) / J]

    begin = PEAK * FRICTION / rate
    run = solve_ivp(rates, (begin, t[-1]), [0.0, 0.0], "DOP853", t_eval=t[t > begin], rtol=1e-11, atol=1e-14)
    assert (run.y[1] > 0.0).all()
    return np.concatenate([np.zeros((t <= begin).sum()), run.y[0]])


@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas"])
@pytest.mark.parametrize("hold", [_bearing, _brake, _freewheel])
@pytest.mark.parametrize(("hardening", "rate"), [(3.31, 0.865), (300.0, 0.865), (30.0, 2.0)])
@pytest.mark.few(1)
def test_a_body_that_breaks_away_is_wound_up_whatever_its_first_trial(hardening, rate, hold, method):
    t = np.linspace(0.0, 3.0, 13)
    run = gb.simulate(_rig(hardening, rate, hold), t=t, method=method, rtol=1e-8)
    wound = _wound(hardening, rate, t)
    assert np.abs(run["body.phi"] - wound).max() < 1e-6 * wound.max()
    assert (run["held.w"] == 0.0).all()
    assert run.stats.steps < 2000


class Cam(gb.Block):
    """A torque in a window of the angle: its ends are searched for along each step."""

    a = gb.Flange("shaft")

    def physics(self, s):
        yield gb.Acts(s.a, sp.Piecewise((1, sp.cos(s.a.phi) > 0.9), (0, True)))


def test_a_rate_inside_a_step_that_is_not_finite_rejects_the_step():
    """Those of dense output alone, which follow once the step is accepted, ended the run."""
    rig = gb.Drivetrain("cam")
    rig.chain(
        rig.add("load", gb.Torque(tau=gb.Input("u") ** 2)),
        rig.add("a", gb.Inertia(J=1.0, w0=1.0)),
        rig.add("cam", Cam()),
    )
    model = gb.build(rig)

    def run(burst):
        asked = []

        def u(t):
            asked.append(t)
            return 1e200 if t == burst else 0.1

        return gb.simulate(model, t=[0, 4.0], inputs={"u": u}, outputs=[], method="dp8"), asked

    plain, asked = run(-1.0)
    ends = {0.0, 4.0, *(e.t for e in plain.events)}  # the motion has no number there
    inside = sorted(set(asked) - ends)
    assert len(inside) > 50
    rejected = 0
    for t in inside:
        found, _ = run(t)
        assert found.complete
        rejected += found.stats.rejected > plain.stats.rejected
    assert rejected > 20
