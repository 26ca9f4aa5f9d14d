"""Rigid constraints, and the rigid groups that they merge nodes into, with exact ratios.

    sum of c_i phi_i = offset      two nodes: phi_a = gain phi_b, merged by union-find; one node: grounded

Constraints over three groups and more stay unmerged (kinematics.py solves them). Knows nothing of inertia or of speeds.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from gearblocks.errors import ModelError
from gearblocks.laws.rational import Exact, over
from gearblocks.train.disjoint_sets import DisjointSets


@dataclass(frozen=True, slots=True)
class RigidConstraint:
    """A rigid constraint of a component: sum of coefficient * angle over nodes = offset (a path of a parameter, or None: 0)."""

    component: str
    coefficients: Mapping[int, Exact]
    offset: str | None = None
    offset_value: float = 0.0
    index: int = 0


@dataclass(slots=True)
class Groups:
    """Rigid groups: phi(node) = gain * phi(root). held_angles: angle of a grounded root and the component that gives it.

    independent: constraints that say something new; redundant: those that the others imply; unmerged: those over more than
    two groups; zeros: parameters of ground angles that must stay 0, because a constraint over a grounded node was taken as
    one of two nodes.
    """

    nodes: DisjointSets[int] = field(default_factory=DisjointSets)
    grounded: dict[int, str | None] = field(default_factory=dict)
    held_angles: dict[int, tuple[float, str]] = field(default_factory=dict)
    independent: list[RigidConstraint] = field(default_factory=list)
    unmerged: list[RigidConstraint] = field(default_factory=list)
    redundant: list[RigidConstraint] = field(default_factory=list)
    zeros: set[str] = field(default_factory=set)

    def find(self, node: int) -> tuple[int, Exact]:
        """(root, gain) of a node."""
        return self.nodes.find(node)


def merge(n_nodes: int, rows: list[RigidConstraint]) -> Groups:
    """Merges nodes by all constraints of two groups. ModelError names the loop where they contradict each other."""
    groups = Groups()
    waiting: list[RigidConstraint] = []
    for row in rows:
        if len(row.coefficients) > 2:
            waiting.append(row)
        else:
            _join(groups, row)
    while waiting:
        left = [row for row in waiting if not _joined(groups, row)]
        if len(left) == len(waiting):
            break
        waiting = left
    groups.unmerged = waiting
    _measure_by_fastest(groups, n_nodes)
    return groups


def _measure_by_fastest(groups: Groups, n_nodes: int) -> None:
    """Makes the fastest node of a group its root: the scale of its state does not depend on the order of the ties."""
    fastest: dict[int, tuple[int, Exact]] = {}
    for node in range(n_nodes):
        root, gain = groups.find(node)
        most: Exact = fastest[root][1] if root in fastest else 1
        if gain * gain > most * most and root not in groups.grounded:
            fastest[root] = node, gain
    groups.nodes.reroot({root: node for root, (node, _) in fastest.items()})


def _joined(groups: Groups, row: RigidConstraint) -> bool:
    """Whether a constraint of three nodes or more turned out to join two groups, the others being grounded at angle zero."""
    left: dict[int, Exact] = {}
    held: set[str | None] = set()
    for node, c in row.coefficients.items():
        root, gain = groups.find(node)
        if groups.held_angles.get(root, (1.0, ""))[0] == 0.0:
            held.add(groups.grounded[root])
        else:
            left[root] = left.get(root, 0) + c * gain
    left = {root: c for root, c in left.items() if c}
    if len(left) != 2 or any(root in groups.grounded for root in left):
        return False
    groups.zeros.update(path for path in held if path is not None)
    _join(groups, RigidConstraint(row.component, left, None, 0.0, row.index), row)
    return True


def _join(groups: Groups, row: RigidConstraint, whole: RigidConstraint | None = None) -> None:
    """Merges the groups of two nodes; `whole`: the constraint that it is a part of."""
    if len(row.coefficients) == 0:
        groups.redundant.append(row)
    elif len(row.coefficients) == 1:
        _ground(groups, row)
    else:
        (a, ca), (b, cb) = row.coefficients.items()
        (ra, ga), (rb, gb) = groups.find(a), groups.find(b)
        if ra == rb:
            if ca * ga + cb * gb != 0:
                raise ModelError(_contradiction(row, a, b, over(-cb, ca), over(ga, gb), groups.independent))
            groups.redundant.append(whole or row)
            return
        if rb in groups.grounded:
            if ra in groups.grounded:
                _agree(groups, row, ra, float(over(-(cb * gb), ca * ga)) * groups.held_angles[rb][0], rb)
                return
            a, b, ca, cb, ra, rb, ga, gb = b, a, cb, ca, rb, ra, gb, ga
        groups.nodes.join(rb, ra, over(-(ca * ga), cb * gb))
        groups.independent.append(whole or row)


def _ground(groups: Groups, row: RigidConstraint) -> None:
    ((node, c),) = row.coefficients.items()
    root, gain = groups.find(node)
    angle = row.offset_value / float(c * gain)
    if root in groups.grounded:
        _agree(groups, row, root, angle, root)
        return
    groups.grounded[root] = row.offset
    groups.held_angles[root] = angle, row.component
    groups.independent.append(row)


def _agree(groups: Groups, row: RigidConstraint, root: int, angle: float, other: int) -> None:
    """A group that is grounded twice must be so at one angle."""
    held, holder = groups.held_angles[root]
    if abs(held - angle) > 1e-12 * max(abs(held), abs(angle)):
        names = " and ".join(
            f"'{name}'" for name in dict.fromkeys((holder, groups.held_angles[other][1], row.component))
        )
        raise ModelError(f"{names} hold one shaft at {held:.9g} and {angle:.9g} rad: give both the same angle")
    groups.redundant.append(row)


def _contradiction(
    row: RigidConstraint, a: int, b: int, asked: Exact, given: Exact, used: list[RigidConstraint]
) -> str:
    """The message for a loop of constraints: its components and what they ask for."""
    neighbours: dict[int, list[tuple[int, str]]] = {}
    for tie in used:
        nodes = list(tie.coefficients)
        if len(nodes) == 2:
            neighbours.setdefault(nodes[0], []).append((nodes[1], tie.component))
            neighbours.setdefault(nodes[1], []).append((nodes[0], tie.component))
    queue, came = deque([a]), {a: (a, "")}
    while queue and b not in came:
        node = queue.popleft()
        for other, component in neighbours.get(node, []):
            if other not in came:
                came[other] = (node, component)
                queue.append(other)
    names = [row.component]
    node = b
    while node != a and node in came:
        node, component = came[node]
        names.append(component)
    loop = ", ".join(f"'{name}'" for name in dict.fromkeys(names))
    return (
        f"the ties of {loop} contradict each other (one turn of one end of '{row.component}' asks the other for "
        f"{float(asked):.9g} and {float(given):.9g} turns): nothing could move; check their ratios and tooth counts"
    )
