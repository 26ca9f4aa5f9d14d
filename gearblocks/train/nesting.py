"""Blocks of a nested train: their Inputs get the path of the train, and their feedback signals are looked for inside it
first. Knows nothing of laws.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from gearblocks.language.block import Block, Declared
from gearblocks.language.expression import Expr
from gearblocks.language.signals import Input


def localised(block: Block, prefix: str, names: Collection[str]) -> Block:
    """The block as it stands in a train at `prefix` (with its dot) that has parts of those names."""
    changed = _owner(block, prefix, names)
    assert isinstance(changed, Block)
    return changed


def _owner(owner: Declared, prefix: str, names: Collection[str]) -> Declared:
    store = owner.__dict__
    new = {name: _value(store[name], prefix, names) for name in type(owner).fields}
    if all(new[name] is store[name] for name in new):
        return owner
    changed = owner.changed(**new)
    assert isinstance(changed, Declared)
    return changed


def _value(value: Any, prefix: str, names: Collection[str]) -> Any:
    if isinstance(value, Input):
        return replace(value, name=prefix + value.name)
    if isinstance(value, Expr):
        return _expr(value, prefix, names)
    if isinstance(value, Declared):
        return _owner(value, prefix, names)
    if isinstance(value, tuple):
        items = tuple(_value(v, prefix, names) for v in value)
        return value if all(a is b for a, b in zip(items, value, strict=True)) else items
    return value


def _expr(e: Expr, prefix: str, names: Collection[str]) -> Expr:
    if e.op == "input":
        return Expr("input", replace(e.args[0], name=prefix + e.args[0].name))
    if e.op == "sense":
        inside = e.args[0].split(".")[0] in names
        return Expr("sense", prefix + e.args[0]) if inside else e
    args = [_expr(a, prefix, names) if isinstance(a, Expr) else a for a in e.args]
    return e if all(a is b for a, b in zip(args, e.args, strict=True)) else Expr(e.op, *args)
