"""Scheme of a train: its shafts, and the elements that are drawn on and between them.

Flanges that an Inertia or a Mass joins lie on one shaft. A Fixed without a body is no shaft: what stands on it is drawn with
ground of its own. Two-port elements side by side between the same shafts are one element; the meshes and planets about one
turning carrier are one set (`planet_sets.py`). Knows nothing of places on the paper.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

from gearblocks.blocks import (
    BeltDrive,
    Differential,
    Fixed,
    Gearbox,
    GearMesh,
    IdealGear,
    IdealPlanetary,
    Inertia,
    LossyGear,
    Mass,
    NonCircularGear,
    PlanetaryGear,
    Rack,
    Worm,
)
from gearblocks.drawing.planet_sets import Gearing, planet_sets, simple_gearing
from gearblocks.language.block import Block
from gearblocks.plurals import singular
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.graph import GROUND, Component, Train

BODIES = (Inertia, Mass)
BETWEEN_LANES = (IdealGear, LossyGear, Gearbox, GearMesh, NonCircularGear, Worm, BeltDrive, Rack)
"""Blocks that are drawn from one axis to a parallel one."""


@final
@dataclass(frozen=True, slots=True)
class Element:
    """What one symbol stands for: blocks by path, and the shaft at each port.

    blocks: those that a symbol stands for, then what holds its grounded flanges. ports: (flange, shaft). grounded: flanges
    that are held fast. parallel: the elements of a bundle, each with its own ports. gearing: the wheels of a planetary set.
    """

    name: str
    blocks: tuple[tuple[str, Block], ...]
    ports: tuple[tuple[str, int], ...]
    grounded: tuple[str, ...] = ()
    parallel: tuple[Element, ...] = ()
    gearing: Gearing | None = None
    slides: bool = False

    @property
    def block(self) -> Block:
        """The first block, whose class decides the symbol."""
        return self.blocks[0][1]

    @property
    def shafts(self) -> tuple[int, ...]:
        """The shaft at each port."""
        return tuple(shaft for _, shaft in self.ports)

    @property
    def is_rider(self) -> bool:
        """Whether it sits on one shaft alone."""
        return len(self.ports) == 1

    @property
    def is_pair(self) -> bool:
        """Whether it is drawn from one axis to a parallel one."""
        return len(self.ports) == 2 and not self.grounded and isinstance(self.block, BETWEEN_LANES)

    @property
    def is_boxed(self) -> bool:
        """Whether it has a place of its own, with lines to its shafts."""
        return not self.is_rider and not self.is_pair

    def leans(self) -> tuple[int, ...]:
        """Whether each port is on top (-1), in the middle (0) or below (1) of the symbol; empty where that is alike."""
        if self.gearing is not None:
            return tuple(-1 if name in self.gearing.rings else 0 for name, _ in self.ports)
        if isinstance(self.block, Differential):
            return tuple({"left": -1, "right": 1}.get(name, 0) for name, _ in self.ports)
        return ()


@final
@dataclass(frozen=True, slots=True)
class Scheme:
    """Elements of a train in its order, and the names on each shaft."""

    name: str
    elements: tuple[Element, ...]
    shafts: tuple[str, ...]

    def __repr__(self) -> str:
        return singular(f"<Scheme of '{self.name}': {len(self.elements)} elements, {len(self.shafts)} shafts>")


def scheme_of(train: Train) -> Scheme:
    """The scheme of a train whose composite blocks are whole."""
    lines = _Lines(train.components)
    placed = [c for c in train.components if not (isinstance(c.block, Fixed) and lines.held(c.nodes[0]))]
    sets = planet_sets(placed, lines.number)
    within = {path: one for one in sets for path, _ in one.blocks}
    elements, drawn = list[Element](), set[int]()
    for c in placed:
        one = within.get(c.path)
        if one is None:
            elements.append(_element(c, lines))
        elif id(one) not in drawn:
            drawn.add(id(one))
            holding = (b for name, line in one.grounded for b in lines.holding(line))
            grounded = tuple(name for name, _ in one.grounded)
            elements.append(Element(one.name, (*one.blocks, *holding), one.ports, grounded, (), one.gearing))
    elements = [e if e.ports else replace(e, ports=(("", -i),)) for i, e in enumerate(elements, 1)]  # alone on a line
    used = sorted({s for e in elements for s in e.shafts})
    number = {s: i for i, s in enumerate(used)}
    elements = [_renumbered(e, number) for e in _bundled(elements)]
    return Scheme(train.name, tuple(elements), tuple(lines.names(s) if s >= 0 else "" for s in used))


@final
class _Lines:
    """Shafts by number (0, 1, ...), and lines that a Fixed holds (-2, -3, ...), for the nodes of a train."""

    def __init__(self, components: Sequence[Component]) -> None:
        self._sets = DisjointSets[int]()
        for c in components:
            if isinstance(c.block, BODIES):
                self._sets.join(c.nodes[1], c.nodes[0])
        self._on = defaultdict[int, list[Component]](list)
        for c in components:
            for root in dict.fromkeys(self._sets.root(n) for n in c.nodes if n != GROUND):
                self._on[root].append(c)
        fixed = self._grounds()
        self._roots = [root for root in self._on if root not in fixed]
        self._number = {root: i for i, root in enumerate(self._roots)} | {root: -2 - i for i, root in enumerate(fixed)}
        self._held = fixed

    def number(self, node: int) -> int:
        """The line of a node; GROUND where it means the ground."""
        return GROUND if node == GROUND else self._number[self._sets.root(node)]

    def held(self, node: int) -> bool:
        """Whether a Fixed is drawn as ground where a node is."""
        return self.number(node) < GROUND

    def holding(self, line: int) -> Iterable[tuple[str, Block]]:
        """What holds a line that is held."""
        return [(c.path, c.block) for c in self._on[self._held[-2 - line]] if isinstance(c.block, Fixed)]

    def names(self, shaft: int) -> str:
        """The bodies on a shaft."""
        return ", ".join(c.path for c in self._on[self._roots[shaft]] if isinstance(c.block, BODIES))

    def _grounds(self) -> list[int]:
        """Lines that are a Fixed alone, without a body, where all that stands there has a shaft somewhere else too."""
        found = []
        for root, parts in self._on.items():
            others = [c for c in parts if not isinstance(c.block, Fixed)]
            if others and len(others) < len(parts) and not any(isinstance(c.block, BODIES) for c in others):
                found.append(root)

        def stands_free(root: int) -> bool:
            others = (c for c in self._on[root] if not isinstance(c.block, Fixed))
            return all(any(n != GROUND and self._sets.root(n) not in found for n in c.nodes) for c in others)

        return [root for root in found if stands_free(root)]


def _element(c: Component, lines: _Lines) -> Element:
    ports, grounded, blocks = list[tuple[str, int]](), list[str](), [(c.path, c.block)]
    for (flange, spec), node in zip(type(c.block).flanges.items(), c.nodes, strict=True):
        line = lines.number(node)
        if line >= 0 and line not in (s for _, s in ports):
            ports.append((flange, line))
        elif line < GROUND:
            blocks += lines.holding(line)
            grounded += [] if spec.ground else [flange]
    gearing = simple_gearing(c.block) if isinstance(c.block, (IdealPlanetary, PlanetaryGear)) else None
    return Element(c.path, tuple(blocks), tuple(ports), tuple(grounded), (), gearing, c.slides)


def _bundled(elements: Sequence[Element]) -> Iterable[Element]:
    """Elements in parallel between the same two shafts as one, at the place of the first."""
    groups = defaultdict[frozenset[int], list[Element]](list)
    for e in elements:
        if len(e.ports) == 2 and e.is_boxed and e.gearing is None:
            groups[frozenset(e.shafts)].append(e)
    for e in elements:
        group = groups.get(frozenset(e.shafts), [e]) if len(e.ports) == 2 and e.is_boxed and e.gearing is None else [e]
        if len(group) == 1:
            yield e
        elif e is group[0]:
            blocks = tuple(b for one in group for b in one.blocks)
            yield replace(e, name=", ".join(one.name for one in group), blocks=blocks, parallel=tuple(group))


def _renumbered(e: Element, number: dict[int, int]) -> Element:
    ports = tuple((flange, number[shaft]) for flange, shaft in e.ports)
    return replace(e, ports=ports, parallel=tuple(_renumbered(one, number) for one in e.parallel))
