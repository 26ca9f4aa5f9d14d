"""Which nonlinear relations are solved for their other flange, so that each prescribed motion has a group of its own.

A matching in a bipartite graph of relations and groups, by augmenting paths (Kuhn 1955): a relation keeps its first flange
unless a ground holds that one or something else prescribes it. Knows nothing of the relations themselves.
"""

from __future__ import annotations

from collections.abc import Sequence

from gearblocks.assembly.rigid_constraints import Groups
from gearblocks.laws.law import Law
from gearblocks.train.graph import GROUND, Component


def inverted_relations(components: Sequence[Component], laws: Sequence[Law], groups: Groups) -> frozenset[int]:
    """The components whose relation is solved for its other flange. Where nothing fits, the relations stay as they are:
    kinematics.py names the conflict."""
    options = {
        i: _options(c, law, groups) for i, (c, law) in enumerate(zip(components, laws, strict=True)) if law.prescribed
    }
    taken: dict[int, tuple[int, int]] = {}  # by group: component and number of its option
    for i in options:
        if not _augmented(i, options, taken, set()):
            return frozenset()
    return frozenset(i for i, number in taken.values() if number)


def _options(c: Component, law: Law, groups: Groups) -> list[int | None]:
    """The groups that the motion of a component may be solved for; None where a ground holds that one."""
    nodes = dict(zip(type(c.block).flanges, c.nodes, strict=True))
    wanted = [law.prescribed[0].flange, *([law.invertible] if law.invertible else [])]
    roots = [groups.find(nodes[f])[0] if nodes[f] != GROUND else None for f in wanted]
    return [None if r in groups.grounded else r for r in roots]


def _augmented(
    i: int, options: dict[int, list[int | None]], taken: dict[int, tuple[int, int]], seen: set[int]
) -> bool:  # fmt: skip
    """Gives component i a group, moving others to their other one where that helps."""
    for number, group in enumerate(options[i]):
        if group is None or group in seen:
            continue
        seen.add(group)
        if group not in taken or _augmented(taken[group][0], options, taken, seen):
            taken[group] = i, number
            return True
    return False
