"""Start values that Parameters give: once more, where a Parameter takes another value."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from gearblocks.errors import ModelError, ParameterError
from gearblocks.language.block import Block
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.signals import Parameter
from gearblocks.model.relative_starts import solve_relative
from gearblocks.model.start_accelerations import fit_accelerations
from gearblocks.model.start_values import contradictions, fit_lossy, fit_prescribed, solve_dependent
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array
from gearblocks.train.graph import Component, Train
from gearblocks.train.values import is_plain, leaves_of, numbers_of


def with_starts(model: Model, train: Train) -> Model:
    """The model with what its start values follow from, where Parameters stand in them."""
    names = {leaf.name for c in train.components for _, leaf in _leaves(c.block)}
    if not names:
        return model
    found = Counter(leaf.name for c in train.components for leaf in leaves_of(c.block))
    return replace(model, starts=train, start_parameters={name: found[name] for name in names})


def _leaves(block: Block) -> Iterator[tuple[str, Parameter]]:
    """Field and Parameter of every start value of a block that is not a number."""
    if is_plain(block):
        return
    for name, value, spec in numbers_of(block, ""):
        if spec.start is not None and isinstance(value, Parameter):
            yield name, value
        elif spec.start is not None and isinstance(value, Expr):
            yield from ((name, leaf.args[0]) for leaf in value.leaves() if leaf.op == "parameter")


def numbers_of_their_own(model: Model) -> list[str]:
    """Start values that an expression of Parameters gives, and that code without this file takes as numbers."""
    components = model.starts.components if model.starts is not None else ()
    given = {f"{c.path}.{name}" for c in components for name, _ in _leaves(c.block)}
    return sorted(given & model.program.parameter_numbers.keys())


def followed(model: Model, vector: Array) -> Array:
    """The parameter vector with every start value as the Parameters in it ask for; those that nobody gives are solved for
    again. Raises ParameterError for start values that contradict each other."""
    assert model.starts is not None
    program = model.program
    train = replace(model.starts, components=tuple(_with_numbers(c, model, vector) for c in model.starts.components))
    values = {p.path: float(vector[i]) for i, p in enumerate(program.parameters) if not p.start}
    for i, p in enumerate(program.parameters):  # states of blocks start as they did
        values |= {p.path: float(vector[i])} if p.start == "state" else {}
    for c in train.components:
        given = ((path, value, spec) for path, value, spec in numbers_of(c.block, c.path + "."))
        values |= {path: float(value) for path, value, spec in given if spec.start is not None and value is not None}
    problems = [*contradictions(program, train), *solve_dependent(program, train, values)]
    problems += solve_relative(program, train, values)
    if problems:
        raise ParameterError("; ".join(problems))
    start = np.array([values.get(p.path, 0.0) for p in program.parameters])
    start.setflags(write=False)
    again = Model(program, model.library, start)
    try:
        fit_prescribed(again, train)
        fit_lossy(again, train)
        fit_accelerations(again, train)
    except ModelError as error:
        raise ParameterError(str(error)) from None
    return again.values


def _with_numbers(c: Component, model: Model, vector: Array) -> Component:
    """A component whose start values are numbers: those of the vector for the Parameters in them."""
    names = {name for name, _ in _leaves(c.block)}
    if not names:
        return c
    numbers = model.program.parameter_numbers

    def value_of(given: Any) -> float:
        if isinstance(given, Parameter):
            return float(vector[numbers[given.name]])
        return evaluate(given, lambda leaf: float(vector[numbers[leaf.args[0].name]]))

    return c._replace(block=c.block.changed(**{name: value_of(c.block.__dict__[name]) for name in names}))
