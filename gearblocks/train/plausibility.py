"""Plausibility of values: bare numbers that are admissible in SI, but which hardly anybody means.

Knows nothing of bounds, which refuse; a value that brings its unit is meant as it stands.
"""

from __future__ import annotations

from collections.abc import Iterator

from gearblocks.errors import warn
from gearblocks.language.block import Block

_LARGEST = {"module": (0.1, "m", "mm")}
"""By field of a block the largest plausible value, its unit, and the unit in which it is usually given."""


def doubts(path: str, block: Block) -> Iterator[str]:
    """What is implausible among the values of a block."""
    for name in _LARGEST.keys() & block.__dict__.keys():
        value, (limit, unit, usual) = block.__dict__[name], _LARGEST[name]
        if type(value) in (int, float) and value > limit:
            yield (
                f"{type(block).__name__} '{path}': {name} = {value!r} {unit} is implausible, above {limit:g} {unit}; "
                f"a bare number is SI: give '{value:g} {usual}' if that is meant"
            )


def warn_of_doubts(path: str, part: object) -> None:
    """A GearblocksWarning, at the line that called the caller, for every implausible value of a part that is a block."""
    for doubt in doubts(path, part) if isinstance(part, Block) else ():
        warn(doubt, stacklevel=3)
