"""Points of work and precision: one way to run a scene, its errors, and what it took. Knows nothing of what is chosen."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Effort
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]

_LEAST = 4  # runs of a mean
_ALONE = 0.1  # of what is asked: a run that scatters by so little answers alone


@final
@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """One way to run: values of the quantities, their relative errors and what these are uncertain by, shape (Q,); members:
    runs whose mean the values are; scatter: what one of them is uncertain by; stats: of one run without its outputs; failure:
    why it did not come to its end, or ""."""

    effort: Effort
    values: Array
    errors: Array
    noise: Array
    members: int = 1
    scatter: Array | None = None
    stats: Stats = field(default_factory=Stats)
    failure: str = ""

    @property
    def line(self) -> tuple[str, bool]:
        """Method, and whether events are located."""
        return self.effort.method, self.effort.locate

    @property
    def seconds(self) -> float:
        """CPU time of all its runs [s]."""
        return self.members * self.stats.cpu_seconds

    @property
    def rhs_calls(self) -> int:
        """Right-hand sides of all its runs, as many in each."""
        return self.members * self.stats.rhs_calls

    def needed(self, asked: float, which: slice) -> int:
        """How many runs tell the means to so much, relative: (scatter/(asked - bias))^2, the bias as far as it shows; one where
        a run scatters by a tenth of that at most."""
        if self.scatter is None:
            return 1
        bias = np.maximum(self.errors - self.noise, 0.0)[which]
        share = float(np.max(self.scatter[which] / (asked - bias)))
        return 1 if share <= _ALONE else max(_LEAST, math.ceil(share**2))

    def within(self, asked: float, which: slice) -> bool:
        """Whether its errors are at most so much, with what they are uncertain by."""
        return not self.failure and bool((self.errors[which] + self.noise[which] <= asked).all())


@final
@dataclass(frozen=True, slots=True, eq=False)
class Verified:
    """How the reference was verified: by a run of another method, whose quantities differ from it by so much, relative."""

    effort: Effort
    errors: Array
