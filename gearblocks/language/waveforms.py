"""Periodic signals over time by name: pulses and trapezoids. Each flank is located in a run.

Knows nothing of what they drive.
"""

from __future__ import annotations

from typing import Any

from gearblocks.errors import ParameterError, by_name_only
from gearblocks.language.expression import Expr, as_expr
from gearblocks.language.functions import piecewise
from gearblocks.language.signals import Table, constant_value, time


@by_name_only
def pulse(
    amplitude: Any = 1.0, *, period: float, duty: float = 0.5, start: float = 0.0, offset: Any = 0.0,
    count: int | None = None,
) -> Expr:  # fmt: skip
    """A pulse train over time: offset + amplitude during the first part `duty` of each period [s], else offset.

    start: time of the first flank [s]; count: number of pulses (None: without end). amplitude and offset may be Parameters,
    Inputs or expressions. The right limit holds at a flank.
    """
    _check("pulse", {"period": period, "start": start}, count)
    if not isinstance(duty, (int, float)) or not 0 < duty < 1:
        raise ParameterError(
            f"pulse: duty = {duty!r} must be > 0 and < 1: the part of a period for which the pulse is on"
        )
    shape = Table([0.0, duty * period, period], [1.0, 0.0, 0.0], kind="step", periodic=True)
    return _train(shape, amplitude, offset, start, period, count)


@by_name_only
def trapezoid(
    amplitude: Any = 1.0, *, rising: float, width: float, falling: float, period: float, start: float = 0.0,
    offset: Any = 0.0, count: int | None = None,
) -> Expr:  # fmt: skip
    """A train of trapezoids over time: offset, up to offset + amplitude within `rising`, held for `width`, down in `falling`.

    All times in s; rising + width + falling <= period. width=0: triangles. start: time of the first rise; count: number of
    trapezoids (None: without end). amplitude and offset may be Parameters, Inputs or expressions.
    """
    _check("trapezoid", {"rising": rising, "falling": falling, "period": period, "start": start}, count)
    if not isinstance(width, (int, float)) or width < 0:
        raise ParameterError(f"trapezoid: width = {width!r} s must be a number >= 0")
    x, y = [0.0, rising], [0.0, 1.0]
    if width > 0:
        x, y = [*x, rising + width], [*y, 1.0]
    end = rising + width + falling
    if end > period * (1 + 1e-12):
        raise ParameterError(
            f"trapezoid: rising + width + falling = {end:.6g} s must fit into the period of {period:.6g} s"
        )
    if end < period * (1 - 1e-12):
        x, y = [*x, end], [*y, 0.0]
    shape = Table([*x, period], [*y, 0.0], periodic=True)
    return _train(shape, amplitude, offset, start, period, count)


def _check(name: str, times: dict[str, Any], count: Any) -> None:
    for what, value in times.items():
        least = "" if what == "start" else " > 0"
        if isinstance(value, bool) or not isinstance(value, (int, float)) or (least and not value > 0):
            flanks = "; gb.pulse has vertical flanks" if what in ("rising", "falling") else ""
            raise ParameterError(f"{name}: {what} = {value!r} s must be a number{least}{flanks}")
    if count is not None and (type(count) is not int or count < 1):
        raise ParameterError(f"{name}: count = {count!r} must be a whole number >= 1, or None: without end")


def _train(shape: Table, amplitude: Any, offset: Any, start: float, period: float, count: int | None) -> Expr:
    """offset + amplitude shape(time - start), within its first and last period."""
    on = as_expr(amplitude) * shape(time - start)
    rest = constant_value(offset) == 0
    pairs: list[tuple[Any, Any]] = [(0.0, time < start)] if start > 0 else []
    if count is not None:
        pairs.append((on, time < start + count * period))
        pairs.append((0.0, True))
    else:
        pairs.append((on, True))
    made = piecewise(*pairs) if len(pairs) > 1 else on
    whole = made if rest else as_expr(offset) + made
    assert isinstance(whole, Expr)
    return whole
