"""Constraint torques of rigid constraints and prescribed motions: in which order they follow from the torques of nodes.

    tau_n + sum of c_kn lambda_k = 0    at every node n, over its constraints k; where some are redundant lambda is
                                        the minimum-norm split

tau_n, the lack of a node, is what all else leaves unbalanced there. A node with one unknown constraint determines it;
those that are coupled are solved together by exact elimination when the program is made. Knows nothing of time: the
numbers are gains of node torques, or slots of gains that the program computes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gearblocks.assembly.elimination import Combination, Elimination, Row, add_row, row_sum
from gearblocks.errors import ModelError
from gearblocks.laws.rational import Exact, over

if TYPE_CHECKING:
    from gearblocks.codegen.generator import Generator


@dataclass(frozen=True, slots=True)
class Reaction:
    """A constraint with one unknown lambda: c by node. slots: nodes whose coefficient is multiplied by a gain.

    pivot: the only node at which a constraint with slots can be solved, else None.
    """

    component: str
    coefficients: Mapping[int, Exact]
    slots: Mapping[int, int]
    pivot: int | None = None


def tie_tables(g: Generator, flange_of: Mapping[str, Mapping[int, int]]) -> dict[str, Any]:
    """Tables for the template: phases of constraints; lambda of each from node torques, and its effect on flanges."""
    ties = _reactions(g)
    spare = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.redundant if row.coefficients]
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
    """The independent rigid constraints, and prescribed motions."""
    found = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.independent]
    if g.dependent is None:
        return found
    for i, f in enumerate(g.dependent.dependent_groups):
        if f.prescribed is None:
            continue
        component = g.assembly.train.components[f.prescribed.component]
        law = next(b.law for b in g.assembly.batches if f.prescribed.component in b.components)
        drive = law.prescribed[f.prescribed.number]
        nodes = dict(zip(type(component.block).flanges, component.nodes, strict=True))
        coefficients: dict[int, Exact] = {nodes[drive.flange]: 1}
        slots: dict[int, int] = {}
        gain_d = g.assembly.group_of_node[nodes[drive.flange]][1]
        for flange, gain in drive.gains.items():
            node = nodes[flange]
            if gain.is_number:
                coefficients[node] = -over(int(gain.p), int(gain.q))
            else:
                slots[node] = g.dependent.slots[i, flange]
                its = g.assembly.group_of_node[node][1] if flange in f.prescribed.factors else 1
                coefficients[node] = -over(gain_d, its)
        found.append(Reaction(component.path, coefficients, slots, nodes[drive.flange] if slots else None))
    return found


def _phases(
    n_nodes: int, ties: list[Reaction], spare: list[Reaction]
) -> list[list[tuple[Reaction, dict[int, Exact]]]]:  # fmt: skip
    """Constraints in an order in which each follows from a node where all others are known; those that are coupled, together.

    spare: redundant constraints.
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
    """The constraint with the coefficient 1 at a node."""
    c = tie.coefficients[node]
    if c == 1:
        return tie
    return Reaction(tie.component, {n: over(x, c) for n, x in tie.coefficients.items()}, tie.slots, tie.pivot)


def _coupled(ties: list[Reaction], spare: list[Reaction]) -> list[tuple[Reaction, dict[int, Exact]]]:
    """Coupled constraints: lambda from C' lambda = -tau by exact elimination of C over its nodes.

    spare: redundant constraints; lambda is then the minimum-norm split.
    """
    for tie in ties:
        if tie.slots:
            raise ModelError(
                f"the reaction of '{tie.component}' belongs to a closed loop of rigid ties; give one of them compliance"
            )
    elimination = Elimination()  # C x = y: x of nodes, y_k the value of tie k
    for k, tie in enumerate(ties):
        form = elimination.reduced(Combination(dict(tie.coefficients), {k: -1}))
        elimination.solve(form, next(iter(form.groups)))
    # x_p = sum_k e_k y_k + what is no pivot: by virtual work tie k gets the share e_k of the lack of node p
    lacks: dict[int, Row] = {k: {} for k in range(len(ties) + len(spare))}
    for node in elimination.definitions:
        for k, share in elimination.reduced(Combination({node: 1})).coordinates.items():
            lacks[k][node] = -share
    for idle in _idle(spare, elimination, len(ties)):
        _leave_out(lacks, idle)
    return [(tie, lacks[k]) for k, tie in enumerate((*ties, *spare))]


def _idle(spare: list[Reaction], elimination: Elimination, first: int) -> list[Row]:
    """Null space of C', lambda that acts on no node: one vector for each redundant constraint, orthogonal by Gram and Schmidt.

    first: number of the first redundant constraint.
    """
    found: list[Row] = []
    for k, tie in enumerate(spare, first):
        rest = elimination.reduced(Combination(dict(tie.coefficients), {k: -1}))
        if rest.groups:
            continue  # two holds of one shaft that agree to rounding only
        idle = rest.coordinates
        for other in found:
            add_row(idle, other, over(-_dot(idle, other), _dot(other, other)))
        found.append(idle)
    return found


def _leave_out(lacks: dict[int, Row], idle: Row) -> None:
    """Takes out of all lambda, linear forms of the lacks of nodes, their part along `idle`."""
    along = row_sum((x, lacks[k]) for k, x in idle.items())
    size = _dot(idle, idle)
    for k, x in idle.items():
        add_row(lacks[k], along, over(-x, size))


def _dot(a: Mapping[int, Exact], b: Mapping[int, Exact]) -> Exact:
    total: Exact = 0
    for key in a.keys() & b.keys():
        total = total + a[key] * b[key]
    return total
