"""Values of a block as people read them: what is given, with its unit. Knows nothing of laws."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from gearblocks.errors import GearblocksError
from gearblocks.language.block import Block, Declared
from gearblocks.language.expression import Expr, to_sympy
from gearblocks.language.fields import Field, same_value
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.language.units import Given, parse_unit, unit_along


def field_texts(block: Block, slides: bool) -> list[str]:
    """ "k = 20000 N m/rad" and the like for each field that is not as by default; slides: units are those of sliders."""
    return list(_fields(block, slides, None))


def _fields(of: Declared, slides: bool, within: Field | None) -> Iterator[str]:
    """within: the field that an effect stands in."""
    for name, field in type(of).fields.items():
        value = of.__dict__[name]
        if value is not None and not same_value(value, field.default):
            spec = field if within is None else within.along(field)
            yield f"{name}{':' if _is_effect(value) else ' ='} {_whole(value, spec, slides)}"


def _is_effect(value: Any) -> bool:
    return isinstance(value, Declared) or (isinstance(value, tuple) and any(isinstance(x, Declared) for x in value))


def _whole(value: Any, field: Field, slides: bool) -> str:
    """A value as it was given, with its unit."""
    if isinstance(value, Declared):
        return f"{type(value).__name__}({', '.join(_fields(value, slides, field))})"
    if isinstance(value, tuple):
        row = [_whole(x, field.entry(i), slides) for i, x in enumerate(value)]
        alike = "^-i" not in field.unit and all(type(x) in (int, float) for x in value)
        plain = [_text(x) for x in value] if alike else row
        inside = f"({', '.join(plain)}{',' if len(row) == 1 else ''})"
        return inside + (_behind(unit_along(field.unit, slides)) if alike else "")
    if isinstance(value, Given) and value.unit:
        return f"{number_text(parse_unit(value.unit).of_si(float(value)))} {value.unit}"
    if isinstance(value, Parameter):
        return f"{value.name} ({number_text(value.value)}{_behind(value.unit)})"
    if isinstance(value, Input):
        return f"input {value.name} ({number_text(value.start)}{_behind(value.unit)})"
    return _text(value) + _behind(unit_along(field.unit, slides))


def _text(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float, Table, Table2, Expr)):
        return repr(value)
    if isinstance(value, (int, float)):
        return number_text(value)
    if isinstance(value, Expr):
        if _is_over_time(value):
            return _text(value.args[0])
        return expression_text(value)
    return repr(value).replace(f", {value.digest()}", "")


def _is_over_time(value: Any) -> bool:
    """Whether a value is a table over time."""
    return isinstance(value, Expr) and value.op == "table" and value.args[1].op == "time"


def expression_text(value: Expr) -> str:
    """An expression as sympy writes it, its numbers in at most 12 digits and its tables without the hash of their points."""
    import sympy as sp

    def leaf(e: Expr) -> Any:
        if e.op in ("table", "table2"):
            return sp.Function("table")(*(to_sympy(x, leaf) for x in e.args[1:]))
        return sp.Symbol("time") if e.op == "time" else sp.Symbol(str(to_sympy(e)))

    try:
        found = to_sympy(value, leaf)
    except GearblocksError:  # 0**-1, which sympy has no number for
        return str(value)
    sizes = {x: sp.Symbol(number_text(abs(float(x)))) for x in found.atoms(sp.Float)}
    return str(found.xreplace({x: -size if x < 0 else size for x, size in sizes.items()}))


def number_text(value: float, digits: int = 12) -> str:
    """A number in its digits, at most `digits` of them: 20000, 0.3, 4e-5, 2e8."""
    text = f"{value:.{digits}g}"
    if not math.isfinite(value) or value == 0 or 1e-4 <= abs(value) < 1e6:
        return text if "e" not in text else f"{value:.0f}"
    size, _, power = f"{value:.{digits - 1}e}".partition("e")
    size = size.rstrip("0").rstrip(".")
    return f"{size}e{int(power)}"


def span_text(low: float, high: float, size: float = 0.0) -> str:
    """The range of a quantity, or the value that it keeps; an end that is rounding beside the other, or a size, is 0."""
    least = 1e-12 * max(abs(low), abs(high), size)
    ends = (0.0 if abs(x) < least else x for x in (low, high))
    return " .. ".join(dict.fromkeys(number_text(float(x), 6) for x in ends))


def _behind(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def short_texts(block: Declared, slides: bool, within: Field | None = None) -> list[str]:
    """ "k = 2e4 N m/rad" and the like for the parameters and signals alone, start values left out; within: the field that
    an effect stands in."""
    found = []
    for name, field in type(block).fields.items():
        value = block.__dict__[name]
        if (
            value is not None
            and not same_value(value, field.default)
            and field.start is None
            and field.role not in ("option", "effect")
        ):
            text = _short(name, value, field if within is None else within.along(field), slides)
            found += [f"{name} = {text}"] if text else []
    return found


def _short(name: str, value: Any, field: Field, slides: bool) -> str:
    """The value of a field in a few letters; empty for what has none."""
    unit = unit_along(field.unit, slides)
    if isinstance(value, Given) and value.unit:
        value, unit = parse_unit(value.unit).of_si(float(value)), value.unit
    if isinstance(value, Parameter):
        value, unit = value.value, value.unit
    if isinstance(value, Input):
        return "an input"
    if isinstance(value, tuple):
        if not all(isinstance(x, (int, float)) for x in value):
            return ""
        if name == "teeth":
            return ":".join(f"{x:.4g}" for x in value)
        if "^-i" in unit:
            own = [unit_along(field.entry(i).unit, slides) for i in range(len(value))]
            return (
                " + ".join(f"{number_text(float(x), 4)}{_behind(u)}" for x, u in zip(value, own, strict=True) if x)
                or "0"
            )
        return ", ".join(number_text(float(x), 4) for x in value) + (f" {unit}" if unit != "1" else "")
    if isinstance(value, (Table, Table2)) or _is_over_time(value):
        return "a table"
    if isinstance(value, Expr):
        if value.op == "sense":
            return str(value.args[0])
        text = expression_text(value)
        return text if len(text) < 20 else "f(...)"
    if isinstance(value, (int, float, Fraction)) and not isinstance(value, bool):
        return number_text(float(value), 4) + (f" {unit}" if unit != "1" else "")
    return ""
