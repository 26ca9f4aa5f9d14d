"""Relative start values: deflections of compliant elements and their rates at the start, phi_rel0 and w_rel0.

    phi_b - phi_a = phi_rel0,    w_b - w_a = w_rel0

Start values of bodies that nothing gives follow: in what is joined with such an element by others, these begin undeformed and
at no rate, as far as given values leave them free, and the first free body begins at 0. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gearblocks.codegen.program import Program, RigidRow
from gearblocks.language.block import Block, start_fields
from gearblocks.language.fields import ANGLE, RELATIVE_ANGLE, RELATIVE_SPEED, SPEED
from gearblocks.model.start_values import start_of
from gearblocks.solver.rigid_motion import AGREES, RigidMotion
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.graph import Train


def solve_relative(program: Program, train: Train, values: dict[str, float]) -> Iterator[str]:
    """Solves for the open start values (into `values`); yields contradictions."""
    if not any(row.gives_angle or row.gives_speed for row in program.deflections):
        return
    blocks: dict[str, Block] = {c.path: c.block for c in train.components}
    for of, relative in ((ANGLE, RELATIVE_ANGLE), (SPEED, RELATIVE_SPEED)):
        if any(_gives(row, of) for row in program.deflections):
            yield from _solve(program, blocks, values, of, relative)


def _gives(row: RigidRow, of: str) -> bool:
    return row.gives_angle if of == ANGLE else row.gives_speed


def _solve(
    program: Program, blocks: dict[str, Block], values: dict[str, float], of: str, relative: str
) -> Iterator[str]:
    joined = DisjointSets[int]()
    for row in (*program.deflections, *program.bodies):
        for g in row.groups[1:]:
            joined.join(g, row.groups[0])
    asked = [row for row in program.deflections if _gives(row, of)]
    problems = [*_without_start(program, asked, blocks, of, relative)]
    yield from problems
    if problems:
        return
    parts = {joined.root(g) for row in asked for g in row.groups}
    near = [row for row in program.bodies if any(joined.root(g) in parts for g in row.groups)]
    motion = RigidMotion()
    given = [row for row in near if _gives(row, of)]
    for row in given:
        wanted = start_of(blocks[row.component], of)
        if wanted is not None:  # contradictions between bodies are said elsewhere
            motion.take(_factors(row), wanted - _constant(program, row, values, of))
    for row in asked:
        wanted, field = start_of(blocks[row.component], relative), start_fields(type(blocks[row.component]))[relative]
        constant = _constant(program, row, values, of)
        if wanted is not None and not motion.take(_factors(row), wanted - constant):
            follows = motion.left(_factors(row))[1] + constant
            if abs(follows - wanted) > AGREES * max(abs(follows), abs(wanted)):
                others = ", ".join(f"'{other.component}'" for other in (*given, *asked) if other is not row)
                yield (
                    f"'{row.component}': {field} = {wanted!r} contradicts the {follows:.9g} that follows from the start values "
                    f"of {others}; leave one of them out"
                )
    for row in program.deflections:
        if not _gives(row, of) and any(joined.root(g) in parts for g in row.groups):
            motion.take(
                _factors(row),
                -_constant(program, row, values, of) + (_rest(program, row, values) if of == ANGLE else 0.0),
            )
    for row in near:
        motion.take(_factors(row), -_constant(program, row, values, of))
    for g in {g for row in near for g in row.groups}:
        start = program.groups[g]
        offset, gain = (start.angle, start.angle_gain) if of == ANGLE else (start.speed, start.speed_gain)
        value = motion.value({g: 1.0})
        if offset >= 0 and value is not None and program.parameters[offset].start:
            values[program.parameters[offset].path] = value * gain


def _without_start(
    program: Program, rows: list[RigidRow], blocks: Mapping[str, Block], of: str, relative: str
) -> Iterator[str]:  # fmt: skip
    """Elements at a shaft that has no start value of its own."""
    for row in rows:
        starts = [program.groups[g] for g in row.groups]
        if any((s.angle if of == ANGLE else s.speed) < 0 or (s.speed < 0 and not s.prescribed) for s in starts):
            field = start_fields(type(blocks[row.component]))[relative]
            yield (
                f"'{row.component}': {field}: one of its ends has no start value of its own, as something moves it, or it "
                f"has no inertia; give the start values of the bodies beside in place of {field}"
            )


def _factors(row: RigidRow) -> dict[int, float]:
    return dict(zip(row.groups, row.factors, strict=True))


def _constant(program: Program, row: RigidRow, values: Mapping[str, float], of: str) -> float:
    """What angles of the ground add to a deflection."""
    if of != ANGLE:
        return 0.0
    paths = (program.parameters[o].path for o in row.offsets)
    return sum(f * values.get(path, 0.0) for path, f in zip(paths, row.offset_factors, strict=True))


def _rest(program: Program, row: RigidRow, values: Mapping[str, float]) -> float:
    """The deflection at which an element carries nothing, as far as a number says it."""
    rest, lower, upper = (
        values.get(program.parameters[i].path, 0.0) if i >= 0 else 0.0 for i in (row.rest, row.lower, row.upper)
    )
    return row.scale * (rest + max(lower, 0.0) + min(upper, 0.0))
