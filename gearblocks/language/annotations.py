"""Classes that the annotation of a field names. Knows nothing of what they are."""

from __future__ import annotations

import functools
import inspect
import re
import sys
from typing import Any, get_args


@functools.cache
def effect_classes(cls: type, name: str) -> tuple[Any, ...]:
    """The classes of effects that the annotation of a field names; empty where it names none."""
    for base in cls.__mro__:
        annotation = inspect.get_annotations(base).get(name)
        if annotation is not None:
            words = re.findall(r"\w+", annotation) if isinstance(annotation, str) else []
            known = vars(sys.modules[base.__module__])
            found = [known.get(word) for word in words] or [*get_args(annotation), annotation]
            return tuple(dict.fromkeys(x for x in found if isinstance(x, type) and hasattr(x, "fields")))
    return ()
