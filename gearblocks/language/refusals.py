"""What Python can ask of a number and an expression does not answer: remainders, whole parts, rounding."""

from __future__ import annotations

from typing import Any, NoReturn

from gearblocks.errors import ParameterError


class NoWholeNumbers:
    """Base of expressions: operators that ask for whole numbers are refused in words."""

    __slots__ = ()

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


def _words(x: Any) -> str:
    """An expression, or a leaf, as it is printed in one."""
    return str(x._expr_()) if hasattr(x, "_expr_") else str(x)


def _refuse(asked: str) -> NoReturn:
    raise ParameterError(
        f"'{asked}': an expression has no whole part and no remainder; what repeats is gb.Table(x, y, periodic=True), gb.pulse "
        "or gb.trapezoid, steps are gb.Table(x, y, 'step') or gb.piecewise((value, condition), (other, True))"
    )
