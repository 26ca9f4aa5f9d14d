"""Train as a graph: components (blocks with their full paths) joined at nodes (flanges that are connected).

Frozen; found without sympy. Knows nothing of laws: whether a node moves by itself is not asked here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from gearblocks.errors import ModelError
from gearblocks.language.block import Block
from gearblocks.language.expression import Expr
from gearblocks.plurals import singular
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.heat import has_heat, receiving
from gearblocks.train.nesting import localised
from gearblocks.train.structure import Kind, kinds_of
from gearblocks.train.translational import sliders_of, sliding_nodes
from gearblocks.train.values import unit_problems, value_problems

GROUND = -1
"""The node number of a flange that means the ground because nothing is connected to it."""


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A relative coordinate for reading: an output, and the unknown of the relative form of the equations."""

    name: str
    expr: Expr
    unit: str


@dataclass(frozen=True, slots=True)
class Tree:
    """A train as composed: parts may be trains themselves. A link joins (part, flange) pairs."""

    name: str
    parts: tuple[tuple[str, Any], ...]
    links: tuple[tuple[tuple[str, str], ...], ...]
    exposed: tuple[tuple[str, tuple[str, str]], ...] = ()
    coordinates: tuple[Coordinate, ...] = ()

    def __repr__(self) -> str:
        return singular(f"<Tree of '{self.name}': {len(self.parts)} parts, {len(self.links)} links>")


def blocks_of(tree: Tree, prefix: str = "") -> Iterator[tuple[str, Block]]:
    """Path and block of every part, composites whole."""
    for name, part in tree.parts:
        if isinstance(part, Tree):
            yield from blocks_of(part, f"{prefix}{name}.")
        else:
            yield prefix + name, part


class Component(NamedTuple):
    """One block with its full path and the node of each flange (GROUND where it means the ground)."""

    path: str
    block: Block
    nodes: tuple[int, ...]
    sliders: frozenset[str] = frozenset()  # flanges that slide
    slides: bool = False  # whether those slide that take both: units are then those of sliders


@dataclass(frozen=True)
class Train:
    """All components of a train, flat, and how many nodes join them."""

    name: str
    components: tuple[Component, ...]
    n_nodes: int
    coordinates: tuple[Coordinate, ...] = ()

    @cached_property
    def kinds(self) -> tuple[Kind, ...]:
        """The kind of each component."""
        return kinds_of(c.block for c in self.components)

    @cached_property
    def examples(self) -> tuple[Block, ...]:
        """A block of each kind."""
        return tuple(kind.example for kind in dict.fromkeys(self.kinds))

    def __reduce__(self) -> tuple[Any, ...]:
        return Train, (self.name, self.components, self.n_nodes, self.coordinates)

    def __repr__(self) -> str:
        return f"<Train '{self.name}': {len(self.components)} components, {self.n_nodes} nodes>"


def flatten(tree: Tree, *, complete: bool = True, whole: bool = False) -> Train:
    """The train with full paths. All problems are gathered into one ModelError; complete=False accepts open ends.

    whole=True leaves composite blocks as they are, where else their parts stand for them.
    """
    parts = _Parts([], DisjointSets(), set(), whole)
    parts.enter(tree, "")
    return _number(tree, parts, complete)


@dataclass(slots=True)
class _Parts:
    """Blocks with their full paths and the number of their first flange; nodes: flanges that are connected are one; joined:
    flanges that stand in a link.

    whole: composite blocks stay as they are. n: flanges so far. problems: of the numbers that composite blocks give their
    parts, as nobody adds these.
    """

    blocks: list[tuple[str, Block, int]]
    nodes: DisjointSets[int]
    joined: set[int]
    whole: bool
    n: int = 0
    problems: list[str] = field(default_factory=list)

    def enter(self, node: Tree, prefix: str) -> dict[str, int]:
        """Takes the parts and links of a tree; what its exposed flanges are."""
        local: dict[tuple[str, str], int] = {}
        names = {name for name, _ in node.parts} if prefix else set()
        for name, part in node.parts:
            path = prefix + name
            if prefix and isinstance(part, Block):
                part = localised(part, prefix, names)
            inner = _inside(name, part, self.whole)
            if inner is not None:
                if isinstance(part, Block):
                    self.problems += [x for n, b in inner.parts for x in value_problems(f"{path}.{n}", b)]
                local |= {(name, flange): end for flange, end in self.enter(inner, path + ".").items()}
                continue
            self.blocks.append((path, part, self.n))
            for flange in type(part).flanges:
                local[name, flange] = self.n
                self.n += 1
        for link in node.links:
            first = local[link[0]]
            for end in link[1:]:
                self.nodes.join(local[end], first)
            self.joined.update(local[end] for end in link)
        return {name: local[end] for name, end in node.exposed}


def _inside(name: str, part: Any, whole: bool) -> Tree | None:
    """The tree inside a nested train or a composite block, None for a plain block, or a composite one that stays whole."""
    if isinstance(part, Tree):
        return part
    if whole:
        return None
    parts = part.parts()
    if parts is None:
        return None
    return Tree(name, tuple(parts.blocks.items()), tuple(parts.links), tuple(parts.flanges.items()))


def _number(tree: Tree, parts: _Parts, complete: bool) -> Train:
    """Numbers the nodes in the order of the components and refuses open ends."""
    numbers, components, problems = dict[int, int](), [], list[str]()
    for path, block, first in parts.blocks:
        nodes = []
        for end, (flange, spec) in enumerate(type(block).flanges.items(), first):
            connected = end in parts.joined
            if not connected and spec.ground:
                nodes.append(GROUND)
                continue
            if not connected and not spec.spare:
                who = f"{type(block).__name__} '{path}'"
                problems.append(f"flange '{flange}' of {who} is open: connect it (to an Inertia, a Fixed, ...)")
            nodes.append(numbers.setdefault(parts.nodes.root(end), len(numbers)))
        if len(set(nodes)) < len(nodes) and _is_looped(nodes):
            problems.append(
                f"{type(block).__name__} '{path}' is connected to itself: two of its flanges share one node; connect them to "
                f"different shafts"
            )
        components.append((path, block, tuple(nodes)))
    sliding, mixed = sliding_nodes(components, len(numbers))
    if (problems or mixed or parts.problems) and complete:
        raise ModelError(parts.problems + problems + mixed)
    if not components:
        raise ModelError(f"the drivetrain '{tree.name}' is empty: add blocks")
    slides = (sliders_of(block, nodes, sliding) if sliding else () for _, block, nodes in components)
    flat = [Component(*c, *more) for c, more in zip(components, slides, strict=True)]
    train = Train(tree.name, tuple(flat), len(numbers), tree.coordinates)
    some = [c for c, kind in zip(flat, train.kinds, strict=True) if not kind.is_plain]
    wrong = [problem for c in some for problem in unit_problems(c.path, c.block, c.slides)]
    if wrong:
        raise ModelError(wrong)
    heated = receiving({c.path: c.block for c in flat}) if complete and has_heat(train.examples) else {}
    if heated:
        flat = [c._replace(block=heated.get(c.path, c.block)) for c in flat]
        return Train(tree.name, tuple(flat), len(numbers), tree.coordinates)
    return train


def _is_looped(nodes: list[int]) -> bool:
    """Whether two flanges share a node."""
    shafts = [n for n in nodes if n != GROUND]
    return len(set(shafts)) < len(shafts)
