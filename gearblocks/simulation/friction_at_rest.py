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
_VIOLATION = 1e-9  # a constraint force that exceeds its bound by less, relative to it, is rounding


def by_slips(point: Point) -> Point:
    """The point with modes by slips alone: friction is stuck where there is none, a stop is closed without a gap."""
    switched = point.sim.constraints().constraints
    if not switched:
        return point
    constraints, modes = point.constraints(), point.modes.copy()
    first = point.program.n - constraints.rows.shape[1]
    slips = constraints.rows @ point.y[first : point.program.n]
    terms = np.abs(constraints.rows) @ np.abs(point.y[first : point.program.n])
    for i, constraint in enumerate(switched):
        if constraint.kind is ConstraintKind.TIE:
            continue
        slip = slips[i] if constraint.is_stop else constraints.slip[i]
        still = bool(abs(slip) <= _ROUNDING * terms[i])
        if constraint.is_stop:
            modes[constraint.active] = still and constraints.slip[i] <= 0.0
        else:
            engaged = _is_engaged(point, constraint, constraints, i)
            modes[constraint.active] = engaged and still
            modes[constraint.slip] = float(np.sign(slip)) if engaged and not still else 0.0
    return point.at(modes=modes).settled()


def _is_engaged(point: Point, constraint: ConstraintSwitches, constraints: ConstraintsAtPoint, i: int) -> bool:
    """Whether friction is pressed at all."""
    return bool(constraints.bounds[i, 4] > 0.0) and not (constraint.free >= 0 and point.modes[constraint.free] > 0.5)


def judged(found: Point) -> Point | None:
    """None where all constraint forces lie within their bounds and no gap is negative; else the point with that stop
    closed, or with the constraint inactive that has one bound and exceeds it. SimulationError for friction that does."""
    switched = found.sim.constraints().constraints
    if not switched:
        return None
    constraints, modes = found.constraints(), found.modes.copy()
    beyond = overlaps(found)
    if beyond:
        deepest = min(beyond, key=lambda i: constraints.slip[i])
        modes[switched[deepest].active] = 1.0
        return found.at(y=_without_overlap(found, constraints, deepest), modes=modes).settled()
    reversed_ties = [
        i
        for i, x in enumerate(switched)
        if x.kind is ConstraintKind.TIE and constraints.forces[i] * modes[x.slip] < 0.0
    ]
    if reversed_ties:  # the constraint force of a lossy tie has the other sign than its mode
        for i in reversed_ties:
            modes[switched[i].slip] *= -1.0
        return found.at(modes=modes).settled()
    violations = np.array(
        [_violation(constraints, i, x.kind) if modes[x.active] > 0.5 else 0.0 for i, x in enumerate(switched)]
    )
    worst = int(np.argmax(violations))
    if violations[worst] <= _VIOLATION:
        return None
    constraint, (lower, upper) = switched[worst], constraints.bounds[worst, :2]
    if constraint.kind is ConstraintKind.LOSS or (np.isfinite(lower) and np.isfinite(upper)):
        raise _too_weak(found, worst, constraints)
    modes[constraint.active] = 0.0
    modes[constraint.slip] = 0.0 if constraint.is_stop else 1.0 if constraints.forces[worst] < lower else -1.0
    return found.at(modes=modes).settled()


def accelerated_by(point: Point) -> list[tuple[str, str]]:
    """Friction between two shafts that slips ever more or less from this equilibrium on, and in words with what. Its torque
    accelerates what is behind it, which an equilibrium takes for its steady motion."""
    switched = point.sim.constraints().constraints
    if not switched:
        return []
    constraints, found, units = point.constraints(), list[tuple[str, str]](), point.program.output_units
    speeds = slice(point.program.n - constraints.rows.shape[1], point.program.n)
    rates = point.rates()[speeds]
    for i, constraint in enumerate(switched):
        component, slip = point.program.switches[constraint.slip].component, float(constraints.slip[i])
        torque = float(constraints.bounds[i, 2 if slip > 0 else 3])
        slides = not constraint.is_stop and constraint.kind is ConstraintKind.FRICTION
        slides = slides and not point.modes[constraint.active] and _is_engaged(point, constraint, constraints, i)
        terms = np.abs(constraints.rows[i]) @ np.abs(point.y[speeds])
        changes = np.abs(constraints.rows[i] @ rates) > _VIOLATION * (np.abs(constraints.rows[i]) @ np.abs(rates))
        if slides and abs(slip) > _ROUNDING * terms and torque > 0.0 and changes and f"{component}.b.w" in units:
            of = [units.get(f"{component}.{n}", "") for n in ("torque", "w_rel")]
            found.append((component, f"{torque:.6g} {of[0]} at {abs(slip):.6g} {of[1]}"))
    return found


def _violation(constraints: ConstraintsAtPoint, i: int, kind: ConstraintKind) -> float:
    """By how much a constraint force exceeds its bounds, relative to the largest one around."""
    lower, upper = constraints.bounds[i, :2]
    size = float(np.abs(constraints.forces).max())
    if kind is ConstraintKind.LOSS:
        violation = constraints.violation[i]
    else:
        violation = max(constraints.forces[i] - upper, lower - constraints.forces[i])
        size = max(size, min(abs(lower), abs(upper)))
    return float(violation / size) if violation > 0.0 and size > 0.0 else 0.0


def overlaps(point: Point) -> list[int]:
    """The stops that are open with a gap below 0, by more than rounding makes of a gap of 0."""
    switched = point.sim.constraints().constraints
    opened = [i for i, x in enumerate(switched) if x.is_stop and not point.modes[x.active]]
    if not opened:
        return []
    constraints = point.constraints()
    first = point.program.n - constraints.rows.shape[1]
    largest = np.abs(point.y[:first]).max(initial=0.0)
    return [i for i in opened if constraints.slip[i] < -_ROUNDING * np.abs(constraints.rows[i]).max() * largest]


def _without_overlap(point: Point, constraints: ConstraintsAtPoint, i: int) -> Array:
    """The state with the gap of a stop at 0 and the slips of the active set unchanged: the smallest such displacement."""
    from gearblocks.solver.kinematics import kinematics

    kin, active = kinematics(point), [*point.active_set(), i]
    wanted = np.zeros(len(active))
    wanted[-1] = -constraints.slip[i]
    moved = np.linalg.lstsq(constraints.rows[active], wanted, rcond=1e-9)[0]
    y = point.y.copy()
    y[kin.coordinates] += kin.B @ moved
    y[kin.angles] += kin.E @ moved
    return y


def _too_weak(point: Point, i: int, constraints: ConstraintsAtPoint) -> SimulationError:
    component = point.program.switches[point.sim.constraints().constraints[i].slip].component
    force, limit = abs(constraints.forces[i]), abs(constraints.bounds[i, 1 if constraints.forces[i] > 0 else 0])
    if point.sim.constraints().constraints[i].kind is ConstraintKind.LOSS:
        limit = max(0.0, force - constraints.violation[i])
    units = {q.name: q.unit for q in point.program.outputs}
    unit = next((f" {units[x]}" for x in (f"{component}.torque", f"{component}.force") if x in units), "")
    return SimulationError(
        point.t, component,
        f"there is no static equilibrium: it would have to carry {force:.6g}{unit} to stay stuck, and holds {limit:.6g}{unit}",
        "raise its capacity, lower the load, or let it start with a slip",
    )  # fmt: skip
