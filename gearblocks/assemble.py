"""From a train to the tables of its equations: kinds and their laws, groups, coordinates, batches.

All ratios are exact fractions. Numbers of parameters take no part: they are read from the train when a model is made.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from gearblocks.coordinates import Combination, Elimination
from gearblocks.errors import ModelError
from gearblocks.graph import GROUND, Component, Train, numbers_of, structure_of
from gearblocks.laws import Law, derive, exact_value
from gearblocks.rational import Exact, exact
from gearblocks.ties import Groups, TieRow, merge

HELD = -1
"""Group number of a flange that the ground holds."""


@dataclass(slots=True)
class Batch:
    """Instances of one kind that share code: the law, and one table column per flange and coordinate.

    flanges: names of the flanges that are not the ground; groups and gains: one entry per instance (group HELD: held).
    sources: per coordinate of the law and instance, the number of a coordinate, or of a dependent combination.
    """

    name: str
    law: Law
    components: list[int] = field(default_factory=list)
    flanges: tuple[str, ...] = ()
    groups: dict[str, list[int]] = field(default_factory=dict)
    gains: dict[str, list[Exact]] = field(default_factory=dict)
    nodes: dict[str, list[int]] = field(default_factory=dict)
    sources: list[list[int]] = field(default_factory=list)
    dependent: tuple[bool, ...] = ()
    exact: dict[Any, list[Exact]] = field(default_factory=dict)
    used: tuple[bool, ...] = ()


@dataclass(slots=True)
class StartValues:
    """Where the start angle and speed of a group come from: the component and the gain of its node."""

    phi0: str
    phi0_gain: Exact
    w0: str
    w0_gain: Exact


@dataclass(slots=True)
class Assembly:
    """Tables of a train's equations.

    rows[i]: coordinate i as a form of group angles; dependents: combinations that close loops; angles: groups whose
    absolute angle is a state; definitions (in order): how other group angles follow. in_law: a law reads angles.
    """

    train: Train
    batches: list[Batch]
    groups: Groups
    group_of_node: list[tuple[int, Exact]]
    held_offset: dict[int, str | None]
    n_groups: int
    rows: list[dict[int, Exact]]
    row_offsets: list[dict[str, Exact]]
    dependents: list[Combination]
    angles: list[int]
    definitions: list[tuple[int, Combination]]
    starts: list[StartValues]
    in_law: bool
    structural: tuple[tuple[str, float], ...] = ()


def speed_row(assembly: Assembly, group: int) -> dict[int, Exact]:  # noqa: ARG001  every group is independent
    """The speed of a group as an exact combination of independent speeds."""
    return {group: 1}


def assemble(train: Train) -> Assembly:
    """Laws per kind, ties, groups, relative coordinates and batches of a train.

    Raises ModelError for contradicting ties and shafts without inertia.
    """
    laws = _laws(train)
    known = _exact_values(train, laws)
    groups = merge(train.n_nodes, list(_tie_rows(train, laws, known)))
    numbering = _number_groups(train, laws, groups)
    assembly = Assembly(
        train, [], groups, [], {}, len(numbering), [], [], [], [], [], [], False,
        tuple(sorted({(p, v) for e in known for p, v in e.structural})),
    )  # fmt: skip
    for node in range(train.n_nodes):
        root, gain = groups.find(node)
        assembly.group_of_node.append((HELD if root in groups.grounded else numbering[root], gain))
        if root in groups.grounded:
            assembly.held_offset[node] = groups.grounded[root]
    assembly.starts = _starts(train, laws, assembly)
    _coordinates(assembly, laws, known)
    return assembly


# -- kinds ------------------------------------------------------------------------------------------------------------


def _grounded(component: Component) -> frozenset[str]:
    return frozenset(
        n for n, node in zip(type(component.block).flanges, component.nodes, strict=True) if node == GROUND
    )


def _laws(train: Train) -> list[Law]:
    """The law of each component; one derivation per kind."""
    made: dict[Any, Law] = {}
    laws = []
    for c in train.components:
        key = (structure_of(c.block), _grounded(c))
        if key not in made:
            made[key] = derive(c.block, key[1])
        laws.append(made[key])
    return laws


@dataclass(slots=True)
class ExactValues:
    """Fractions of the symbols that enter ratios of one component, and which float parameters became structural."""

    values: dict[Any, Exact]
    structural: list[tuple[str, float]]


def _exact_values(train: Train, laws: list[Law]) -> list[ExactValues]:
    result = []
    wanted: dict[int, list[tuple[Any, Any]]] = {}
    for c, law in zip(train.components, laws, strict=True):
        if id(law) not in wanted:
            exprs = [x for form in law.forms for x in form.coefficients.values()]
            exprs += [x for coefficients, _ in law.ties for x in coefficients.values()]
            symbols = {x for e in exprs for x in e.free_symbols}
            symbols |= {x for x, slot in law.pool.slots.items() if slot.role == "exact"}
            wanted[id(law)] = sorted(((x, law.pool.slots[x]) for x in symbols), key=lambda pair: str(pair[0].name))
        found = ExactValues({}, [])
        if wanted[id(law)]:
            numbers = {path: value for path, value, _ in numbers_of(c.block, "")}
            for symbol, slot in wanted[id(law)]:
                if slot.role == "exact":
                    found.values[symbol] = exact(numbers[slot.of])
                elif slot.role == "own":
                    found.values[symbol] = exact(numbers[slot.of])
                    found.structural.append((f"{c.path}.{slot.of}", float(numbers[slot.of])))
                else:
                    raise ModelError(
                        f"'{c.path}': a ratio depends on '{symbol}', which can change; ratios are structural"
                    )
        result.append(found)
    return result


def _tie_rows(train: Train, laws: list[Law], known: list[ExactValues]) -> Iterable[TieRow]:
    for c, law, values in zip(train.components, laws, known, strict=True):
        names = list(type(c.block).flanges)
        for coefficients, constant in law.ties:
            row: dict[int, Exact] = {}
            for flange, expr in coefficients.items():
                node = c.nodes[names.index(flange)]
                row[node] = row.get(node, 0) + exact_value(expr, values.values)
            offset, held = None, 0.0
            if constant != 0:
                slot = law.pool.slots.get(-constant)
                if slot is None or slot.role != "own" or len(row) != 1:
                    raise ModelError(
                        f"'{c.path}': the tie has the constant '{constant}'; only -phi0 at one flange is known"
                    )
                offset = f"{c.path}.{slot.of}"
                held = float(getattr(c.block, slot.of))
            yield TieRow(c.path, {n: v for n, v in row.items() if v}, offset, held)


# -- groups -----------------------------------------------------------------------------------------------------------


def _number_groups(train: Train, laws: list[Law], groups: Groups) -> dict[int, int]:
    """Numbers of the groups that turn, in the order of their first bodies; shafts without inertia are refused."""
    numbering: dict[int, int] = {}
    for c, law in zip(train.components, laws, strict=True):
        names = list(type(c.block).flanges)
        for flange, _ in law.bodies:
            root, _gain = groups.find(c.nodes[names.index(flange)])
            if root not in groups.grounded:
                numbering.setdefault(root, len(numbering))
    massless: dict[int, list[str]] = {}
    for c in train.components:
        for name, node in zip(type(c.block).flanges, c.nodes, strict=True):
            if node != GROUND:
                root, _gain = groups.find(node)
                if root not in numbering and root not in groups.grounded:
                    massless.setdefault(root, []).append(f"{c.path}.{name}")
    if massless:
        raise ModelError(
            [
                f"the shaft at {', '.join(ends[:4])}{', ...' if len(ends) > 4 else ''} has no inertia: connect an Inertia there"
                for ends in massless.values()
            ]
        )
    return numbering


def _starts(train: Train, laws: list[Law], assembly: Assembly) -> list[StartValues]:
    """For each group the component that owns its start values (the first one that gives them)."""
    found: dict[str, dict[int, tuple[str, Exact, bool]]] = {"phi0": {}, "w0": {}}
    for c, law in zip(train.components, laws, strict=True):
        for flange, _ in law.bodies:
            group, gain = assembly.group_of_node[c.nodes[list(type(c.block).flanges).index(flange)]]
            for key, owners in found.items():
                value = getattr(c.block, key, None)
                given = value is not None
                if group == HELD and key == "w0" and isinstance(value, (int, float)) and value != 0:
                    raise ModelError(f"'{c.path}': w0 = {value!r} rad/s, but a Fixed holds this shaft; leave w0 out")
                if group != HELD and (group not in owners or (given and not owners[group][2])):
                    owners[group] = (c.path, gain, given)
    return [StartValues(*found["phi0"][g][:2], *found["w0"][g][:2]) for g in range(assembly.n_groups)]


# -- coordinates and batches ------------------------------------------------------------------------------------------


def _dynamics(law: Law) -> list[Any]:
    """Every expression that a run evaluates at each stage."""
    exprs = [*law.forces.values(), *law.torques.values(), *law.rates.values(), *(s.surface for s in law.switches)]
    return exprs + [e for e in (law.stored, law.loss, law.supplied) if e is not None]


def _coordinates(assembly: Assembly, laws: list[Law], known: list[ExactValues]) -> None:
    elimination = Elimination()
    batches: dict[Any, Batch] = {}
    facts: dict[int, tuple[tuple[bool, ...], bool]] = {}
    for index, (c, law) in enumerate(zip(assembly.train.components, laws, strict=True)):
        if id(law) not in facts:
            symbols = {x for e in _dynamics(law) for x in e.free_symbols}
            reads = any(law.pool.slots[x].role == "phi" for x in symbols)
            facts[id(law)] = (tuple(u in symbols for u in law.coordinates), reads)
        used, reads = facts[id(law)]
        assembly.in_law |= reads
        nodes = {n: node for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node != GROUND}
        sources, dependent = _take(assembly, elimination, law, nodes, known[index], used)
        held = frozenset(n for n, node in nodes.items() if assembly.group_of_node[node][0] == HELD)
        key = (id(law), held, dependent)
        if key not in batches:
            name = f"{type(c.block).__name__.lower()}_{len(batches)}"
            batches[key] = Batch(name, law, flanges=tuple(nodes), dependent=dependent, used=used)
            batches[key].sources = [[] for _ in law.forms]
        _append(batches[key], assembly, index, nodes, sources, known[index])
    assembly.batches = list(batches.values())
    assembly.rows = elimination.rows
    free = [g for g in range(assembly.n_groups) if g not in elimination.definitions]
    assembly.angles = free
    order = elimination.order(list(range(assembly.n_groups)))
    assembly.definitions = [(g, elimination.definitions[g]) for g in order]


def _take(
    assembly: Assembly, elimination: Elimination, law: Law, nodes: dict[str, int], values: ExactValues, used: tuple[bool, ...]
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
            c = exact_value(expr, values.values)
            node = nodes[flange]
            group, gain = assembly.group_of_node[node]
            if group == HELD:
                offset = assembly.held_offset[node]
                if offset is not None:
                    combination.add(Combination(offsets={offset: gain}), c)
            else:
                combination.add(Combination({group: gain}), c)
        taken = elimination.take(combination)
        if isinstance(taken, int):
            assembly.row_offsets.append(dict(combination.offsets))
            sources.append(taken)
        else:
            sources.append(len(assembly.dependents))
            assembly.dependents.append(taken)
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
