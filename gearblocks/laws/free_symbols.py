"""The free symbols of an expression, remembered: sympy gathers them anew from every leaf each time it is asked.

Knows nothing of what symbols stand for.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy as sp


@lru_cache(maxsize=50_000)
def symbols_in(expr: Any) -> frozenset[Any]:
    """What expr.free_symbols holds."""
    if expr.is_Symbol:
        return frozenset((expr,))
    if type(expr).free_symbols is not sp.Basic.free_symbols:  # an expression that binds symbols
        return frozenset(expr.free_symbols)
    return _EMPTY.union(*map(symbols_in, expr.args))


_EMPTY: frozenset[Any] = frozenset()
