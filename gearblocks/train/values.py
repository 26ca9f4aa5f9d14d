"""Values of blocks: parameters by path, their bounds, and copies with other values."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from gearblocks.errors import ModelError, did_you_mean
from gearblocks.language.annotations import effect_classes
from gearblocks.language.block import Block, Declared, Effect, field_values
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Field
from gearblocks.language.heat import heat_port, reads_temperature
from gearblocks.language.reference import annotation_of
from gearblocks.language.signals import Input, Parameter, Table, constant_value
from gearblocks.language.tables import Table2
from gearblocks.language.units import Given, parse_unit, unit_along
from gearblocks.train.summary import expression_text

_PLAIN = frozenset((float, int, bool, str, type(None)))


def numbers_of(owner: Any, prefix: str) -> Iterator[tuple[str, Any, Field]]:
    """(path, number or Parameter or expression, field) of every numeric field that is present, effects included."""
    store = owner.__dict__
    for name, field in type(owner).fields.items():
        value = store[name]
        if field.unless:
            field = field.binding(store)
        if type(value) is float:
            if field.role not in ("option", "effect"):
                yield prefix + name, value, field
        elif isinstance(value, Declared):
            inner = numbers_of(value, f"{prefix}{name}.")
            yield from ((path, v, field.along(f)) for path, v, f in inner) if field.turns else inner
        elif value is None or field.role == "option":
            continue
        elif isinstance(value, tuple):
            for i, v in enumerate(value[: field.leading]):
                yield f"{prefix}{name}[{i}]", v, field.entry(i)
        elif field.role != "effect" and not isinstance(value, str):
            yield prefix + name, value, field


def is_plain(block: Any) -> bool:
    """Whether all that a block holds is numbers, words and choices: no signal, no Parameter, no effect."""
    return _PLAIN.issuperset(map(type, block.__dict__.values()))


def leaves_of(block: Any) -> Iterator[Parameter | Input]:
    """Every Parameter and Input that a block or its effects refer to."""
    if is_plain(block):
        return
    for _, value, _ in numbers_of(block, ""):
        if isinstance(value, (Parameter, Input)):
            yield value
        elif isinstance(value, Expr):
            for leaf in value.leaves():
                if leaf.op in ("parameter", "input"):
                    yield leaf.args[0]


def value_problems(path: str, block: Block, *, again: bool = False) -> list[str]:
    """Numbers that are not finite or out of bounds, and what the block itself finds wrong; again: of a block that joined a
    train with other numbers."""
    if _is_within(block):
        found = [*(block.number_problems() if again else block.problems())]
    else:
        found = [*_field_problems(block, ""), *_temperature_problems(block)] or [*_own_problems(block, again)]
        if not found and not is_plain(block):
            found = [*_problems_of_numbers(block)]
    return [f"{type(block).__name__} '{path}': {problem}" for problem in found]


def _is_within(block: Block) -> bool:
    """Whether a block holds numbers, words and choices alone, none of which a field refuses: most blocks, told sooner."""
    values = tuple(block.__dict__.values())
    if len(values) != len(type(block).fields):  # it keeps more for itself (functools.cached_property)
        return False
    ranges = _ranges(type(block), tuple(map(type, values)))
    return ranges is not None and all(low < values[i] < high for i, low, high in ranges)


@cache
def _ranges(kind: type[Declared], sorts: tuple[type, ...]) -> tuple[tuple[int, float, float], ...] | None:
    """Of blocks with plain values of these sorts: the place of each number and the next numbers outside its bounds; None where
    a field asks for another sort."""
    found = []
    for i, (spec, sort) in enumerate(zip(kind.fields.values(), sorts, strict=True)):
        if sort not in _PLAIN:
            return None
        if spec.role == "option":
            fits = sort is bool or not isinstance(spec.default, bool)
        elif sort is type(None):
            fits = spec.role == "effect" or spec.default is None or spec.belongs_to is not None
        else:
            fits = sort in (float, int) and spec.role != "effect" and not spec.many
            found.append((i, *_around(spec)))
        if not fits:
            return None
    return tuple(found)


def _around(spec: Field) -> tuple[float, float]:
    """The greatest number below the bounds of a field, and the least above."""
    lower = -sys.float_info.max if spec.ge is None else math.nextafter(spec.ge, -math.inf)
    upper = sys.float_info.max if spec.le is None else math.nextafter(spec.le, math.inf)
    return max(lower, lower if spec.gt is None else spec.gt), min(upper, upper if spec.lt is None else spec.lt)


def _own_problems(block: Block, again: bool) -> Iterator[str]:
    """What a block and its effects find wrong by themselves, or of their numbers alone."""
    yield from block.number_problems() if again else block.problems()
    for name, part in field_values(block).items():
        if isinstance(part, Declared):
            found = part.number_problems() if again else part.problems()
            yield from (p if p.startswith(name) else f"{name}: {p}" for p in found)


def _problems_of_numbers(block: Block) -> Iterator[str]:
    """What they find wrong with the numbers that the Parameters of the block stand for."""
    numbers = with_values(block, "", lambda _, value: _number_of_constant(value))
    if numbers is not block:
        named = {x.name: x for x in leaves_of(block) if isinstance(x, Parameter)}.values()
        told = ", ".join(f"{x.name} = {x.value!r}{'' if x.unit == '1' else f' {x.unit}'}" for x in named)
        yield from (f"{problem} (where {told})" for problem in _own_problems(numbers, again=True))


def _number_of_constant(value: Any) -> Any:
    """The number that a Parameter or an expression of Parameters stands for; any other value as it is."""
    constant = isinstance(value, Parameter) or (isinstance(value, Expr) and _is_constant(value))
    return _constant(value) if constant else value


def with_values(owner: Any, prefix: str, change: Callable[[str, Any], Any]) -> Any:
    """A block or effect with other numbers, Parameters and signals. change: takes the path of each and what stands there, and
    gives what takes its place; numbers of a row that follow from the first one keep their ratio to it."""
    new: dict[str, Any] = {}
    for name, field in type(owner).fields.items():
        value = owner.__dict__[name]
        if isinstance(value, Declared):
            new[name] = with_values(value, f"{prefix}{name}.", change)
        elif field.role not in ("param", "signal") or value is None or isinstance(value, str):
            continue
        elif isinstance(value, tuple):
            row = [change(f"{prefix}{name}[{i}]", v) for i, v in enumerate(value[: field.leading])]
            if any(a is not b for a, b in zip(row, value, strict=False)):
                new[name] = (*row, *(v * row[0] / value[0] for v in value[len(row) :]))
        else:
            new[name] = change(prefix + name, value)
    new = {name: value for name, value in new.items() if value is not owner.__dict__[name]}
    return owner.changed(**new) if new else owner


def _temperature_problems(block: Block) -> Iterator[str]:
    """Signals that contain gb.temperature of a block without a heat port."""
    if not is_plain(block) and heat_port(block) is None:
        for name, value, _ in numbers_of(block, ""):
            if reads_temperature(value):
                yield f"{name} = '{expression_text(value)}' contains gb.temperature: give the block heat=gb.HeatPort(T=...)"


def _row_wanted(owner: type[Declared], name: str, value: Any) -> str:
    """The row of numbers that a field asks for, with the value in it."""
    declared = re.match(r"tuple\[([^]]*)]", str(annotation_of(owner, name)))
    entries = declared[1].split(",") if declared else []
    if isinstance(value, str) and "," in value:
        return f"a row of numbers, given one by one: {name}[0] = {value.split(',')[0].strip(' ([')} and so on"
    if isinstance(value, str):
        with suppress(ValueError):
            value = float(value)
    if len(entries) < 2 or entries[-1].strip() == "...":
        return f"a row of numbers such as ({value!r:.40},)"
    return f"a row of {len(entries)} numbers such as ({', '.join([f'{value!r:.20}'] * len(entries))})"


_SEVERAL = (np.ndarray, list, dict, set)
_ONE = re.compile(r"(str|bool|int|float|None)( \| (str|bool|int|float|None|[A-Z]\w+))*")
"""Annotations of choices that are one value; what is not annotated takes anything."""


def _field_problems(owner: Declared, prefix: str) -> Iterator[str]:
    """What is wrong with the fields taken one by one, those of effects included."""
    for name, field in type(owner).fields.items():
        value = owner.__dict__[name]
        if field.role == "effect":
            if value is not None:
                problem = _effect_problem(owner, name, value)
                yield from [problem] if problem else _field_problems(value, f"{prefix}{name}.")
        elif field.role == "option":
            if isinstance(field.default, bool) and not isinstance(value, bool):
                yield f"{prefix}{name} = {value!r} must be True or False"
            elif isinstance(value, Declared):
                yield from _field_problems(value, f"{prefix}{name}.")
            elif isinstance(value, _SEVERAL) and _ONE.fullmatch(annotation_of(type(owner), name) or ""):
                yield f"{prefix}{name} = {value!r:.80} must be one value, not several: {field.words}"
        elif value is None:
            if field.default is not None and field.belongs_to is None:
                yield f"{prefix}{name} = None ({field.words}): a value must be given"
        elif field.many and not isinstance(value, tuple):
            yield f"{prefix}{name} = {value!r:.80} must be {_row_wanted(type(owner), name, value)}: {field.words}"
        elif field.many:
            yield from filter(None, (_problem(f"{prefix}{name}[{i}]", v, field.entry(i)) for i, v in enumerate(value)))
        elif not (isinstance(value, str) and value in (field.default, "angle")):  # the effect itself judges "angle"
            problem = _problem(prefix + name, value, field.binding(owner.__dict__))
            if problem:
                yield problem


def unit_problems(path: str, block: Block, slides: bool) -> Iterator[str]:
    """Values that were given in a unit of something else than what their field is, on a shaft or on a slider."""
    if is_plain(block):
        return
    for name, value, field in numbers_of(block, ""):
        unit = value.unit if isinstance(value, (Given, Parameter, Input)) else "1"
        wanted = unit_along(field.unit, slides)
        if unit not in ("", "1") and not parse_unit(unit).measures(parse_unit(wanted)):
            along = " on a slider" if wanted != field.unit else ""
            along += parse_unit(unit).doubt(parse_unit(wanted))
            yield f"{type(block).__name__} '{path}': {name} is given in {unit}, but what belongs here is in {wanted}{along}"


def _effect_problem(owner: Declared, name: str, value: Any) -> str:
    """An effect that is no effect object, or not of a class that the field is annotated with."""
    kind: Any = type(owner)
    allowed = effect_classes(kind, name)
    if isinstance(value, Effect):
        if not allowed or type(value) in allowed:
            return ""
        if not type(value).__module__.startswith("gearblocks.") and isinstance(value, allowed):
            return ""
    wanted = " or ".join(f"gb.{kind.__name__}(...)" for kind in allowed)
    such = f"an effect object such as {wanted or 'gb.Backlash(...)'}" if not isinstance(value, Effect) else wanted
    return f"{name} = {value!r:.80} must be {such}, or None"


def _problem(name: str, value: Any, field: Field) -> str:
    unit = "" if field.unit == "1" else f" {field.unit}"
    if isinstance(value, (Parameter, Input, Table, Expr)):
        problem = _signal_problem(name, value, field)
        if problem or isinstance(value, (Input, Table)) or (isinstance(value, Expr) and not _is_constant(value)):
            return problem
        number, shown = (
            _constant(value),
            f" ({value!r})" if isinstance(value, Parameter) else f" ('{expression_text(value)}')",
        )
    elif isinstance(value, Table2):
        return f"{name} = {value!r} is no signal by itself: call it with two quantities, such as table(gb.sense('motor.w'), u)"
    elif isinstance(value, bool) or not isinstance(value, (int, float, Fraction if field.role == "exact" else int)):
        kinds = ", Parameter, Input, Table or expression" * (field.role == "signal")
        return f"{name} = {value!r:.80} is no number{kinds}: {_way(name, value, field)}"
    else:
        number, shown = _float(value), ""
    if not math.isfinite(number):
        return f"{name} = {number!r}{unit}{shown} must be a finite number"
    problem = bound_problem(name, number, unit + shown, (field.gt, field.ge, field.lt, field.le), field.why)
    degrees = type(value) in (int, float) and field.unit == "rad" and 1.6 < abs(number) <= 360
    return (
        f"{problem}; a bare number is in rad: give '{number:g} deg' if that is meant"
        if problem and degrees
        else problem
    )


def _way(name: str, value: object, field: Field) -> str:
    """How what stands for a signal is given: a function and values over time have ways of their own."""
    short = name.rpartition(".")[2]
    if field.role == "signal" and callable(value):
        unit = f", unit='{field.unit}'" if field.unit not in ("", "1") else ""
        call = f"gb.simulate(..., inputs={{'{short}': function}})"
        return f"a function of time is given to a run, {short}=gb.Input('{short}'{unit}) and {call}"
    if field.role == "signal" and hasattr(value, "__len__") and not isinstance(value, str):
        return f"values over time are {short}=gb.Table(t, values)"
    return f"give {_example(field)}"


def _example(field: Field) -> str:
    if field.unit in ("", "1"):
        return "a plain number"
    return f"one in {field.unit}, or text with its unit such as '3 {field.unit}'"


def _float(value: float | Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _is_constant(value: Expr) -> bool:
    return all(leaf.op == "parameter" for leaf in value.leaves())


def _constant(value: Parameter | Expr) -> float:
    """The number of a Parameter, or of an expression of Parameters; NaN where it has none."""
    return constant_value(value)


def _signal_problem(name: str, value: Any, field: Field) -> str:
    if field.role == "exact":
        return f"{name} = {value!r:.80} enters a ratio: give a plain number, and another one with rig.set(...)"
    if isinstance(value, Expr) and value.op in ("<", "<=", ">", ">=", "And", "Or", "Not"):
        shown = expression_text(value)
        return f"{name} = '{shown}' is a condition, not a value: give gb.piecewise((value, condition), (other, True))"
    if field.role == "signal":
        leaves = value.leaves() if isinstance(value, Expr) else ()
        own = (field.over, "temperature")  # of a heat port, which the block is asked for
        local = next((x.args[0] for x in leaves if x.op == "local" and x.args[0] not in own), None)
        by = {
            "twist": "the torque of a Shaft",
            "slip": "a law of friction",
            "driver_angle": "the k of a NonCircularGear",
            "distance": "a Vehicle or a Chassis",
        }.get(str(local), "its block")
        return (
            "" if local is None else f"{name} = '{expression_text(value)}' contains gb.{local}, which only {by} knows"
        )
    changing = not isinstance(value, (Expr, Parameter)) or (isinstance(value, Expr) and not _is_constant(value))
    return (
        f"{name} is a parameter: it takes a number, a gb.Parameter or an expression of Parameters" if changing else ""
    )


def bound_problem(name: str, x: float, unit: str, bounds: tuple[float | None, ...], why: str = "") -> str:
    """What is wrong with x against (gt, ge, lt, le), with the words behind it, or the empty text."""
    gt, ge, lt, le = bounds
    broken = [
        f"{sign} {limit:g}"
        for sign, limit, holds in (
            (">", gt, gt is None or x > gt), (">=", ge, ge is None or x >= ge),
            ("<", lt, lt is None or x < lt), ("<=", le, le is None or x <= le),
        ) if not holds
    ]  # fmt: skip
    percent = f"; {x:g} % is {x / 100:g} or '{x:g} %'" if lt == 1 or le == 1 else ""
    percent = percent if 1 < x <= 100 and unit.strip() in ("", "1") else ""
    return f"{name} = {x!r}{unit} must be {' and '.join(broken)}{percent}{why}" if broken else ""


def field_paths(owner: Declared) -> Iterator[str]:
    """Paths of all fields inside a block, those of its effects and the entries of rows included."""
    for name in type(owner).fields:
        yield name
        value = owner.__dict__[name]
        if isinstance(value, Declared):
            yield from (f"{name}.{rest}" for rest in field_paths(value))
        elif isinstance(value, tuple):
            yield from (f"{name}[{i}]" for i in range(len(value)))


def gone_with_effect(path: str, before: Iterable[tuple[str, Declared | None]], dropped: Iterable[str]) -> str:
    """That a path is of something that was left out, in words; else empty. before: blocks as they were, by path; dropped: the
    effects that went."""
    was = [f"{name}.{field}" for name, block in before if block is not None for field in field_paths(block)]
    if not isinstance(path, str) or not any(x == path or x.endswith(f".{path}") for x in was):
        return ""
    return (
        f"'{path}' went with what was left out of this train ({', '.join(dropped)}); set it before, or keep its effect"
    )


def unique_path(path: str, known: set[str]) -> str:
    """The full path that a path, or a unique end of one, means."""
    if not isinstance(path, str):
        raise ModelError(f"path {path!r} must be text such as 'mesh.k'")
    if path in known:
        return path
    ends = sorted(p for p in known if p.endswith("." + path))
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise ModelError(f"'{path}' is not unique: it could be {', '.join(ends)}; give one of them in full")
    raise ModelError(f"'{path}' does not exist; rig.describe() lists all values{did_you_mean(path, known)}")


def replaced(owner: Any, path: list[str], value: Any) -> Any:
    """A copy of a block or effect with another value at a path inside it."""
    name, *rest = path
    match = re.fullmatch(r"(\w+)\[(\d+)\]", name)
    if match:
        values = list(owner.__dict__[match[1]])
        values[int(match[2])] = value
        return owner.changed(**{match[1]: tuple(values)})
    return owner.changed(**{name: replaced(owner.__dict__[name], rest, value) if rest else value})
