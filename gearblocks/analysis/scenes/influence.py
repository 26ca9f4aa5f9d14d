"""Influence by structure: the components that can act on a quantity at all.

Torques pass through shared nodes, but not through the ground, nor through a node whose motion is prescribed: what moves
as it is told moves so whatever acts on it. Feedback signals join what they read to what reads it. What is not reached this way
cannot change the quantity. Rigid ties to a prescribed node are taken to pass torques, which may find influence where there
is none, never the reverse. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.analysis.quantity import Quantity, belongs
from gearblocks.blocks.sources import Acceleration, Angle, Speed
from gearblocks.language.block import Declared, field_values
from gearblocks.language.expression import Expr
from gearblocks.train.graph import GROUND, Component, Train


def without_influence(train: Train, measures: tuple[Any, ...]) -> frozenset[str]:
    """Paths of the components that cannot act on any of the quantities; empty where one of them reads all of the train."""
    asked = set[str]()
    for measure in measures:
        read = _read_by(measure, train)
        if read is None:
            return frozenset()
        asked |= read
    return frozenset(c.path for c in train.components) - _reached(train, asked)


def _read_by(measure: Any, train: Train) -> set[str] | None:
    """The components whose outputs a quantity reads; None for all."""
    if not isinstance(measure, Quantity):
        return None
    names = {c.path for c in train.components}
    component, output = getattr(measure, "component", None), getattr(measure, "output", None)
    if component is not None:
        return {name for name in names if belongs(name, component)}
    if not isinstance(output, str):
        return None
    owner = output.rpartition(".")[0]
    while owner and owner not in names:
        owner = owner.rpartition(".")[0]
    return {owner} if owner else None


def _reached(train: Train, asked: set[str]) -> set[str]:
    """The components that can act on those that are asked about, and these."""
    by_path = {c.path: c for c in train.components}
    at: dict[int, list[str]] = {}
    for c in train.components:
        for node in c.nodes:
            at.setdefault(node, []).append(c.path)
    movers = {c.path: c.nodes[0] for c in train.components if _prescribes(c)}
    told = set(movers.values())
    read: dict[str, set[str]] = {}
    for c in train.components:
        read.setdefault(c.path, set()).update(_sensed(c, by_path))
    found, todo = set[str](), list(asked)
    while todo:
        path = todo.pop()
        if path in found:
            continue
        found.add(path)
        todo += read[path]
        for node in by_path[path].nodes:
            if node == GROUND:
                continue
            if path in asked or (node not in told and path not in movers):
                todo += at[node]
            else:
                todo += [other for other in at[node] if other in movers]
    return found


def _prescribes(c: Component) -> bool:
    return isinstance(c.block, (Speed, Angle, Acceleration)) and c.nodes[1] == GROUND


def _sensed(c: Component, by_path: dict[str, Component]) -> Iterator[str]:
    """Components whose outputs the signals of a component read."""
    for leaf in _leaves(tuple(field_values(c.block).values())):
        name = str(leaf)
        while name and name not in by_path:
            name = name.rpartition(".")[0]
        if name:
            yield name


def _leaves(values: tuple[Any, ...]) -> Iterator[Any]:
    for value in values:
        if isinstance(value, Expr):
            yield from (leaf.args[0] for leaf in value.leaves() if leaf.op == "sense")
        elif isinstance(value, tuple):
            yield from _leaves(value)
        elif isinstance(value, Declared):
            yield from _leaves(tuple(field_values(value).values()))
