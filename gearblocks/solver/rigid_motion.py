"""Motions of a train that turns as one piece: rows over group angles (or speeds) that are taken one by one,

    sum of c_g x_g = d        each solved for one group; what it contradicts, or says again, is left out and told

Gaussian elimination over sparse rows in floating point, in reduced form: every definition names free groups alone. The group
that fewest definitions name is solved for, so that a chain of n rows takes of order n log n operations. Knows nothing of
what the rows mean.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

_DEPENDENT = 1e-11  # of the sizes of the terms of a row: what is left of its coefficients is rounding
AGREES = 1e-9
"""Of the sizes of what a row compares: a difference that is rounding."""


class RigidMotion:
    """Rows so far. definitions: each group that follows, as (factors of free groups, constant)."""

    def __init__(self) -> None:
        self.definitions: dict[int, tuple[dict[int, float], float]] = {}
        self._readers: dict[int, set[int]] = {}

    def copied(self) -> RigidMotion:
        """The same, to be gone on with apart from this one."""
        other = RigidMotion()
        other.definitions = {g: (dict(factors), constant) for g, (factors, constant) in self.definitions.items()}
        other._readers = {g: set(readers) for g, readers in self._readers.items()}
        return other

    def left(self, row: Mapping[int, float]) -> tuple[dict[int, float], float]:
        """A row over the free groups, and the constant that the others add."""
        found: dict[int, float] = {}
        sizes: dict[int, float] = {}
        constant = 0.0
        for group, c in row.items():
            factors, own = self.definitions.get(group, ({group: 1.0}, 0.0))
            constant += c * own
            for free, factor in factors.items():
                found[free] = found.get(free, 0.0) + c * factor
                sizes[free] = sizes.get(free, 0.0) + abs(c * factor)
        largest = max(sizes.values(), default=0.0)
        return {g: c for g, c in found.items() if abs(c) > _DEPENDENT * max(sizes[g], 1e-3 * largest)}, constant

    def value(self, row: Mapping[int, float]) -> float | None:
        """The value of a form, where it is determined."""
        left, constant = self.left(row)
        return None if left else constant

    def take(self, row: Mapping[int, float], wanted: float) -> bool:
        """Takes a row unless it is determined; whether it was taken."""
        left, constant = self.left(row)
        if not left:
            return False
        largest = max(map(abs, left.values()))
        near = [g for g, c in left.items() if abs(c) > 1e-3 * largest]
        pivot = min(near, key=lambda g: len(self._readers.get(g, ())))
        c = left.pop(pivot)
        self._define(pivot, {g: -x / c for g, x in left.items()}, (wanted - constant) / c)
        return True

    def _define(self, pivot: int, factors: dict[int, float], constant: float) -> None:
        for reader in self._readers.pop(pivot, ()):
            before, own = self.definitions[reader]
            share = before.pop(pivot)
            for g, x in factors.items():
                total = before.get(g, 0.0) + share * x
                before[g] = total
                self._readers.setdefault(g, set()).add(reader)
            self.definitions[reader] = before, own + share * constant
        self.definitions[pivot] = factors, constant
        for g in factors:
            self._readers.setdefault(g, set()).add(pivot)

    def moved(self) -> Iterator[int]:
        """Free groups that stand beside a constant in some definition, directly or through others."""
        found: set[int] = set()
        waiting = [g for factors, constant in self.definitions.values() if constant for g in factors]
        while waiting:
            free = waiting.pop()
            if free not in found:
                found.add(free)
                waiting += [g for reader in self._readers.get(free, ()) for g in self.definitions[reader][0]]
        yield from sorted(found)
