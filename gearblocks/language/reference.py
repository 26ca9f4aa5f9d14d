"""What Python itself is told of blocks and effects: `__doc__` with tables of all that a class declares, and `__signature__`.

Both are made when they are read (help, Shift-Tab, an IDE), never when a class or a train is made. Knows nothing of values.
"""

from __future__ import annotations

import functools
import inspect
import re
from abc import ABCMeta
from typing import Any

from gearblocks.language.annotations import effect_classes


class Documented(ABCMeta):
    # A docstring here would be that of every class: what stands at its place is the property below.
    __instancecheck__ = type.__instancecheck__  # by descent alone: long trains ask millions of times, and an ABC thinks

    @property
    def __doc__(cls) -> str:  # type: ignore[override]
        """The written text, then tables of fields, flanges, states, outputs and effects."""
        return _reference(cls)

    @property
    def __signature__(cls) -> inspect.Signature:
        """The fields, all by name."""
        return inspect.Signature([
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, annotation=Verbatim(annotation_of(cls, name) or "Any"),
                default=inspect.Parameter.empty if field.required else field.default,
            )
            for name, field in cls.fields.items()  # type: ignore[attr-defined]  # of every class that this one makes
        ])  # fmt: skip


class Verbatim(str):
    """An annotation that is printed as it was written."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def written_doc(cls: type) -> str:
    """The docstring as it was written, without that of a base."""
    own = vars(cls).get("__doc__")
    return inspect.cleandoc(own) if isinstance(own, str) else ""


def example_of(cls: type) -> str:
    """The lines of Python under "Example:" in the written docstring, or the empty text."""
    found = re.search(r"^Example:\n((?:(?: {4}.*)?(?:\n|$))+)", written_doc(cls), re.M)
    return inspect.cleandoc(found[1]) + "\n" if found else ""


def annotation_of(cls: type, name: str) -> Any:
    """The annotation of a field, as text where its module postpones them; None where it has none."""
    owner = next((base for base in cls.__mro__ if name in vars(base).get("__annotations__", {})), None)
    if owner is None:
        return None
    found = inspect.get_annotations(owner)[name]
    return found if isinstance(found, str) or not isinstance(found, type) else found.__name__


@functools.cache
def _reference(cls: Any) -> str:
    from gearblocks.language.reference_text import reference

    return reference(cls, written_doc(cls), {name: effect_classes(cls, name) for name in cls.fields})
