"""Rows of a matrix whose numbers are computed each time: constants, numbers that functions write, sums of products."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from gearblocks.laws.rational import Exact

Row = dict[int, int]
"""By unknown, or -1 - s of a kinematic state s: the offset of a number."""


@dataclass(slots=True)
class Numbers:
    """What rows are made of: constants, numbers that functions write, and sums of products of both.

    start: their values, 0 where computed; steps: (target, one, other) in order, target += one * other.
    """

    start: list[Exact] = field(default_factory=list)
    steps: list[tuple[int, int, int]] = field(default_factory=list)
    _constants: dict[Exact, int] = field(default_factory=dict)
    _fixed: set[int] = field(default_factory=set)

    def constant(self, value: Exact) -> int:
        """The offset of a constant."""
        if value not in self._constants:
            self._constants[value] = self.place(value)
            self._fixed.add(self._constants[value])
        return self._constants[value]

    def place(self, start: Exact = 0) -> int:
        """A new offset, for a number that something writes."""
        self.start.append(start)
        return len(self.start) - 1

    def is_constant(self, row: Row) -> bool:
        """Whether no number of a row is computed."""
        return self._fixed.issuperset(row.values())

    def combine(self, terms: Iterable[tuple[int, Row]]) -> Row:
        """The sum of rows, each times a number."""
        found: dict[int, list[tuple[int, int]]] = {}
        for factor, row in terms:
            for x, number in row.items():
                found.setdefault(x, []).append((factor, number))
        summed = {x: self._sum(products) for x, products in found.items()}
        return {x: number for x, number in summed.items() if number != self._constants.get(0)}

    def _sum(self, products: list[tuple[int, int]]) -> int:
        if all(a in self._fixed and b in self._fixed for a, b in products):
            return self.constant(sum(self.start[a] * self.start[b] for a, b in products))
        if len(products) == 1:
            for a, b in (products[0], products[0][::-1]):
                if a == self._constants.get(1):
                    return b
        target = self.place()
        self.steps += [(target, a, b) for a, b in products]
        return target
