"""A clutch between two paths of nearly one ratio, of which one loses: all turn back at the same instant, but for rounding."""

import numpy as np
import pytest

import gearblocks as gb

# ratio of the lossy gear and of the other path, efficiencies, inertias of both sides
TRAINS = [
    (2.0, 2.02, (0.6, 0.58), (0.07, 0.05)), (-2.0, -1.97, (0.9, 0.3), (0.02, 0.5)), (-2.0, -1.97, (0.5, 0.9), (0.07, 0.05)),
    (3.0, 2.9, (0.9, 0.3), (0.07, 0.05)), (3.0, 2.9, (0.5, 0.9), (0.02, 0.5)),
]  # fmt: skip
T = np.linspace(0.0, 1.0, 101)


def _train(ratio, other, efficiency, inertias, capacity=None):
    rig = gb.Drivetrain("across")
    a, b = rig.add("a", gb.Inertia(J=inertias[0], w0=-5.0)), rig.add("b", gb.Inertia(J=inertias[1]))
    gear = rig.add("gear", gb.LossyGear(ratio=ratio, efficiency=efficiency))
    drive, load = rig.add("drive", gb.Torque(tau=2.0)), rig.add("load", gb.Torque(tau=0.3))
    rig.connect(drive.flange, a.a)
    rig.connect(a.b, gear.a)
    rig.connect(gear.b, b.a)
    rig.connect(b.b, load.flange)
    if capacity is not None:
        path, clutch = rig.add("path", gb.IdealGear(ratio=other)), rig.add("clutch", gb.Clutch(capacity=capacity))
        rig.connect(b.b, path.b)
        rig.connect(path.a, clutch.a)
        rig.connect(clutch.b, a.a)
    return rig


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize(("ratio", "other", "efficiency", "inertias"), TRAINS)
@pytest.mark.few(1)
def test_a_clutch_that_carries_next_to_nothing_changes_next_to_nothing(ratio, other, efficiency, inertias, method):
    """Stuck it would jam the loop: the matrix of both forces has a negative determinant, and its force goes to the bound that
    pivoting did not try."""
    free = gb.simulate(_train(ratio, other, efficiency, inertias), t=T, rtol=1e-10)
    assert free["a.w"][-1] > 0.0
    model = gb.build(_train(ratio, other, efficiency, inertias, capacity=1e-6))
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(model, t=T, rtol=rtol, method=method)
        assert np.abs(run["a.w"] - free["a.w"]).max() < 2e-5
        assert run.energy.residual <= 10.0 * rtol


@pytest.mark.parametrize(("ratio", "other", "efficiency", "inertias"), TRAINS)
@pytest.mark.few(1)
def test_one_that_carries_something_does_so_by_its_arm(ratio, other, efficiency, inertias):
    """Its torque acts by the difference of both ratios: as a drag of that size on a, as far as the gear passes on what its
    other side takes."""
    capacity = 0.2
    model = gb.build(_train(ratio, other, efficiency, inertias, capacity=capacity))
    right = gb.simulate(model, t=T, rtol=1e-11, method="dp5")
    for method in ("auto", "dp8", "rodas"):
        run = gb.simulate(model, t=T, rtol=1e-7, method=method)
        assert np.abs(run["a.w"] - right["a.w"]).max() < 10e-7 * np.abs(right["a.w"]).max()
        assert np.abs(run["clutch.torque"]).max() == pytest.approx(capacity, rel=1e-12)
        assert run.energy.residual <= 10e-7
