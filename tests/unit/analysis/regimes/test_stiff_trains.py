"""What is said of trains whose fastest motion asks for very many explicit steps."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gearblocks as gb

SECTION = gb.stroboscopic("drive")


def _two_discs(damping: float) -> gb.Drivetrain:
    """A light disc on a shaft whose damping makes it follow at damping/1e-3 1/s."""
    rig, drive = gb.Drivetrain("two discs"), gb.Parameter("drive", 10.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("stub", gb.Shaft(k=1e4, c=damping)), rig.add("light", gb.Inertia(J=1e-3)),
        rig.add("spring", gb.Shaft(k=50.0, c=1.0)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    return rig


@pytest.mark.long
def test_a_stiff_train_is_named_before_long_work() -> None:
    with pytest.warns(
        gb.GearblocksWarning, match=r"the fastest motion of 'stub', 2e\+05 1/s, asks for about 6e\+04 steps"
    ):
        orbit = gb.periodic_orbit(_two_discs(200.0), SECTION, transient=0)
    assert orbit.stable
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lean = gb.periodic_orbit(_two_discs(200.0).without("stub.compliance"), SECTION, transient=0)
        gb.periodic_orbit(_two_discs(20.0), SECTION, transient=0)
    # without it the slow multipliers are the same, to the ratio of the stiffnesses, 50 to 1e4
    assert np.abs(orbit.multipliers[:2]) == pytest.approx(np.abs(lean.multipliers), rel=5e-3)
