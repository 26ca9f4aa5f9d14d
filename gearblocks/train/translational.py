"""Which shafts are sliders: positions in m, speeds in m/s and forces in N in place of angles and torques.

Knows nothing of laws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Protocol, TypeAlias

from gearblocks.language.block import Block, start_fields
from gearblocks.language.fields import SPEED, Field
from gearblocks.language.units import unit_along
from gearblocks.train.disjoint_sets import DisjointSets

Ends: TypeAlias = "tuple[str, Block, Sequence[int]]"  # path, block, and the node of each flange (below 0: the ground)


class Placed(Protocol):
    """A component as far as this module knows it."""

    @property
    def path(self) -> str:
        """Its full path."""

    @property
    def block(self) -> Block:
        """What it is."""

    @property
    def sliders(self) -> frozenset[str]:
        """Its flanges that slide."""


def start_name(block: Block | None, of: str, slides: bool) -> str:
    """Name of the start angle or speed of a shaft among the parameters: that of the field which its block declares, else phi0
    or w0, and s0 or v0 of a slider."""
    return _start_name(None if block is None else type(block), of, slides)


@cache
def _start_name(kind: type[Block] | None, of: str, slides: bool) -> str:
    names = {} if kind is None else start_fields(kind)
    return names[of] if of in names else f"{flange_names(slides)[of == SPEED]}0"


def takes_start(block: Block, of: str) -> bool:
    """Whether a start value can bear the name of the block: nothing else of the block is called so."""
    return _takes_start(type(block), of)


@cache
def _takes_start(kind: type[Block], of: str) -> bool:
    name = _start_name(kind, of, _kind_slides(kind))
    return of in start_fields(kind) or not (name in kind.fields or name in kind.states)


def _slides(block: Block) -> bool:
    """Whether all flanges of a block slide, whatever they are connected to."""
    return _kind_slides(type(block))


@cache
def _kind_slides(kind: type[Block]) -> bool:
    return all(f.slider for f in kind.flanges.values())


def slider_names(components: Iterable[Placed]) -> set[str]:
    """Paths of all blocks whose flanges all slide, and of all flanges that slide."""
    found = {f"{c.path}.{flange}" for c in components for flange in c.sliders}
    return found | {c.path for c in components if _slides(c.block)}


def flange_names(slides: bool) -> tuple[str, str, str, str]:
    """Names of angle, speed, torque and power among the outputs of a flange."""
    return ("s", "v", "f", "power") if slides else ("phi", "w", "tau", "power")


def words_along(words: str, slides: bool) -> str:
    """The words on a slider: force for torque, position for angle."""
    if not slides:
        return words
    for turning, sliding in (("torsional ", ""), ("torque", "force"), ("angle", "position"), ("twist", "deflection")):
        words = words.replace(turning, sliding)
    return words


def field_along(spec: Field, slides: bool) -> Field:
    """The declaration of a field as it reads on a slider."""
    if not slides:
        return spec
    return replace(spec, unit=unit_along(spec.unit, True), words=words_along(spec.words, True))


def sliders_of(block: Block, nodes: Sequence[int], sliding: frozenset[int]) -> tuple[frozenset[str], bool]:
    """Flanges of a block that slide, and whether those do that take both (the ground follows its fellows)."""
    flanges = type(block).flanges
    both = any(f.slider is None and n in sliding for f, n in zip(flanges.values(), nodes, strict=True))
    return frozenset(name for name, f in flanges.items() if (both if f.slider is None else f.slider)), both


@dataclass(slots=True)
class _Line:
    """Nodes of one kind: the first flange that turns, the first that slides, and the blocks that carry the kind on."""

    turning: str = ""
    sliding: str = ""
    through: list[str] = field(default_factory=list)


def sliding_nodes(components: Sequence[Ends], n_nodes: int) -> tuple[frozenset[int], list[str]]:
    """The nodes that slide, and what is wrong where sliders meet turning shafts.

    A flange that takes both (slider=None) is what it is connected to; all such flanges of a block are alike.
    """
    if not any(f.slider for kind in {type(block) for _, block, _ in components} for f in kind.flanges.values()):
        return frozenset(), []
    alike = DisjointSets[int]()
    fixed: list[tuple[int, str, bool]] = []
    carriers: list[tuple[int, str]] = []
    for path, block, nodes in components:
        flanges = type(block).flanges
        ends = [(n, f, name) for n, (name, f) in zip(nodes, flanges.items(), strict=True) if n >= 0]
        both = [n for n, f, _ in ends if f.slider is None]
        fixed += [
            (n, f"flange '{name}' of {type(block).__name__} '{path}'", f.slider) for n, f, name in ends
            if f.slider is not None
        ]  # fmt: skip
        for n in both[1:]:
            alike.join(n, both[0])
        if len(both) > 1:
            carriers.append((both[0], f"{type(block).__name__} '{path}'"))
    lines: dict[int, _Line] = {}
    for n, name, slides in fixed:
        line = lines.setdefault(alike.root(n), _Line())
        if slides:
            line.sliding = line.sliding or name
        else:
            line.turning = line.turning or name
    for n, name in carriers:
        lines.setdefault(alike.root(n), _Line()).through.append(name)
    slide = {root for root, line in lines.items() if line.sliding}
    return frozenset(n for n in range(n_nodes) if alike.root(n) in slide), list(_contradictions(lines))


def _contradictions(lines: Mapping[int, _Line]) -> Iterable[str]:
    for line in lines.values():
        if line.sliding and line.turning:
            through = f" (through {', '.join(line.through[:3])})" if line.through else ""
            yield (
                f"{line.sliding} slides, but {line.turning}, which it is connected to{through}, turns: "
                "put a Rack between them"
            )
