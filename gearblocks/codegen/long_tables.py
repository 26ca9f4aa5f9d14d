"""Long tables of the generated C that follow a pattern, as a few numbers: the library writes them out when it is loaded.

A compiler takes a microsecond for each number of an array, and the tables of a long train have many, nearly all of them
predictable. Knows nothing of what the tables mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

LONG = 512
"""A table of this many numbers is looked at; shorter ones stand in the text, where the compiler folds them."""
LAGS = (1, 2, 3, 4, 6)
_WORTH = 4  # numbers of the table for each of those that stand for it
_LARGEST = 2**28  # sums of three stay within an int of C


@dataclass(frozen=True, slots=True)
class Pattern:
    """x[i] = 2 x[i - lag] - x[i - 2 lag], and zeros before, but for the bends (i, what is added), which end at (n, 0).

    numbers: what stands in the table for 0, 1, ..., where that is not x itself.
    """

    kind: str
    name: str
    n: int
    lag: int
    bends: tuple[tuple[int, int], ...]
    numbers: tuple[str, ...] = ()


@dataclass(slots=True)
class LongTables:
    """The tables of one program that are written out on loading, in the order in which their text was made."""

    patterns: list[Pattern] = field(default_factory=list)

    def take(self, kind: str, name: str, values: Sequence[Any]) -> Pattern | None:
        """The pattern of a table that is long and has one; kind: its type in C."""
        found = pattern_of(kind, name, values) if len(values) >= LONG else None
        if found is not None:
            self.patterns.append(found)
        return found

    @property
    def kinds(self) -> list[str]:
        """Types of the tables that are written out."""
        return sorted({pattern.kind for pattern in self.patterns})


def pattern_of(kind: str, name: str, values: Sequence[Any]) -> Pattern | None:
    """The shortest pattern of whole numbers, or of texts of few different numbers; None where that saves little."""
    numbers: tuple[str, ...] = ()
    if kind == "double":
        texts = values if isinstance(values[0], str) else [*map(str, values)]
        places = {text: i for i, text in enumerate(dict.fromkeys(texts))}
        numbers, values = tuple(places), [places[text] for text in texts]
    if len(numbers) * _WORTH > len(values):
        return None
    x = np.asarray(values, dtype=np.int64)
    if np.abs(x).max() >= _LARGEST:
        return None
    added = {lag: _added(x, lag) for lag in LAGS}
    lag = min(LAGS, key=lambda k: np.count_nonzero(added[k]))
    at = np.flatnonzero(added[lag])
    if (2 * len(at) + len(numbers)) * _WORTH > len(x):
        return None
    bends = (*zip(at.tolist(), added[lag][at].tolist(), strict=True), (len(x), 0))
    return Pattern(kind, name, len(x), lag, bends, numbers)


def _added(x: Any, lag: int) -> Any:
    """What each number is above the line through those one and two lags before."""
    added = x.copy()
    added[lag:] -= 2 * x[:-lag]
    added[2 * lag :] += x[: -2 * lag]
    return added
