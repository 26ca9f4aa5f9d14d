"""The reference of a class of blocks or effects as text: what was written, then what it declares, in tables.

Knows nothing of values, nor of trains.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from types import FunctionType
from typing import Any

from gearblocks.language.fields import Field, Flange
from gearblocks.language.written_outputs import written_outputs

WIDTH = 112
"""Characters of a line: help() indents by four more."""

_KINDS = {
    "param": "number",
    "exact": "exact",
    "option": "choice",
    "signal": "signal",
    "effect": "effect",
}
_MEANING = {
    "param": 'number: a number in the unit, text with a unit ("3 mm"), gb.Parameter or an expression of Parameters',
    "exact": "exact: a plain number, which enters ratios exactly",
    "option": "choice: decides the form of the law",
    "signal": (
        "signal: what a number may be, and gb.Input, gb.Table over time, expressions of gb.time, gb.sense(...), gb.sin ... "
        "and of sympy"
    ),
    "effect": "effect: one of the classes under Effects; None: absent, without a trace in equations and C",
}


def reference(cls: Any, written: str, effects: Mapping[str, Sequence[type]]) -> str:
    """Everything about a class: what was written, then what it declares. effects: classes of effects by field."""
    if not (cls.fields or cls.flanges or cls.states):
        return written
    return "\n".join([*filter(None, [written]), *_tables(cls, effects)])


def _tables(cls: Any, effects: Mapping[str, Sequence[type]]) -> Iterator[str]:
    yield from _section(
        "Fields: name, kind, unit, default, bounds, meaning", [_field(n, f) for n, f in cls.fields.items()]
    )
    roles = {field.role for field in cls.fields.values()}
    yield from (line for role, words in _MEANING.items() if role in roles for line in _wrapped(words))
    yield from _section("Flanges", [_flange(name, flange) for name, flange in cls.flanges.items()])
    yield from _flange_notes({flange.slider for flange in cls.flanges.values()})
    yield from _section(
        "States: name, unit, start, meaning",
        [(name, _unit(state.unit), f"{state.start:g}", state.words) for name, state in cls.states.items()],
    )
    if hasattr(cls, "physics"):
        yield from _outputs(cls)
    rows = [(name, ", ".join(_public(kind) for kind in kinds)) for name, kinds in effects.items() if kinds]
    owned = [*_owned(cls)]
    yield from _section("Effects: field, classes", rows) if rows or not owned else ["", "Effects"]
    yield from owned


def _owned(cls: Any) -> Iterator[str]:
    """Effects that are made of several fields."""
    owned: dict[str, list[str]] = {}
    for name, field in cls.fields.items():
        if field.belongs_to:
            owned.setdefault(field.belongs_to, []).append(name)
    for effect, names in owned.items():
        yield from _wrapped(f'{effect} is present by {", ".join(names)}; rig.without("*.{effect}") takes it away')


def _field(name: str, field: Field) -> tuple[str, ...]:
    bounds = ", ".join(
        f"{sign} {limit:g}"
        for sign, limit in ((">", field.gt), (">=", field.ge), ("<", field.lt), ("<=", field.le))
        if limit is not None
    ) + (f" unless {field.unless}" if field.unless else "")
    default = "required" if field.required else _shown(field.default)
    return name, _KINDS[field.role], _unit(field.unit), default, bounds, field.words


def _shown(value: Any) -> str:
    return f"{value:g}" if type(value) is float else repr(value)


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _flange(name: str, flange: Flange) -> tuple[str, ...]:
    kind = {True: "slides", False: "turns", None: "turns or slides"}[flange.slider]
    open_end = "; ground when open" if flange.ground else "; may stay open" if flange.spare else ""
    return name, kind + open_end, flange.words


def _flange_notes(slides: set[bool | None]) -> Iterator[str]:
    """Signs and outputs of the flanges. slides: what `slider` of them says."""
    if slides - {True}:
        yield from _wrapped(
            "signs: all angles count positive the same way round; tau is the torque that the block exerts on the flange, "
            "power = tau w goes from the block into the flange. Outputs of each: phi [rad], w [rad/s], tau [N m], power [W]"
        )
    if slides & {True}:
        yield from _wrapped(
            "signs of what slides: all positions count positive the same way; f is the force that the block exerts on the "
            "flange. Outputs of each: s [m], v [m/s], f [N], power [W]"
        )
    if None in slides:
        yield from _wrapped(
            "where it slides, m stands for rad and N for N m; the outputs of a flange are then s [m], v [m/s], f [N], power [W]"
        )


def _outputs(cls: Any) -> Iterator[str]:
    outputs = [(x.name, _unit(x.unit), x.words) for x in written_outputs(cls)]
    yield from _section("Outputs: name, unit, meaning (which of them there are depends on the fields)", outputs)
    if parts := _parts(cls):
        yield ""
        yield from textwrap.wrap(f"Parts, with their own flanges and outputs by path: {', '.join(parts)}", WIDTH)


def _parts(cls: Any) -> list[str]:
    """The blocks that those of a composite class may stand for, from the names that its methods mention."""
    own = inspect.getattr_static(cls, "parts", None)
    if not isinstance(own, FunctionType) or own.__globals__["__name__"] == "gearblocks.language.block":
        return []
    methods = [f for base in cls.__mro__ for f in vars(base).values() if isinstance(f, FunctionType)]
    named = {n: f.__globals__.get(n) for f in methods if f.__globals__ is own.__globals__ for n in f.__code__.co_names}
    return [_public(kind) for kind in named.values() if isinstance(kind, type(cls)) and kind.flanges]


def _public(kind: type) -> str:
    return f"gb.{kind.__name__}" if kind.__module__.startswith("gearblocks.") else kind.__name__


def _section(title: str, rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """A title and its rows; the last column wraps within itself."""
    if not rows:
        return
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    left = 4 + sum(w + 2 for w in widths if w)
    yield from ("", title)
    for row in rows:
        head = "    " + "".join(f"{cell:<{w}}  " for cell, w in zip(row, widths, strict=False) if w)
        lines = textwrap.wrap(row[-1], max(WIDTH - left, 24)) or [""]
        yield (head + lines[0]).rstrip()
        yield from (" " * left + line for line in lines[1:])


def _wrapped(words: str) -> Iterator[str]:
    yield from textwrap.wrap(words, WIDTH, initial_indent="    ", subsequent_indent="      ")
