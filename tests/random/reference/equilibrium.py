"""Static starts: where accelerations and the rates of further states vanish, from an undeformed train at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import root

from tests.random.expressions import walk
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array


def at_rest(dynamics: Any, y: Array) -> Array:
    """The state y moved into its equilibrium."""
    s, cut = dynamics.s, dynamics.cut
    moving = s.train.initial == "static" and any(
        n.op in ("time", "table", "input") for p in s.train.parts for n in walk(p.fields)
    )
    if moving or not dynamics.plain or dynamics.n1 or np.any(y[cut[1] : cut[2]]):
        raise NoEvidenceError("this static start")
    free = np.r_[0 : cut[0], cut[3] : cut[4]]
    asked = np.r_[cut[1] : cut[2], cut[3] : cut[4]]

    def rates(x: Array) -> Array:
        moved = y.copy()
        moved[free] = x
        return np.asarray(dynamics(0.0, moved)[asked])

    found = root(rates, y[free], tol=1e-14)
    size = max(float(np.abs(rates(y[free])).max()), 1e-300)
    slope = np.array([(rates(found.x + h) - rates(found.x)) / 1e-6 for h in 1e-6 * np.eye(len(free))])
    if np.abs(rates(found.x)).max() > 1e-9 * size or np.linalg.cond(slope) > 1e10:
        raise NoEvidenceError("a static start that balance leaves open")
    y = y.copy()
    y[free] = found.x
    return y
