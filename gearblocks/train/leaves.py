"""Blocks and expressions with other leaves in them: Parameters, Inputs and feedback signals. Knows nothing of laws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from gearblocks.language.block import Declared
from gearblocks.language.expression import Expr
from gearblocks.language.signals import Input, Parameter

Change = Callable[[Any], Any]
"""A Parameter, an Input or a sense(...) and what takes its place: itself where it stays."""


def with_leaves(value: Any, change: Change) -> Any:
    """A block, effect, expression or row of them with its leaves changed; the same object where none is."""
    if isinstance(value, Parameter | Input):
        return change(value)
    if isinstance(value, Expr):
        return _expr(value, change)
    if isinstance(value, Declared):
        new = {name: with_leaves(value.__dict__[name], change) for name in type(value).fields}
        return value if all(new[name] is value.__dict__[name] for name in new) else value.changed(**new)
    if isinstance(value, tuple):
        items = tuple(with_leaves(v, change) for v in value)
        return value if all(a is b for a, b in zip(items, value, strict=True)) else items
    return value


def _expr(e: Expr, change: Change) -> Expr:
    if e.op == "sense":
        changed: Expr = change(e)
        return changed
    if e.op in ("input", "parameter"):
        args = [change(e.args[0])]
    else:
        args = [_expr(a, change) if isinstance(a, Expr) else a for a in e.args]
    return e if all(a is b for a, b in zip(args, e.args, strict=True)) else Expr(e.op, *args)


def with_parameter(value: Any, name: str, number: Any) -> Any:
    """A block, effect, expression or row of them where the Parameter of a name has another value, in its unit or by text."""

    def changed(leaf: Any) -> Any:
        return replace(leaf, value=number) if isinstance(leaf, Parameter) and leaf.name == name else leaf

    return with_leaves(value, changed)
