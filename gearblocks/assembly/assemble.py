"""From a train to the tables of its equations: kinds and their laws, groups, coordinates, batches.

All ratios are exact fractions. Numbers of parameters take no part: they are read from the train when a model is made.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gearblocks.assembly.algebraic_friction import algebraic_forces, force_unknowns
from gearblocks.assembly.coordinates import Coordinates
from gearblocks.assembly.elimination import Combination, dependency_order
from gearblocks.assembly.gauged_gears import with_gauged_gears
from gearblocks.assembly.inverted_relations import inverted_relations
from gearblocks.assembly.kinematics import DependentGroup, PrescribedRow
from gearblocks.assembly.rigid_constraints import RigidConstraint, merge
from gearblocks.assembly.rigid_groups import inertias, number_groups, start_values
from gearblocks.assembly.series_friction import with_series_locked
from gearblocks.assembly.tables import GROUND_GROUP, Assembly, Batch, ExactValues, StartValues
from gearblocks.errors import ModelError
from gearblocks.laws.derivation import check_feedback, derive, unlocated
from gearblocks.laws.law import STAGE, Law
from gearblocks.laws.prescribed_motion import is_steady
from gearblocks.laws.rational import Exact, exact, exact_value
from gearblocks.train.graph import GROUND, Component, Train
from gearblocks.train.structure import structure_of
from gearblocks.train.values import numbers_of

__all__ = ["GROUND_GROUP", "Assembly", "Batch", "StartValues", "assemble", "expand_rows"]


def assemble(train: Train, *, reading: bool = False) -> Assembly:
    """Laws per kind, rigid constraints, groups, relative coordinates and batches of a train.

    reading: for people, every shaft as it is, and friction as it is written. Raises ModelError for contradicting rigid
    constraints.
    """
    assembly = _assemble(train, reading)
    if reading or not assembly.n_massless:
        return assembly
    whole, numbers = with_series_locked(assembly)
    if numbers:
        assembly = _assemble(whole, reading)
    assembly = _with_forces(assembly)
    assembly.structural = tuple(sorted({*assembly.structural, *numbers}))
    return assembly


def _with_forces(assembly: Assembly) -> Assembly:
    """The train whose friction, locks and lossy gears at massless groups are algebraic forces; where these are not told by the
    balance of torques, and a lossy gear ties such a group to others, its tie has an inertia."""
    while True:
        try:
            whole = algebraic_forces(assembly)
        except ModelError:
            whole = with_gauged_gears(assembly)
            if whole is assembly.train:
                raise
            assembly = _assemble(whole, reading=False)
            continue
        return assembly if whole is assembly.train else _assemble(whole, reading=False)


def _assemble(train: Train, reading: bool) -> Assembly:
    made: dict[Any, Law] = {}
    laws = _laws(train, made, frozenset())
    known = _exact_values(train, laws)
    groups = merge(train.n_nodes, list(_rigid_constraints(train, laws, known)))
    inverted = inverted_relations(train.components, laws, groups)
    if inverted:
        laws = _laws(train, made, inverted)
        known = _exact_values(train, laws)
    assembly = Assembly(train, [], groups, inverted=inverted)
    structural = {(p, v) for e in known for p, v in e.structural}
    bodies = inertias(train, laws)
    structural |= bodies.zeros | {(path, 0.0) for path in groups.zeros}
    assembly.structural = tuple(sorted(structural))
    number_groups(assembly, laws, bodies, None if reading else known)
    assembly.force_unknowns = force_unknowns(assembly)
    assembly.starts = start_values(assembly, laws)
    _coordinates(assembly, laws, known)
    return assembly


# -- kinds ------------------------------------------------------------------------------------------------------------


def _grounded(component: Component) -> frozenset[str]:
    return frozenset(
        n for n, node in zip(type(component.block).flanges, component.nodes, strict=True) if node == GROUND
    )


def _laws(train: Train, made: dict[Any, Law], inverted: frozenset[int]) -> list[Law]:
    """The law of each component; one derivation per kind. inverted: components whose relation is solved for its other
    flange."""
    laws = []
    for index, c in enumerate(train.components):
        key = (structure_of(c.block), _grounded(c), index in inverted)
        if key not in made:
            made[key] = _derived(c, key)
            check_feedback(made[key], c.path)
        laws.append(made[key])
    return _with_sensed_conditions(train, made, inverted, laws)


def _derived(c: Component, key: tuple[Any, frozenset[str], bool]) -> Law:
    """The law of a component, whose name stands in what cannot be derived."""
    try:
        return derive(c.block, key[1], inverted=key[2])
    except ModelError as error:
        kind = type(c.block).__name__
        named = (f"{kind} '{c.path}'{p.removeprefix(kind)}" if p.startswith(f"{kind}: ") else p for p in error.problems)
        raise ModelError(list(named)) from None


def _with_sensed_conditions(train: Train, made: dict[Any, Law], inverted: frozenset[int], laws: list[Law]) -> list[Law]:
    """The laws, where others read outputs with conditions of their own with these as modes."""
    read = {meaning.of for law in laws for meaning in law.pool.roles.values() if meaning.role == "sense"}
    for index, (c, law) in enumerate(zip(train.components, laws, strict=True)):
        sensed = frozenset(name for name in unlocated(law) if f"{c.path}.{name}" in read) if read else frozenset()
        if sensed:
            key = (structure_of(c.block), _grounded(c), index in inverted, sensed)
            if key not in made:
                made[key] = derive(c.block, key[1], inverted=key[2], sensed=sensed)
            laws[index] = made[key]
    return laws


def _exact_values(train: Train, laws: list[Law]) -> list[ExactValues]:
    result = []
    wanted: dict[int, list[tuple[Any, Any]]] = {}
    for c, law in zip(train.components, laws, strict=True):
        if id(law) not in wanted:
            exprs = [x for form in law.forms for x in form.coefficients.values()]
            exprs += [x for coefficients, _ in law.ties for x in coefficients.values()]
            exprs += [x for constraint in law.constraints.values() for x in constraint.row.values()]
            symbols = {x for e in exprs for x in e.free_symbols}
            symbols |= {x for x, meaning in law.pool.roles.items() if meaning.role == "exact"}
            wanted[id(law)] = sorted(((x, law.pool.roles[x]) for x in symbols), key=lambda pair: str(pair[0].name))
        found = ExactValues({}, [])
        if wanted[id(law)]:
            numbers = {path: value for path, value, _ in numbers_of(c.block, "")}
            for symbol, meaning in wanted[id(law)]:
                if meaning.role == "exact":
                    found.values[symbol] = exact(numbers[meaning.of])
                elif meaning.role == "own":
                    found.values[symbol] = exact(numbers[meaning.of])
                    found.structural.append((f"{c.path}.{meaning.of}", float(numbers[meaning.of])))
                else:
                    raise ModelError(
                        f"'{c.path}': a ratio depends on '{symbol}', which can change; ratios are structural"
                    )
        result.append(found)
    return result


def _rigid_constraints(train: Train, laws: list[Law], known: list[ExactValues]) -> Iterable[RigidConstraint]:
    for index, (c, law, values) in enumerate(zip(train.components, laws, known, strict=True)):
        names = list(type(c.block).flanges)
        for coefficients, constant in law.ties:
            row: dict[int, Exact] = {}
            for flange, expr in coefficients.items():
                node = c.nodes[names.index(flange)]
                row[node] = row.get(node, 0) + _factor(c.path, flange, expr, values)
            offset, offset_value = None, 0.0
            if constant != 0:
                meaning = law.pool.roles.get(-constant)
                if meaning is None or meaning.role != "own" or len(row) != 1:
                    raise ModelError(
                        f"'{c.path}': the tie has the constant '{constant}'; only a start angle at one flange is known"
                    )
                offset = f"{c.path}.{meaning.of}"
                offset_value = float(getattr(c.block, meaning.of))
            yield RigidConstraint(c.path, {n: v for n, v in row.items() if v}, offset, offset_value, index)


# -- coordinates and batches ------------------------------------------------------------------------------------------


def _coordinates(assembly: Assembly, laws: list[Law], known: list[ExactValues]) -> None:
    dependent_groups = {f.group: f for f in assembly.dependent_groups}
    expanded = expand_rows(assembly)
    given = {
        g: [root for s in f.sources for root in (expanded[s].groups if s in expanded else (s,))]
        for g, f in dependent_groups.items() if f.prescribed is not None and not f.prescribed.by_speed
    }  # fmt: skip
    massless = assembly.n_speeds + assembly.n_massless
    prescribed = massless + assembly.n_prescribed
    coordinates = Coordinates(given, range(assembly.n_speeds, massless), range(massless, prescribed))
    batches: dict[Any, Batch] = {}
    facts: dict[int, tuple[tuple[bool, ...], bool]] = {}
    for index, (c, law) in enumerate(zip(assembly.train.components, laws, strict=True)):
        if id(law) not in facts:
            symbols = {x for e in law.expressions(STAGE) for x in e.free_symbols}
            reads = any(law.pool.roles[x].role == "phi" for x in symbols)
            facts[id(law)] = (tuple(u in symbols for u in law.coordinates), reads)
        used, reads = facts[id(law)]
        assembly.in_law |= reads
        nodes = {n: node for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node != GROUND}
        sources, dependent = _take(c.path, assembly, coordinates, expanded, law, nodes, known[index], used)
        grounded = frozenset(n for n, node in nodes.items() if assembly.group_of_node[node][0] == GROUND_GROUP)
        key = (id(law), grounded, dependent)
        if key not in batches:
            name = f"{type(c.block).__name__.lower()}_{len(batches)}"
            batches[key] = Batch(name, law, flanges=tuple(nodes), dependent=dependent, used=used)
            batches[key].sources = [[] for _ in law.forms]
        _append(batches[key], assembly, index, nodes, sources, known[index])
    assembly.batches = list(batches.values())
    assembly.rows = coordinates.rows
    assembly.steady = _steady(assembly, laws)
    definitions = coordinates.outward()
    _steady_first(assembly, definitions.values())
    rows: dict[int, Combination | PrescribedRow] = dict(definitions)
    rows |= {group: Combination() for group in assembly.force_unknowns}  # no angle
    for g, f in dependent_groups.items():
        if f.row is not None:
            rows[g] = f.row
        elif f.prescribed is not None and g in given:
            rows[g] = f.prescribed
    assembly.angles = [g for g in range(assembly.n_groups) if g not in rows]
    assembly.definitions = _ordered(rows, dependent_groups)


def _steady(assembly: Assembly, laws: list[Law]) -> frozenset[int]:
    """Groups whose speeds are fixed combinations of the speeds and states (time aside)."""
    moving: set[int] = set()
    for f in assembly.dependent_groups:
        if not moving.isdisjoint(f.sources) or (
            f.prescribed and not is_steady(laws[f.prescribed.component], f.prescribed.number)
        ):
            moving.add(f.group)
    return frozenset(range(assembly.n_groups)) - moving


def _steady_first(assembly: Assembly, definitions: Iterable[Combination]) -> None:
    """Renumbers the coordinates: those whose rates are fixed combinations of speeds come first."""
    fixed = [assembly.steady.issuperset(row) for row in assembly.rows]
    assembly.n_steady = sum(fixed)
    order = sorted(range(len(fixed)), key=lambda j: not fixed[j])
    index = {j: i for i, j in enumerate(order)}
    assembly.rows = [assembly.rows[j] for j in order]
    assembly.row_offsets = [assembly.row_offsets[j] for j in order]
    for combination in (*definitions, *assembly.dependents):
        combination.coordinates = {index[j]: c for j, c in combination.coordinates.items()}
    for batch in assembly.batches:
        for j, dependent in enumerate(batch.dependent):
            if batch.used[j] and not dependent:
                batch.sources[j] = [index[i] for i in batch.sources[j]]


def expand_rows(assembly: Assembly) -> dict[int, Combination]:
    """The angles of groups that are dependent by rows, over groups that are not."""
    found: dict[int, Combination] = {}
    for f in assembly.dependent_groups:
        if f.row is not None:
            found[f.group] = Combination({}, {}, dict(f.row.offsets))
            for source, c in f.row.groups.items():
                found[f.group].add(found.get(source, Combination({source: 1})), c)
    return found


def _ordered(
    rows: dict[int, Combination | PrescribedRow], dependent_groups: dict[int, DependentGroup]
) -> list[tuple[int, Combination | PrescribedRow]]:
    """Definitions of angles, each after those it reads."""

    def sources(group: int) -> Iterable[int]:
        row = rows[group]
        return row.groups if isinstance(row, Combination) else dependent_groups[group].sources

    return [(g, rows[g]) for g in dependency_order(rows, rows, sources)]


def _factor(path: str, flange: str, expr: Any, values: ExactValues) -> Exact:
    """The factor of a flange angle in a tie or deflection."""
    try:
        return exact_value(expr, values.values)
    except ZeroDivisionError as error:
        zeros = ", ".join(sorted(f"{x} = 0" for x, v in values.values.items() if v == 0 and x in expr.free_symbols))
        raise ModelError(
            f"'{path}': the factor of flange '{flange}', {expr}, has no value{f' with {zeros}' if zeros else ''}: a deflection "
            f"is measured in the angle of its first flange; give that flange a factor that is not 0, or leave it out"
        ) from error


def _take(
    path: str, assembly: Assembly, coordinates: Coordinates, expanded: dict[int, Combination], law: Law, nodes: dict[str, int],
    values: ExactValues, used: tuple[bool, ...],
) -> tuple[list[int], tuple[bool, ...]]:  # fmt: skip
    """Where each coordinate of one instance comes from."""
    sources, dependent = [], []
    for form, wanted in zip(law.forms, used, strict=True):
        if not wanted:
            sources.append(-1)
            dependent.append(False)
            continue
        combination = Combination()
        for flange, expr in form.coefficients.items():
            c = _factor(path, flange, expr, values)
            node = nodes[flange]
            group, gain = assembly.group_of_node[node]
            if group == GROUND_GROUP:
                offset = assembly.ground_offset[node]
                if offset is not None:
                    combination.add(Combination(offsets={offset: gain}), c)
            elif group in expanded:
                combination.add(expanded[group], c * gain)
            else:
                combination.add(Combination({group: gain}), c)
        taken = coordinates.take(combination)
        if isinstance(taken, int):
            assembly.row_offsets.append(dict(combination.offsets))
            sources.append(taken)
        else:
            sources.append(len(assembly.dependents))
            assembly.dependents.append(taken)
            assembly.in_law |= bool(taken.groups)
        dependent.append(not isinstance(taken, int))
    return sources, tuple(dependent)


def _append(
    batch: Batch, assembly: Assembly, index: int, nodes: dict[str, int], sources: list[int], values: ExactValues
) -> None:  # fmt: skip
    batch.components.append(index)
    for name, node in nodes.items():
        group, gain = assembly.group_of_node[node]
        batch.groups.setdefault(name, []).append(group)
        batch.gains.setdefault(name, []).append(gain)
        batch.nodes.setdefault(name, []).append(node)
    for column, source in zip(batch.sources, sources, strict=True):
        column.append(source)
    for symbol, value in values.values.items():
        batch.exact.setdefault(symbol, []).append(value)
