"""An independent reference: equations written anew in numpy, events located, modes by trying every set of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.random.description import Train
from tests.random.reference.dynamics import Dynamics
from tests.random.reference.elements import system_of
from tests.random.reference.given_starts import WrongStartError
from tests.random.reference.integrate import KICKS, Integration
from tests.random.reference.starts import start
from tests.random.reference.switches import NoEvidenceError

RTOL = 1e-11


def reference_motion(
    train: Train,
    t: NDArray[np.float64],
    perturbation: float = 0.0,
    rtol: float = RTOL,
    given: NDArray[np.float64] | None = None,
    draw: int = 0,
    kicks: int = KICKS,
) -> Any:
    """The motion of a train at times t; with a relative perturbation of its start speeds and, all along the run, its state.

    draw: which perturbation of that size; kicks: how many there are beside that of the start. given: angles and speeds of
    the bodies at the start of a run: whether they are as asked is looked at where values do not tell them.
    """
    from tests.random.judge import Motion

    with np.errstate(all="ignore"):
        dynamics = Dynamics(system_of(train))
        integration = Integration(dynamics, rtol, float(t[-1]), perturbation, draw, kicks)
        angles, speeds = integration.run(start(dynamics, perturbation, given, draw), t)
        rises = integration.rises
    own = len(train.bodies)  # composites bring along more
    return Motion(angles[:own], speeds[:own], np.array(integration.modes.jumps), rises)


__all__ = ["KICKS", "NoEvidenceError", "WrongStartError", "reference_motion"]
