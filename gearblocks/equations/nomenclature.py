"""What the symbols of printed equations mean: words, value, unit and path of each.

Knows nothing of how they are shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final

from gearblocks.language.block import Declared
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Field
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.language.units import Given, parse_unit, unit_along
from gearblocks.laws.symbols import LawTable
from gearblocks.train.graph import Component
from gearblocks.train.summary import number_text
from gearblocks.train.translational import words_along

_TO_THE_USER = re.compile(r"[,:] an? gb\.\w+|, also over [\w.()]+|, over time or gb\.\w+|; None: [^;]*")


@final
@dataclass(frozen=True, slots=True)
class Entry:
    """Words, value (text, empty where there is none), unit and path of a symbol; table: what it stands for, if that is one."""

    words: str
    value: str = ""
    unit: str = "1"
    path: str = ""
    table: Any = None


def of_number(c: Component, path: str) -> Entry:
    """A number of a block, by its path inside it."""
    field, value = _found(c.block, path)
    unit = unit_along(field.unit, c.slides)
    return Entry(words_along(_told(field), c.slides), _value(value), _unit(value, unit), f"{c.path}.{path}")


def declared_symbol(c: Component, path: str) -> str:
    """The symbol that a field or a state of a block or of its effects declares for itself, if it does."""
    *effects, last = path.partition("[")[0].split(".")
    owner: Any = c.block
    for effect in effects:
        owner = getattr(owner, effect.partition("[")[0])
        owner = owner[0] if isinstance(owner, tuple) else owner
    declared = type(owner).fields.get(last) or type(owner).states.get(last)
    return "" if declared is None else declared.symbol


def of_shared(leaf: Parameter | Input) -> Entry:
    """A Parameter or an Input."""
    if isinstance(leaf, Input):
        return Entry("input", number_text(leaf.start, 6), leaf.unit, leaf.name)
    return Entry("parameter", number_text(leaf.value, 6), leaf.unit, leaf.name)


def of_state(c: Component, path: str) -> Entry:
    """A state of a block or of one of its effects."""
    owner: Any = c.block
    *effects, name = path.split(".")
    turns = False
    for effect in effects:
        turns |= type(owner).fields[effect].turns
        owner = getattr(owner, effect)
    state = type(owner).states.get(name)
    unit = state.unit if state else "1"
    unit = re.sub(r"\bm\b", "rad", unit) if turns and not c.slides else unit_along(unit, c.slides)
    return Entry(words_along(state.words, c.slides) if state else name, "", unit, f"{c.path}.{path}")


def of_table(c: Component, paths: Sequence[str], table: Any) -> Entry:
    """A table in a field of a block; in several fields the same one."""
    own = next(own for path, own in tables_of(c.block) if path == paths[0])
    words = ", and ".join(dict.fromkeys(_words_of_table(c, path) for path in paths))
    if isinstance(table, Table2):
        words = f"{words}: {len(table.x)} by {len(table.y)} points"
    elif not isinstance(table, Table):
        words = "periodic part of the ratio law, over the angle of gear 1"
    else:
        words = _points(words + (", without its jumps" if getattr(own, "jumps", ()) else ""), table)
    unit = unit_along(_found(c.block, paths[0])[0].unit, c.slides)
    return Entry(words, "", unit, f"{c.path}.{paths[0]}", table)


def _told(field: Field) -> str:
    """The words of a field without what they say to the one who fills it in: its class, what None means."""
    return _TO_THE_USER.sub("", field.words)


def _words_of_table(c: Component, path: str) -> str:
    """What a table is: the words of its field, of what an effect is made of those of the effect."""
    *effects, last = path.split(".")
    if not effects or last != "table":
        return words_along(_told(_found(c.block, path)[0]), c.slides)
    words = (_told(_found(c.block, ".".join(effects[: n + 1]))[0]) for n in range(len(effects)))
    return words_along(", ".join(x.partition(",")[0] for x in words), c.slides)


def of_law_table(c: Component, made: LawTable) -> Entry:
    """A table that the law of a block makes from one of its fields."""
    unit = unit_along(made.unit, c.slides)
    return Entry(_points(made.words, made.table), "", unit, f"{c.path}.{made.field}", made.table)


def of_unnamed_table(c: Component, table: Any) -> Entry:
    """A table that the law of a block makes, and says nothing of."""
    return Entry(_points("made by its law", table), "", "1", c.path, table)


def _points(words: str, table: Any) -> str:
    ends = "periodic" if table.periodic else "held outside"
    if getattr(table, "extrapolate", "hold") == "linear":
        ends = "extrapolated"
    return f"{words}: {len(table.x)} points from {table.x[0]:.4g} to {table.x[-1]:.4g}, {table.kind}, {ends}"


def tables_of(block: Declared, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """(path, table) of every table and ratio curve in the fields of a block and its effects."""
    for name in type(block).fields:
        value = block.__dict__[name]
        if isinstance(value, Declared):
            yield from tables_of(value, f"{prefix}{name}.")
        elif isinstance(value, (Table, Table2)):
            yield prefix + name, value
        elif isinstance(value, Expr):
            found = [leaf.args[0] for leaf in value.leaves() if leaf.op in ("table", "table2")]
            yield from (
                (prefix + name + (f"[{i}]" if i else ""), table) for i, table in enumerate(dict.fromkeys(found))
            )
        elif hasattr(value, "curve"):
            yield prefix + name, value.curve


def _found(block: Declared, path: str) -> tuple[Field, Any]:
    """The declaration and the value of a field."""
    owner: Any = block
    *effects, last = path.split(".")
    name, _, place = last.partition("[")
    turned = None
    for effect in effects:
        spec = type(owner).fields[effect]
        turned, owner = (spec if spec.turns else turned), getattr(owner, effect)
    field, value = type(owner).fields[name], owner.__dict__[name]
    field = field if turned is None else turned.along(field)
    if not place or not isinstance(value, tuple):
        return field, value
    i = int(place.rstrip("]"))
    return field.entry(i), value[i]


def _value(value: Any) -> str:
    if isinstance(value, Given) and value.unit:
        return number_text(parse_unit(value.unit).of_si(float(value)), 6)
    if isinstance(value, Parameter):
        return value.name
    return number_text(value, 6) if isinstance(value, (int, float)) else str(value)


def _unit(value: Any, unit: str) -> str:
    return value.unit if isinstance(value, Given) and value.unit else unit
