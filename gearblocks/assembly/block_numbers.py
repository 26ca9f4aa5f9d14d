"""Numbers of blocks as they are before any run: what expressions of laws have for a value then.

Knows nothing of what they are asked for.
"""

from __future__ import annotations

import math
from typing import Any

from gearblocks.assembly.tables import Batch
from gearblocks.language.signals import constant_value
from gearblocks.train.graph import Component
from gearblocks.train.values import numbers_of


def number(batch: Batch, c: Component, expression: Any) -> float:
    """An expression of numbers of a block; NaN where it holds anything else."""
    numbers = {path: constant_value(value) for path, value, _ in numbers_of(c.block, "")}
    values = {}
    for symbol in getattr(expression, "free_symbols", ()):
        meaning = batch.law.pool.roles[symbol]
        values[symbol] = meaning.of.si if meaning.role == "shared" else numbers.get(meaning.of, math.nan)
    try:
        return float(expression.xreplace(values)) if values else float(expression)
    except (TypeError, ValueError):
        return math.nan
