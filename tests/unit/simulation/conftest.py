"""A run made by hand, with everything that a run can hold."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gearblocks.simulation.events import Event
from gearblocks.simulation.records import EnergyLedger, FinalState, Stats
from gearblocks.simulation.trajectory import Trajectory


def _make_run(**changes: Any) -> Trajectory:
    t = np.array([0.0, 0.1, 0.1, 1.0 / 3.0])
    fields: dict[str, Any] = {
        "t": t,
        "columns": {
            "mesh.force": np.array([1.0, 2.0 / 3.0, 5e-324, -1.7976931348623157e308]),
            "mesh.deflection": np.array([0.1, -0.0, 1e-17, 3.0]),
            "wheel.w": np.array([100.0, 100.0, 100.1, np.pi]),
            "planet.sun_mesh[1].force": np.array([1.0, 2.0, 3.0, 4.0]),
        },
        "units": {"mesh.force": "N", "mesh.deflection": "m", "wheel.w": "rad/s", "planet.sun_mesh[1].force": "N"},
        "events": (Event(0.1, "mesh", "state", 1.0, 0.0), Event(0.2, "drive", "time", 0.0, 1.0)),
        "stats": Stats(steps=3, rejected=1, rhs_calls=40, events=2, cpu_seconds=1e-3, method="dp8", why="asked for"),
        "energy": EnergyLedger(
            stored={"motor": 2.0, "mesh": 1.0},
            start=1.0,
            dissipated={"mesh": 0.25, "shaft": 0.75},
            supplied={"drive": 3.0},
            exchanged=16.0,
            largest_stored=4.0,
        ),
        "meta": {"train": "a pair", "method": "dp8", "rtol": 1e-8, "parameters": {"mesh.k": 1.5e8, "stop": math.inf}},
        "final_state": FinalState(1.0 / 3.0, np.array([0.1, 0.2]), np.array([1.0]), "abc"),
    }
    return Trajectory(**(fields | changes))


@pytest.fixture(scope="session")
def make_run() -> Callable[..., Trajectory]:
    """make_run(**changes): that run, some of its fields changed."""
    return _make_run
