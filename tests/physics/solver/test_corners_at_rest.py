"""Corners of laws on which a stuck joint holds the state: rounding puts it on either side, and nothing depends on it."""

import numpy as np
import pytest

import gearblocks as gb

LIMIT, STIFFNESS, HALF_GAP = 0.07, 40.0, 0.002
SPEED = gb.sense("behind.w")
LOADS = {
    "dry load": gb.SpeedLoad(coeffs=(0.1, 0.0, 0.0)),
    "dry and viscous load": gb.SpeedLoad(coeffs=(0.7, 0.2, 0.01)),
    "jump over the speed": gb.Torque(tau=gb.piecewise((-0.3, SPEED > 0.0), (0.2, True))),
    "corner over the speed": gb.Torque(tau=gb.piecewise((-0.3 * SPEED, SPEED > 0.0), (0.0, True))),
}


def held_by_a_stop(order: int, load: gb.SpeedLoad | gb.Torque) -> gb.Drivetrain:
    """A body pressed against a stop, a second one behind a joint with a law over speed, a third on a soft coupling."""
    rig = gb.Drivetrain("rig")
    driven = rig.add("driven", gb.Inertia(J=1.0))
    free = rig.add("free", gb.Inertia(J=1.0))
    coupling = rig.add("coupling", gb.Lash(k=STIFFNESS, half_gap=HALF_GAP))
    behind = rig.add("behind", gb.Inertia(J=1.0))
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3, order=order), external=True))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, upper=LIMIT))
    torque = rig.add("torque", gb.Torque(tau=20.0))
    rig.connect(driven.a, coupling.a, pair.a, stop.a, torque.flange)
    rig.connect(free.a, coupling.b)
    rig.connect(behind.a, pair.b, rig.add("load", load).flange)
    return rig


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.few(1)
def test_what_a_stop_holds_rests_on_the_corner_of_its_law_and_the_rest_moves_on(load, order, method):
    rig = held_by_a_stop(order, LOADS[load])
    run = gb.simulate(rig, t_end=1.0, method=method, rtol=1e-8, outputs="*")
    hit = next(e.t for e in run.events if e.kind == "impact")
    rests = run.t > hit + 1e-9
    np.testing.assert_allclose(run["driven.phi"][rests], LIMIT, rtol=1e-9)
    np.testing.assert_allclose(run["behind.w"][rests], 0.0, atol=1e-12)
    twist = run["driven.phi"] - run["free.phi"]
    pressed = np.sign(twist) * np.maximum(np.abs(twist) - HALF_GAP, 0.0)
    energy = 0.5 * run["free.w"] ** 2 + 0.5 * STIFFNESS * pressed**2
    np.testing.assert_allclose(energy[rests], energy[rests][0], rtol=1e-6)
    assert rests.sum() > 10
    assert len(run.events) < 200
