"""Start angles of rigid groups that were several before: those of the first body stay, the others depend on it."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from gearblocks.language.block import given_start, start_fields
from gearblocks.language.fields import ANGLE
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.graph import GROUND, Train


def released_angles(train: Train, stiffened: Collection[str]) -> Iterator[str]:
    """Paths of bodies whose start angle now depends on another one, because the elements named have become rigid.

    The deflections that these angles described are gone with the compliance.
    """
    shafts = DisjointSets[int]()
    touched: set[int] = set()
    for c in train.components:
        nodes = [n for n in c.nodes if n != GROUND]
        if nodes and (c.path in stiffened or ANGLE in start_fields(type(c.block))):
            for node in nodes[1:]:
                shafts.join(node, nodes[0])
            if c.path in stiffened:
                touched.update(nodes)
    roots = {shafts.root(node) for node in touched}
    seen: set[int] = set()
    for c in train.components:
        if len(c.nodes) == 2 and given_start(c.block, ANGLE) is not None and (root := shafts.root(c.nodes[0])) in roots:
            if root in seen:
                yield c.path
            seen.add(root)
