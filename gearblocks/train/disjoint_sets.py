"""Union-find: disjoint sets of elements, each element a fixed multiple of the root of its set.

    x(element) = gain * x(root)    gains are whole numbers or fractions, exact; 1 where only membership counts

Path compression (Tarjan 1975) keeps a search near constant time; the gains along a path are multiplied as it is
compressed. The caller chooses which root stays, so that the order of joining decides nothing by itself: sets are not
weighed by size. Knows nothing of nodes, angles or ties.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from fractions import Fraction
from typing import Generic, TypeAlias, TypeVar

Gain: TypeAlias = "int | Fraction"
_T = TypeVar("_T", bound=Hashable)


class DisjointSets(Generic[_T]):
    """Sets of elements that need not be declared: one that was never joined is alone."""

    __slots__ = ("_above", "_gains")

    def __init__(self) -> None:
        self._above: dict[_T, _T] = {}  # of every element but the roots
        self._gains: dict[_T, Gain] = {}  # relative to the element above

    def root(self, element: _T) -> _T:
        """The element that stands for the whole set."""
        return self.find(element)[0]

    def find(self, element: _T) -> tuple[_T, Gain]:
        """(root, gain) of an element."""
        root = self._above.get(element)
        if root is None:
            return element, 1
        path = [element]
        while (above := self._above.get(root)) is not None:
            path.append(root)
            root = above
        if len(path) < 2:
            return root, self._gains[element]
        gain = self._gains[path[-1]]
        for below in path[-2::-1]:
            gain = gain * self._gains[below]
            self._above[below], self._gains[below] = root, gain
        return root, gain

    def join(self, element: _T, other: _T, gain: Gain = 1) -> None:
        """Joins two sets by x(element) = gain * x(other); the root of `other` stays. Nothing happens within one set."""
        (below, own), (above, its) = self.find(element), self.find(other)
        if below != above:
            self._above[below], self._gains[below] = above, _over(gain * its, own)

    def reroot(self, roots: Mapping[_T, _T]) -> None:
        """Makes other elements the roots of their sets. roots: by the root until now."""
        found = {element: self.find(element) for element in self._above}
        for element, (root, gain) in (*found.items(), *((root, (root, 1)) for root in roots)):
            if root not in roots:
                continue
            new = roots[root]
            if element == new:
                self._above.pop(element, None)
                self._gains.pop(element, None)
            else:
                self._above[element] = new
                self._gains[element] = _over(gain, found[new][1] if new in found else 1)


def _over(a: Gain, b: Gain) -> Gain:
    """a / b; a whole number where it is one."""
    if b == 1:
        return a
    quotient = Fraction(a) / b
    return quotient.numerator if quotient.denominator == 1 else quotient
