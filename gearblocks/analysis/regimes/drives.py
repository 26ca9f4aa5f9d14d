"""How often the drives of a train repeat with its section: dy/dt at (t, y) and at (t + m T, y) are one for all t and y.

Knows nothing of motions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.strobe import Strobe

Array = NDArray[np.float64]

_INSTANTS = 40
_ALIKE = 1e-9  # of what time alone changes of a rate


def drive_periods(seen: Strobe, y: Array, longest: int, after: int) -> int:
    """The number of periods of the section after which all drives repeat, at most `longest`; 0: none that small."""
    times = seen.period * (after + np.random.default_rng(0).uniform(0.0, 100.0, _INSTANTS))
    full = np.zeros(seen.model.program.n_total)
    full[: seen.n] = y
    with seen.opened(y) as sim:

        def rates(shift: float) -> Array:
            found = []
            for t in (times + shift).tolist():
                modes = sim.probe(t, full, None, "modes")
                found.append(sim.probe(t, full, modes, "rates")[: seen.n])
            return np.array(found)

        here = rates(0.0)
        change = np.ptp(here, axis=0)
        floor = 1e-12 * np.abs(here).max(axis=0)
        for m in range(1, longest + 1):
            if (np.abs(rates(m * seen.period) - here) <= np.maximum(_ALIKE * change, floor)).all():
                return m
    return 0
