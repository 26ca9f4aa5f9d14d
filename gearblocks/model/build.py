"""From a train to a model that runs: equations, program and library, from the cache where they were made before."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import ModelError, log
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.signals import Input, Parameter
from gearblocks.model.cache_key import classes_digest, package_digest, structural_text
from gearblocks.model.following_starts import with_starts
from gearblocks.model.relative_starts import solve_relative
from gearblocks.model.start_accelerations import fit_accelerations
from gearblocks.model.start_values import contradictions, fit_lossy, fit_prescribed, parameter_value, solve_dependent
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.library import Model, compile_program, core_identity, start_core_build
from gearblocks.train.expression_depth import refused_where_too_deep
from gearblocks.train.graph import GROUND, Train, Tree, flatten
from gearblocks.train.rules import Rules


def build_train(train: Train) -> Model:
    """The model of a train. Raises ModelError, or CompileError where there is no working compiler."""
    with without_collector(), refused_where_too_deep(train.components):
        return _build(train)


def build_tree(tree: Tree) -> Model:
    """The model of a composition, which keeps that for its drawing."""
    with without_collector():
        return replace(build_train(flatten(tree)), tree=tree)


@contextmanager
def without_collector() -> Iterator[None]:
    """Pauses the garbage collector: a long train makes a million objects at once, none of them garbage. They count as old
    afterwards, or the collector would go through all of them at once."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            if not gc.get_freeze_count():  # others' frozen objects stay frozen
                gc.freeze()
                gc.unfreeze()
            gc.enable()


def program_of(train: Train) -> tuple[Program, dict[str, float]]:
    """The program of a train and the values of its parameters by path; nothing is compiled."""
    with without_collector(), refused_where_too_deep(train.components):
        return _program(train)


def _program(train: Train, first: Callable[[], object] = lambda: None) -> tuple[Program, dict[str, float]]:
    """The program, from the cache where it was made before, and the values. first: called before one is made."""
    values, names = _values(train)
    cache = user_cache()
    key = digest("program", package_digest(), classes_digest(train), structural_text(train))
    program = _stored(cache.read("programs", key), values)
    if program is None:
        first()
        began = time.perf_counter()
        program = make_program(train)
        log.info("'%s': equations and C text made in %.3g s", train.name, time.perf_counter() - began)
        cache.write("programs", key, program.to_bytes())
    else:
        log.debug("'%s': equations and C text are in the cache", train.name)
    _check_against(program, train, values, names)
    return program, values


def _build(train: Train) -> Model:
    program, values = _program(train, start_core_build)
    start = np.array([values.get(p.path, 0.0) for p in program.parameters])
    start.setflags(write=False)
    model = Model(program, compile_program(program), start, rules=Rules(train.components))
    fit_prescribed(model, train)
    fit_lossy(model, train)
    fit_accelerations(model, train)
    return with_starts(model, train)


def train_digest(train: Train) -> str:
    """Digest of what the model of a train is made of: the program's key, the core, and all numbers. Raises ModelError."""
    numbers = sorted(_values(train)[0].items())
    return digest(
        "train", package_digest(), core_identity(), classes_digest(train), structural_text(train), repr(numbers)
    )


def make_program(train: Train) -> Program:
    """The program of a train, made anew."""
    from gearblocks.assembly.assemble import assemble
    from gearblocks.codegen.generate import generate

    check_user_blocks(train)
    try:
        return generate(assemble(train), user_cache())
    except OverflowError:
        raise ModelError(
            "the ties multiply to a ratio beyond 1e308 between two shafts; shorten the chain of gears"
        ) from None
    except NotImplementedError as error:  # of sympy's printers
        raise ModelError(f"a law contains a function that the generated C does not know: {error}") from error


def _stored(data: bytes | None, values: dict[str, float]) -> Program | None:
    """A program from the cache, unless its ratios rest on other values."""
    if data is None:
        return None
    program = Program.from_bytes(data)  # the cache verifies that it reads what was written
    fits = all(values.get(path) == value for path, value in program.structural)
    return program if fits else None


def _values(train: Train) -> tuple[dict[str, float], set[str]]:
    """The number of every parameter path, Parameter and start value; names of Parameters and Inputs.

    Raises ModelError for names that mean two things.
    """
    values: dict[str, float] = {}
    shared: dict[str, Parameter | Input] = {}
    problems: dict[str, None] = {}
    for c, kind in zip(train.components, train.kinds, strict=True):
        for name, value, spec in kind.numbers(c.block):
            if isinstance(value, (int, float)):
                values[f"{c.path}.{name}"] = float(value)
            elif isinstance(value, Expr) and spec.start is not None:
                values[f"{c.path}.{name}"] = evaluate(value, parameter_value)
        for name, start in kind.states:
            values[f"{c.path}.{name}"] = start
        for leaf in kind.leaves:
            if shared.setdefault(leaf.name, leaf) != leaf:
                problems[_two_meanings(shared[leaf.name], leaf)] = None
    for coordinate in train.coordinates:
        for found in coordinate.expr.leaves():
            if found.op == "parameter" and shared.setdefault(found.args[0].name, found.args[0]) != found.args[0]:
                problems[_two_meanings(shared[found.args[0].name], found.args[0])] = None
    for name, leaf in shared.items():
        if name in values:
            problems[f"{leaf!r} has the name of the parameter '{name}' of a block; give it another name"] = None
    if problems:
        raise ModelError(list(problems))
    values.update({name: leaf.si for name, leaf in shared.items() if isinstance(leaf, Parameter)})
    return values, set(shared)


def _two_meanings(one: Parameter | Input, other: Parameter | Input) -> str:
    return f"the name '{one.name}' stands for {one!r} and for {other!r}; use one object, or two names"


def _check_against(program: Program, train: Train, values: dict[str, float], names: set[str]) -> None:
    """Raises ModelError for start values that contradict each other, and for names that are outputs too. `values` gets start
    values that are solved for."""
    double = names & {q.name for q in program.outputs} if names else set()
    problems = [f"'{name}' names an input or Parameter and an output; rename the first" for name in sorted(double)]
    states = {s.name for s in program.starts if s.of == "state"}
    problems += [
        f"'{s.name}' names a state of this block and the start {s.of} of its body; rename the state"
        for s in program.starts if s.of != "state" and s.name in states
    ]  # fmt: skip
    problems += contradictions(program, train)
    problems += solve_dependent(program, train, values)
    problems += solve_relative(program, train, values)
    if problems:
        raise ModelError(problems)


def check_user_blocks(train: Train) -> None:
    """ModelError for all that is wrong in what blocks written by users yield. Blocks of the catalogue cost nothing."""
    seen: set[Any] = set()
    problems: list[str] = []
    for c, kind in zip(train.components, train.kinds, strict=True):
        if not type(c.block).__module__.startswith("gearblocks."):
            key = (kind.structure, tuple(node == GROUND for node in c.nodes))
            if key not in seen:
                from gearblocks.laws.checks import physics_problems

                seen.add(key)
                flanges = zip(type(c.block).flanges, c.nodes, strict=True)
                problems += physics_problems(c.path, c.block, frozenset(n for n, node in flanges if node == GROUND))
    if problems:
        raise ModelError(problems)
