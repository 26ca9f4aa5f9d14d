"""Blocks of a nested train: their Inputs get the path of the train, and their feedback signals are looked for inside it
first. Knows nothing of laws.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.expression import Expr
from gearblocks.language.signals import Input
from gearblocks.train.leaves import with_leaves


def localised(block: Block, prefix: str, names: Collection[str]) -> Block:
    """The block as it stands in a train at `prefix` (with its dot) that has parts of those names."""

    def changed(leaf: Any) -> Any:
        if isinstance(leaf, Input):
            return replace(leaf, name=prefix + leaf.name)
        if isinstance(leaf, Expr) and leaf.args[0].split(".")[0] in names:
            return Expr("sense", prefix + leaf.args[0])
        return leaf

    found = with_leaves(block, changed)
    assert isinstance(found, Block)
    return found
