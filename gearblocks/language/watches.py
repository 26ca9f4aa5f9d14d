"""What shows that an effect would have acted where it was left out, and what frequencies excite a train: declared by blocks.

Knows nothing of trains and runs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, final

from gearblocks.errors import arguments_told
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.signals import Table, constant_value
from gearblocks.language.tidy import Tidy


@final
@arguments_told
@dataclass(frozen=True, slots=True)
class Watch(metaclass=Tidy):
    """An output of a block that shows that an effect would act: its size exceeds `limit` [its unit], or, without one, its sign
    changes. words: what this means. unless: another output; where a train has it, this one tells nothing."""

    output: str
    words: str
    limit: float | None = None
    unless: str = ""

    def of_part(self, part: str) -> Watch:
        """The same, of a composite block whose part has these outputs."""
        return replace(self, output=f"{part}.{self.output}", unless=self.unless and f"{part}.{self.unless}")


def beyond(table: Any, output: str) -> Iterator[Watch]:
    """That the size of an output leaves a Table whose end value is held although its last line rises or falls."""
    if not isinstance(table, Table) or (table.kind, table.periodic, table.extrapolate) != ("linear", False, "hold"):
        return
    if len(table.x) > 1 and table.x[-1] > 0 and table.y[-1] != table.y[-2]:
        yield Watch(output, f"beyond its last point, {table.x[-1]:.6g}, it is held", float(table.x[-1]))


def beyond_both(table: Any, output: str, shift: float = 0.0) -> Iterator[Watch]:
    """That an output, less a shift, leaves a Table over it whose end values are held although a line at an end rises or
    falls: sizes alone are watched, so that of two ends the farther one counts."""
    if not isinstance(table, Table) or (table.kind, table.periodic, table.extrapolate) != ("linear", False, "hold"):
        return
    low, high = float(table.x[0]) + shift, float(table.x[-1]) + shift
    level = (table.y[0] == table.y[1], table.y[-1] == table.y[-2])
    limit = max(-low, high)
    if isfinite(limit) and limit > 0 and not (all(level) or (level[0] and -low > high) or (level[1] and high > -low)):
        yield Watch(output, f"beyond its points, {table.x[0]:.6g} to {table.x[-1]:.6g}, it is held", limit)


@final
@arguments_told
@dataclass(frozen=True, slots=True)
class Excitation(metaclass=Tidy):
    """What excites a train: order times the speed of a flange against another one (None: the ground), or a frequency
    [rad/s]."""

    words: str
    frequency: float = 0.0
    order: float = 0.0
    flange: str = ""
    against: str | None = None


def excitations_by_time(values: Iterable[Any]) -> Iterator[Excitation]:
    """Frequencies of the waves sin(w t + ...) and cos(w t + ...) in expressions of time, Parameters at their values."""
    for value in values:
        if isinstance(value, Expr):
            yield from (Excitation("a source", frequency=w) for w in sorted(set(_frequencies(value))))


def _frequencies(e: Expr) -> Iterator[float]:
    """Frequencies of waves whose argument rises evenly with time."""
    for a in e.args:
        if isinstance(a, Expr):
            yield from _frequencies(a)
    if e.op in ("sin", "cos") and isinstance(e.args[0], Expr):
        argument = e.args[0]
        if {leaf.op for leaf in argument.leaves()} <= {"time", "parameter"}:
            first, middle, last = (_at(argument, t) for t in (0.0, 1.0, 2.0))
            if last != first and abs(last - 2 * middle + first) <= 1e-9 * abs(last - first):
                yield abs(last - first) / 2


def _at(e: Expr, t: float) -> float:
    return evaluate(e, lambda leaf: t if leaf.op == "time" else constant_value(leaf.args[0]))


def orders_of(effect: Any, per_cycle: float, words: str, flange: str, against: str | None) -> Iterator[Excitation]:
    """What an effect over the angle or a frequency excites: the orders of its cycle, each per_cycle turns of the flange."""
    rows = [getattr(effect, name, None) for name in ("cos", "sin")]
    orders = max([1, *(len(row) for row in rows if isinstance(row, tuple))])
    for part in ("first", "second"):
        if getattr(effect, part, None) is not None:
            yield from orders_of(getattr(effect, part), per_cycle, words, flange, against)
    driven = getattr(effect, "driven_by", None)
    for j in range(1, orders + 1):
        if isinstance(driven, str):
            yield Excitation(words, order=j * per_cycle, flange=flange, against=against)
        elif isfinite(value := constant_value(driven)):
            yield Excitation(words, frequency=abs(j * value))
