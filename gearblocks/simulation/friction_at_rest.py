"""Friction and stops at rest: what is stuck at start values, and whether it can carry what balance asks of it."""

from __future__ import annotations

import numpy as np

from gearblocks.errors import SimulationError
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array
from gearblocks.solver.switched_constraints import LockKind, LockPlace, Locks

_ROUNDING = 64 * np.finfo(float).eps  # of the largest speed times the numbers of a row
_OVER = 1e-9  # a held force that exceeds its limit by less, relative to it, is rounding


def by_slips(point: Point) -> Point:
    """The point with modes by slips alone: stuck where there is none, sliding where there is one; closed without a gap."""
    places = point.sim.locks().places
    if not places:
        return point
    locks, modes = point.locks(), point.modes.copy()
    first = point.program.n - locks.rows.shape[1]
    rates = locks.rows @ point.y[first : point.program.n]
    terms = np.abs(locks.rows) @ np.abs(point.y[first : point.program.n])
    for i, place in enumerate(places):
        if place.kind is LockKind.TIE:
            continue
        slip = rates[i] if place.is_stop else locks.slip[i]
        rests = bool(abs(slip) <= _ROUNDING * terms[i])
        if place.is_stop:
            modes[place.hold] = rests and locks.slip[i] <= 0.0
        else:
            rubs = _rubs(point, place, locks, i)
            modes[place.hold] = rubs and rests
            modes[place.slip] = float(np.sign(slip)) if rubs and not rests else 0.0
    return point.at(modes=modes).settled()


def _rubs(point: Point, place: LockPlace, locks: Locks, i: int) -> bool:
    return bool(locks.limits[i, 4] > 0.0) and not (place.free >= 0 and point.modes[place.free] > 0.5)


def judged(found: Point) -> Point | None:
    """None where everything that holds can do so, and nothing has gone through a stop; else the point with the stop
    closed, or with that opened which holds one way only. Raises SimulationError for friction that cannot hold."""
    places = found.sim.locks().places
    if not places:
        return None
    locks, modes = found.locks(), found.modes.copy()
    met = [
        i for i, x in enumerate(places) if x.is_stop and not modes[x.hold] and locks.slip[i] < -_reach(found, locks, i)
    ]
    if met:
        deepest = min(met, key=lambda i: locks.slip[i])
        modes[places[deepest].hold] = 1.0
        return found.at(y=_moved_out(found, locks, deepest), modes=modes).settled()
    turned = [i for i, x in enumerate(places) if x.kind is LockKind.TIE and locks.held[i] * modes[x.slip] < 0.0]
    if turned:  # the force of a tie has the other sign
        for i in turned:
            modes[places[i].slip] *= -1.0
        return found.at(modes=modes).settled()
    over = np.array([_excess(locks, i, x.kind) if modes[x.hold] > 0.5 else 0.0 for i, x in enumerate(places)])
    worst = int(np.argmax(over))
    if over[worst] <= _OVER:
        return None
    place, (lower, upper) = places[worst], locks.limits[worst, :2]
    if place.kind is LockKind.LOSS or (np.isfinite(lower) and np.isfinite(upper)):
        raise _too_weak(found, worst, locks)
    modes[place.hold] = 0.0
    modes[place.slip] = 0.0 if place.is_stop else 1.0 if locks.held[worst] < lower else -1.0
    return found.at(modes=modes).settled()


def _excess(locks: Locks, i: int, kind: LockKind) -> float:
    """By how much a held force exceeds its limits, relative to the largest force around."""
    lower, upper = locks.limits[i, :2]
    size = float(np.abs(locks.held).max())
    if kind is LockKind.LOSS:
        over = locks.excess[i]
    else:
        over = max(locks.held[i] - upper, lower - locks.held[i])
        size = max(size, min(abs(lower), abs(upper)))
    return float(over / size) if over > 0.0 and size > 0.0 else 0.0


def _reach(point: Point, locks: Locks, i: int) -> float:
    """What rounding makes of a gap of 0."""
    first = point.program.n - locks.rows.shape[1]
    return float(_ROUNDING * np.abs(locks.rows[i]).max() * np.abs(point.y[:first]).max(initial=0.0))


def _moved_out(point: Point, locks: Locks, i: int) -> Array:
    """The state with the gap of a stop at 0, all that holds kept where it is."""
    from gearblocks.solver.motion import motion

    whole, holding = motion(point), [*point.holding(), i]
    wanted = np.zeros(len(holding))
    wanted[-1] = -locks.slip[i]
    turned = np.linalg.lstsq(locks.rows[holding], wanted, rcond=1e-9)[0]
    y = point.y.copy()
    y[whole.coordinates] += whole.B @ turned
    y[whole.angles] += whole.E @ turned
    return y


def _too_weak(point: Point, i: int, locks: Locks) -> SimulationError:
    component = point.program.switches[point.sim.locks().places[i].slip].component
    held, limit = abs(locks.held[i]), abs(locks.limits[i, 1 if locks.held[i] > 0 else 0])
    if point.sim.locks().places[i].kind is LockKind.LOSS:
        limit = max(0.0, held - locks.excess[i])
    return SimulationError(
        point.t, component,
        f"there is no static equilibrium: it would have to carry {held:.6g} to stay stuck, and holds {limit:.6g}",
        "raise its capacity, lower the load, or let it start with a slip",
    )  # fmt: skip
