"""Torques that ties carry: in which order they follow from what the nodes of a train lack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gearblocks.errors import ModelError
from gearblocks.laws.rational import Exact, over

if TYPE_CHECKING:
    from gearblocks.codegen.generator import Generator


@dataclass(frozen=True, slots=True)
class Reaction:
    """A tie with one unknown: nodes with their coefficients. slots: nodes whose coefficient is multiplied by a gain.

    pivot: the only node at which a tie with slots can be solved, else None.
    """

    component: str
    coefficients: Mapping[int, Exact]
    slots: Mapping[int, int]
    pivot: int | None = None


def tie_tables(g: Generator, flange_of: Mapping[str, Mapping[int, int]]) -> dict[str, Any]:
    """Tables for the template: phases of ties; the unknown of each from node torques, and its effect on flanges."""
    ties = _reactions(g)
    spare = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.spare if row.coefficients]
    curved = any(tie.slots for tie in ties)
    phases = _phases(g.assembly.train.n_nodes, ties, [] if curved else spare)
    tables: dict[str, Any] = {"phase": [0], "lack_start": [0], "lack_node": [], "lack_value": []}
    tables |= {"effect_start": [0], "effect_node": [], "effect_flange": [], "effect_slot": [], "effect_value": []}
    for phase in phases:
        for reaction, lacks in phase:
            for node, value in lacks.items():
                tables["lack_node"].append(node)
                tables["lack_value"].append(repr(float(value)))
            tables["lack_start"].append(len(tables["lack_node"]))
            for node, c in reaction.coefficients.items():
                tables["effect_node"].append(node)
                tables["effect_flange"].append(flange_of[reaction.component][node])
                tables["effect_slot"].append(reaction.slots.get(node, -1))
                tables["effect_value"].append(repr(float(c)))
            tables["effect_start"].append(len(tables["effect_node"]))
        tables["phase"].append(len(tables["lack_start"]) - 1)
    return tables


def _reactions(g: Generator) -> list[Reaction]:
    """Every tie that says something new, prescribed motions among them."""
    found = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.used]
    if g.motion is None:
        return found
    for i, f in enumerate(g.motion.followers):
        if f.drive is None:
            continue
        component = g.assembly.train.components[f.drive.component]
        law = next(b.law for b in g.assembly.batches if f.drive.component in b.components)
        drive = law.drives[f.drive.number]
        nodes = dict(zip(type(component.block).flanges, component.nodes, strict=True))
        coefficients: dict[int, Exact] = {nodes[drive.flange]: 1}
        slots: dict[int, int] = {}
        gain_d = g.assembly.group_of_node[nodes[drive.flange]][1]
        for flange, gain in drive.gains.items():
            node = nodes[flange]
            if gain.is_number:
                coefficients[node] = -over(int(gain.p), int(gain.q))
            else:
                slots[node] = g.motion.slots[i, flange]
                its = g.assembly.group_of_node[node][1] if flange in f.drive.factors else 1
                coefficients[node] = -over(gain_d, its)
        found.append(Reaction(component.path, coefficients, slots, nodes[drive.flange] if slots else None))
    return found


def _phases(
    n_nodes: int, ties: list[Reaction], spare: list[Reaction]
) -> list[list[tuple[Reaction, dict[int, Exact]]]]:  # fmt: skip
    """Ties in an order in which each follows from a node where all others are known; those that are coupled together.

    spare: ties that say what the others say already.
    """
    independent, ties = len(ties), ties + spare
    at: list[set[int]] = [set() for _ in range(n_nodes)]
    for k, tie in enumerate(ties):
        for node in tie.coefficients:
            at[node].add(k)
    phases: list[list[tuple[Reaction, dict[int, Exact]]]] = []
    open_ties = dict.fromkeys(range(len(ties)))
    ready = [node for node in range(n_nodes) if len(at[node]) == 1]

    def settle(k: int) -> None:
        del open_ties[k]
        for node in ties[k].coefficients:
            at[node].discard(k)
            if len(at[node]) == 1:
                ready.append(node)

    while open_ties:
        while ready:
            node = ready.pop()
            if len(at[node]) != 1:
                continue
            (k,) = at[node]
            if ties[k].pivot not in (None, node):
                continue
            phases.append([(_scaled(ties[k], node), {node: -1})])
            settle(k)
        if open_ties:
            block = list(open_ties)
            used = [ties[k] for k in block if k < independent]
            phases.append(_coupled(used, [ties[k] for k in block if k >= independent]))
            for k in block:
                settle(k)
    return phases


def _scaled(tie: Reaction, node: int) -> Reaction:
    """The tie with the coefficient 1 at a node."""
    c = tie.coefficients[node]
    if c == 1:
        return tie
    return Reaction(tie.component, {n: over(x, c) for n, x in tie.coefficients.items()}, tie.slots, tie.pivot)


def _coupled(ties: list[Reaction], spare: list[Reaction]) -> list[tuple[Reaction, dict[int, Exact]]]:
    """Ties that can only be solved together: by exact elimination over their nodes.

    spare: ties that follow from the others; torques are then shared by minimum norm of the multipliers of the ties.
    """
    for tie in ties:
        if tie.slots:
            raise ModelError(
                f"the reaction of '{tie.component}' belongs to a closed loop of rigid ties; give one of them compliance"
            )
    rows = {k: dict(tie.coefficients) for k, tie in enumerate(ties)}
    shares: dict[int, dict[int, Exact]] = {k: {k: 1} for k in rows}
    pivots: dict[int, int] = {}
    for k in rows:
        node = next(n for n in rows[k])
        pivots[k] = node
        for other in rows:
            if other != k and node in rows[other]:
                factor = over(rows[other][node], rows[k][node])
                _subtract(rows[other], rows[k], factor)
                _subtract(shares[other], shares[k], factor)
    # rows[k] = sum_j shares[k][j] ties[j] vanishes at the pivots of all others: tie j gets its share of that node's lack
    lacks: dict[int, dict[int, Exact]] = {k: {} for k in range(len(ties) + len(spare))}
    for k, node in pivots.items():
        for j, share in shares[k].items():
            lacks[j][node] = lacks[j].get(node, 0) - over(share, rows[k][node])
    for idle in _idle(spare, rows, shares, pivots):
        _leave_out(lacks, idle)
    return [(tie, lacks[k]) for k, tie in enumerate((*ties, *spare))]


def _idle(
    spare: list[Reaction], rows: dict[int, dict[int, Exact]], shares: dict[int, dict[int, Exact]], pivots: dict[int, int]
) -> list[dict[int, Exact]]:  # fmt: skip
    """Sets of multipliers of all ties that push nothing, each orthogonal to the others: one for each spare tie."""
    found: list[dict[int, Exact]] = []
    for number, tie in enumerate(spare):
        rest = dict(tie.coefficients)
        idle: dict[int, Exact] = {len(rows) + number: 1}
        for k, node in pivots.items():
            if node in rest:
                factor = over(rest[node], rows[k][node])
                _subtract(rest, rows[k], factor)
                _subtract(idle, shares[k], factor)
        if rest:
            continue  # two holds of one shaft that agree to rounding only
        for other in found:
            _subtract(idle, other, over(_dot(idle, other), _dot(other, other)))
        found.append(idle)
    return found


def _leave_out(lacks: dict[int, dict[int, Exact]], idle: dict[int, Exact]) -> None:
    """Takes out of all multipliers, linear forms of the lacks of nodes, their part along `idle`."""
    along: dict[int, Exact] = {}
    for k, x in idle.items():
        _subtract(along, lacks[k], -x)
    size = _dot(idle, idle)
    for k, x in idle.items():
        _subtract(lacks[k], along, over(x, size))


def _dot(a: Mapping[int, Exact], b: Mapping[int, Exact]) -> Exact:
    total: Exact = 0
    for key in a.keys() & b.keys():
        total = total + a[key] * b[key]
    return total


def _subtract(target: dict[int, Exact], source: Mapping[int, Exact], factor: Exact) -> None:
    for key, value in source.items():
        total = target.get(key, 0) - factor * value
        if total:
            target[key] = total
        else:
            target.pop(key, None)
