"""Classes of which help() shows what they declare, not what every object of Python has."""

from __future__ import annotations

from abc import ABCMeta
from collections.abc import Iterable

_TELLING = frozenset(
    ("__init__", "__call__", "__getitem__", "__len__", "__iter__", "__doc__", "__module__", "__dict__")
)


class Tidy(ABCMeta):
    """Metaclass whose classes list no methods with two underscores around their name, but for those that are called by name or
    by brackets. Objects list all that they have."""

    __instancecheck__ = type.__instancecheck__  # by descent alone, which is quick

    def __dir__(cls) -> Iterable[str]:
        return [name for name in super().__dir__() if not name.startswith("_") or name in _TELLING]
