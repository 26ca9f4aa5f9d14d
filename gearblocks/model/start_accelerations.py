"""Start accelerations: open start values are found so that bodies have the accelerations that they give.

    a(phi_0, w_0) = a_0    in the open start angles of the bodies themselves; then of all; then in the open start speeds

Newton's method with differences, minimum norm where several do. Needs a compiled model. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gearblocks.codegen.program import RigidRow
from gearblocks.errors import ModelError
from gearblocks.language.block import Block, start_fields
from gearblocks.language.fields import ACCELERATION, SPEED
from gearblocks.model.start_values import is_open, start_of, started
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array
from gearblocks.train.graph import Train

_ROUNDS, _STEP, _MET = 50, 1e-6, 1e-9


def fit_accelerations(model: Model, train: Train) -> None:
    """Chooses the open start values (into model.values). ModelError for accelerations that no choice gives."""
    rows = [row for row in model.program.bodies if row.gives_acceleration]
    if not rows:
        return
    blocks: dict[str, Block] = {c.path: c.block for c in train.components}
    asked = np.array([start_of(blocks[row.component], ACCELERATION) for row in rows], dtype=np.float64)
    groups = model.program.groups
    for row in rows:
        if any(groups[g].speed < 0 for g in row.groups):
            raise ModelError(
                f"'{row.component}': {_field(blocks, row)} is given, but something moves this shaft, or it has no inertia, so "
                "that its acceleration follows; leave it out"
            )
    own = [groups[g].angle for row in rows for g in row.groups]
    angles = [g.angle for g in groups if g.angle >= 0]
    speeds = [g.speed for g in groups if g.speed >= 0]
    for tried in (own, angles, [*angles, *speeds]):
        open_ones = [i for i in dict.fromkeys(tried) if is_open(model.program, blocks, i)]
        found, left = _newton(model, rows, asked, open_ones)
        if not left:
            model.values.setflags(write=True)
            model.values[:] = found
            model.values.setflags(write=False)
            return
    there = _accelerations(model, rows, model.values)
    raise ModelError([
        f"'{row.component}': {_field(blocks, row)} = {wanted:.9g}, but its acceleration at the start is {x:.9g}, and no start "
        f"angle or speed that is open changes that as asked; leave one out, or {_field(blocks, row)}"
        for row, wanted, x in zip(rows, asked, there, strict=True)
    ])  # fmt: skip


def _field(blocks: dict[str, Block], row: RigidRow) -> str:
    return start_fields(type(blocks[row.component]))[ACCELERATION]


def _newton(model: Model, rows: Sequence[RigidRow], asked: Array, free: list[int]) -> tuple[Array, bool]:
    """The parameters, and whether an acceleration is not met."""
    values = model.values.copy()
    found = _accelerations(model, rows, values)
    for _ in range(_ROUNDS):
        if (np.abs(found - asked) <= _MET * np.maximum(np.abs(asked), np.abs(found))).all():
            return values, False
        columns = []
        for i in free:
            moved = values.copy()
            moved[i] += _STEP
            columns.append((_accelerations(model, rows, moved) - found) / _STEP)
        if not columns or not np.isfinite(columns).all():
            break
        slopes = np.column_stack(columns)
        step = np.linalg.lstsq(slopes, asked - found, rcond=1e-10)[0]
        values[free] += step
        found = _accelerations(model, rows, values)
        if not np.isfinite(found).all() or not step.any():
            break
    return values, not (np.abs(found - asked) <= 1e-7 * np.maximum(np.abs(asked), np.abs(found))).all()


def _accelerations(model: Model, rows: Sequence[RigidRow], values: Array) -> Array:
    """Accelerations of the bodies at t = 0; NaN where the start fails."""
    first = next(i for i, s in enumerate(model.program.states) if s.kind == SPEED)
    with started(model, values) as sim:
        if sim is None:
            return np.full(len(rows), np.nan)
        y, modes = sim.state(), sim.modes()
        rates = sim.probe(0.0, y, modes, "rates")
    return np.array([sum(f * rates[first + g] for g, f in zip(r.groups, r.factors, strict=True)) for r in rows])
