"""Structure of blocks: what of them decides the form of the equations, and what is only a number; and their kinds.

Two trains of equal structure share one program. A long train has many blocks of few kinds: what is asked of the blocks but
does not depend on their numbers is asked of one of each kind. Knows nothing of laws, nor of trains.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from gearblocks.language.block import Block, Declared
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Field
from gearblocks.language.signals import Input, Parameter, Table, constant_value
from gearblocks.language.tables import Table2
from gearblocks.language.units import Given
from gearblocks.train.content import content_of
from gearblocks.train.values import is_plain, leaves_of, numbers_of


def structure_of(value: Any, *, exact: bool = False) -> Any:
    """What decides the law of a block: its class, which fields are present, choices, signals; no numbers.

    exact=True adds the values that enter ratios, and which numbers are zero (an inertia that is not there). Plain tuples
    and text, equal for equal structure.
    """
    parts: list[Any] = [f"{type(value).__module__}.{type(value).__qualname__}"]
    store = value.__dict__
    for name, field in type(value).fields.items():
        parts.append(_structure(store[name], field, exact))
    return tuple(parts)


def _structure(value: Any, field: Field, exact: bool) -> Any:
    if value is None:
        return None
    if type(value) is float and field.role in ("param", "signal"):
        return "zero" if exact and value == 0 and field.ge == 0 else "number"
    if isinstance(value, tuple):
        return tuple(_structure(v, field, exact) for v in value)
    if field.role == "exact":
        return repr(value) if exact else "exact"
    if isinstance(value, (float, int)) and field.role in ("param", "signal"):
        return "zero" if exact and value == 0 and field.ge == 0 else "number"
    if isinstance(value, Declared):
        return structure_of(value, exact=exact)
    if isinstance(value, Parameter):
        zero = exact and value.value == 0 and field.ge == 0
        return ("parameter", value.name, value.unit, *(["zero"] if zero else []))
    if isinstance(value, Input):
        return ("input", value.name, value.start, value.unit)
    if isinstance(value, (Table, Table2)):
        return ("table", value.digest())
    if isinstance(value, Expr):
        zero = exact and field.ge == 0 and constant_value(value) == 0
        return (*structure_of_expression(value), *(["zero"] if zero else []))
    return content_of(value)


def structure_of_expression(value: Expr) -> tuple[str, ...]:
    """An expression with its Inputs, and with its Parameters but for their values: programs know the units of both."""
    inputs = sorted({repr(leaf.args[0]) for leaf in value.leaves() if leaf.op == "input"})
    parameters = sorted({f"{x.args[0].name} in {x.args[0].unit}" for x in value.leaves() if x.op == "parameter"})
    return ("expression", str(value), *inputs, *parameters)


_NUMBERS = frozenset((float, int, Given))
_WORDS = frozenset((float, int, bool, str))
_BARE = frozenset((*_NUMBERS, *_WORDS, type(None)))


class Kind:
    """Blocks of one train that are equal but for their numbers, and of these none is zero where another's is not; a Parameter,
    a table or an expression is the same object in all of them. example: one of them."""

    def __init__(self, example: Any) -> None:
        self.example = example

    @cached_property
    def structure(self) -> Any:
        """What decides their law, see structure_of."""
        return structure_of(self.example)

    @cached_property
    def digest(self) -> str:
        """Hash of their structure with the values that enter ratios."""
        return hashlib.sha256(repr(structure_of(self.example, exact=True)).encode()).hexdigest()[:16]

    @cached_property
    def is_plain(self) -> bool:
        """Whether all that they hold is numbers, words and choices."""
        return is_plain(self.example)

    @cached_property
    def leaves(self) -> tuple[Parameter | Input, ...]:
        """The Parameters and Inputs that they refer to."""
        return tuple(leaves_of(self.example))

    @cached_property
    def _fields(self) -> tuple[tuple[str, Field], ...] | None:
        """The fields with numbers, where these stand nowhere else."""
        if not _BARE.issuperset(map(type, self.example.__dict__.values())):
            return None
        return tuple((name, spec) for name, _, spec in numbers_of(self.example, ""))

    @cached_property
    def states(self) -> tuple[tuple[str, float], ...]:
        """Path inside a block and start value of each state of its own and of its parts."""
        return tuple(_states(self.example, ""))

    def numbers(self, block: Any) -> Sequence[tuple[str, Any, Field]]:
        """Path inside it, value and field of every number of a block of this kind, see numbers_of."""
        if self._fields is None:
            return tuple(numbers_of(block, ""))
        store = block.__dict__
        return [(name, store[name], spec) for name, spec in self._fields]

    def effects(self, block: Any) -> Iterable[str]:
        """Names of the effects of a block of this kind."""
        return self._effects if type(block).effects is Block.effects else block.effects().keys()

    @cached_property
    def _effects(self) -> tuple[str, ...]:
        return tuple(self.example.effects())


def _states(owner: Declared, prefix: str) -> Iterator[tuple[str, float]]:
    for name, state in type(owner).states.items():
        yield prefix + name, state.start
    for name in type(owner).fields:
        part = owner.__dict__[name]
        if isinstance(part, Declared):
            yield from _states(part, f"{prefix}{name}.")


def kinds_of(blocks: Iterable[Any]) -> tuple[Kind, ...]:
    """The kind of each block."""
    known: dict[Any, Kind] = {}
    plans: dict[Any, _Plan] = {}
    found = []
    for block in blocks:
        key = _sort(block, plans)
        kind = known.get(key)
        found.append(known.setdefault(key, Kind(block)) if kind is None else kind)
    return tuple(found)


class _Plan(NamedTuple):
    """Which values of an object, by place, tell its kind: of numbers and rows of numbers whether they are 0, what is compared
    by value, what by identity, and parts with values of their own."""

    numbers: tuple[int, ...]
    rows: tuple[int, ...]
    plain: tuple[int, ...]
    others: tuple[int, ...]
    parts: tuple[int, ...]


def _sort(owner: Any, plans: dict[Any, _Plan]) -> tuple[Any, ...]:
    """What is equal for objects of one kind, and for no others."""
    values = tuple(owner.__dict__.values())
    form = (type(owner), *map(type, values))
    plan = plans.get(form)
    if plan is None:
        plan = plans[form] = _plan(owner)
    key: list[Any] = [form]
    for i in plan.numbers:
        key.append(values[i] == 0)
    for i in plan.rows:
        key.append(_sort_of_row(values[i]))
    for i in plan.plain:
        key.append(values[i])
    for i in plan.others:
        key.append(id(values[i]))
    for i in plan.parts:
        key.append(_sort(values[i], plans))
    return tuple(key)


def _sort_of_row(row: tuple[Any, ...]) -> Any:
    """Of numbers which are 0; else the row itself, which is one object."""
    return tuple([x == 0 for x in row]) if _NUMBERS.issuperset(map(type, row)) else id(row)


def _plan(owner: Any) -> _Plan:
    places: tuple[list[int], ...] = ([], [], [], [], [])
    for i, (name, value) in enumerate(owner.__dict__.items()):
        spec, sort = type(owner).fields.get(name), type(value)
        if spec is None:  # what a block keeps for itself (functools.cached_property) tells nothing
            continue
        by_value = spec.belongs_to is not None and spec.default is not None  # at its default the effect is not there
        is_number = spec.role in ("param", "signal") and not by_value
        if is_number and (sort in _NUMBERS or sort is tuple):
            places[sort is tuple].append(i)
        elif sort in _WORDS or (sort is tuple and spec.role == "exact"):
            places[2].append(i)
        elif value is not None:
            places[4 if isinstance(value, Declared) else 3].append(i)
    return _Plan(*map(tuple, places))
