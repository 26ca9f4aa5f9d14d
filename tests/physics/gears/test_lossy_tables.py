"""Loss tables where a run starts, or an impact leaves the gear, far from the first segment: the losses are those of that speed.

The first segment drawn on to such speeds would have efficiencies below zero. Closed forms: with a torque tau at a and the
load L at b the gear is  tau - J1 w' = what enters at a,  by the efficiencies and bearing torques at that speed.
"""

import numpy as np
import pytest

import gearblocks as gb

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

STEEP = ((0.0, 0.98, 0.677, 0.0622, 0.0622), (0.589, 0.501, 0.548, 0.337, 0.337))
FREE = tuple((*row[:3], 0.0, 0.0) for row in STEEP)
THREE = ((0.0, 0.84, 0.985, 0.0, 0.0), (1.0, 0.694, 0.668, 0.785, 0.785), (7.71, 0.686, 0.923, 0.0, 0.0))
LATE = ((0.5, 0.6, 0.753, 1.58, 1.58), (1.0, 0.939, 0.549, 0.2, 0.3), (9.59, 0.959, 0.961, 0.0, 0.0))
J1, J2 = 0.113, 1.6


def _train(table, ratio, tau, load, w0):
    rig = gb.Drivetrain("table")
    drive, one = rig.add("drive", gb.Torque(tau=tau)), rig.add("one", gb.Inertia(J=J1, w0=w0))
    two, brake = rig.add("two", gb.Inertia(J=J2)), rig.add("load", gb.Torque(tau=load))
    rig.chain(drive, one, rig.add("gear", gb.LossyGear(ratio=ratio, loss_table=table)), two, brake)
    return rig, one


def _acceleration(table, ratio, tau, load, w, inertia=J1):
    """Of side a that turns with w: the side of the gear with which it agrees."""
    speeds, *columns = zip(*table, strict=True)
    eta1, eta2, tau1, tau2 = (float(np.interp(abs(w), speeds, c)) for c in columns)
    d, found = np.sign(w), []
    for gain, rest, side in ((1 / eta1, tau1, 1), (eta2, tau2, -1)):
        alpha = (tau - gain * (-load / ratio + d * rest)) / (inertia + gain * J2 / ratio**2)
        leaves = d * (J2 * alpha / ratio - load) / ratio + rest
        found += [alpha] if leaves * side > 0 else []
    assert len(found) == 1
    return found[0]


@pytest.mark.long
@pytest.mark.parametrize("table", [STEEP, THREE, LATE], ids=["steep", "three", "late"])
@pytest.mark.parametrize("w0", [21.3, -21.3, 4.0, -0.7])
@pytest.mark.parametrize(("ratio", "tau", "load"), [(-1.0, -2.4, 0.0), (0.25, 3.0, -1.0), (4.0, 0.0, 5.0)])
@pytest.mark.few(1)
def test_a_run_starts_with_the_losses_of_its_speed(table, w0, ratio, tau, load):
    run = gb.simulate(_train(table, ratio, tau, load, w0)[0], t_end=1e-3)
    assert run["one.alpha"][0] == pytest.approx(_acceleration(table, ratio, tau, load, w0), rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("w0", [60.0, -60.0])
@pytest.mark.parametrize("table", [FREE, STEEP, THREE], ids=["free", "steep", "three"])
def test_an_impact_leaves_the_gear_with_the_losses_of_its_new_speed(table, w0):
    """A dog clutch closes on a flywheel: the momentum about shaft a is kept, the gear loses nothing in the impact."""
    ratio, tau, flywheel, slow = -1.0, -2.4, 2.0, 0.3
    rig, one = _train(table, ratio, tau, 0.0, slow)
    wheel, dog = rig.add("wheel", gb.Inertia(J=flywheel, w0=w0)), rig.add("dog", gb.DogClutch(engaged=gb.time - 0.01))
    rig.chain(wheel, dog)
    rig.connect(dog.b, one.a)
    run = gb.simulate(rig, t_end=0.02, method="dp8", rtol=1e-10)
    at = int(np.searchsorted(run.t, 0.01, side="right"))
    before = slow + 0.01 * _acceleration(table, ratio, tau, 0.0, slow)
    w = (flywheel * w0 + (J1 + J2 / ratio**2) * before) / (flywheel + J1 + J2 / ratio**2)
    assert run["one.w"][at] == pytest.approx(w, rel=2e-3)
    true = _acceleration(table, ratio, tau, 0.0, run["one.w"][at], J1 + flywheel)
    assert run["one.alpha"][at] == pytest.approx(true, rel=1e-9)


@pytest.mark.parametrize("eta1", [0.993, 1.0])
@pytest.mark.parametrize("eta2", [0.638, 1.0, -0.3])
@pytest.mark.parametrize("speed", [11.1, 7.7, 0.3])
@pytest.mark.few(1)
def test_a_table_without_bearing_torque_at_rest_holds_nothing_and_moves_nothing(speed, eta2, eta1):
    """Beside a gear at rest that is loaded; 2 - J1 w' = J2 w'/(4 eta1) from where the torque comes on."""
    table = ((0.0, eta1, eta2, 0.0, 0.0), (speed, 0.769, 0.793 if eta2 > 0 else -0.4, 0.372, 0.372))
    rig, _ = _train(table, 2.0, gb.piecewise((2.0, gb.time > 0.5), (0.0, True)), 0.0, 0.0)
    held = rig.add("held", gb.LossyGear(ratio=-0.5, efficiency=(0.928, 0.564), bearing=(1.1, 1.1)))
    three, four = rig.add("three", gb.Inertia(J=0.25)), rig.add("four", gb.Inertia(J=0.9))
    rig.chain(rig.add("pull", gb.Torque(tau=0.665)), three, held, four)
    end = 0.5 + 1e-3 * speed
    run = gb.simulate(rig, t=[0.0, 0.5, end], rtol=1e-9)
    assert set(run["three.w"]) == set(run["four.w"]) == {0.0} == set(run["one.w"][:2])
    assert run["one.w"][2] == pytest.approx(2.0 / (J1 + J2 / (4 * eta1)) * (end - 0.5), rel=1e-2)
