"""Contacts with k g abs(g)^(n - 1), whose law has no second derivative where they end: steps that end there are right.

The stages beyond the end take the law with the other sign, and of the step sizes that are tried one is found for which
the estimate passes zero. Nothing is lost here, so that the energy is that of the start.
"""

import numpy as np
import pytest

import gearblocks as gb

K, LOWER, UPPER, SHAFT = 1050.0, -0.05, 0.033, 40.0
RTOLS = [float(r) for r in np.geomspace(1e-9, 1e-6, 13)]


def _rig(exponent, third):
    rig = gb.Drivetrain("bends")
    a, b = rig.add("a", gb.Inertia(J=1.37, w0=-2.1)), rig.add("b", gb.Inertia(J=1.78, w0=4.7))
    lash = rig.add("lash", gb.Lash(k=K, lower=LOWER, upper=UPPER, exponent=exponent))
    rig.connect(a.a, lash.a)
    rig.connect(lash.b, b.a)
    if third:
        c, shaft = rig.add("c", gb.Inertia(J=0.02)), rig.add("shaft", gb.Shaft(k=SHAFT))
        rig.connect(a.b, shaft.a)
        rig.connect(shaft.b, c.a)
    return rig


def _energy(run, exponent, third):
    a, b = run["a.phi"], run["b.phi"]
    x = b - a
    g = np.maximum(x - UPPER, 0.0) + np.maximum(LOWER - x, 0.0)
    energy = 0.5 * (1.37 * run["a.w"] ** 2 + 1.78 * run["b.w"] ** 2) + K * g ** (exponent + 1) / (exponent + 1)
    if third:
        energy += 0.5 * (0.02 * run["c.w"] ** 2 + SHAFT * (run["c.phi"] - a) ** 2)
    return energy


@pytest.mark.parametrize("third", [False, True], ids=["two bodies", "three bodies"])
@pytest.mark.parametrize("exponent", [1.5, 2.0, 2.5])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.few(1)
def test_no_step_that_ends_a_contact_adds_or_takes_energy(method, exponent, third):
    model = gb.build(_rig(exponent, third))
    for rtol in RTOLS:
        run = gb.simulate(model, t=np.linspace(0.0, 1.0, 51), rtol=rtol, method=method)
        energy = _energy(run, exponent, third)
        assert len(run.events) > 10
        assert np.abs(energy / energy[0] - 1.0).max() < 20.0 * rtol  # of a turnover that is at least the energy
        assert run.energy.residual < 10.0 * rtol
