"""Constraint torques of rigid constraints and prescribed motions: in which order they follow from the torques of nodes.

    tau_n + sum of c_kn lambda_k = 0    at every node n, over its constraints k; where some are redundant lambda is
                                        the minimum-norm split

tau_n, the unbalanced torque of a node, is the sum of all other torques there. A node with one unknown constraint
determines it; those that are coupled are solved together by exact elimination when the program is made. Knows nothing of
time: the numbers are gains of node torques, or indices of gains that the program computes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from gearblocks.assembly.elimination import Combination, Elimination, Row, add_row, row_sum
from gearblocks.codegen.function import texts_of
from gearblocks.errors import ModelError
from gearblocks.laws.rational import Exact, over

if TYPE_CHECKING:
    from gearblocks.codegen.generator import Generator


class Reaction(NamedTuple):
    """A constraint with one unknown lambda: c by node. gain_index: nodes whose coefficient is multiplied by a gain.

    pivot: the only node at which a constraint with gain_index can be solved, else None.
    """

    component: str
    coefficients: Mapping[int, Exact]
    gain_index: Mapping[int, int]
    pivot: int | None = None


def flange_numbers(g: Generator) -> dict[str, dict[int, int]]:
    """Number in flange_tau of the flange at each node of each component that holds or moves shafts."""
    numbers: dict[str, dict[int, int]] = {}
    for code in (x for x in g.codes if x.law.ties or x.law.prescribed):
        for flange in code.batch.flanges:
            for e in range(code.n):
                mine = numbers.setdefault(code.paths[e], {})
                mine.setdefault(code.batch.nodes[flange][e], code.offsets.flange_torques[flange] + e)
    return numbers


def reaction_tables(g: Generator, flange_of: Mapping[str, Mapping[int, int]]) -> dict[str, Any]:
    """Tables for the template: phases of constraints; lambda of each from node torques, and its effect on flanges."""
    reactions = _reactions(g)
    spare = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.redundant if row.coefficients]
    curved = any(reaction.gain_index for reaction in reactions)
    phases = _phases(g.assembly.train.n_nodes, reactions, [] if curved else spare)
    tables: dict[str, Any] = {"phase": [0], "lambda_start": [0], "lambda_node": [], "lambda_value": []}
    tables |= {"effect_start": [0], "effect_node": [], "effect_flange": [], "effect_gain": [], "effect_value": []}
    tables["coupled"] = False
    for phase in phases:
        for reaction, forms in phase:
            tables["coupled"] |= len(phase) > 1 or len(forms) != 1
            tables["lambda_node"] += forms
            tables["lambda_value"] += forms.values()
            tables["lambda_start"].append(len(tables["lambda_node"]))
            flanges, nodes = flange_of[reaction.component], reaction.coefficients
            tables["effect_node"] += nodes
            tables["effect_flange"] += [flanges[node] for node in nodes]
            tables["effect_gain"] += [reaction.gain_index.get(node, -1) for node in nodes]
            tables["effect_value"] += nodes.values()
            tables["effect_start"].append(len(tables["effect_node"]))
        tables["phase"].append(len(tables["lambda_start"]) - 1)
    for name in ("lambda_value", "effect_value"):
        tables[name] = texts_of(tables[name])
    return tables


def _reactions(g: Generator) -> list[Reaction]:
    """The independent rigid constraints, and prescribed motions."""
    found = [Reaction(row.component, row.coefficients, {}) for row in g.assembly.groups.independent]
    if g.dependent is None:
        return found
    for i, f in enumerate(g.dependent.members):
        if f.prescribed is None:
            continue
        component = g.assembly.train.components[f.prescribed.component]
        law = next(b.law for b in g.assembly.batches if f.prescribed.component in b.components)
        motion = law.prescribed[f.prescribed.number]
        nodes = dict(zip(type(component.block).flanges, component.nodes, strict=True))
        coefficients: dict[int, Exact] = {nodes[motion.flange]: 1}
        gain_index: dict[int, int] = {}
        gain_d = g.assembly.group_of_node[nodes[motion.flange]][1]
        for flange, gain in motion.gains.items():
            node = nodes[flange]
            if gain.is_number:
                coefficients[node] = -over(int(gain.p), int(gain.q))
            else:
                gain_index[node] = g.dependent.gain_index[i, flange]
                its = g.assembly.group_of_node[node][1] if flange in f.prescribed.factors else 1
                coefficients[node] = -over(gain_d, its)
        found.append(Reaction(component.path, coefficients, gain_index, nodes[motion.flange] if gain_index else None))
    return found


def _phases(
    n_nodes: int, reactions: list[Reaction], spare: list[Reaction]
) -> Iterator[list[tuple[Reaction, dict[int, Exact]]]]:  # fmt: skip
    """Constraints in an order in which each follows from a node where all others are known; those that are coupled, together.

    spare: redundant constraints.
    """
    independent, reactions = len(reactions), reactions + spare
    left, names = [0] * n_nodes, [0] * n_nodes  # unsolved constraints of a node: how many, and the sum of their numbers
    for k, reaction in enumerate(reactions):
        for node in reaction.coefficients:
            left[node] += 1
            names[node] += k
    unsolved = dict.fromkeys(range(len(reactions)))
    ready = [node for node in range(n_nodes) if left[node] == 1]

    def settle(k: int) -> None:
        del unsolved[k]
        for node in reactions[k].coefficients:
            left[node] -= 1
            names[node] -= k
            if left[node] == 1:
                ready.append(node)

    while unsolved:
        while ready:
            node = ready.pop()
            if left[node] != 1:
                continue
            k = names[node]
            if reactions[k].pivot not in (None, node):
                continue
            yield [(_scaled(reactions[k], node), {node: -1})]
            settle(k)
        if unsolved:
            block = list(unsolved)
            used = [reactions[k] for k in block if k < independent]
            yield _coupled(used, [reactions[k] for k in block if k >= independent])
            for k in block:
                settle(k)


def _scaled(reaction: Reaction, node: int) -> Reaction:
    """The constraint with the coefficient 1 at a node."""
    c = reaction.coefficients[node]
    if c == 1:
        return reaction
    return Reaction(
        reaction.component,
        {n: over(x, c) for n, x in reaction.coefficients.items()},
        reaction.gain_index,
        reaction.pivot,
    )


def _coupled(reactions: list[Reaction], spare: list[Reaction]) -> list[tuple[Reaction, dict[int, Exact]]]:
    """Coupled constraints: lambda from C' lambda = -tau by exact elimination of C over its nodes.

    spare: redundant constraints; lambda is then the minimum-norm split.
    """
    for reaction in reactions:
        if reaction.gain_index:
            raise ModelError(
                f"the reaction of '{reaction.component}' belongs to a closed loop of rigid ties; give one of them compliance"
            )
    elimination = Elimination()  # C x = y: x of nodes, y_k the value of constraint k
    for k, reaction in enumerate(reactions):
        form = elimination.reduced(Combination(dict(reaction.coefficients), {k: -1}))
        elimination.solve(form, next(iter(form.groups)))
    # x_p = sum_k e_k y_k + what is no pivot: by virtual work constraint k takes the part e_k of the torque of node p
    forms: dict[int, Row] = {k: {} for k in range(len(reactions) + len(spare))}
    for node in elimination.definitions:
        for k, part in elimination.reduced(Combination({node: 1})).coordinates.items():
            forms[k][node] = -part
    for idle in _idle(spare, elimination, len(reactions)):
        _leave_out(forms, idle)
    return [(reaction, forms[k]) for k, reaction in enumerate((*reactions, *spare))]


def _idle(spare: list[Reaction], elimination: Elimination, first: int) -> list[Row]:
    """Null space of C', lambda that acts on no node: one vector for each redundant constraint, orthogonal by Gram and Schmidt.

    first: number of the first redundant constraint.
    """
    found: list[Row] = []
    for k, reaction in enumerate(spare, first):
        rest = elimination.reduced(Combination(dict(reaction.coefficients), {k: -1}))
        if rest.groups:
            continue  # two ground angles of one shaft that agree to rounding only
        idle = rest.coordinates
        for other in found:
            add_row(idle, other, over(-_dot(idle, other), _dot(other, other)))
        found.append(idle)
    return found


def _leave_out(forms: dict[int, Row], idle: Row) -> None:
    """Takes out of all lambda, linear forms of the unbalanced torques of nodes, their part along `idle`."""
    along = row_sum((x, forms[k]) for k, x in idle.items())
    size = _dot(idle, idle)
    for k, x in idle.items():
        add_row(forms[k], along, over(-x, size))


def _dot(a: Mapping[int, Exact], b: Mapping[int, Exact]) -> Exact:
    total: Exact = 0
    for key in a.keys() & b.keys():
        total = total + a[key] * b[key]
    return total
