"""Structure of a train: what of its blocks decides the form of the equations, and what is only a number.

Two trains of equal structure share one program. Knows nothing of laws.
"""

from __future__ import annotations

import hashlib
from typing import Any

from gearblocks.language.block import Declared
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Field
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.train.graph import Train


def structure_of(value: Any, *, exact: bool = False) -> Any:
    """What decides the law of a block: its class, which fields are present, choices, signals; no numbers.

    exact=True adds the values that enter ratios, and which numbers are zero (an inertia that is not there). Plain tuples
    and text, equal for equal structure.
    """
    parts: list[Any] = [f"{type(value).__module__}.{type(value).__qualname__}"]
    store = value.__dict__
    for name, field in type(value).fields.items():
        parts.append(_structure(store[name], field, exact))
    return tuple(parts)


def _structure(value: Any, field: Field, exact: bool) -> Any:
    if value is None:
        return None
    if type(value) is float and field.role in ("param", "signal"):
        return "zero" if exact and value == 0 and field.ge == 0 else "number"
    if isinstance(value, tuple):
        return tuple(_structure(v, field, exact) for v in value)
    if field.role == "exact":
        return repr(value) if exact else "exact"
    if isinstance(value, (float, int)) and field.role in ("param", "signal"):
        return "zero" if exact and value == 0 and field.ge == 0 else "number"
    if isinstance(value, Declared):
        return structure_of(value, exact=exact)
    if isinstance(value, Parameter):
        zero = exact and value.value == 0 and field.ge == 0
        return ("parameter", value.name, value.unit, *(["zero"] if zero else []))
    if isinstance(value, Input):
        return ("input", value.name, value.start, value.unit)
    if isinstance(value, (Table, Table2)):
        return ("table", value.digest())
    if isinstance(value, Expr):
        leaves = sorted({repr(leaf.args[0]) for leaf in value.leaves() if leaf.op == "input"})
        return ("expression", str(value), *leaves)
    return repr(value)


def structural_text(train: Train) -> str:
    """Canonical text of the whole structure: equal text, equal program."""
    lines = [train.name, str(train.n_nodes)]
    memo: dict[Any, str] = {}
    for c in train.components:
        structure = structure_of(c.block, exact=True)
        if structure not in memo:
            memo[structure] = hashlib.sha256(repr(structure).encode()).hexdigest()[:16]
        lines.append(f"{c.path} {memo[structure]} {c.nodes}")
    lines += [f"{c.name} {c.expr} {c.unit}" for c in train.coordinates]
    return "\n".join(lines)
