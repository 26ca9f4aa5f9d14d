"""None"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gearblocks.laws.rational import Exact


@dataclass(frozen=True, slots=True)
class Column:
    """One number per instance of a batch: a constant, an arithmetic progression or a table."""

    name: str
    values: tuple[float | int, ...]

    @property
    def is_table(self) -> bool:
        """Whether it needs an array in C."""
        return len(self.values) > 2 and self._progression() is None

    def _progression(self) -> tuple[Any, Any] | None:
        v = self.values
        step = v[1] - v[0] if len(v) > 1 else 0
        if all(isinstance(x, int) for x in v) and all(v[i] == v[0] + i * step for i in range(len(v))):
            return v[0], step
        return (v[0], 0) if all(x == v[0] for x in v) else None

    def at(self, i: int) -> str:
        """C for the entry of instance i."""
        return repr(self.values[i])

    def text(self) -> str:
        """C for the entry of instance `e`."""
        found = self._progression()
        if found is None:
            return f"{self.name}[e]"
        start, step = found
        if step == 0:
            return repr(start)
        return "e" if (start, step) == (0, 1) else f"{start} + {step} * e"

    @property
    def is_constant(self) -> bool:
        """Whether all instances share the value."""
        return all(x == self.values[0] for x in self.values)


def column(name: str, values: Sequence[float | Exact]) -> Column:
    """A column with plain numbers."""
    return Column(name, tuple(v if isinstance(v, int) else float(v) for v in values))


UNROLLED = 8
"""Batches of at most this many instances are called one by one, with numbers in place of table columns."""


@dataclass(slots=True)
class Statement:
    """lhs op rhs, for the template."""

    lhs: str
    op: str
    rhs: str
    full: bool = False


@dataclass(slots=True)
class Function:
    """One function of a batch. args: (C type, name, column); prologue: (name, text) of its constants."""

    name: str
    args: list[tuple[str, str, Column]]
    prologue: list[tuple[str, str]]
    body: list[Statement]
    count: int

    @property
    def calls(self) -> list[str]:
        """Argument lists of one call per instance, or of the single call inside a loop."""
        if self.count <= UNROLLED:
            return [", ".join([str(e), *(c.at(e) for _, _, c in self.args)]) for e in range(self.count)]
        return [", ".join(["e", *(c.text() for _, _, c in self.args)])]

    @property
    def looped(self) -> bool:
        """Whether the calls stand in a loop."""
        return self.count > UNROLLED

    @property
    def tables(self) -> list[Column]:
        """Columns that need an array."""
        return [c for _, _, c in self.args if self.looped and c.is_table]


def identifier(text: str) -> str:
    """A C identifier from a path."""
    return re.sub(r"\W+", "_", text).strip("_")


_VECTORS = (
    "par", "before", "mode", "tau", "y", "loop", "phi", "whole", "gain", "bias", "surplus", "w", "alpha", "torque", "growth",
    "drag", "stiff", "sense", "flange_tau", "direction", "loop_direction", "t", "u", "dy", "s", "out", "energy", "scale", "lo",
    "hi", "kept", "diag", "lower", "upper", "slope", "change", "speed", "turn", "rise",
    "coef", "entry", "held", "limit", "skew",
)  # fmt: skip


_INTEGERS = ("full", "i")


_SCALARS = ("g",)


@dataclass(frozen=True, slots=True)
class FunctionView:
    """A function ready to print: signature, body, and the calls of all instances."""

    name: str
    signature: str
    function: Function
    calls: list[str]


def function_view(function: Function) -> FunctionView:
    """Gives a function the vectors that its text names."""
    text = " ".join([*(x for _, x in function.prologue), *(f"{s.lhs} {s.rhs}" for s in function.body)])
    written = {word for s in function.body for word in re.findall(r"\w+", s.lhs.split("[")[0])}
    if any(s.op in ("call", "below", "above") for s in function.body):
        text += " mode lo hi"
        written |= {"lo", "hi"}
    if any(s.op in ("spread", "spread_terms") for s in function.body):
        text += " diag lower upper"
        written |= {"diag", "lower", "upper"}
    if any(s.op == "spread_terms" for s in function.body):
        text += " coef entry"
        written.add("entry")
    words = set(re.findall(r"[A-Za-z_]\w*", text))
    if any(s.full for s in function.body):
        words.add("full")
    used = [
        (f"{'' if name in written else 'const '}double *restrict {name}", name) for name in _VECTORS if name in words
    ]
    used += [(f"const double {name}", name) for name in _SCALARS if name in words]
    used += [(f"const int {name}", name) for name in _INTEGERS if name in words]
    args = [f"const {kind} {name}" for kind, name, _ in function.args]
    signature = ", ".join([*(kind for kind, _ in used), "const int e", *args])
    prefix = "".join(f"{name}, " for _, name in used)
    return FunctionView(function.name, signature, function, [prefix + call for call in function.calls])
