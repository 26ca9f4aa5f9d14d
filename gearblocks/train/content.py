"""Content of values that a law can reach, as text: equal for equal content, in every process.

Functions and classes by their code and by what it names, data by value; what is ours or was installed by its name. Addresses,
as most objects print them, tell nothing: another object has them later. Knows nothing of trains.
"""

from __future__ import annotations

import hashlib
import sys
from abc import ABC
from collections.abc import Iterable, Mapping
from contextlib import suppress
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

_SIMPLE = frozenset((type(None), bool, int, float, complex, str, bytes, Fraction))
_MADE_BY_PYTHON = 1 << 9  # Py_TPFLAGS_HEAPTYPE: all classes but those of C
_NOT_CODE = ("__dict__", "__weakref__", "_abc_impl", "__abstractmethods__")


def content_of(value: Any) -> str:
    """The content of one value."""
    try:
        return Contents().of(value)
    except RecursionError:
        return object.__repr__(value)


class Contents:
    """The contents of values that may refer to each other: what was met before stands as its number."""

    def __init__(self) -> None:
        self._met: dict[
            int, tuple[int, Any]
        ] = {}  # with the objects, as an address stands for another one when they are gone

    def of(self, value: Any) -> str:
        """The content of a value."""
        if type(value) in _SIMPLE:
            return repr(value)
        if id(value) in self._met:
            return f"<{self._met[id(value)][0]}>"
        self._met[id(value)] = len(self._met), value
        if isinstance(value, (property, staticmethod, classmethod, cached_property, MethodType, FunctionType)):
            return self._of_function(value)
        if isinstance(value, type):
            return f"{value.__module__}.{value.__qualname__}" if _is_known(value) else self.of_members(value)
        if isinstance(value, ModuleType):
            return _of_module(value)
        return self._of_data(value)

    def of_members(self, cls: type) -> str:
        """The members of a class and of its bases that are not ours."""
        foreign = [base for base in cls.__mro__ if base is not object and base is not ABC and not _is_ours(base)]
        members = [(n, m) for base in foreign for n, m in sorted(vars(base).items()) if n not in _NOT_CODE]
        return _digest(cls.__qualname__, *(part for name, member in members for part in (name, self.of(member))))

    def _all(self, values: Iterable[Any]) -> str:
        return _digest(*map(self.of, values))

    def _of_data(self, value: Any) -> str:
        kind = f"{type(value).__module__}.{type(value).__qualname__}"
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            return _digest(kind, str(value.dtype), str(value.shape), value.tobytes())
        if isinstance(value, (tuple, list)):
            return _digest(kind, self._all(value))
        if isinstance(value, (set, frozenset)):
            return _digest(kind, *sorted(Contents().of(x) for x in value))
        if isinstance(value, Mapping):
            return _digest(kind, self._all(x for pair in value.items() for x in pair))
        if isinstance(value, BuiltinFunctionType):
            return _digest(kind, value.__qualname__, self.of(value.__self__))
        try:
            made = value.__reduce_ex__(2)
        except Exception:  # noqa: BLE001  what others write: it cannot be taken apart
            return repr(value)
        return _digest(kind, made if isinstance(made, str) else self._all(made))

    def _of_function(self, value: Any) -> str:
        if isinstance(value, MethodType):
            return _digest(self.of(value.__func__), self.of(value.__self__))
        if not isinstance(value, FunctionType):
            return self.of(
                value.fget if isinstance(value, property) else getattr(value, "func", None) or value.__func__
            )
        if _is_ours(value) or _came_along(value.__code__.co_filename):
            return f"{value.__module__}.{value.__qualname__}"
        cells = []
        for cell in value.__closure__ or ():
            with suppress(ValueError):  # an empty cell
                cells.append(cell.cell_contents)
        kept = [*cells, *(value.__defaults__ or ()), *(value.__kwdefaults__ or {}).values()]
        return _digest(self._of_code(value.__code__, value.__globals__), self._all(kept))

    def _of_code(self, code: CodeType, scope: dict[str, Any]) -> str:
        """The bytecode with its constants and the values it names."""
        constants = [self._of_code(x, scope) if isinstance(x, CodeType) else self.of(x) for x in code.co_consts]
        named = [name + (self.of(scope[name]) if name in scope else "") for name in code.co_names]
        return _digest(code.co_code, *constants, *named)


def _of_module(module: ModuleType) -> str:
    """An installed module by name, another one by its source."""
    file = getattr(module, "__file__", None)
    if file is not None and not _came_along(file):
        with suppress(OSError):
            return _digest(module.__name__, Path(file).read_bytes())
    return module.__name__


def _is_ours(thing: Any) -> bool:
    return str(getattr(thing, "__module__", "")).startswith("gearblocks.")


def _is_known(cls: type) -> bool:
    """Whether a class is ours, or came with Python or a package: its name stands for it. What a notebook or exec makes says
    that it is of a module without a file."""
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    return _is_ours(cls) or not cls.__flags__ & _MADE_BY_PYTHON or (file is not None and _came_along(file))


def _came_along(file: str) -> bool:
    """Whether a file came with Python or was installed: its version stands for its content."""
    return "site-packages" in file or file.startswith((sys.base_prefix, "<frozen"))


def _digest(*parts: str | bytes) -> str:
    """Hash of texts, which tells where one ends and the next begins."""
    total = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(len(data).to_bytes(8, "little") + data)
    return total.hexdigest()[:40]
