"""rodas beside light bodies under a load over time: rounding counts as far as a step shows it, and no further."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 2.0, 101)


def _driven(*behind: gb.Block) -> gb.Drivetrain:
    """A sine drives a train of a lossy gear, light bodies and shafts."""
    rig = gb.Drivetrain("light")
    parts = [rig.add(f"part{i}", block) for i, block in enumerate(behind)]
    rig.chain(
        rig.add("drive", gb.Torque(tau=10 * gb.sin(5 * gb.time))), rig.add("a", gb.Inertia(J=0.1, w0=50.0)), *parts,
        rig.add("b", gb.Inertia(J=1.0, w0=20.0)),
    )  # fmt: skip
    return rig


def _error(rig: gb.Drivetrain, rtol: float) -> float:
    model = gb.build(rig)
    fine = gb.simulate(model, t=T, rtol=1e-11, method="dp8")["b.w"]
    run = gb.simulate(model, t=T, rtol=rtol, method="rodas")
    return float(np.abs(run["b.w"] - fine).max() / np.abs(fine).max() / rtol)


GEAR = gb.LossyGear(ratio=2.5, efficiency=(0.9, 0.8))


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_a_light_body_tied_to_a_heavy_one_rounds_as_that_one(rtol: float) -> None:
    """At the gear its acceleration is that of the other side, whatever its own inertia makes of forces that cancel."""
    assert _error(_driven(GEAR, gb.Inertia(J=1e-5), gb.Shaft(k=800.0, c=1.0)), rtol) < 1.0  # 0.1 seen; 77 to 16000


@pytest.mark.parametrize("rtol", [1e-8, 1e-10])
def test_what_the_states_make_of_a_rate_is_no_noise_of_its_slope_in_time(rtol: float) -> None:
    """The stiffness of a shaft, which a light body feels at every instant alike."""
    assert _error(_driven(gb.Shaft(k=500.0, c=2.0), gb.Inertia(J=1e-5), GEAR), rtol) < 1.0  # 0.07 seen; 70 and 1500
