"""Signals of a random train as plain trees, turned into gearblocks' expressions or into the text of a script.

Knows nothing of trains. A tree is a number or a Node; both compare and print as values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Node:
    """One operation. op: time, twist, slip, distance, temperature, sense, input, parameter, table, object, + * /, < >, both,
    one, not, either, cases, or a function's name."""

    op: str
    args: tuple[Any, ...] = ()

    def __add__(self, other: Any) -> Node:
        return Node("+", (self, other))

    def __radd__(self, other: Any) -> Node:
        return Node("+", (other, self))

    def __sub__(self, other: Any) -> Node:
        return Node("+", (self, -other if isinstance(other, Node) else -1.0 * other))

    def __rsub__(self, other: Any) -> Node:
        return Node("+", (other, -self))

    def __mul__(self, other: Any) -> Node:
        return Node("*", (self, other))

    def __rmul__(self, other: Any) -> Node:
        return Node("*", (other, self))

    def __neg__(self) -> Node:
        return Node("*", (-1.0, self))

    def __lt__(self, other: Any) -> Node:
        return Node("<", (self, other))

    def __gt__(self, other: Any) -> Node:
        return Node(">", (self, other))


TIME = Node("time")
TWIST = Node("twist")
SLIP = Node("slip")
DISTANCE = Node("distance")
TEMPERATURE = Node("temperature")
PULSES = ("pulse", "trapezoid")
LOCAL = ("time", "twist", "slip", "distance", "temperature")


def sense(path: str) -> Node:
    """An output of another part."""
    return Node("sense", (path,))


def call(name: str, *args: Any) -> Node:
    """A function: sin, cos, exp, Abs, sign, Min, Max, tanh."""
    return Node(name, args)


def either(value: Any, condition: Node, other: Any) -> Node:
    """value where the condition holds, else other."""
    return Node("either", (value, condition, other))


def cases(*pairs: tuple[Any, Any], other: Any) -> Node:
    """The value of the first condition that holds, else other."""
    return Node("cases", (*(x for pair in pairs for x in pair), other))


def table(
    x: tuple[float, ...], y: tuple[float, ...], kind: str = "linear", beyond: bool | str = False, over: Any = None
) -> Node:
    """A table over time, or over another quantity; over=None inside of a field that says itself over what it goes.

    beyond its ends: True: it repeats; False: held; "hold", "linear": the same said, and as its first and last line go on."""
    return Node("table", (tuple(x), tuple(y), kind, beyond, over))


def thing(name: str, **fields: Any) -> Node:
    """An effect or another object of gearblocks, by its class and fields; "RatioLaw.ellipse" is a maker."""
    return Node("object", (name, tuple(fields.items())))


def pulses(kind: str, size: float, **fields: Any) -> Node:
    """gb.pulse or gb.trapezoid of numbers."""
    return Node(kind, (size, tuple(fields.items())))


def walk(x: Any) -> Iterator[Node]:
    """Every Node of a value, depth first."""
    if isinstance(x, Node):
        yield x
        parts: Any = x.args
    else:
        parts = x if isinstance(x, tuple) else ()
    for part in parts:
        yield from walk(part)


def rewrite(x: Any, change: Callable[[Any], Any]) -> Any:
    """x with change applied to every value inside, from the leaves upward."""
    if isinstance(x, Node):
        x = Node(x.op, tuple(rewrite(a, change) for a in x.args))
    elif isinstance(x, tuple):
        x = tuple(rewrite(a, change) for a in x)
    return change(x)


def to_gearblocks(x: Any, gb: Any) -> Any:
    """The value that gearblocks takes; gb is the package."""
    if isinstance(x, tuple):
        return tuple(to_gearblocks(a, gb) for a in x)
    if not isinstance(x, Node):
        return x
    if x.op in LOCAL:
        return getattr(gb, x.op)
    if x.op == "sense":
        return gb.sense(x.args[0])
    if x.op == "input":
        return gb.Input(x.args[0], start=x.args[1])
    if x.op == "parameter":
        return gb.Parameter(x.args[0], x.args[1])
    if x.op == "table":
        xs, ys, kind, beyond, over = x.args
        more = {"extrapolate": beyond} if isinstance(beyond, str) else {"periodic": beyond}
        made = gb.Table(list(xs), list(ys), kind=kind, **more)
        return made if over is None else made(to_gearblocks(over, gb))
    if x.op in PULSES:
        return getattr(gb, x.op)(x.args[0], **dict(x.args[1]))
    if x.op == "object":
        target = gb
        for part in x.args[0].split("."):
            target = getattr(target, part)
        return target(**{name: to_gearblocks(value, gb) for name, value in x.args[1]})
    args = [to_gearblocks(a, gb) for a in x.args]
    return _operation(x.op, args, gb)


def _operation(op: str, a: list[Any], gb: Any) -> Any:
    if op == "+":
        return a[0] + a[1]
    if op == "*":
        return a[0] * a[1]
    if op == "/":
        return a[0] / a[1]
    if op == "<":
        return a[0] < a[1]
    if op == ">":
        return a[0] > a[1]
    if op == "both":
        return a[0] & a[1]
    if op == "one":
        return a[0] | a[1]
    if op == "not":
        return ~a[0]
    if op in ("either", "cases"):
        return gb.piecewise(*zip(a[:-1:2], a[1::2], strict=True), (a[-1], True))
    if op in ("sin", "cos"):
        return getattr(gb, op)(a[0])
    import sympy as sp

    return getattr(sp, op)(*a)


def to_text(x: Any) -> str:
    """The same as text of a script that imports gearblocks as gb and sympy as sp."""
    if isinstance(x, tuple):
        return "(" + ", ".join(to_text(a) for a in x) + ("," if len(x) == 1 else "") + ")"
    if not isinstance(x, Node):
        return repr(x)
    if x.op in LOCAL:
        return f"gb.{x.op}"
    if x.op == "sense":
        return f"gb.sense({x.args[0]!r})"
    if x.op == "input":
        return f"gb.Input({x.args[0]!r}, start={x.args[1]!r})"
    if x.op == "parameter":
        return f"gb.Parameter({x.args[0]!r}, {x.args[1]!r})"
    if x.op == "table":
        xs, ys, kind, beyond, over = x.args
        more = f", kind={kind!r}" if kind != "linear" else ""
        more += f", extrapolate={beyond!r}" if isinstance(beyond, str) else ", periodic=True" if beyond else ""
        text = f"gb.Table({list(xs)!r}, {list(ys)!r}{more})"
        return text if over is None else f"{text}({to_text(over)})"
    if x.op in PULSES:
        return f"gb.{x.op}({to_text(x.args[0])}, {', '.join(f'{n}={v!r}' for n, v in x.args[1])})"
    if x.op == "object":
        return f"gb.{x.args[0]}({', '.join(f'{n}={to_text(v)}' for n, v in x.args[1])})"
    a = [to_text(v) for v in x.args]
    if x.op in ("+", "*", "/", "<", ">"):
        return f"({a[0]} {x.op} {a[1]})"
    if x.op in ("both", "one"):
        return f"({a[0]} {'&' if x.op == 'both' else '|'} {a[1]})"
    if x.op == "not":
        return f"~({a[0]})"
    if x.op in ("either", "cases"):
        pairs = ", ".join(f"({v}, {c})" for v, c in zip(a[:-1:2], a[1::2], strict=True))
        return f"gb.piecewise({pairs}, ({a[-1]}, True))"
    return f"{'gb' if x.op in ('sin', 'cos') else 'sp'}.{x.op}({', '.join(a)})"
