"""Trains whose motions are known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb


@pytest.fixture(scope="session")
def oscillator() -> Callable[..., gb.Drivetrain]:
    """x'' + c x' + k x = torque(drive, x, x'), with the drive as a Parameter of 1 rad/s."""

    def made(torque: Callable[[Any, Any, Any], Any], k: float = 1.0, c: float = 0.05, **start: float) -> gb.Drivetrain:
        rig = gb.Drivetrain("oscillator")
        drive = gb.Parameter("drive", 1.0, "rad/s")
        source = gb.Torque(tau=torque(drive, gb.sense("disc.phi"), gb.sense("disc.w")))
        disc = gb.Inertia(J=1.0, **start)
        rig.chain(
            rig.add("source", source), rig.add("disc", disc), rig.add("spring", gb.Shaft(k=k, c=c)),
            rig.add("ground", gb.Fixed()),
        )  # fmt: skip
        return rig

    return made
