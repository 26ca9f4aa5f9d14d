"""Switched constraints of a program: rows G over the speeds, offsets of the Delassus matrix, force bounds and switches.

slip = G v; a constraint force lambda acts on the speeds as G' lambda. Knows nothing of which constraints are active.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import accumulate, combinations
from typing import TYPE_CHECKING, Any

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.codegen.function import Column
from gearblocks.codegen.jacobian.sparsity import Pattern, eliminate
from gearblocks.codegen.operands import Assignment, Operand, Role, Statement
from gearblocks.codegen.parts import VALUES, SwitchedConstraint, SwitchedConstraints
from gearblocks.errors import ModelError
from gearblocks.laws.rational import exact_value
from gearblocks.train.disjoint_sets import DisjointSets

if TYPE_CHECKING:
    from gearblocks.codegen.batch import BatchCode
    from gearblocks.codegen.function import Function
    from gearblocks.codegen.generator import Generator
    from gearblocks.laws.switched_constraints import ConstraintLaw

_MOST_COUPLED = 64  # constraints that one acts on, on average, up to which the Delassus matrix is worth being sparse


def lay_out_switched_constraints(g: Generator, at: int) -> int:
    """Fills g.constraints; the Delassus matrix lies in par[] from `at`, where it is constant. Returns the next free offset."""
    constraints = g.constraints
    for number, batch in enumerate(g.assembly.batches):
        for name, constraint in batch.law.constraints.items():
            constraints.first[number, name] = len(constraints.members)
            constraints.members += [
                SwitchedConstraint(path, constraint, row) for path, row in _rows_of(g, number, constraint)
            ]
    if not constraints.members:
        return at
    constraints.lossy = any(x.law.share is not None for x in constraints.members)
    constraints.dynamic = g.dependent is not None and g.dependent.dynamic
    constraints.prescribed = g.dependent is not None and g.dependent.prescribed
    constraints.driven = g.dependent is not None and g.dependent.driven
    constraints.rows = [_over_speeds(g, x.row) for x in constraints.members]
    reached = sorted({speed for row in constraints.rows for speed in row})
    place = {speed: i for i, speed in enumerate(reached)}
    constraints.speeds = reached
    constraints.rows = [{place[s]: v for s, v in sorted(row.items())} for row in constraints.rows]
    if constraints.dynamic:  # a gain that is not known yet may lead anywhere
        constraints.speeds = list(range(g.assembly.n_speeds))
        constraints.rows = [dict.fromkeys(constraints.speeds, 0.0) for _ in constraints.rows]
        return at
    constraints.matrix0 = at
    constraints.pattern = None if constraints.lossy else _sparse_pattern(g, constraints)
    return at + constraints.matrix_size


def _sparse_pattern(g: Generator, constraints: SwitchedConstraints) -> Pattern | None:
    """The pattern of the factors of W = G M^-1 G': constraints are coupled that reach a speed, or a block of M, in common.
    None where most are coupled with each other."""
    blocks: DisjointSets[int] = DisjointSets()
    if g.dependent is not None and not g.assembly.plain:
        mass = g.dependent.pattern
        for k, speed in enumerate(mass.order):
            for place in range(mass.start[k], mass.start[k + 1]):
                blocks.join(speed, mass.order[mass.row[place]])
    reaching: dict[int, set[int]] = {}
    for i, row in enumerate(constraints.rows):
        for column in row:
            reaching.setdefault(blocks.root(constraints.speeds[column]), set()).add(i)
    n = len(constraints.members)
    if sum(len(x) ** 2 for x in reaching.values()) > _MOST_COUPLED * n:
        return None
    pattern = eliminate(n, (pair for x in reaching.values() for pair in combinations(sorted(x), 2)))
    return pattern if len(pattern.row) <= _MOST_COUPLED * n else None


def _rows_of(g: Generator, number: int, constraint: ConstraintLaw) -> list[tuple[str, dict[int, float]]]:
    """Path and row over the group speeds of each instance of a switched constraint."""
    batch = g.assembly.batches[number]
    found = []
    for e, component in enumerate(batch.components):
        path = g.assembly.train.components[component].path
        row: dict[int, Any] = {}
        for flange, expr in constraint.row.items():
            group = batch.groups[flange][e]
            if group == GROUND_GROUP:
                continue
            value = exact_value(expr, {s: v[e] for s, v in batch.exact.items()}) * batch.gains[flange][e]
            row[group] = row.get(group, 0) + value
            _refuse_massless(g, path, flange, group)
        found.append((path, {k: float(v) for k, v in row.items() if v}))
    return found


def _refuse_massless(g: Generator, path: str, flange: str, group: int) -> None:
    a = g.assembly
    reached, dependent = {group}, {f.group: f for f in a.dependent_groups}
    while reached:
        group = reached.pop()
        if a.n_speeds <= group < a.n_speeds + a.n_massless:
            raise ModelError(
                f"'{path}': friction that can stick, or a stop, acts at '{flange}' on a shaft without inertia, which it "
                f"could not hold by itself; put an Inertia there"
            )
        reached.update(dependent[group].sources if group in dependent else ())


def _over_speeds(g: Generator, row: dict[int, float]) -> dict[int, float]:
    """A row over group speeds as one over the speeds of independent groups (constant gains)."""
    a, motion = g.assembly, g.dependent
    rest, order = dict(row), {f.group: i for i, f in enumerate(a.dependent_groups)}
    for group in sorted((x for x in range(a.n_groups) if x in order), key=lambda x: -order[x]):
        if group in rest and motion is not None:
            value, i = rest.pop(group), order[group]
            for k in range(motion.start[i], motion.start[i + 1]):
                rest[motion.index[k]] = rest.get(motion.index[k], 0.0) + value * motion.value[k]
    sizes = max((abs(v) for v in row.values()), default=0.0)
    return {k: v for k, v in rest.items() if abs(v) > 1e-14 * sizes}


def switched_constraint_functions(g: Generator, code: BatchCode) -> None:
    """Function of a batch for the force bounds of its switched constraints; offsets of their switches and states."""
    values = code.constraint_values
    assignments: list[Assignment] = []
    unlimited: list[Statement] = []
    for name, constraint in code.law.constraints.items():
        first = g.constraints.first[code.number, name]
        if constraint.share is not None:
            skew = Assignment(Operand(Role.SKEWS, first, instance=True), "=", values[name]["share"])
            g.keep("skews", code.function("skews", [skew]))
        keys = [f"loss_{i}" for i in range(4)] if constraint.losses else ["lower", "upper", "forward", "backward"]
        for k, key in enumerate((*keys, "engaged")):
            place = Operand(Role.FORCE_BOUNDS, f"{VALUES} * ({first} + e) + {k}")
            source = "restitution" if constraint.is_stop and key == "forward" else key
            if source in values[name]:
                assignments.append(Assignment(place, "=", values[name][source]))
            else:
                unlimited.append(Statement(place, "=", "-HUGE_VAL" if key == "lower" else "HUGE_VAL"))
        for e in range(code.n):
            _place(g, code, g.constraints.members[first + e], constraint, e)
            if constraint.partner is not None:
                g.constraints.members[first + e].partner = g.constraints.first[code.number, constraint.partner] + e
    function: Function = code.function("force_bounds", assignments)
    function.body += unlimited
    g.keep("force_bounds", function)


def constraint_torques(code: BatchCode) -> Iterator[tuple[str, Any]]:
    """(flange, torque) of the constraint forces."""
    for constraint in code.law.constraints.values():
        force = code.law.pool.symbol("constraint_force", constraint.name, f"held_{constraint.name}".rstrip("_"))
        for flange, c in constraint.row.items():
            if flange in code.batch.groups:
                yield flange, c * force
        if constraint.share is not None and constraint.partner is not None:
            share = code.constraint_values[constraint.name]["share"]
            for flange, c in code.law.constraints[constraint.partner].row.items():
                if flange in code.batch.groups:
                    yield flange, -c * share * force


def _place(g: Generator, code: BatchCode, member: SwitchedConstraint, constraint: ConstraintLaw, e: int) -> None:
    switches = {what: code.offsets.switches[number] + e for what, number in constraint.switches.items()}
    member.slip = next(iter(switches.values()))
    member.active, member.free = switches["hold"], switches.get("engaged", -1)
    member.heat = 1 + g.lay.state0[code.number, code.law.heat] + e if code.law.heat else 0
    for key in ("impulse", "impacts"):
        state = getattr(constraint, key)
        if state is not None:
            setattr(member, key, g.lay.state0[code.number, state] + e)


def loss_offsets(g: Generator) -> None:
    """Offsets of the ledger entries that impacts add their losses to."""
    offsets = {x.component: x.offset for x in g.integrals if x.part == "loss"}
    for member in g.constraints.members:
        member.loss = offsets.get(member.path, -1)


def constraint_columns(constraints: SwitchedConstraints) -> dict[str, Column]:
    """The rows as tables: start of each, columns, values, and the speed of each column."""
    start = [0]
    for row in constraints.rows:
        start.append(start[-1] + len(row))
    return {
        "start": Column("constraint_start", tuple(start)),
        "column": Column("constraint_column", tuple(c for row in constraints.rows for c in row)),
        "value": Column("constraint_value", tuple(v for row in constraints.rows for v in row.values())),
        "speed": Column("constraint_speed", tuple(constraints.speeds)),
    }


def delassus_columns(constraints: SwitchedConstraints) -> list[Column]:
    """Tables of the pattern of the factors of the Delassus matrix, by columns and by rows (gb_symmetric_pattern)."""
    pattern = constraints.pattern
    if pattern is None:
        return []
    rows: list[list[tuple[int, int]]] = [[] for _ in pattern.order]
    for k in range(len(pattern.order)):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            rows[pattern.row[place]].append((k, place))
    row_start = tuple(accumulate((len(row) for row in rows), initial=0))
    return [
        Column("delassus_order", pattern.order),
        Column("delassus_step", pattern.steps),
        Column("delassus_start", pattern.start),
        Column("delassus_row", pattern.row),
        Column("delassus_row_start", row_start),
        Column("delassus_row_column", tuple(k for row in rows for k, _ in row)),
        Column("delassus_row_place", tuple(place for row in rows for _, place in row)),
    ]
