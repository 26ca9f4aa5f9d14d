"""Active set of switched constraints at rest: which are active at start values, and whether their constraint forces are
within their bounds once balance is found.

    |G v| <= rounding   ->   active (friction stuck, stop closed);    lower <= lambda <= upper for all that are active

At rest the constraint forces follow from balance alone, so that one which exceeds its bounds makes its constraint inactive
(a stop, a freewheel) or shows that there is no equilibrium (friction). Knows nothing of how balance is found.
"""

from __future__ import annotations

import numpy as np

from gearblocks.errors import SimulationError
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array
from gearblocks.solver.switched_constraints import ConstraintKind, ConstraintsAtPoint, ConstraintSwitches

_ROUNDING = 64 * np.finfo(float).eps  # of the sum of |G| |v| of a row
_EXCESS = 1e-9  # a constraint force that exceeds its bound by less, relative to it, is rounding


def by_slips(point: Point) -> Point:
    """The point with modes by slips alone: friction is stuck where there is none, a stop is closed without a gap."""
    places = point.sim.constraints().constraints
    if not places:
        return point
    constraints, modes = point.constraints(), point.modes.copy()
    first = point.program.n - constraints.rows.shape[1]
    slips = constraints.rows @ point.y[first : point.program.n]
    terms = np.abs(constraints.rows) @ np.abs(point.y[first : point.program.n])
    for i, place in enumerate(places):
        if place.kind is ConstraintKind.TIE:
            continue
        slip = slips[i] if place.is_stop else constraints.slip[i]
        still = bool(abs(slip) <= _ROUNDING * terms[i])
        if place.is_stop:
            modes[place.active] = still and constraints.slip[i] <= 0.0
        else:
            engaged = _is_engaged(point, place, constraints, i)
            modes[place.active] = engaged and still
            modes[place.slip] = float(np.sign(slip)) if engaged and not still else 0.0
    return point.at(modes=modes).settled()


def _is_engaged(point: Point, place: ConstraintSwitches, constraints: ConstraintsAtPoint, i: int) -> bool:
    """Whether friction is pressed at all."""
    return bool(constraints.bounds[i, 4] > 0.0) and not (place.free >= 0 and point.modes[place.free] > 0.5)


def judged(found: Point) -> Point | None:
    """None where all constraint forces lie within their bounds and no gap is negative; else the point with that stop
    closed, or with the constraint inactive that has one bound and exceeds it. SimulationError for friction that does."""
    places = found.sim.constraints().constraints
    if not places:
        return None
    constraints, modes = found.constraints(), found.modes.copy()
    overlaps = [i for i, place in enumerate(places) if _overlaps(found, place, constraints, i)]
    if overlaps:
        deepest = min(overlaps, key=lambda i: constraints.slip[i])
        modes[places[deepest].active] = 1.0
        return found.at(y=_without_overlap(found, constraints, deepest), modes=modes).settled()
    reversed_ties = [
        i for i, x in enumerate(places) if x.kind is ConstraintKind.TIE and constraints.forces[i] * modes[x.slip] < 0.0
    ]
    if reversed_ties:  # the constraint force of a lossy tie has the other sign than its mode
        for i in reversed_ties:
            modes[places[i].slip] *= -1.0
        return found.at(modes=modes).settled()
    excess = np.array([_excess(constraints, i, x.kind) if modes[x.active] > 0.5 else 0.0 for i, x in enumerate(places)])
    worst = int(np.argmax(excess))
    if excess[worst] <= _EXCESS:
        return None
    place, (lower, upper) = places[worst], constraints.bounds[worst, :2]
    if place.kind is ConstraintKind.LOSS or (np.isfinite(lower) and np.isfinite(upper)):
        raise _too_weak(found, worst, constraints)
    modes[place.active] = 0.0
    modes[place.slip] = 0.0 if place.is_stop else 1.0 if constraints.forces[worst] < lower else -1.0
    return found.at(modes=modes).settled()


def _excess(constraints: ConstraintsAtPoint, i: int, kind: ConstraintKind) -> float:
    """By how much a constraint force exceeds its bounds, relative to the largest one around."""
    lower, upper = constraints.bounds[i, :2]
    size = float(np.abs(constraints.forces).max())
    if kind is ConstraintKind.LOSS:
        excess = constraints.violation[i]
    else:
        excess = max(constraints.forces[i] - upper, lower - constraints.forces[i])
        size = max(size, min(abs(lower), abs(upper)))
    return float(excess / size) if excess > 0.0 and size > 0.0 else 0.0


def _overlaps(point: Point, place: ConstraintSwitches, constraints: ConstraintsAtPoint, i: int) -> bool:
    """Whether a stop is open with a gap below 0, by more than rounding makes of a gap of 0."""
    if not place.is_stop or point.modes[place.active]:
        return False
    first = point.program.n - constraints.rows.shape[1]
    size = np.abs(constraints.rows[i]).max() * np.abs(point.y[:first]).max(initial=0.0)
    return bool(constraints.slip[i] < -_ROUNDING * size)


def _without_overlap(point: Point, constraints: ConstraintsAtPoint, i: int) -> Array:
    """The state with the gap of a stop at 0 and the slips of the active set unchanged: the smallest such displacement."""
    from gearblocks.solver.kinematics import kinematics

    kin, active = kinematics(point), [*point.holding(), i]
    wanted = np.zeros(len(active))
    wanted[-1] = -constraints.slip[i]
    moved = np.linalg.lstsq(constraints.rows[active], wanted, rcond=1e-9)[0]
    y = point.y.copy()
    y[kin.coordinates] += kin.B @ moved
    y[kin.angles] += kin.E @ moved
    return y


def _too_weak(point: Point, i: int, constraints: ConstraintsAtPoint) -> SimulationError:
    component = point.program.switches[point.sim.constraints().constraints[i].slip].component
    held, limit = abs(constraints.forces[i]), abs(constraints.bounds[i, 1 if constraints.forces[i] > 0 else 0])
    if point.sim.constraints().constraints[i].kind is ConstraintKind.LOSS:
        limit = max(0.0, held - constraints.violation[i])
    return SimulationError(
        point.t, component,
        f"there is no static equilibrium: it would have to carry {held:.6g} to stay stuck, and holds {limit:.6g}",
        "raise its capacity, lower the load, or let it start with a slip",
    )  # fmt: skip
