"""From a train to the tables of its equations: kinds and their laws, groups, coordinates, batches.

All ratios are exact fractions. Numbers of parameters take no part: they are read from the train when a model is made.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from gearblocks.assembly.algebraic_friction import algebraic_forces, force_unknowns
from gearblocks.assembly.coordinates import Coordinates
from gearblocks.assembly.elimination import Combination, add_row, dependency_order
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
from gearblocks.train.structure import Kind
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
    if GROUND not in component.nodes:
        return frozenset()
    return frozenset(
        n for n, node in zip(type(component.block).flanges, component.nodes, strict=True) if node == GROUND
    )


def _laws(train: Train, made: dict[Any, Law], inverted: frozenset[int]) -> list[Law]:
    """The law of each component; one derivation per kind. inverted: components whose relation is solved for its other
    flange."""
    laws: list[Law] = []
    of_kind: dict[tuple[Kind, frozenset[str], bool], Law] = {}
    for index, (c, kind) in enumerate(zip(train.components, train.kinds, strict=True)):
        mine = kind, _grounded(c), index in inverted
        if mine not in of_kind:
            key = (kind.structure, *mine[1:])
            if key not in made:
                made[key] = _derived(c, key)
                check_feedback(made[key], c.path)
            of_kind[mine] = made[key]
        laws.append(of_kind[mine])
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
    distinct = {id(law): law for law in laws}.values()
    read = {meaning.of for law in distinct for meaning in law.pool.roles.values() if meaning.role == "sense"}
    for index, (c, law) in enumerate(zip(train.components, laws, strict=True)) if read else ():
        sensed = frozenset(name for name in unlocated(law) if f"{c.path}.{name}" in read)
        if sensed:
            key = (train.kinds[index].structure, _grounded(c), index in inverted, sensed)
            if key not in made:
                made[key] = derive(c.block, key[1], inverted=key[2], sensed=sensed)
            laws[index] = made[key]
    return laws


def _exact_values(train: Train, laws: list[Law]) -> list[ExactValues]:
    result = []
    nothing = ExactValues({}, [])
    wanted: dict[int, list[tuple[Any, Any]]] = {}
    for c, law in zip(train.components, laws, strict=True):
        if id(law) not in wanted:
            exprs = [x for form in law.forms for x in form.coefficients.values()]
            exprs += [x for coefficients, _ in law.ties for x in coefficients.values()]
            exprs += [x for constraint in law.constraints.values() for x in constraint.row.values()]
            symbols = {x for e in exprs for x in e.free_symbols}
            symbols |= {x for x, meaning in law.pool.roles.items() if meaning.role == "exact"}
            wanted[id(law)] = sorted(((x, law.pool.roles[x]) for x in symbols), key=lambda pair: str(pair[0].name))
        found = nothing
        if wanted[id(law)]:
            found = ExactValues({}, [])
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
    ties: dict[int, list[tuple[list[tuple[int, str, Any]], Any]]] = {}
    for index, (c, law, values) in enumerate(zip(train.components, laws, known, strict=True)):
        if id(law) not in ties:
            places = {name: i for i, name in enumerate(type(c.block).flanges)}
            ties[id(law)] = [
                ([_term(c, places, *item, values) for item in row.items()], constant) for row, constant in law.ties
            ]
        for terms, constant in ties[id(law)]:
            row: dict[int, Exact] = {}
            for place, flange, found in terms:
                node = c.nodes[place]
                factor = found if isinstance(found, (int, Fraction)) else _factor(c.path, flange, found, values)
                row[node] = row.get(node, 0) + factor
            offset, offset_value = None, 0.0
            if constant != 0:
                meaning = law.pool.roles.get(-constant)
                if meaning is None or meaning.role != "own" or len(row) != 1:
                    raise ModelError(
                        f"'{c.path}': the tie has the constant '{constant}'; only a start angle at one flange is known"
                    )
                offset = f"{c.path}.{meaning.of}"
                offset_value = float(getattr(c.block, meaning.of))
            if not all(row.values()):
                row = {n: v for n, v in row.items() if v}
            yield RigidConstraint(c.path, row, offset, offset_value, index)


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
    forms: dict[int, _Forms] = {}
    for index, (c, law) in enumerate(zip(assembly.train.components, laws, strict=True)):
        if id(law) not in forms:
            forms[id(law)] = _forms(c, law, known[index])
        mine = forms[id(law)]
        assembly.in_law |= mine.read_angles
        sources, dependent = _take(c, assembly, coordinates, expanded, mine, known[index])
        grounded = [place for place in mine.places if assembly.group_of_node[c.nodes[place]][0] == GROUND_GROUP]
        key = (id(law), *grounded, dependent)
        if key not in batches:
            name = f"{type(c.block).__name__.lower()}_{len(batches)}"
            batches[key] = Batch(name, law, flanges=mine.flanges, dependent=dependent, used=mine.used)
            batches[key].sources = [[] for _ in law.forms]
        batches[key].components.append(index)
        for column, source in zip(batches[key].sources, sources, strict=True):
            column.append(source)
    for batch in batches.values():
        _fill(batch, assembly, forms[id(batch.law)].places, known)
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
    if all(fixed):
        return
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


@cache
def _number(expr: Any) -> Exact:
    """The number that a coefficient without symbols is."""
    return exact_value(expr, {})


def _factor(path: str, flange: str, expr: Any, values: ExactValues) -> Exact:
    """The factor of a flange angle in a tie or deflection."""
    try:
        return exact_value(expr, values.values) if values.values else _number(expr)
    except ZeroDivisionError as error:
        zeros = ", ".join(sorted(f"{x} = 0" for x, v in values.values.items() if v == 0 and x in expr.free_symbols))
        raise ModelError(
            f"'{path}': the factor of flange '{flange}', {expr}, has no value{f' with {zeros}' if zeros else ''}: a deflection "
            f"is measured in the angle of its first flange; give that flange a factor that is not 0, or leave it out"
        ) from error


class _Forms(NamedTuple):
    """What the coordinates of a law ask of each of its components.

    flanges, places: names and numbers of the flanges that are no ground; used: coordinates that laws read; terms: of each of
    these (number of a flange, its name, factor), as a number where it is one, else symbolic; read_angles: whether laws do.
    """

    flanges: tuple[str, ...]
    places: tuple[int, ...]
    used: tuple[bool, ...]
    terms: tuple[tuple[tuple[int, str, Any], ...], ...]
    read_angles: bool


def _forms(c: Component, law: Law, values: ExactValues) -> _Forms:
    """Those of the law of a component."""
    symbols = {x for e in law.expressions(STAGE) for x in e.free_symbols}
    places = {n: i for i, n in enumerate(type(c.block).flanges) if c.nodes[i] != GROUND}
    used = tuple(u in symbols for u in law.coordinates)

    terms = tuple(
        tuple(_term(c, places, *item, values) for item in form.coefficients.items()) if wanted else ()
        for form, wanted in zip(law.forms, used, strict=True)
    )
    reads = any(law.pool.roles[x].role == "phi" for x in symbols)
    return _Forms(tuple(places), tuple(places.values()), used, terms, reads)


def _term(c: Component, places: Mapping[str, int], flange: str, expr: Any, values: ExactValues) -> tuple[int, str, Any]:
    """Number and name of a flange, and its factor: as a number where it is one, else symbolic."""
    return places[flange], flange, expr if expr.free_symbols else _factor(c.path, flange, expr, values)


def _take(
    c: Component, assembly: Assembly, coordinates: Coordinates, expanded: dict[int, Combination], forms: _Forms,
    values: ExactValues,
) -> tuple[list[int], tuple[bool, ...]]:  # fmt: skip
    """Where each coordinate of one instance comes from."""
    sources, dependent = [], []
    for terms, wanted in zip(forms.terms, forms.used, strict=True):
        if not wanted:
            sources.append(-1)
            dependent.append(False)
            continue
        combination = Combination()
        for place, flange, found in terms:
            factor = found if isinstance(found, (int, Fraction)) else _factor(c.path, flange, found, values)
            node = c.nodes[place]
            group, gain = assembly.group_of_node[node]
            if group == GROUND_GROUP:
                offset = assembly.ground_offset[node]
                if offset is not None:
                    add_row(combination.offsets, {offset: gain}, factor)
            elif group in expanded:
                combination.add(expanded[group], factor * gain)
            elif group in combination.groups:
                add_row(combination.groups, {group: gain}, factor)
            elif factor:
                combination.groups[group] = factor * gain
        taken = coordinates.take(combination)
        if isinstance(taken, int):
            assembly.row_offsets.append(combination.offsets)
            sources.append(taken)
        else:
            sources.append(len(assembly.dependents))
            assembly.dependents.append(taken)
            assembly.in_law |= bool(taken.groups)
        dependent.append(not isinstance(taken, int))
    return sources, tuple(dependent)


def _fill(batch: Batch, assembly: Assembly, places: Sequence[int], known: Sequence[ExactValues]) -> None:
    """The columns of a batch that follow from its components."""
    components = [assembly.train.components[index] for index in batch.components]
    for name, place in zip(batch.flanges, places, strict=True):
        nodes = batch.nodes[name] = [c.nodes[place] for c in components]
        found = [assembly.group_of_node[node] for node in nodes]
        batch.groups[name] = [group for group, _ in found]
        batch.gains[name] = [gain for _, gain in found]
    batch.exact = {x: [known[i].values[x] for i in batch.components] for x in known[batch.components[0]].values}
