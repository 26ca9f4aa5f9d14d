"""From a train to a model that runs: equations, program and library, from the cache where they were made before."""

from __future__ import annotations

import functools
import gc
import inspect
import sys
from abc import ABC
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.errors import ModelError
from gearblocks.language.block import _Declared
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.signals import Input, Parameter
from gearblocks.model.start_values import contradictions, follow, follow_moved, parameter_value
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.library import Model, compile_program, start_core_build
from gearblocks.train.graph import GROUND, Train, leaves_of, numbers_of, structural_text, structure_of


def build_train(train: Train) -> Model:
    """The model of a train. Raises ModelError, or CompileError where there is no working compiler."""
    with _without_collector():
        return _build(train)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Pauses the garbage collector: a long train makes a million objects at once, none of them garbage."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def _build(train: Train) -> Model:
    values, names = _values(train)
    cache = user_cache()
    key = digest("program", _package_digest(), _classes_digest(train), structural_text(train))
    program = _stored(cache.read("programs", key), values)
    if program is None:
        start_core_build()
        program = make_program(train)
        cache.write("programs", key, program.to_bytes())
    _check_against(program, train, values, names)
    start = np.array([values.get(p.path, 0.0) for p in program.parameters])
    start.setflags(write=False)
    model = Model(program, compile_program(program), start)
    follow_moved(model, train)
    return model


def make_program(train: Train) -> Program:
    """The program of a train, made anew."""
    from gearblocks.assembly.assemble import assemble
    from gearblocks.codegen.generate import generate

    check_user_blocks(train)
    try:
        return generate(assemble(train))
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
    for c in train.components:
        for path, value, _ in numbers_of(c.block, c.path + "."):
            if isinstance(value, (int, float)):
                values[path] = float(value)
            elif isinstance(value, Expr) and path.endswith((".phi0", ".w0", ".s0", ".v0")):
                values[path] = evaluate(value, parameter_value)
        _starts(c.path, c.block, values)
        for leaf in leaves_of(c.block):
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
    values.update({name: leaf.value for name, leaf in shared.items() if isinstance(leaf, Parameter)})
    return values, set(shared)


def _two_meanings(one: Parameter | Input, other: Parameter | Input) -> str:
    return f"the name '{one.name}' stands for {one!r} and for {other!r}; use one object, or two names"


def _check_against(program: Program, train: Train, values: dict[str, float], names: set[str]) -> None:
    """Start values that contradict each other through ties, and names that are outputs too. `values` gets start values that
    follow."""
    double = names & {q.name for q in program.outputs} if names else set()
    problems = [f"'{name}' names an input or Parameter and an output; rename the first" for name in sorted(double)]
    problems += contradictions(program, train)
    problems += follow(program, train, values)
    if problems:
        raise ModelError(problems)


def _starts(path: str, owner: _Declared, values: dict[str, float], prefix: str = "") -> None:
    for name, state in type(owner).states.items():
        values[f"{path}.{prefix}{name}"] = state.start
    for name in type(owner).fields:
        part = owner.__dict__[name]
        if isinstance(part, _Declared):
            _starts(path, part, values, f"{prefix}{name}.")


def check_user_blocks(train: Train) -> None:
    """ModelError for all that is wrong in what blocks written by users yield. Blocks of the catalogue cost nothing."""
    seen: set[Any] = set()
    problems: list[str] = []
    for c in train.components:
        if not type(c.block).__module__.startswith("gearblocks."):
            key = (structure_of(c.block), tuple(node == GROUND for node in c.nodes))
            if key not in seen:
                from gearblocks.laws.checks import physics_problems

                seen.add(key)
                flanges = zip(type(c.block).flanges, c.nodes, strict=True)
                problems += physics_problems(c.path, c.block, frozenset(n for n, node in flanges if node == GROUND))
    if problems:
        raise ModelError(problems)


@functools.cache
def _package_digest() -> str:
    """A sum over the sources of this package: another version makes its own programs."""
    here = Path(__file__).parents[1]
    paths = sorted([*here.rglob("*.py"), *here.rglob("*.jinja")])
    return digest(*(part for path in paths for part in (path.name, path.read_bytes())))


def _classes_digest(train: Train) -> str:
    """A sum over the code of every class that is not ours."""
    classes: set[type[_Declared]] = {type(c.block) for c in train.components}
    for c in train.components:
        classes |= {type(v) for v in c.block.__dict__.values() if isinstance(v, _Declared)}
    foreign = sorted(
        (cls for cls in classes if not cls.__module__.startswith("gearblocks.")),
        key=lambda c: (c.__qualname__, c.__module__),
    )
    for one, other in pairwise(foreign):
        if (one.__module__, one.__qualname__) == (other.__module__, other.__qualname__):
            raise ModelError(f"two classes of blocks are named {one.__qualname__}; rename one, or make its blocks anew")
    return digest(*(_class_text(cls) for cls in foreign))


def _class_text(cls: type) -> str:
    """Source file of a class where there is one, and the code of its methods with what they call."""
    parts = [cls.__qualname__]
    with suppress(OSError, TypeError):
        parts.append(Path(inspect.getfile(cls)).read_text(encoding="utf-8"))
    return "\n".join([*parts, _members_text(cls, set())])


_NOT_CODE = ("__dict__", "__weakref__", "_abc_impl", "__abstractmethods__")


def _members_text(cls: type, seen: set[int]) -> str:
    """The members of a class and of its bases that are not ours."""
    foreign = [base for base in cls.__mro__ if base is not object and base is not ABC and not _is_ours(base)]
    members = [(n, m) for base in foreign for n, m in sorted(vars(base).items()) if n not in _NOT_CODE]
    return digest(*(part for name, member in members for part in (name, _value_text(member, seen))))


def _is_ours(thing: Any) -> bool:
    return str(getattr(thing, "__module__", "")).startswith("gearblocks.")


def _value_text(value: Any, seen: set[int]) -> str:
    """What a value that a law can reach contributes to its form: functions and classes by code, data by content."""
    value = getattr(value, "__func__", value.fget if isinstance(value, property) else value)
    if isinstance(value, FunctionType):
        return value.__qualname__ if _is_ours(value) else _function_text(value, seen)
    if isinstance(value, type):
        if _is_ours(value) or id(value) in seen or _is_installed(sys.modules.get(value.__module__)):
            return value.__qualname__
        seen.add(id(value))
        return _members_text(value, seen)
    if isinstance(value, ModuleType):
        file = getattr(value, "__file__", None)
        if file is None or _is_installed(value):
            return value.__name__
        with suppress(OSError):
            return digest(value.__name__, Path(file).read_bytes())
    if isinstance(value, np.ndarray):
        return digest(str(value.dtype), str(value.shape), value.tobytes())
    return repr(value)


def _is_installed(module: ModuleType | None) -> bool:
    """Whether a module came with Python or was installed: its version stands for its content."""
    file = getattr(module, "__file__", None) or ""
    return module is not None and (not file or "site-packages" in file or file.startswith(sys.base_prefix))


def _function_text(function: FunctionType, seen: set[int]) -> str:
    """Bytecode, constants, defaults and closure of a function, and all that it names, followed."""
    if id(function.__code__) in seen:
        return ""
    cells = []
    for cell in function.__closure__ or ():
        with suppress(ValueError):  # an empty cell
            cells.append(cell.cell_contents)
    kept = [*cells, *(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
    return digest(_code_text(function.__code__, function.__globals__, seen), *(_value_text(x, seen) for x in kept))


def _code_text(code: CodeType, scope: dict[str, Any], seen: set[int]) -> str:
    """The bytecode with its constants and the values it names."""
    seen.add(id(code))
    constants = [_code_text(x, scope, seen) if isinstance(x, CodeType) else repr(x) for x in code.co_consts]
    named = [name + (_value_text(scope[name], seen) if name in scope else "") for name in code.co_names]
    return digest(code.co_code, *constants, *named)
