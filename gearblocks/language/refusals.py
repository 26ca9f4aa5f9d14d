"""What Python can ask of a number and an expression does not answer: truth, remainders, whole parts, rounding."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NoReturn

from gearblocks.errors import GearblocksError, ParameterError


class ConditionError(GearblocksError, TypeError):
    """An expression that is asked whether it holds, as `if`, `and`, `not` and np.where do; sympy expects a TypeError."""


def condition_asked(condition: object) -> ConditionError:
    """The error of a condition whose truth is asked before any run."""
    return ConditionError(
        f"'{condition}' is a condition, not a truth: in place of if or np.where write gb.piecewise((value, condition), "
        "(other, True)), in place of max and min gb.maximum and gb.minimum, in place of and, or, not write & and | and ~ with "
        "each condition in brackets, in place of a < x < b write (a < x) & (x < b)"
    )


def no_condition(sign: str, value: object) -> ParameterError:
    """The error of a value that stands where conditions are joined."""
    return ParameterError(
        f"'{value}' is no condition: {sign} goes with such, each in brackets: (x > 0) & (x < 1), ~(x > 0)"
    )


def condition_in(condition: object) -> ParameterError:
    """The error of a condition that stands as a number."""
    return ParameterError(
        f"'{condition}' is a condition, no number: in place of 5 * (x > 0) write gb.piecewise((5, x > 0), (0, True))"
    )


@lru_cache(maxsize=1)
def _asked_conditions(told: Callable[[Any], Any], joined: Callable[..., Any]) -> dict[Any, Any]:
    """By the relations of sympy, and by what joins them, the same that say, where they are asked whether they hold, what to
    write instead. told: a sympy condition in our words; joined: two conditions by "And" or "Or"."""
    import sympy as sp

    def condition(kind: Any) -> Any:
        class Condition(kind):  # type: ignore[misc]  # sympy carries no types
            __slots__ = ()

            func = kind
            """What it becomes where sympy makes it anew."""

            @classmethod
            def _of(cls, made: Any) -> Any:
                return sp.Basic.__new__(cls, *made.args)

            def __bool__(self) -> bool:
                raise condition_asked(told(self))

            def __and__(self, other: Any) -> Any:
                return joined("And", self, other)

            def __or__(self, other: Any) -> Any:
                return joined("Or", self, other)

            __rand__, __ror__ = __and__, __or__

            def __invert__(self) -> Any:
                return asked(sp.Not(self), told, joined)

            def __mul__(self, other: Any) -> NoReturn:
                raise condition_in(told(self))

            __add__ = __radd__ = __sub__ = __rsub__ = __rmul__ = __truediv__ = __rtruediv__ = __pow__ = __rpow__ = (
                __mul__
            )

            def __reduce_ex__(self, protocol: object) -> tuple[Any, ...]:
                return kind, self.args

        Condition.__name__ = kind.__name__
        return Condition

    return {kind: condition(kind) for kind in (sp.Lt, sp.Le, sp.Gt, sp.Ge, sp.And, sp.Or, sp.Not)}


def asked(made: Any, told: Callable[[Any], Any], joined: Callable[..., Any]) -> Any:
    """What sympy made, as one of these where it is a condition."""
    kind = _asked_conditions(told, joined).get(type(made))
    return made if kind is None else kind._of(made)


class NoWholeNumbers:
    """Base of expressions: truth, and operators that ask for whole numbers, are refused in words."""

    __slots__ = ()

    def __bool__(self) -> bool:
        raise ConditionError(
            f"'{_words(self)}' is a value that a run gives, neither true nor false: compare it, as gb.piecewise((value, x > "
            "0.5), (other, True)) does, and join conditions by & and |, each in brackets; whether something is there at all "
            "is asked by `is not None`"
        )

    def __and__(self, other: Any) -> Any:
        raise no_condition("&", _words(self))

    def __or__(self, other: Any) -> Any:
        raise no_condition("|", _words(self))

    __rand__, __ror__ = __and__, __or__

    def __invert__(self) -> Any:
        raise no_condition("~", _words(self))

    def __mod__(self, other: Any) -> NoReturn:
        _refuse(f"{_words(self)} % {_words(other)}")

    def __rmod__(self, other: Any) -> NoReturn:
        _refuse(f"{_words(other)} % {_words(self)}")

    def __floordiv__(self, other: Any) -> NoReturn:
        _refuse(f"{_words(self)} // {_words(other)}")

    def __rfloordiv__(self, other: Any) -> NoReturn:
        _refuse(f"{_words(other)} // {_words(self)}")

    def __divmod__(self, other: Any) -> NoReturn:
        _refuse(f"divmod({_words(self)}, {_words(other)})")

    def __int__(self) -> NoReturn:
        _refuse(f"int({_words(self)})")

    def __trunc__(self) -> NoReturn:
        _refuse(f"trunc({_words(self)})")

    def __round__(self, digits: int | None = None) -> NoReturn:
        _refuse(f"round({_words(self)})")

    def rint(self) -> NoReturn:
        """What np.round asks for."""
        _refuse(f"round({_words(self)})")


def _words(x: Any) -> str:
    """An expression, or a leaf, as it is printed in one."""
    return str(x._expr_()) if hasattr(x, "_expr_") else str(x)


def _refuse(asked: str) -> NoReturn:
    raise ParameterError(
        f"'{asked}': an expression has no whole part and no remainder; what repeats is gb.Table(x, y, periodic=True), gb.pulse "
        "or gb.trapezoid, steps are gb.Table(x, y, 'step') or gb.piecewise((value, condition), (other, True))"
    )
