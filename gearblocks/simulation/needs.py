"""What is asked of a run between its samples (outputs at times, energies lost, what outputs are along it), and what answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.simulation.events import Events

Array = NDArray[np.float64]


class Along(NamedTuple):
    """What is kept of an output along a run, in the window [after, before] of time [s]; kind: peak, trough, mean, rms or std.
    factor: another output that it is multiplied by."""

    kind: str
    output: str
    after: float
    before: float
    factor: str = ""


@final
@dataclass(frozen=True, slots=True)
class Needs:
    """What is asked of a run: outputs by name and the energy that components (losses) have lost, at times [s]; what outputs
    are along the run; static: outputs in the static equilibrium, excitations at their means."""

    outputs: tuple[str, ...] = ()
    times: tuple[float, ...] = ()
    losses: tuple[str, ...] = ()
    along: tuple[Along, ...] = ()
    static: tuple[str, ...] = ()


class Solution(Protocol):
    """What quantities are measured on (`measured_runs.py`, `sampled_run.py`)."""

    @property
    def events(self) -> Events: ...
    def value(self, output: str, time: float) -> float: ...
    def table(self, outputs: Sequence[str], times: Array) -> Array: ...
    def lost(self, component: str, time: float) -> float: ...
    def along_run(self, wanted: Along) -> float: ...
    def static_value(self, output: str) -> float: ...
