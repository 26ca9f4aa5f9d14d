"""What a run watches: effects that were left out of a train (the blocks as they were before, and the train with the compliance
that some of them lost), and tables that it may leave.

Knows nothing of runs: what a run watches of it is found there.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, final

from gearblocks.errors import GearblocksError
from gearblocks.language.block import Block
from gearblocks.language.fields import COMPLIANCE
from gearblocks.language.watches import Watch
from gearblocks.train.graph import Train, Tree, flatten


@final
@dataclass(frozen=True, slots=True, eq=False)
class LeftOut:
    """Blocks by path as they were, with the effects that went; full: the train with the compliance that some lost, these
    without backlash; tables: path of a block, its field with a table, what shows that a run is beyond it."""

    blocks: tuple[tuple[str, Block, tuple[str, ...]], ...]
    full: Train | None
    tables: tuple[tuple[str, str, Watch], ...] = ()

    def __repr__(self) -> str:
        return f"<left out: {', '.join(self.names) or 'nothing'}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Dotted names of the effects."""
        return tuple(f"{path}.{effect}" for path, _, effects in self.blocks for effect in effects)

    @property
    def rigid(self) -> tuple[str, ...]:
        """Dotted names of the compliances among them."""
        return tuple(name for name in self.names if _is(COMPLIANCE, name))

    def beyond_tables(self, outputs: Container[str]) -> Iterator[tuple[str, str, Watch]]:
        """Name of a field with a table, name of an output of the train, and what it shows."""
        for path, field, watch in self.tables:
            if f"{path}.{watch.unless}" not in outputs:
                yield f"{path}.{field}", f"{path}.{watch.output}", watch

    def watches(self) -> Iterator[tuple[str, str, Watch]]:
        """Name of an effect, name of an output of the train, and what it shows."""
        for path, block, effects in self.blocks:
            for effect in effects:
                yield from ((f"{path}.{effect}", f"{path}.{w.output}", w) for w in block.would_show(effect))


def left_out_of(tree: Tree, rows: Iterable[tuple[str, Block | None, Block]]) -> LeftOut | None:
    """rows: path of each block, what it was before anything was left out of it, what it is; None where nothing is missing, and
    no table can be left."""
    blocks, tables = [], list[tuple[str, str, Watch]]()
    for path, before, now in rows:
        tables += ((path, field, watch) for field, watch in now.beyond_tables())
        if before is not None:
            has = now.effects()
            if gone := tuple(name for name in before.effects() if name not in has):
                blocks.append((path, before, gone))
    if not blocks and not tables:
        return None
    soft = {path: closed(block) for path, block, gone in blocks if any(_is(COMPLIANCE, x) for x in gone)}
    return LeftOut(tuple(blocks), _with(tree, soft) if soft else None, tuple(tables))


def _is(effect: str, name: str) -> bool:
    return name.rpartition(".")[2] == effect


def closed(block: Block) -> Block:
    """The block without its backlash: in contact, whatever the load."""
    for name in [x for x in block.effects() if _is("backlash", x)]:
        block = block.without_effect(name)
    return block


def _with(tree: Tree, blocks: Mapping[str, Block]) -> Train | None:
    """The train with these blocks in place of those at their paths; None where it is none."""
    try:
        return flatten(_replaced(tree, blocks, ""))
    except GearblocksError:
        return None


def _replaced(tree: Tree, blocks: Mapping[str, Block], prefix: str) -> Tree:
    def part(name: str, present: Any) -> Any:
        path = prefix + name
        return _replaced(present, blocks, f"{path}.") if isinstance(present, Tree) else blocks.get(path, present)

    return replace(tree, parts=tuple((name, part(name, present)) for name, present in tree.parts))
