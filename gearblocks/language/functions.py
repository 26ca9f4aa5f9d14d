"""Functions for signals and laws: of numbers a number, of gb.time, Parameters, Inputs, Tables and gb.sense(...) an
expression, of sympy expressions (and so of the symbols in `physics`) a sympy expression.

Functions that are not here are sympy's or numpy's: np.arctan(gb.time), sympy.asinh(...), abs(...) give expressions too.
Knows nothing of laws.
"""

from __future__ import annotations

import math
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, by_name_only
from gearblocks.language.expression import Expr, as_expr, evaluate, function, is_condition, is_sympy, number

pi = math.pi
"""The ratio of a circle's circumference to its diameter."""


@by_name_only
def sin(x: Any) -> Any:
    """Sine of an angle in rad."""
    return _call("sin", x)


@by_name_only
def cos(x: Any) -> Any:
    """Cosine of an angle in rad."""
    return _call("cos", x)


@by_name_only
def tan(x: Any) -> Any:
    """Tangent of an angle in rad."""
    return _call("tan", x)


@by_name_only
def tanh(x: Any) -> Any:
    """Hyperbolic tangent: a smooth sign."""
    return _call("tanh", x)


@by_name_only
def exp(x: Any) -> Any:
    """Exponential function."""
    return _call("exp", x)


@by_name_only
def log(x: Any) -> Any:
    """Natural logarithm."""
    return _call("log", x)


@by_name_only
def sqrt(x: Any) -> Any:
    """Square root."""
    return _call("sqrt", x)


@by_name_only
def minimum(*values: Any) -> Any:
    """The least of several values; where another one becomes it is located in a run."""
    return _call("Min", *_several("minimum", values))


@by_name_only
def maximum(*values: Any) -> Any:
    """The largest of several values; where another one becomes it is located in a run."""
    return _call("Max", *_several("maximum", values))


@by_name_only
def Heaviside(x: Any) -> Any:
    """1 where x >= 0, else 0; the jump is located in a run."""
    return _call("Heaviside", x)


_COMPARED = "; == and != compare no values: abs(x - 2) < 0.5; between numbers choose with `a if n > 3 else b`"


@by_name_only
def piecewise(*pairs: tuple[Any, Any]) -> Any:
    """(value, condition) pairs, the first true condition wins; the last condition must be True.

    Conditions are met in passing. What stays on a limit (a pedal at 0, the number of a gear) is as > or >= says.
    """
    flat: list[Any] = []
    for i, pair in enumerate(pairs):
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[1] is False:
            raise ParameterError(
                f"piecewise: {pair!r:.80} must be (value, condition), the condition made with < or >{_COMPARED}"
            )
        if pair[1] is True and i < len(pairs) - 1:
            raise ParameterError(
                f"piecewise: {pair!r:.80} stands before others, which its condition True keeps from counting{_COMPARED}"
            )
        if pair[1] is not True and not is_condition(pair[1]):
            raise ParameterError(f"piecewise: the condition of {pair!r:.80} is a value: compare it, such as x > 0.5")
        flat += pair
    if not pairs or pairs[-1][1] is not True:
        raise ParameterError("piecewise has no value where no condition holds: end it with (value, True)")
    if any(is_sympy(x) and not _is_signal(x) for x in flat):
        import sympy as sp

        return sp.Piecewise(*pairs)
    return Expr("Piecewise", *(number(1.0) if x is True else as_expr(x) for x in flat))


@overload
def rpm(speed: float) -> float: ...
@overload
def rpm(speed: NDArray[Any] | list[float] | tuple[float, ...]) -> NDArray[np.float64]: ...
@overload
def rpm(speed: Any) -> Any: ...
@by_name_only
def rpm(speed: Any) -> Any:
    """Revolutions per minute as rad/s, for a number, an array or an expression."""
    if isinstance(speed, (int, float)) or hasattr(speed, "_expr_") or is_sympy(speed):
        return speed / 60.0 * (2.0 * math.pi)
    try:
        if None in np.asarray(speed, dtype=object).ravel().tolist():  # numpy's number for it is NaN
            raise TypeError
        return np.asarray(speed, dtype=np.float64) / 60.0 * (2.0 * math.pi)
    except (TypeError, ValueError):
        raise ParameterError(
            f"rpm({speed!r:.80}): what it converts are numbers; a value with its unit is the text alone, '3000 rpm'"
        ) from None


def _call(name: str, *arguments: Any) -> Any:
    """The number, expression or sympy expression that a function of such is."""
    if any(is_sympy(x) and not _is_signal(x) for x in arguments):
        import sympy as sp

        exact = [sp.sympify(x) for x in arguments]
        return sp.Heaviside(exact[0], 1) if name == "Heaviside" else getattr(sp, name)(*exact)
    made = function(name, *arguments)
    if any(x.op != "number" for x in made.args):
        return made
    try:
        value = evaluate(made, lambda _: math.nan)  # there is no leaf
    except (ArithmeticError, ValueError):
        value = math.nan
    if not math.isfinite(value):
        raise ParameterError(f"'{made}' is no finite real number")
    return value


def _is_signal(x: Any) -> bool:
    """Whether a sympy expression is one of gb.time and its like alone, none of the symbols of a law."""
    return all(hasattr(symbol, "leaf") for symbol in x.free_symbols)


def _several(name: str, values: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(values) < 2:
        raise ParameterError(f"{name} compares two or more values, one by one, not {values!r:.80}")
    return values
