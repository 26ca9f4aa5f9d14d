"""Rigid groups, numbered by what determines their speed: independent (a state), massless (a balance of torques),
prescribed, or dependent on others; and which component owns the start values of each.

    speeds of all groups = K speeds of the independent and massless ones + prescribed

A group is independent where it has inertia itself or moves inertia through groups that depend on it. Knows nothing of
relative coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.kinematics import DependentGroup, GroupRow, Kinematics, PrescribedRow, solve_dependent
from gearblocks.assembly.massless_groups import MasslessGroups, floating
from gearblocks.assembly.tables import GROUND_GROUP, Assembly, ExactValues, StartValues
from gearblocks.errors import ModelError
from gearblocks.language.block import given_start, places_of, start_fields
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.fields import ANGLE, SPEED, Unseen
from gearblocks.language.signals import Parameter
from gearblocks.laws.algebraic_friction import TIE, ForceUnknown, tie_row
from gearblocks.laws.law import Law
from gearblocks.laws.prescribed_motion import PrescribedMotion
from gearblocks.laws.rational import Exact, exact, exact_value, over
from gearblocks.train.graph import Component, Train
from gearblocks.train.structure import Kind
from gearblocks.train.translational import takes_start
from gearblocks.train.values import numbers_of


@dataclass(slots=True)
class Bodies:
    """Nodes with a body: present (inertia not zero) or empty (J = 0). zeros: numbers that make inertias zero."""

    present: list[int] = field(default_factory=list)
    empty: list[int] = field(default_factory=list)
    zeros: set[tuple[str, float]] = field(default_factory=set)


def inertias(train: Train, laws: Iterable[Law]) -> Bodies:
    """Where there is inertia, by the numbers that the blocks have now."""
    found = Bodies()
    heavy: set[tuple[Kind, Any]] = set()  # kinds, and inertias of theirs that are made of numbers other than zero
    for c, kind, law in zip(train.components, train.kinds, laws, strict=True):
        for place, inertia in bodies_of(c, law):
            if (kind, inertia) not in heavy:
                values = _numbers_in(inertia, c, law)
                if values and all(v != 0 for _, v in values.values()):
                    heavy.add((kind, inertia))
                elif inertia.xreplace({x: v for x, (_, v) in values.items()}) == 0:
                    found.zeros.update((path, v) for path, v in values.values() if v == 0)
                    found.empty.append(c.nodes[place])
                    continue
            found.present.append(c.nodes[place])
    return found


def bodies_of(c: Component, law: Law) -> Iterable[tuple[int, Any]]:
    """Number of the flange and inertia of each body of a component."""
    names = tuple(type(c.block).flanges) if law.bodies else ()
    return ((names.index(flange), inertia) for flange, inertia in law.bodies)


def _numbers_in(inertia: Any, c: Component, law: Law) -> dict[Any, tuple[str, float]]:
    """Path and value of each symbol of an inertia."""
    numbers: dict[str, Any] = {}
    values: dict[Any, tuple[str, float]] = {}
    for symbol in inertia.free_symbols:
        meaning = law.pool.roles[symbol]
        if meaning.role == "shared":
            values[symbol] = meaning.of.name, meaning.of.si
            continue
        if not numbers:
            numbers = {path: value for path, value, _ in numbers_of(c.block, "")}
        value = numbers[meaning.of]
        if isinstance(value, Expr):
            value = evaluate(value, lambda leaf: leaf.args[0].si)
        values[symbol] = f"{c.path}.{meaning.of}", float(value.si if isinstance(value, Parameter) else value)
    return values


# -- numbers of groups ------------------------------------------------------------------------------------------------


def number_groups(assembly: Assembly, laws: list[Law], bodies: Bodies, known: Sequence[ExactValues] | None) -> None:
    """Numbers the groups that are not grounded and finds the dependent ones. known: exact values by component, or None:
    floating massless groups stay as they are."""
    groups, train = assembly.groups, assembly.train
    roots = dict.fromkeys(groups.find(node)[0] for node in (*bodies.present, *bodies.empty, *range(train.n_nodes)))
    free = [r for r in roots if r not in groups.grounded]
    with_inertia = {groups.find(node)[0] for node in bodies.present}
    given = _given_starts(assembly, laws)
    unseen = {groups.find(node)[0] for node in _unseen_nodes(train)}
    reluctance = {r: (int(r not in unseen), int(r in given), int(r in with_inertia)) for r in free}
    ground_angles = {path: groups.held_angles[r][0] for r, path in groups.grounded.items() if path is not None}
    kinematics = solve_dependent(_rows(assembly), _prescribed(assembly, laws), reluctance, ground_angles)
    for row, new in zip(groups.unmerged, kinematics.new, strict=True):
        if new:
            groups.independent.append(row)
        else:
            groups.redundant.append(row)
    dependent = kinematics.dependent
    moving_inertia = set(with_inertia)  # groups that move inertia, their own or that of dependent ones
    for f in reversed(kinematics.dependent_groups):
        if f.group in moving_inertia:
            moving_inertia.update(f.sources)
    independent = [r for r in free if r not in dependent and r in moving_inertia]
    massless = [r for r in free if r not in dependent and r not in moving_inertia]
    parts = {} if known is None else _floating_parts(assembly, laws, known, massless, kinematics, given)
    massless = [parts.get(r, r) for r in massless]
    prescribed = [f.group for f in kinematics.dependent_groups if f.prescribed is not None and f.prescribed.by_speed]
    others = [f.group for f in kinematics.dependent_groups if f.group not in set(prescribed)]
    number = {r: i for i, r in enumerate((*independent, *massless, *prescribed, *others))}
    assembly.n_groups, assembly.n_speeds = len(number), len(independent)
    assembly.n_massless, assembly.n_prescribed = len(massless), len(prescribed)
    assembly.with_inertia = frozenset(number[r] for r in with_inertia if r in number)
    assembly.floating = {number[part]: number[r] for r, part in parts.items()}
    bases = {g for f in kinematics.dependent_groups[: len(parts)] for g in f.sources if g < train.n_nodes}
    assembly.floating_bases = frozenset(number[g] - len(independent) for g in bases)
    assembly.dependent_groups = [_renumbered(f, number) for f in kinematics.dependent_groups]
    for node in range(train.n_nodes):
        root, gain = groups.find(node)
        assembly.group_of_node.append((GROUND_GROUP if root in groups.grounded else number[root], gain))
        if root in groups.grounded:
            assembly.ground_offset[node] = groups.grounded[root]


def _unseen_nodes(train: Train) -> Iterable[int]:
    """Nodes that the assembly added."""
    for c in train.components:
        for place in places_of(type(c.block), Unseen):
            yield c.nodes[place]


def _floating_parts(
    assembly: Assembly, laws: list[Law], known: Sequence[ExactValues], massless: list[int], kinematics: Kinematics,
    given: Mapping[int, str],
) -> dict[int, int]:  # fmt: skip
    """Makes floating groups dependent, each on those that stand for it and on a part of its own; by root: the number of its
    part."""
    groups = MasslessGroups(assembly.groups, massless, kinematics.dependent_groups)
    rows = floating(groups, assembly.train.components, laws, known)
    bound = {g for r, row in rows.items() for g in (r, *row)} & given.keys()
    if bound:
        raise ModelError(
            f"the shaft of '{given[min(bound)]}' has no inertia and is damped only against others without: springs give its "
            f"angle; leave its start value out, or give it J > 0"
        )
    parts = {r: assembly.train.n_nodes + r for r in rows}
    kinematics.dependent_groups[:0] = [DependentGroup(r, Combination({**row, parts[r]: 1})) for r, row in rows.items()]
    return parts


def _renumbered(f: DependentGroup, number: dict[int, int]) -> DependentGroup:
    if f.row is not None:
        f.row.groups = {number[g]: c for g, c in f.row.groups.items()}
        return DependentGroup(number[f.group], f.row)
    assert f.prescribed is not None
    d = f.prescribed
    factors = {name: (number[g], c) for name, (g, c) in d.factors.items()}
    return DependentGroup(number[f.group], None, replace(d, group=number[d.group], factors=factors))


def _rows(assembly: Assembly) -> Iterable[GroupRow]:
    """Rigid constraints that union-find could not take, over the roots of groups."""
    groups = assembly.groups
    for row in groups.unmerged:
        coefficients: dict[int, Exact] = {}
        offsets: dict[str, Exact] = {}
        grounded = False
        for node, c in row.coefficients.items():
            root, gain = groups.find(node)
            if root in groups.grounded:
                path = groups.grounded[root]
                grounded = True
                if path is not None:
                    offsets[path] = offsets.get(path, 0) + c * gain
            else:
                coefficients[root] = coefficients.get(root, 0) + c * gain
        yield GroupRow(
            row.component, {g: c for g, c in coefficients.items() if c}, {p: c for p, c in offsets.items() if c},
            grounded,
        )  # fmt: skip


def _prescribed(assembly: Assembly, laws: list[Law]) -> Iterable[PrescribedRow]:
    """Prescribed motions over the roots of groups."""
    groups = assembly.groups
    for index, (c, law) in enumerate(zip(assembly.train.components, laws, strict=True)):
        if not law.prescribed:
            continue
        nodes = dict(zip(type(c.block).flanges, c.nodes, strict=True))
        for number, motion in enumerate(law.prescribed):
            root, gain = groups.find(nodes[motion.flange])
            if root in groups.grounded:
                holder = groups.held_angles[root][1]
                raise ModelError(
                    f"'{c.path}' prescribes the motion of a shaft that '{holder}' holds; leave one of them out"
                )
            scale = over(1, gain)
            factors = {}
            for flange in motion.gains:
                source, its = groups.find(nodes[flange])
                if source not in groups.grounded:
                    factors[flange] = source, its * scale
            own = _own_gain(motion, root, factors)
            scale = over(scale, 1 - own)
            factors = {f: (g, over(x, 1 - own)) for f, (g, x) in factors.items() if g != root or not own}
            yield PrescribedRow(index, number, c.path, root, scale, factors, motion.angle is None, own != 0)


def _own_gain(motion: PrescribedMotion, root: int, factors: Mapping[str, tuple[int, Exact]]) -> Exact:
    """Gain of a prescribed motion on its own dependent group, through other flanges of that group: 0 where there is none, and
    where it is 1 or no number."""
    same = [f for f, (group, _) in factors.items() if group == root]
    if not all(motion.gains[f].is_number for f in same):
        return 0
    own = sum(exact_value(motion.gains[f], {}) * factors[f][1] for f in same)
    return 0 if own == 1 else own


# -- start values -----------------------------------------------------------------------------------------------------


def _given_starts(assembly: Assembly, laws: list[Law]) -> dict[int, str]:
    """Roots of groups for which a component gives a start angle or speed."""
    found: dict[int, str] = {}
    for c, law in zip(assembly.train.components, laws, strict=True):
        if law.bodies and any(given_start(c.block, of) is not None for of in (ANGLE, SPEED)):
            for place, _ in bodies_of(c, law):
                found.setdefault(assembly.groups.find(c.nodes[place])[0], c.path)
    return found


_Pair: TypeAlias = "tuple[tuple[int, Exact], tuple[int, Exact]]"  # groups with factors


def _through_lossy_ties(pairs: Sequence[_Pair], owners: dict[int, tuple[str, Exact, bool]]) -> None:
    """Groups beside a lossy tie start as the other side does, where only that one is given."""
    changed = True
    while changed:
        changed = False
        for (one, a), (two, b) in (*pairs, *((y, x) for x, y in pairs)):
            path, gain, given = owners.get(one, ("", 1, False))  # none: nothing on it has a start
            if given and not owners.get(two, ("", 1, False))[2]:
                owners[two] = (path, gain * over(-b, a), True)
                changed = True


def lossy_tie_of(c: Component, law: Law) -> Mapping[str, Any]:
    """The row of a lossy tie, whose force may be an unknown; empty without one."""
    tie = law.constraints.get("tie")
    if tie is not None and tie.share is not None:
        return tie.row
    return tie_row(law) if isinstance(type(c.block).flanges.get(TIE), ForceUnknown) else {}


def _lossy_pairs(assembly: Assembly, laws: list[Law]) -> Iterable[tuple[Component, _Pair]]:
    """Components with the two groups of their lossy tie and their factors in it."""
    tied: dict[int, Mapping[str, Any]] = {}
    for c, law in zip(assembly.train.components, laws, strict=True):
        if id(law) not in tied:
            tied[id(law)] = lossy_tie_of(c, law)
        if tied[id(law)]:
            yield from ((c, pair) for pair in _lossy_pair(assembly, c, law, tied[id(law)]))


def _lossy_pair(assembly: Assembly, c: Component, law: Law, tied: Mapping[str, Any]) -> Iterable[_Pair]:
    numbers = {path: value for path, value, _ in numbers_of(c.block, "")}
    nodes = dict(zip(type(c.block).flanges, c.nodes, strict=True))
    row: dict[int, Exact] = {}
    for flange, expr in tied.items():
        values = {x: exact(numbers[law.pool.roles[x].of]) for x in expr.free_symbols}
        group, gain = assembly.group_of_node[nodes[flange]] if nodes[flange] >= 0 else (GROUND_GROUP, 1)
        row[group] = row.get(group, 0) + exact_value(expr, values) * gain
    moving = [(g, v) for g, v in row.items() if g != GROUND_GROUP and v]
    if len(moving) == 2:
        yield moving[0], moving[1]


def start_values(assembly: Assembly, laws: list[Law]) -> list[Any]:
    """For each group without a dependent angle the component that owns its start values (the first that gives them).

    A shaft without any body is named by the first flange at it.
    """
    found: dict[str, dict[int, tuple[str, Exact, bool]]] = {ANGLE: {}, SPEED: {}}
    for c, law in zip(assembly.train.components, laws, strict=True):
        for place, _ in bodies_of(c, law):
            group, gain = assembly.group_of_node[c.nodes[place]]
            for of, owners in found.items():
                value = given_start(c.block, of)
                given = value is not None
                if group == GROUND_GROUP and of == SPEED and isinstance(value, (int, float)) and value != 0:
                    name, flange = start_fields(type(c.block))[of], list(type(c.block).flanges)[place]
                    shown = f"{name} = {value!r} {'m/s' if flange in c.sliders else 'rad/s'}"
                    raise ModelError(f"'{c.path}': {shown}, but a Fixed holds this shaft; leave {name} out")
                if group != GROUND_GROUP and (group not in owners or (given and not owners[group][2])):
                    owner = c.path if takes_start(c.block, of) else f"{c.path}.{list(type(c.block).flanges)[place]}"
                    owners[group] = (owner, gain, given)
    count = assembly.n_speeds + assembly.n_massless + assembly.n_prescribed
    if any(group not in found[ANGLE] for group in range(count)):
        for c in assembly.train.components:
            for name, node in zip(type(c.block).flanges, c.nodes, strict=True):
                group, gain = assembly.group_of_node[node] if node >= 0 else (GROUND_GROUP, 1)
                if group != GROUND_GROUP:
                    for owners in found.values():
                        owners.setdefault(group, (f"{c.path}.{name}", gain, False))
    lossy = [*_lossy_pairs(assembly, laws)]
    for owners in found.values():
        _through_lossy_ties([pair for _, pair in lossy], owners)
    assembly.speed_ties = tuple(pair for c, pair in lossy if TIE in type(c.block).flanges)
    for part, whole in assembly.floating.items():  # a part is named as its shaft
        for owners in found.values():
            owners[part] = owners[whole]
    seen = next(
        (g for g in range(count) if g not in assembly.force_unknowns), 0
    )  # forces have no start angle: any does
    names = [seen if g in assembly.force_unknowns else g for g in range(count)]
    return [StartValues(*found[ANGLE][g][:2], *found[SPEED][g][:2]) for g in names]
