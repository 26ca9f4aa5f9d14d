"""Values of a block as people read them: what is given, with its unit. Knows nothing of laws."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from gearblocks.language.block import Block, Declared
from gearblocks.language.expression import Expr, to_sympy
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.language.units import Given, parse_unit, unit_along


def field_texts(block: Block, slides: bool) -> list[str]:
    """ "k = 20000.0 N m/rad" and the like for each field that is not as by default; slides: units are those of sliders."""
    parts = []
    for name, field in type(block).fields.items():
        value = block.__dict__[name]
        if value is not None and value != field.default:
            if isinstance(value, Declared):
                parts.append(f"{name}: {value!r}")
            else:
                parts.append(f"{name} = {_whole(value, unit_along(field.unit, slides))}")
    return parts


def _whole(value: Any, unit: str) -> str:
    """A value as it was given, with its unit."""
    if isinstance(value, Given) and value.unit:
        return f"{parse_unit(value.unit).of_si(float(value)):.12g} {value.unit}"
    if isinstance(value, Parameter):
        return f"{value.name} ({value.value:.12g}{_behind(value.unit)})"
    if isinstance(value, Input):
        return f"input {value.name} ({value.start:.12g}{_behind(value.unit)})"
    text = str(to_sympy(value)) if isinstance(value, Expr) else repr(value)
    return text + _behind(unit)


def _behind(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def short_texts(block: Declared, slides: bool) -> list[str]:
    """ "k = 2e+04 N m/rad" and the like for the parameters and signals alone, start values left out."""
    found = []
    for name, field in type(block).fields.items():
        value = block.__dict__[name]
        if (
            value is not None
            and value != field.default
            and field.start is None
            and field.role not in ("option", "effect")
        ):
            text = _short(name, value, unit_along(field.unit, slides))
            found += [f"{name} = {text}"] if text else []
    return found


def _short(name: str, value: Any, unit: str) -> str:
    """The value of a field in a few letters; empty for what has none."""
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
        return ", ".join(f"{float(x):.4g}" for x in value) + (f" {unit}" if unit != "1" else "")
    if isinstance(value, (Table, Table2)):
        return "a table"
    if isinstance(value, Expr):
        if value.op == "sense":
            return str(value.args[0])
        return str(value) if len(str(value)) < 20 else "f(...)"
    if isinstance(value, (int, float, Fraction)) and not isinstance(value, bool):
        return f"{float(value):.4g}".replace("e+0", "e").replace("e-0", "e-") + (f" {unit}" if unit != "1" else "")
    return ""
