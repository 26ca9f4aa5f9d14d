"""Trials far longer than a contact, whose damping grows with the force: they run away, and say nothing of what rounds."""

import numpy as np
import pytest

import gearblocks as gb


def _rig(restitution, J, w):
    """A dog clutch that closes on a speed difference, while the play before it is open: bodies at rest are set in motion."""
    rig = gb.Drivetrain("runs away")
    contact = gb.HuntCrossley(restitution=restitution)
    drive, between = rig.add("drive", gb.Inertia(J=0.56, w0=w)), rig.add("between", gb.Inertia(J=0.16))
    lash = rig.add("lash", gb.Lash(k=3216.0, half_gap=0.01, contact_damping=contact))
    dog = rig.add("dog", gb.DogClutch(engaged=gb.Heaviside(gb.time - 0.988)))
    rig.chain(drive, lash, between, dog, rig.add("load", gb.Inertia(J=J)))
    rig.connect(rig.add("late", gb.Torque(tau=56.3 * gb.Heaviside(gb.time - 1.32))).flange, drive.b)
    return rig


@pytest.mark.parametrize(("restitution", "J", "w"), [(0.75, 0.31, 13.3), (0.5, 1.0, 5.0), (0.9, 0.05, -20.0)])
@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_what_a_dog_clutch_sets_in_motion_behind_a_play(restitution, J, w, method):
    model = gb.build(_rig(restitution, J, w))
    true = gb.simulate(model, t=[0.0, 1.1, 1.2], method="rodas", rtol=1e-9)
    for rtol in (1e-4, 1e-6):
        run = gb.simulate(model, t=[0.0, 1.1, 1.2], method=method, rtol=rtol)
        off = max(np.abs(run[f"{name}.w"] - true[f"{name}.w"]).max() for name in ("drive", "load"))
        assert off <= 300 * rtol * abs(w)  # 20 contacts magnify
