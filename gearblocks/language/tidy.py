"""Classes of which help() shows what they declare, not what every object of Python has."""

from __future__ import annotations

import dataclasses
import inspect
from abc import ABCMeta
from collections.abc import Iterable
from typing import Any, TypeVar

_TELLING = frozenset(
    ("__init__", "__call__", "__getitem__", "__len__", "__iter__", "__doc__", "__module__", "__dict__")
)


class Tidy(ABCMeta):
    """Metaclass whose classes list no methods with two underscores around their name, but for those that are called by name or
    by brackets. Objects list all that they have."""

    __instancecheck__ = type.__instancecheck__  # by descent alone, which is quick

    def __dir__(cls) -> Iterable[str]:
        return [name for name in super().__dir__() if not name.startswith("_") or name in _TELLING]


_C = TypeVar("_C", bound=type)


def told(kind: _C) -> _C:
    """A dataclass whose signature shows the defaults that it makes ({}), not that it makes them (<factory>)."""
    made = {f.name: f.default_factory() for f in dataclasses.fields(kind) if callable(f.default_factory)}
    own: Any = vars(kind)["__init__"]
    given = inspect.signature(own)
    shown = [p.replace(default=made.get(p.name, p.default)) for p in given.parameters.values()]
    own.__signature__ = given.replace(parameters=shown)
    return kind
