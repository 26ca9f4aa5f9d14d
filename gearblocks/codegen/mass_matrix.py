"""Mass matrix over the independent groups, and dependent groups as tables and functions.

w = velocity bias + sum gain w[source]; torques go back by the same gains; the inertia J of a dependent group with the row
g over the independent speeds adds J g' g to the mass matrix. Knows nothing of laws besides prescribed motions.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from gearblocks.assembly.kinematics import Driven
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
    """Fills g.motion and places inertias, mobilities and (where it is constant) the factored mass matrix in par[]."""
    motion = g.motion = DependentGroups(g.assembly.followers)
    laws = {i: batch.law for batch in g.assembly.batches for i in batch.components}
    for i, f in enumerate(motion.followers):
        if f.row is not None:
            motion.index += f.row.groups
            motion.value += [float(c) for c in f.row.groups.values()]
        else:
            assert f.drive is not None
            gains = laws[f.drive.component].drives[f.drive.number].gains
            for flange, (group, factor) in f.drive.factors.items():
                if gains[flange].is_number:
                    motion.value.append(float(gains[flange]) * float(factor))
                else:
                    motion.dynamic = True
                    motion.slots[i, flange] = len(motion.value)
                    motion.value.append(0.0)
                motion.index.append(group)
        motion.start.append(len(motion.index))
    for i, f in enumerate(motion.followers):
        if f.drive is not None:  # gains of flanges that the ground holds: their reactions need them
            for flange, gain in laws[f.drive.component].drives[f.drive.number].gains.items():
                if flange not in f.drive.factors and not gain.is_number:
                    motion.slots[i, flange] = len(motion.value)
                    motion.value.append(0.0)
    _rows(g, motion)
    _matrix(g, motion)
    g.mass = at
    return at + g.assembly.n_groups + g.assembly.n_speeds + len(motion.pattern.row)


def _rows(g: Generator, motion: DependentGroups) -> None:
    """Rows of the dependent groups with inertia, and of those that such groups follow from."""
    order = {f.group: i for i, f in enumerate(motion.followers)}
    wanted = {order[group] for group in g.assembly.massive if group in order}
    for i in reversed(range(len(motion.followers))):
        if i in wanted:
            wanted.update(order[s] for s in motion.followers[i].sources if s in order)
    for i in sorted(wanted):
        row: dict[int, int] = {}
        for k in range(motion.start[i], motion.start[i + 1]):
            source = motion.index[k]
            inner = motion.rows[order[source]] if source in order else {source: -1}
            for speed, entry in inner.items():
                if speed not in row:
                    row[speed] = motion.n_entries
                    motion.n_entries += 1
                motion.steps.append((row[speed], k, entry))
        motion.rows[i] = row


def _matrix(g: Generator, motion: DependentGroups) -> None:
    """The pattern of the mass matrix and what dependent groups add to it."""
    pairs: set[tuple[int, int]] = set()
    massive = [(i, f.group) for i, f in enumerate(motion.followers) if f.group in g.assembly.massive]
    for i, _ in massive:
        speeds = sorted(motion.rows[i])
        pairs.update((a, b) for n, a in enumerate(speeds) for b in speeds[:n])
    pattern = motion.pattern = eliminate(g.assembly.n_speeds, pairs)
    for i, group in massive:
        row = motion.rows[i]
        for a in row:
            motion.products.append((-1 - pattern.steps[a], row[a], row[a], group))
            motion.products += [
                (pattern.place(a, b), row[a], row[b], group) for b in row if pattern.steps[b] > pattern.steps[a]
            ]


def check_mobility(g: Generator, used: Iterable[tuple[int, str]]) -> list[int]:
    """The groups whose mobility laws read. ModelError for those where it is infinite or changes with the state."""
    groups: dict[int, str] = dict(used)
    a, motion = g.assembly, g.motion
    if motion is None:
        return []
    changing = _changing(motion)
    order = {f.group: i for i, f in enumerate(motion.followers)}
    for group, path in groups.items():
        if a.n_speeds <= group < a.n_speeds + a.n_hidden:
            raise ModelError(
                f"'{path}': damping_ratio needs inertia on both sides, and a shaft beside has none; give c"
            )
        touched = set(motion.rows.get(order[group], ())) if group in order else {group}
        if touched & changing or (
            group in order and order[group] not in motion.rows and motion.followers[order[group]].sources
        ):
            raise ModelError(
                f"'{path}': damping_ratio needs a constant inertia beside, and this one changes with the position; give c"
            )
    return sorted(groups)


def _changing(motion: DependentGroups) -> set[int]:
    """Speeds whose inertia changes with the state."""
    slots = set(motion.slots.values())
    moved: set[int] = set()
    found: set[int] = set()
    order = {f.group: i for i, f in enumerate(motion.followers)}
    for i in range(len(motion.followers)):
        entries = range(motion.start[i], motion.start[i + 1])
        if any(k in slots or order.get(motion.index[k]) in moved for k in entries):
            moved.add(i)
            found.update(motion.rows.get(i, ()))
    return found


# -- prescribed motions -----------------------------------------------------------------------------------------------


def prescribed_motion_functions(g: Generator, code: BatchCode) -> None:
    """Functions of the prescribed motions of one batch: angle, gains, velocity and acceleration bias."""
    motion = g.motion
    if motion is None:
        return
    mine = {(f.drive.component, f.drive.number): (i, f.drive) for i, f in enumerate(motion.followers) if f.drive}
    for number, drive in enumerate(code.drives):
        rows = [mine[c, number] for c in code.batch.components]
        scale = column(f"{code.batch.name}_scale{number}", [float(d.scale) for _, d in rows])
        place = column(f"{code.batch.name}_follower{number}", [i for i, _ in rows])
        factor = Argument("double", f"scale{number}", scale)
        args = [factor, Argument("int", f"follower{number}", place)]
        if drive.angle is not None:
            groups = column(f"{code.batch.name}_into{number}", [d.group for _, d in rows])
            into = Argument("int", f"into{number}", groups)
            target = Operand(Role.ANGLES, into.name)
            angle = _scaled(code, f"drive_angle{number}", target, drive.angle, [factor, into])
            g.keep("drive_angles", angle)
            for e, (i, _) in enumerate(rows):
                motion.calls[i] = Call(angle, e)
        if drive.bias != 0:
            target = Operand(Role.VELOCITY_BIASES, f"follower{number}")
            g.keep("drive_values", _scaled(code, f"drive_bias{number}", target, drive.bias, args))
            motion.powered += [i for i, _ in rows]
        if drive.surplus != 0:
            target = Operand(Role.ACCELERATION_BIASES, f"follower{number}")
            g.keep("drive_surplus", _scaled(code, f"drive_surplus{number}", target, drive.surplus, args))
        for flange, gain in drive.gains.items():
            if not gain.is_number:
                _gain_function(g, code, number, flange, gain, rows)


def _scaled(code: BatchCode, name: str, target: Operand, expr: Any, arguments: list[Argument]) -> Function:
    """A function that stores an expression times the first of its arguments."""
    function = code.function(name, [Assignment(target, "=", expr, factor=arguments[0].name)])
    function.take(arguments)
    return function


def _gain_function(
    g: Generator, code: BatchCode, number: int, flange: str, gain: Any, rows: list[tuple[int, Driven]]
) -> None:  # fmt: skip
    assert g.motion is not None
    slots = [g.motion.slots[i, flange] for i, _ in rows]
    factors = [float(d.factors[flange][1] if flange in d.factors else d.scale) for _, d in rows]
    name = f"{code.batch.name}_{number}_{flange}"
    args = [
        Argument("double", f"factor{number}", column(f"{name}_factor", factors)),
        Argument("int", f"slot{number}", column(f"{name}_slot", slots)),
    ]
    target = Operand(Role.GAINS, f"slot{number}")
    g.keep("drive_values", _scaled(code, f"drive_gain{number}_{flange}", target, gain, args))
