"""What a run follows from, besides its model: with it the run can be done again, to the bit.

Knows nothing of what is recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, final

from gearblocks.simulation.events import Events
from gearblocks.simulation.needs import Needs, Solution
from gearblocks.simulation.run_explanation import RunExplanation
from gearblocks.solver.library import Library
from gearblocks.solver.structures import Array, Options


@final
@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What a run follows from, besides its model: parameters, inputs by name, options, start and end [s], start state; again:
    what does it once more; explained: what says why it took its steps."""

    library: Library
    parameters: Array
    inputs: Mapping[str, Any]
    options: Options
    begin: float
    end: float
    y0: Array | None
    again: Callable[[Case, Needs], AbstractContextManager[Solution]] | None = None
    explained: Callable[[str, str, Case, Events], RunExplanation] | None = None
