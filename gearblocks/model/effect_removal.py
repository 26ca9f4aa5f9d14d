"""Removal of effects: the blocks of a train without some of their effects, and the start values that follow from others then.

Of a small part the inertia is an effect. Without it the part turns with its neighbour: the stiffest compliant element at its
shaft becomes rigid (Rivin, ASME paper 80-DET-104, 1980: the partial system of the highest frequency is merged), so that the
inertia J is lumped into the body behind it, times the ratio squared, and none is lost. Where nothing that may become rigid
is there, the part stays. Knows nothing of laws.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

from gearblocks.blocks.bodies import Inertia
from gearblocks.blocks.translational import Mass
from gearblocks.language.block import Block, start_fields
from gearblocks.language.fields import COMPLIANCE, GIVING_WAY, INERTIA
from gearblocks.train.graph import GROUND, Train, Tree, flatten


@dataclass(frozen=True, slots=True)
class Removal:
    """The changed blocks by path, and what went: effects, then start values that depend on others now."""

    blocks: Mapping[str, Block]
    dropped: tuple[str, ...]


def without_effects(tree: Tree, goes: Callable[[str], bool], kept: Container[str] = ()) -> Removal:
    """A train without the effects, by dotted name, that go, and what cannot be without them. kept: compliances that stay
    compliant though a small part rests on them."""
    before = dict(blocks_of(tree))
    after, small = dict(before), list[str]()
    for path, block in before.items():
        for effect in sorted(block.effects(), key=lambda e: e.endswith(COMPLIANCE)):
            if goes(f"{path}.{effect}") and effect in after[path].effects():
                if effect == INERTIA and isinstance(block, (Inertia, Mass)):
                    small.append(path)
                else:
                    after[path] = after[path].without_effect(effect)
    for path in small:
        _lump(tree, before, after, path, kept)
    names, left = _effects(before), set(_effects(after))
    dropped = tuple(name for name in names if name not in left)
    released = _released(tree, before, after) if _may_tie(before, after) else ()
    return Removal({p: b for p, b in after.items() if b is not before[p]}, (*dropped, *released))


def needed(block: Block, kept: AbstractSet[str]) -> set[str]:
    """The effects of a block that it would lose one of `kept` without."""
    present = block.effects().keys()
    return {e for e in present if not kept <= block.without_effect(e).effects().keys() | {e}} if kept else set()


def blocks_of(tree: Tree, prefix: str = "") -> Iterator[tuple[str, Block]]:
    """Path and block of every block; composite ones as they are."""
    for name, part in tree.parts:
        if isinstance(part, Tree):
            yield from blocks_of(part, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", part


def with_blocks(tree: Tree, blocks: Mapping[str, Block], prefix: str = "") -> Tree:
    """The tree with other blocks at some paths."""
    parts = tuple(
        (n, with_blocks(p, blocks, f"{prefix}{n}.") if isinstance(p, Tree) else blocks.get(f"{prefix}{n}", p))
        for n, p in tree.parts
    )
    return replace(tree, parts=parts)


def _effects(blocks: Mapping[str, Block]) -> list[str]:
    return [f"{path}.{effect}" for path, block in blocks.items() for effect in block.effects()]


def _lump(tree: Tree, before: Mapping[str, Block], blocks: dict[str, Block], path: str, kept: Container[str]) -> None:
    """The inertia of a small part into the body on its shaft, or the one behind an element there: the one that went
    rigid already, else the stiffest."""
    train = flatten(with_blocks(tree, blocks), complete=False, whole=True)
    part = next(c for c in train.components if c.path == path)
    found: list[tuple[float, str, str]] = []
    for c in train.components:
        for flange, node in zip(type(c.block).flanges, c.nodes, strict=True):
            if c.path == path or node == GROUND or node not in part.nodes:
                continue
            gives_way = c.block.gives_way(flange)
            went_rigid = gives_way is None and before[c.path].gives_way(flange) is not None
            if went_rigid or isinstance(c.block, (Inertia, Mass)):
                blocks[path] = blocks[path].without_effect(INERTIA)
                return
            if gives_way is not None and f"{c.path}.{gives_way[0]}" not in kept:
                found.append((gives_way[1], c.path, gives_way[0]))
    if found:
        _, owner, effect = max(found, key=lambda x: x[0])
        blocks[owner] = blocks[owner].without_effect(effect)
        blocks[path] = blocks[path].without_effect(INERTIA)


def _may_tie(before: Mapping[str, Block], after: Mapping[str, Block]) -> bool:
    """Whether a block may have become a rigid tie: one of the catalogue by the effects that it lost, any other that changed."""
    for path, block in before.items():
        left = after[path].effects()
        gone = block.effects().keys() - left.keys()
        if gone and not type(block).__module__.startswith("gearblocks."):
            return True
        for effect in gone:
            group, dot, own = effect.rpartition(".")
            if own in GIVING_WAY and left.keys().isdisjoint(f"{group}{dot}{e}" for e in GIVING_WAY):
                return True  # with a gap left, a rigid impact is no tie
    return False


def _released(tree: Tree, before: Mapping[str, Block], after: dict[str, Block]) -> tuple[str, ...]:
    """Takes out the start values that depend on others now; their names."""
    from gearblocks.assembly.dependent_starts import dependent_starts

    was, now = (dependent_starts(_flat(tree, blocks)) for blocks in (before, after))
    names = []
    for of, paths in now.items():
        for path in paths:
            if path not in was[of] and path in after:
                start = start_fields(type(after[path]))[of]
                after[path] = after[path].changed(**{start: None})
                names.append(f"{path}.{start}")
    return tuple(names)


def _flat(tree: Tree, blocks: Mapping[str, Block]) -> Train:
    return flatten(with_blocks(tree, blocks), complete=False)
