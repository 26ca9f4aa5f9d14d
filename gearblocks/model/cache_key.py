"""Cache key of a program: the sources of this package, the code of foreign classes, the structure of the train."""

from __future__ import annotations

import functools
import inspect
import sys
from abc import ABC
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from gearblocks.errors import ModelError
from gearblocks.language.block import Declared, values_of
from gearblocks.solver.cache import digest
from gearblocks.train.graph import Train

PACKAGE = Path(__file__).parents[1]


@functools.cache
def package_digest(package: Path = PACKAGE) -> str:
    """Digest of all Python sources and templates below a folder, by path and content: another version of this package
    makes its own programs. The C core is no part of it: what is compiled has a key of its own (solver/library.py)."""
    paths = [*package.rglob("*.py"), *package.rglob("*.jinja")]
    sources = {path.relative_to(package).as_posix(): path.read_bytes() for path in paths}
    return digest(*(part for name in sorted(sources) for part in (name, sources[name])))


def classes_digest(train: Train) -> str:
    """Digest of the code of every class of blocks and effects that is not ours."""
    classes: set[type[Declared]] = {type(block) for block in train.examples}
    for block in train.examples:
        classes |= {type(v) for v in values_of(block).values() if isinstance(v, Declared)}
    foreign = sorted(
        (cls for cls in classes if not cls.__module__.startswith("gearblocks.")),
        key=lambda c: (c.__qualname__, c.__module__),
    )
    for one, other in pairwise(foreign):
        if (one.__module__, one.__qualname__) == (other.__module__, other.__qualname__):
            raise ModelError(f"two classes of blocks are named {one.__qualname__}; rename one, or make its blocks anew")
    return digest(*(_class_text(cls) for cls in foreign))


def structural_text(train: Train) -> str:
    """Canonical text of the whole structure: equal text, equal program."""
    lines = [train.name, str(train.n_nodes)]
    lines += [f"{c.path} {kind.digest} {c.nodes}" for c, kind in zip(train.components, train.kinds, strict=True)]
    lines += [f"{c.name} {c.expr} {c.unit}" for c in train.coordinates]
    return "\n".join(lines)


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
