"""Mass matrix over the independent groups, and dependent groups as tables and functions.

w = velocity bias + sum gain w[source]; torques go back by the same gains; the inertia J of a dependent group with the row
g over the independent speeds adds J g' g to the mass matrix. Knows nothing of laws besides prescribed motions.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from gearblocks.assembly.kinematics import PrescribedRow
from gearblocks.codegen.function import Argument, column
from gearblocks.codegen.jacobian.sparsity import eliminate
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.codegen.parts import Call, DependentGroups
from gearblocks.errors import ModelError

if TYPE_CHECKING:
    from gearblocks.codegen.batch import BatchCode
    from gearblocks.codegen.function import Function
    from gearblocks.codegen.generator import Generator


def lay_out_mass(g: Generator, at: int) -> int:
    """Fills g.dependent and places inertias, mobilities and (where it is constant) the factored mass matrix in par[]."""
    dependent = g.dependent = DependentGroups(g.assembly.dependent_groups)
    laws = {i: batch.law for batch in g.assembly.batches for i in batch.components}
    for i, f in enumerate(dependent.members):
        if f.row is not None:
            dependent.index += f.row.groups
            dependent.value += [float(c) for c in f.row.groups.values()]
        else:
            assert f.prescribed is not None
            motion = laws[f.prescribed.component].prescribed[f.prescribed.number]
            dependent.driven |= motion.velocity_bias != 0
            gains = motion.gains
            for flange, (group, factor) in f.prescribed.factors.items():
                if gains[flange].is_number:
                    dependent.value.append(float(gains[flange]) * float(factor))
                else:
                    dependent.dynamic = True
                    dependent.gain_index[i, flange] = len(dependent.value)
                    dependent.value.append(0.0)
                dependent.index.append(group)
        dependent.start.append(len(dependent.index))
    for i, f in enumerate(dependent.members):
        if f.prescribed is not None:  # gains of flanges at the ground: their reactions need them
            for flange, gain in laws[f.prescribed.component].prescribed[f.prescribed.number].gains.items():
                if flange not in f.prescribed.factors and not gain.is_number:
                    dependent.gain_index[i, flange] = len(dependent.value)
                    dependent.value.append(0.0)
    _rows(g, dependent)
    _matrix(g, dependent)
    g.mass = at
    return at + g.assembly.n_groups + g.assembly.n_speeds + len(dependent.pattern.row)


def _rows(g: Generator, dependent: DependentGroups) -> None:
    """Rows of the dependent groups with inertia, and of those that such groups depend on."""
    order = {f.group: i for i, f in enumerate(dependent.members)}
    wanted = {order[group] for group in g.assembly.with_inertia if group in order}
    for i in reversed(range(len(dependent.members))):
        if i in wanted:
            wanted.update(order[s] for s in dependent.members[i].sources if s in order)
    for i in sorted(wanted):
        row: dict[int, int] = {}
        for k in range(dependent.start[i], dependent.start[i + 1]):
            source = dependent.index[k]
            inner = dependent.rows[order[source]] if source in order else {source: -1}
            for speed, entry in inner.items():
                if speed not in row:
                    row[speed] = dependent.n_entries
                    dependent.n_entries += 1
                dependent.steps.append((row[speed], k, entry))
        dependent.rows[i] = row


def _matrix(g: Generator, dependent: DependentGroups) -> None:
    """The pattern of the mass matrix and what dependent groups add to it."""
    pairs: set[tuple[int, int]] = set()
    with_inertia = [(i, f.group) for i, f in enumerate(dependent.members) if f.group in g.assembly.with_inertia]
    for i, _ in with_inertia:
        speeds = sorted(dependent.rows[i])
        pairs.update((a, b) for n, a in enumerate(speeds) for b in speeds[:n])
    pattern = dependent.pattern = eliminate(g.assembly.n_speeds, pairs)
    for i, group in with_inertia:
        row = dependent.rows[i]
        for a in row:
            dependent.products.append((-1 - pattern.steps[a], row[a], row[a], group))
            dependent.products += [
                (pattern.place(a, b), row[a], row[b], group) for b in row if pattern.steps[b] > pattern.steps[a]
            ]


def check_mobility(g: Generator, used: Iterable[tuple[int, str]]) -> list[int]:
    """The groups whose mobility laws read. ModelError for those where it is infinite or changes with the state."""
    groups: dict[int, str] = dict(used)
    a, dependent = g.assembly, g.dependent
    if dependent is None:
        return []
    changing = _changing(dependent)
    order = {f.group: i for i, f in enumerate(dependent.members)}
    for group, path in groups.items():
        if a.n_speeds <= group < a.n_speeds + a.n_massless:
            raise ModelError(
                f"'{path}': damping_ratio needs inertia on both sides, and a shaft beside has none; give c"
            )
        touched = set(dependent.rows.get(order[group], ())) if group in order else {group}
        if touched & changing or (
            group in order and order[group] not in dependent.rows and dependent.members[order[group]].sources
        ):
            raise ModelError(
                f"'{path}': damping_ratio needs a constant inertia beside, and this one changes with the position; give c"
            )
    return sorted(groups)


def _changing(dependent: DependentGroups) -> set[int]:
    """Speeds whose inertia changes with the state."""
    changing = set(dependent.gain_index.values())
    moved: set[int] = set()
    found: set[int] = set()
    order = {f.group: i for i, f in enumerate(dependent.members)}
    for i in range(len(dependent.members)):
        entries = range(dependent.start[i], dependent.start[i + 1])
        if any(k in changing or order.get(dependent.index[k]) in moved for k in entries):
            moved.add(i)
            found.update(dependent.rows.get(i, ()))
    return found


# -- prescribed motions -----------------------------------------------------------------------------------------------


def prescribed_motion_functions(g: Generator, code: BatchCode) -> None:
    """Functions of the prescribed motions of one batch: angle, gains, velocity and acceleration bias."""
    dependent = g.dependent
    if dependent is None:
        return
    mine = {
        (f.prescribed.component, f.prescribed.number): (i, f.prescribed)
        for i, f in enumerate(dependent.members)
        if f.prescribed
    }
    for number, motion in enumerate(code.prescribed):
        rows = [mine[c, number] for c in code.batch.components]
        scale = column(f"{code.batch.name}_scale{number}", [float(d.scale) for _, d in rows])
        place = column(f"{code.batch.name}_dependent{number}", [i for i, _ in rows])
        factor = Argument("double", f"scale{number}", scale)
        args = [factor, Argument("int", f"dependent{number}", place)]
        if motion.angle is not None:
            groups = column(f"{code.batch.name}_into{number}", [d.group for _, d in rows])
            into = Argument("int", f"into{number}", groups)
            target = Operand(Role.ANGLES, into.name)
            angle = _scaled(code, f"prescribed_angle{number}", target, motion.angle, [factor, into])
            g.keep("prescribed_angles", angle)
            for e, (i, _) in enumerate(rows):
                dependent.calls[i] = Call(angle, e)
        if motion.velocity_bias != 0:
            target = Operand(Role.VELOCITY_BIASES, f"dependent{number}")
            g.keep("prescribed_values", _scaled(code, f"velocity_bias{number}", target, motion.velocity_bias, args))
            dependent.supplied += [i for i, _ in rows]
        if motion.acceleration_bias != 0:
            target = Operand(Role.ACCELERATION_BIASES, f"dependent{number}")
            g.keep(
                "acceleration_biases",
                _scaled(code, f"acceleration_bias{number}", target, motion.acceleration_bias, args),
            )
        for flange, gain in motion.gains.items():
            if not gain.is_number:
                _gain_function(g, code, number, flange, gain, rows)


def _scaled(code: BatchCode, name: str, target: Operand, expr: Any, arguments: list[Argument]) -> Function:
    """A function that stores an expression times the first of its arguments."""
    function = code.function(name, [Assignment(target, "=", expr, factor=arguments[0].name)])
    function.take(arguments)
    return function


def _gain_function(
    g: Generator, code: BatchCode, number: int, flange: str, gain: Any, rows: list[tuple[int, PrescribedRow]]
) -> None:  # fmt: skip
    assert g.dependent is not None
    indices = [g.dependent.gain_index[i, flange] for i, _ in rows]
    factors = [float(d.factors[flange][1] if flange in d.factors else d.scale) for _, d in rows]
    name = f"{code.batch.name}_{number}_{flange}"
    args = [
        Argument("double", f"factor{number}", column(f"{name}_factor", factors)),
        Argument("int", f"gain_index{number}", column(f"{name}_gain_index", indices)),
    ]
    target = Operand(Role.GAINS, f"gain_index{number}")
    g.keep("prescribed_values", _scaled(code, f"prescribed_gain{number}_{flange}", target, gain, args))
