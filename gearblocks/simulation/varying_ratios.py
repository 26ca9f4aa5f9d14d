"""Relations whose gains change with the angles, at one point: non-circular pairs, joints, drives on moving housings.

    w_g = sum of K_gj w_j + rate,    q' = sum of k_j w_j + rate      exact at these angles: speeds are linear in speeds
    phi_g = sum of K_gj phi_j + c,   q = sum of k_j phi_j + c        beside them: the tangent, for Newton's method

g: groups that such a relation moves; q: deflections of such pairs with compliance. K by one look at the speeds and deflections
per independent speed. Knows nothing of what a start asks for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gearblocks.codegen.program import GroupStart, Program, RigidRow
from gearblocks.errors import ParameterError
from gearblocks.solver.kinematics import kinds
from gearblocks.solver.point import Point
from gearblocks.solver.structures import Array


@dataclass(frozen=True, slots=True)
class Tangent:
    """A relation at a point. row: over groups, that moved one included; rate: its value at rest, which speeds have to make up
    for; constant: that of the tangent, NaN where an angle is not related."""

    row: RigidRow
    rate: float
    constant: float


@dataclass(frozen=True, slots=True)
class VaryingRatios:
    """groups: what moves groups; deflections: of compliant pairs, by their place among Program.deflections."""

    groups: tuple[Tangent, ...]
    deflections: dict[int, Tangent]


def varies(program: Program) -> bool:
    """Whether there are such relations."""
    return any(g.varying for g in program.groups) or any(row.varying for row in program.deflections)


def varying_ratios(point: Point, vector: Array) -> VaryingRatios:
    """The relations at a point in which the train is at rest; vector: its parameters. ParameterError for a pair beside a shaft
    without inertia, and for a block of a user that does not show its deflection."""
    program = point.program
    found = point.outputs()
    gains = _outputs_by_speed(point, found)
    angles = np.array([_angle(program, start, found, vector) for start in program.groups])
    groups = []
    for g, start in enumerate(program.groups):
        if start.varying:
            at = program.output_numbers[start.output]
            factors = gains[at] / start.output_gain
            related = start.angle < 0
            groups.append(
                _tangent(RigidRow("", (), (), (), ()), {g: 1.0}, -factors, found[at] / start.output_gain,
                         angles[g] if related else np.nan, angles)
            )  # fmt: skip
    deflections = {}
    for i, row in enumerate(program.deflections):
        if row.varying:
            q, rate = (_shown(program, row, name) for name in ("deflection", "deflection_rate"))
            deflections[i] = _tangent(row, {}, gains[rate], -found[rate], -found[q], angles)
    return VaryingRatios(tuple(groups), deflections)


def _tangent(row: RigidRow, own: dict[int, float], gains: Array, rate: float, value: float, angles: Array) -> Tangent:
    """sum of factors phi = constant, sum of factors w = rate; value: what the constant is where all angles are 0."""
    factors = own | {j: float(x) for j, x in enumerate(gains) if x}
    constant = value + sum(x * angles[g] for g, x in factors.items() if g not in own)
    made = row._replace(
        groups=tuple(factors), factors=tuple(factors.values()), offsets=(), offset_factors=(), varying=False
    )
    return Tangent(made, float(rate), float(constant))


def _shown(program: Program, row: RigidRow, name: str) -> int:
    """The number of an output of a compliant pair."""
    at = program.output_numbers.get(f"{row.component}.{name}")
    if at is None or any(_is_massless(program.groups[g]) for g in row.groups):
        why = f"and shows no {name}" if at is None else "beside a shaft without inertia"
        raise ParameterError(
            f"initial: '{row.component}' is a pair whose ratio varies, {why}: a rolling start is not known there; give start "
            "values by name"
        )
    return at


def _is_massless(start: GroupStart) -> bool:
    return start.speed < 0 and not start.prescribed and start.angle >= 0


def _outputs_by_speed(point: Point, at_rest: Array) -> Array:
    """Derivatives of the outputs by the independent speeds, outputs first."""
    v = kinds(point.program)[3]
    gains = np.zeros((len(at_rest), len(v)))
    for j, i in enumerate(v):
        y = point.y.copy()
        y[v] = 0.0
        y[i] = 1.0
        gains[:, j] = point.outputs(y) - at_rest
    return gains


def _angle(program: Program, start: GroupStart, outputs: Array, vector: Array) -> float:
    """The angle of a group."""
    if start.angle >= 0:
        return float(vector[start.angle]) / start.angle_gain
    if not start.output:
        return 0.0
    flange, _, speed = start.output.rpartition(".")
    at = program.output_numbers.get(f"{flange}.{'phi' if speed == 'w' else 's'}")
    return 0.0 if at is None else float(outputs[at]) / start.output_gain  # a force that is an unknown has no angle
