"""Events of which a transient below the tolerance tells when: implicit steps do not follow it, and yet what comes after the
event is no longer fast."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

T = np.linspace(0.0, 3.0, 31)


@pytest.mark.parametrize("method", ["rodas", "auto"])
@pytest.mark.parametrize(
    ("width", "rtol"),
    [(1e-3, 1e-3), (1e-4, 1e-4), (1e-5, 1e-5), (1e-5, 1e-6), (1e-6, 1e-6), (1e-7, 1e-6), (1e-7, 1e-8)],
)
def test_a_saturated_command_is_right_where_its_line_is_narrower_than_the_tolerance(
    width: float, rtol: float, method: str
) -> None:
    """The set point falls through the speed: the command leaves its line at once, up to 10 ms late before."""
    rig = gb.Drivetrain("line")
    target = 0.834 + 0.417 * gb.sin(4.0 * gb.time)
    line = gb.Torque(tau=sp.Max(0, sp.Min(1.2, 0.6 + 1.2 / width * (target - gb.sense("j.w")))))
    rig.chain(rig.add("line", line), rig.add("j", gb.Inertia(J=1.53)))
    model = gb.build(rig)
    fine = gb.simulate(model, t=T, rtol=1e-11, method="dp5")["j.w"]
    run = gb.simulate(model, t=T, rtol=rtol, method=method)
    off = np.abs(run["j.w"] - fine).max()
    assert off < rtol, off / rtol  # 0.1 seen; up to 4700
    assert run.stats.steps < 80
