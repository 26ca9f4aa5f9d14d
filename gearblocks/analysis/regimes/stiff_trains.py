"""A word before long work: regimes are told by explicit steps, whose length the fastest motion of a train limits.

Knows nothing of regimes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gearblocks.analysis.regimes.sizes import REACH
from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.errors import SimulationError, warn
from gearblocks.solver.fast_modes import fast_modes
from gearblocks.solver.point import Point

_MANY = 5e4  # steps in a period: five hundred periods with a tangent take minutes


def warn_if_stiff(seen: Strobe, initial: Any) -> None:
    """Warns where the fastest motion at the start asks for very many steps in a period, and names where it is."""
    try:
        y = seen.start(initial)
        full = np.zeros(seen.model.program.n_total)
        full[: seen.n] = y
        with seen.opened(y) as sim:
            modes = sim.probe(0.0, full, None, "modes")
            fastest = next(iter(fast_modes(Point(sim, seen.model.program, 0.0, full, modes))), None)
    except (SimulationError, np.linalg.LinAlgError):  # the run says so itself
        return
    steps = 0.0 if fastest is None else seen.period * fastest.rate / REACH
    if fastest is None or steps < _MANY:
        return
    where = f" of '{fastest.element}'" if fastest.element else ""
    warn(
        f"the fastest motion{where}, {fastest.rate:.0e} 1/s, asks for about {steps:.0e} steps in each period of the section: "
        "derivatives beside a motion are told by explicit steps, for which this train is stiff; if that motion does not "
        "matter here, take away what makes it (rig.effects() lists what can go: a compliance becomes rigid), or this takes long"
    )
