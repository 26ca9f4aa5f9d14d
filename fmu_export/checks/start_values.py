"""Whether the values that the description promises are those of a new instance, and what is set comes back.

The standard lets variables be read from the initialization mode on; parameters and inputs have by then the values that
the description or the importer gave. FMUs of gearblocks answer before it too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from fmu_export.checks.instance import Instance, Plan
from fmu_export.checks.lifecycle import reals
from fmu_export.checks.report import Item

_CLOSE = 1e-9
"""Of numbers that a description of others gives in decimals."""


def check_start_values(plan: Plan) -> Item:
    """Start values as described; set and got back."""
    return _own(plan) if plan.unpacked.own else _of_others(plan)


def _own(plan: Plan) -> Item:
    given = [v for v in reals(plan.unpacked) if v.start is not None]
    refs = [v.valueReference for v in given]
    with plan.open() as instance:
        values = instance.get(refs)
        wrong = [v.name for v, x in zip(given, values, strict=True) if x != float(v.start)]
        other = [_inside(v, float(v.start)) for v in given]
        instance.set(refs, other)
        lost = [v.name for v, x, y in zip(given, instance.get(refs), other, strict=True) if x != y]
    return _item(wrong, lost, f"{len(given)} as described; set and got back")


def _inside(variable: object, start: float) -> float:
    """Another value within the variable's limits."""
    low = float(getattr(variable, "min", None) or -math.inf)
    high = float(getattr(variable, "max", None) or math.inf)
    candidates = (start * 1.25 + 0.5, start * 0.75, start)
    return next(x for x in candidates if low <= x <= high)


def _of_others(plan: Plan) -> Item:
    """Parameters before the initialization mode, inputs within it; both read after it."""
    described = plan.unpacked.description.modelVariables
    given = [v for v in described if v.causality in ("parameter", "input") and v.start is not None and v.type in _TYPES]
    with plan.open() as instance:
        instance.start(plan.begin)
        wrong = [v.name for v in given if not _equal(v, _get(instance, v))]
    with plan.open() as instance:
        _set(instance, [v for v in given if v.causality == "parameter" and v.variability in ("fixed", "tunable")])
        instance.fmu.setupExperiment(startTime=plan.begin)
        instance.fmu.enterInitializationMode()
        _set(instance, [v for v in given if v.causality == "input"])
        instance.fmu.exitInitializationMode()
        lost = [v.name for v in given if v.name not in wrong and not _equal(v, _get(instance, v))]
    return _item(wrong, lost, f"{len(given)} parameters and inputs as described; set and got back")


def _item(wrong: Sequence[str], lost: Sequence[str], words: str) -> Item:
    found = [f"'{name}' differs from the description" for name in wrong] + [f"'{name}' is not kept" for name in lost]
    return Item("start values", not found, "; ".join(found[:5]) or words)


def _truth(text: Any) -> int:
    return int(str(text).lower() in ("true", "1"))


_TYPES: dict[str, tuple[str, Any]] = {
    "Real": ("Real", float),
    "Integer": ("Integer", int),
    "Enumeration": ("Integer", int),
    "Boolean": ("Boolean", _truth),
    "String": ("String", str),
}
"""Suffix of the functions and meaning of the text in the description, by type."""


def _get(instance: Instance, variable: Any) -> Any:
    return getattr(instance.fmu, f"get{_TYPES[variable.type][0]}")([variable.valueReference])[0]


def _set(instance: Instance, variables: Sequence[Any]) -> None:
    for v in variables:
        suffix, meaning = _TYPES[v.type]
        getattr(instance.fmu, f"set{suffix}")([v.valueReference], [meaning(v.start)])


def _equal(variable: Any, value: Any) -> bool:
    promised = _TYPES[variable.type][1](variable.start)
    if isinstance(value, bytes):
        value = value.decode(errors="replace")
    if isinstance(promised, float):
        return math.isclose(promised, value, rel_tol=_CLOSE, abs_tol=_CLOSE * abs(promised))
    return bool(promised == value)
