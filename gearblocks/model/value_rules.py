"""Value rules: what the blocks of a model refuse of the numbers that a run or a study gives, as they do when a train is built.

Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

import numpy as np

from gearblocks.codegen.program import ParameterInfo
from gearblocks.errors import ParameterError
from gearblocks.language.expression import finite_number
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array
from gearblocks.train.rules import Given
from gearblocks.train.values import bound_problem


def check_bounds(info: ParameterInfo, number: float) -> None:
    """ParameterError by name where a number is out of the bounds of a parameter, which an open one leaves out."""
    low, high = info.lower, info.upper
    above = low is None or number > low or (number == low and not info.open_lower)
    if above and (high is None or number < high or (number == high and not info.open_upper)):
        return
    lower = (low, None) if info.open_lower else (None, low)
    upper = (high, None) if info.open_upper else (None, high)
    unit = "" if info.unit in ("", "1") else f" {info.unit}"
    if problem := bound_problem(info.path, number, unit, (*lower, *upper), info.why):
        raise ParameterError(problem)


def check_numbers(model: Model, vector: Array, given: Iterable[int], later: Collection[int] = ()) -> None:
    """ParameterError where a number at one of the offsets is out of its bounds, or its block refuses it beside the others.
    later: offsets of what will vary; blocks that these belong to are asked then."""
    rules, infos = model.rules, model.program.parameters
    known = _given(model, vector, {})
    asked = dict[str, None]()
    for i in given:
        info, number = infos[i], float(vector[i])
        try:
            check_bounds(info, number)
        except ParameterError:
            if rules is not None and rules.is_parameter(info.path):  # then the field that it stands in is told
                _refuse(problem for path in rules.all_of(info.path) for problem in rules.problems(path, known))
            raise
        if rules is not None:
            asked |= dict.fromkeys(rules.of(info.path))
    if asked and rules is not None:
        waiting = {path for i in later for path in rules.of(infos[i].path)}
        _refuse(problem for path in asked if path not in waiting for problem in rules.problems(path, known))


def check_rows(model: Model, base: Array, columns: Mapping[int, Array]) -> None:
    """The same for numbers that vary together: by the offset of each its values, point by point. base: all others."""
    rules, infos = model.rules, model.program.parameters
    touched: dict[str, list[int]] = {}
    for i, column in columns.items():
        for extreme in (column.min(), column.max()):
            number = finite_number(infos[i].path, float(extreme))
            check_numbers(model, _with(base, i, number), (i,), columns)
        for path in rules.of(infos[i].path) if rules is not None else ():
            touched.setdefault(path, []).append(i)
    if rules is None:
        return
    for path, offsets in touched.items():
        for row in np.unique(np.column_stack([columns[i] for i in offsets]), axis=0):
            known = _given(model, base, dict(zip(offsets, row.tolist(), strict=True)))
            _refuse(rules.problems(path, known))


def _with(base: Array, offset: int, number: float) -> Array:
    vector = np.array(base)
    vector[offset] = number
    return vector


def _given(model: Model, vector: Array, others: Mapping[int, float]) -> Given:
    """The numbers of a vector by path, but for others by offset."""
    offsets = model.program.parameter_numbers

    def given(path: str) -> float | None:
        i = offsets.get(path)
        return None if i is None else others[i] if i in others else float(vector[i])

    return given


def _refuse(problems: Iterable[str]) -> None:
    if found := dict.fromkeys(problems):
        raise ParameterError("; ".join(found))
