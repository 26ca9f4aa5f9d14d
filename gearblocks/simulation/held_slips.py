"""What holds at the start of a train that rolls: ties of lossy gears, and friction and locks by their strength.

    ties: slip = 0 always;   friction: slip = 0 as far as it is engaged, |force| <= strength

Forces that are algebraic (shafts without inertia) have no switched constraint: F and B, the bounds against forward and
backward slip, follow from their event functions there, q - F and -q - B with the force q. Knows nothing of what is held first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gearblocks.codegen.program import AlgebraicSlip, RigidRow
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array
from gearblocks.solver.switched_constraints import ConstraintKind


@dataclass(frozen=True, slots=True)
class Held:
    """Friction, a lock or a stop that may hold a slip: force bounds of one that drives it down and up; stop: between two
    bodies, at a gap."""

    row: RigidRow
    lower: float
    upper: float
    stop: bool = False

    @property
    def strength(self) -> float:
        """The larger of the sizes of both bounds."""
        return max(-self.lower, self.upper)


def ties(point: Point) -> list[RigidRow]:
    """The ties of lossy gears."""
    kinds = (x.kind for x in point.sim.constraints().constraints)
    rows = [row for row, kind in zip(point.program.slips, kinds, strict=True) if kind is ConstraintKind.TIE]
    return rows + [slip.row for slip in point.program.algebraic_slips if slip.tie]


def engaged(point: Point) -> list[Held]:
    """Friction and locks that are pressed, the strongest first, then stops between two bodies."""
    kinds = [x.kind for x in point.sim.constraints().constraints]
    bounds, slips = point.constraints().bounds, point.program.slips
    found = [
        Held(row, float(b[0]), float(b[1]))
        for row, kind, b in zip(slips, kinds, bounds, strict=True)
        if kind is ConstraintKind.FRICTION and b[4] > 0
    ]
    found += _algebraic(point)
    found.sort(key=lambda held: -held.strength)
    stops = [row for row, kind in zip(slips, kinds, strict=True) if kind is ConstraintKind.STOP and len(row.groups) > 1]
    return found + [Held(row, 0.0, np.inf, stop=True) for row in stops]


def _algebraic(point: Point) -> list[Held]:
    """Those whose forces are algebraic; where both sides are bounded each has half of what both can do together."""
    slips = [slip for slip in point.program.algebraic_slips if not slip.tie]
    if not slips:
        return []
    modes = point.modes.copy()
    modes[[i for slip in slips for i in slip.switches[:2] if i >= 0]] = 0.0  # as if stuck
    surfaces, found = point.at(modes=modes).surfaces(), []
    for slip in slips:
        lower, upper = _bounds(slip, surfaces)
        pressed = slip.switches[2] < 0 or point.modes[slip.switches[2]] > 0.5
        if pressed and max(-lower, upper) > 0 and all(point.sim.parameters[i] > 0 for i in slip.pressed):
            found.append(Held(slip.row, lower, upper))
    return found


def _bounds(slip: AlgebraicSlip, surfaces: Array) -> tuple[float, float]:
    """Of a force that drives the slip: what holds it back, and what pushes it on."""
    forward, backward, _ = slip.switches
    if forward >= 0 and backward >= 0:
        half = -float(surfaces[forward] + surfaces[backward]) / 2
        return -half, half
    return (-np.inf if forward < 0 else 0.0), (np.inf if backward < 0 else 0.0)
