"""Functions of numpy on expressions: np.sin(expression) and arithmetic with numpy scalars."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from gearblocks.errors import ParameterError

_NUMPY_OPERATORS: dict[str, Callable[..., Any]] = {
    "add": operator.add, "subtract": operator.sub, "multiply": operator.mul, "divide": operator.truediv,
    "power": operator.pow, "float_power": operator.pow, "negative": operator.neg, "positive": operator.pos,
    "less": operator.lt, "less_equal": operator.le, "greater": operator.gt, "greater_equal": operator.ge,
}  # fmt: skip
_NUMPY_FUNCTIONS = {
    "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan2", "absolute": "Abs", "fabs": "Abs",
    "minimum": "Min", "maximum": "Max",
}  # fmt: skip


def numpy_call(
    as_expr: Callable[[Any], Any], functions: tuple[str, ...], ufunc: Any, method: str, inputs: tuple[Any, ...]
) -> Any:
    """The expression that a numpy function of expressions and numbers means; ParameterError for arrays, other functions."""
    name = ufunc.__name__
    arguments = [as_expr(x) for x in inputs]
    if method == "__call__" and name in _NUMPY_OPERATORS:
        return _NUMPY_OPERATORS[name](*arguments)
    name = _NUMPY_FUNCTIONS.get(name, name)
    if method == "__call__" and name in functions:
        return type(arguments[0])(name, *arguments)
    raise ParameterError(
        f"np.{ufunc.__name__} takes no expression such as '{arguments[0]}'; there are {', '.join(functions)}"
    )
