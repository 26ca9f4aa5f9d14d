"""Compliant elements made stiffer and stiffer tend to the rigid tie, at a cost that does not grow."""

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 1.0, 201)


def _rig(factor, damping_ratio=0.1):
    """Motor, shaft, gear pair, wheel, soft shaft, load; shaft and mesh stiffened at a constant damping ratio."""
    rig = gb.Drivetrain("stiffened")
    mesh = gb.GearMesh(teeth=(20, 30), r_base=(0.02, 0.03), external=True, k=1e6 * factor, damping_ratio=damping_ratio)
    parts = {
        "drive": gb.Torque(tau=5 + 3 * gb.sin(40 * gb.time)), "motor": gb.Inertia(J=0.02),
        "shaft": gb.Shaft(k=1e3 * factor, damping_ratio=damping_ratio), "pinion": gb.Inertia(J=1e-3), "mesh": mesh,
        "wheel": gb.Inertia(J=0.01), "out": gb.Shaft(k=200.0, c=0.05), "load": gb.Inertia(J=0.1),
    }  # fmt: skip
    rig.chain(*(rig.add(name, part) for name, part in parts.items()))
    return rig


def _distance(run, rigid):
    names = ("motor.phi", "motor.w", "wheel.w", "load.phi", "load.w", "out.torque")
    return max(np.abs(run[name] - rigid[name]).max() / np.abs(rigid[name]).max() for name in names)


@pytest.mark.parametrize(
    ("method", "rtol", "damping_ratio"),
    [("rodas", 1e-8, 0.1), ("auto", 1e-8, 0.1), ("auto", 1e-7, 0.1), ("auto", 1e-8, 0.2), ("auto", 1e-9, 0.2)],
)
@pytest.mark.few(1)
def test_the_motion_tends_to_that_of_the_rigid_ties_and_the_steps_stay_as_many(method, rtol, damping_ratio):
    rigid = gb.simulate(_rig(1.0).without("shaft.*", "mesh.*"), t=T, watch=False, rtol=1e-10, method="dp8")
    model, steps = gb.build(_rig(1.0, damping_ratio)), {}
    for factor in (1e3, 1e6, 1e9, 1e12):
        values = {"mesh.k": 1e6 * factor, "shaft.k": 1e3 * factor}
        run = gb.simulate(model, t=T, rtol=rtol, method=method, parameters=values)
        # the deflections, which fall as 1/factor, and some ten steps' worth of tolerance
        assert _distance(run, rigid) < 3.0 / factor + 10 * rtol
        assert np.abs(run["mesh.force"]).max() < 2000.0  # the load's, 5 + 3 N m at 0.02 m, and a start-up swing
        assert run.energy.residual < rtol
        steps[factor] = run.stats.steps + run.stats.rejected
    assert max(steps.values()) < 1.25 * steps[1e3]
