"""Static starts: where accelerations and the rates of further states vanish, from an undeformed train at rest.

Where balance leaves something open (gaps without load, rotations that nothing answers), it is asked whether the start of a run
is in balance: bodies at the angles of that start, what lies between them (planets, lumps) where forces put it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import least_squares, root

from tests.random.expressions import walk
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array

NEAR = 1e-8  # of the largest angle: how far balance may move a start


def at_rest(dynamics: Any, y: Array, given: Array | None) -> Array:
    """The state y moved into its equilibrium. given: angles of the bodies of the train at the start of a run."""
    s, cut = dynamics.s, dynamics.cut
    moving = s.train.initial == "static" and any(
        n.op in ("time", "table", "input") for p in s.train.parts for n in walk(p.fields)
    )
    if moving or not dynamics.plain or s.has_massless or np.any(y[cut[1] : cut[2]]):
        raise NoEvidenceError("this static start")
    free = np.r_[0 : cut[0], cut[3] : cut[4]]
    asked = np.r_[cut[1] : cut[2], cut[3] : cut[4]]

    def rates(x: Array) -> Array:
        moved = y.copy()
        moved[free] = x
        return np.asarray(dynamics(0.0, moved)[asked])

    found = root(rates, y[free], tol=1e-14)
    size = max(float(np.abs(rates(y[free])).max()), 1e-300)
    x = np.asarray(found.x)
    slope = _slope(rates, x)
    if not np.abs(rates(x)).max() <= 1e-9 * size or not np.linalg.cond(slope) <= 1e10:
        if given is None or s.extra:
            raise NoEvidenceError("a static start that balance leaves open")
        x = _balanced(dynamics, rates, given, size)
    y = y.copy()
    y[free] = x
    return y


def _slope(rates: Callable[[Array], Array], x: Array) -> Array:
    return np.array([(rates(x + h) - rates(x - h)) / 2e-6 for h in 1e-6 * np.eye(len(x))]).T


def _balanced(dynamics: Any, rates: Callable[[Array], Array], given: Array, size: float) -> Array:
    """All angles for those of the bodies, which must be in balance but for rotations that nothing answers."""
    s = dynamics.s
    elastic = np.array(s.elastic).reshape(-1, len(s.node_names)) @ s.N
    own = [s.index[p.node("a")] for p in s.train.bodies][: len(given)]
    bodies = s.N[own]
    turns = _open(elastic)
    weights = turns @ np.linalg.solve(turns.T @ s.M @ turns, turns.T @ s.M) if turns.size else np.zeros_like(s.M)

    def force(x: Array) -> Array:  # steady accelerations of what turns freely are balance as well
        a = rates(x)
        return np.asarray(s.M @ (a - weights @ a))

    between = _open(bodies)
    x = np.linalg.lstsq(bodies, given, rcond=1e-12)[0]
    if between.size:  # as little deformed as may be, and from there by forces
        x = x - between @ np.linalg.lstsq(elastic @ between, elastic @ x, rcond=1e-10)[0]
    least = size * float(np.abs(s.M).max())
    for moves in (between, np.eye(len(x))):  # first what no body shows; then everything, by hardly anything
        if moves.size and np.abs(force(x)).max() > 1e-13 * least:
            x = _least(force, x, moves)
    moved = np.abs(bodies @ x - given).max()
    if not np.abs(force(x)).max() <= 1e-9 * least or not moved <= NEAR * max(float(np.abs(given).max()), 1e-3):
        raise NoEvidenceError("a static start that is not the run's")
    return np.asarray(x)


def _least(force: Callable[[Array], Array], x: Array, moves: Array) -> Array:
    """The angles of least forces in some directions; gaps that close on the way ask for small steps."""
    z = np.zeros(moves.shape[1])
    found = least_squares(lambda z: force(x + moves @ z), z, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return np.asarray(x + moves @ found.x)


def _open(rows: Array) -> Array:
    """Directions that no row sees."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, size, V = np.linalg.svd(rows)
    rank = int((size > 1e-10 * max(float(size.max()), 1e-300)).sum())
    return np.asarray(V[rank:].T)
