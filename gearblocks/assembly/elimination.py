"""Row echelon form of a sparse matrix over the rationals, found row by row:

    A x + B y = 0    each independent row solved for one of its unknowns, its pivot:    x_p = D x + E y

x: unknowns (`Combination.groups`); y: quantities that are carried along and never are pivots (`coordinates`, `offsets`),
so that E tells which given rows a solved one consists of. D x may name unknowns that became pivots themselves, before or
after: definitions stay as short as the rows are, and a chain of n rows takes memory and time of order n. Substituting
them all gives the reduced row form, which is unique for given pivots.

Gaussian elimination in exact arithmetic, so that a pivot is chosen for meaning, not for size: the caller names it. Whole
numbers stay whole numbers (laws/rational.py). Knows nothing of trains, and of no reason why a row is what it is.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, TypeVar

from gearblocks.laws.rational import Exact, over

Row: TypeAlias = "dict[int, Exact]"
_K = TypeVar("_K", int, str)


@dataclass(slots=True)
class Combination:
    """Linear form: sum of coefficient * unknown (of a train: the angle of a group) + coordinates + offsets.

    coordinates, by number, and offsets, by the path of a parameter, are never solved for.
    """

    groups: Row = field(default_factory=dict)
    coordinates: Row = field(default_factory=dict)
    offsets: dict[str, Exact] = field(default_factory=dict)

    def add(self, other: Combination, factor: Exact) -> None:
        """Adds factor times another form."""
        add_row(self.groups, other.groups, factor)
        add_row(self.coordinates, other.coordinates, factor)
        add_row(self.offsets, other.offsets, factor)


def add_row(target: dict[_K, Exact], source: Mapping[_K, Exact], factor: Exact) -> None:
    """target += factor * source; what cancels leaves no entry."""
    if not target:
        target.update(scaled(source, factor))
        return
    for key, value in source.items():
        total = target.get(key, 0) + factor * value
        if total:
            target[key] = total
        else:
            target.pop(key, None)


def scaled(row: Mapping[_K, Exact], factor: Exact) -> dict[_K, Exact]:
    """factor * row."""
    return {key: product for key, value in row.items() if (product := factor * value)}


def row_sum(terms: Iterable[tuple[Exact, Mapping[int, Exact]]], rounding: float = 0.0) -> Row:
    """Sum of factor * row. An entry below `rounding` times the sizes of its terms is 0: what floats, taken at their binary
    value, leave where they cancel (three times 120 degrees, in factors that are cosines, close the circle)."""
    terms = list(terms)
    if len(terms) == 1:  # nothing cancels
        return scaled(terms[0][1], terms[0][0])
    total: Row = {}
    for factor, row in terms:
        add_row(total, row, factor)
    if not rounding or all(isinstance(c, int) for c in total.values()):
        return total
    sizes = dict.fromkeys(total, 0.0)
    for factor, row in terms:
        for key, c in row.items():
            if key in sizes:
                sizes[key] += abs(float(factor) * float(c))
    return {key: c for key, c in total.items() if abs(float(c)) > rounding * sizes[key]}


def solved(form: Combination, pivot: int) -> Combination:
    """What an unknown is where the row `form` is 0."""
    factor = over(-1, form.groups[pivot])
    groups = scaled(form.groups, factor)
    del groups[pivot]
    return Combination(groups, scaled(form.coordinates, factor), scaled(form.offsets, factor))


class Elimination:
    """Rows that are solved one by one; `definitions`: each pivot by the other unknowns of its row and what is carried along.

    rounding: relative size below which what is left of an entry is 0 (`row_sum`); 0 where every number is exact.
    """

    def __init__(self, rounding: float = 0.0) -> None:
        self.rounding = rounding
        self.definitions: dict[int, Combination] = {}
        self._gains: dict[int, Row] = {}

    def solve(self, form: Combination, pivot: int) -> None:
        """Makes an unknown of the row `form` = 0 its pivot. form: a reduced row, or a row whose unknowns stand in no
        definition together, directly or through others (else definitions could name each other in a circle)."""
        self.definitions[pivot] = definition = solved(form, pivot)
        self._gains[pivot] = definition.groups

    def left(self, row: Mapping[int, Exact]) -> Row:
        """A row over the unknowns that are no pivots, without what is carried along; empty: it says nothing new."""
        if self.definitions.keys().isdisjoint(row):
            return {x: c for x, c in row.items() if c}
        return row_sum(((c, self.gains(x)) for x, c in row.items()), self.rounding)

    def gains(self, unknown: int) -> Row:
        """An unknown over those that are no pivots. Kept, as the path compression of a union-find keeps roots."""
        if unknown not in self.definitions:
            return {unknown: 1}
        gains = self._gains[unknown]
        while not self.definitions.keys().isdisjoint(gains):
            terms = ((c, self._gains[x] if x in self.definitions else {x: 1}) for x, c in gains.items())
            gains = self._gains[unknown] = row_sum(terms, self.rounding)
        return gains

    def reduced(self, form: Combination) -> Combination:
        """A form over the unknowns that are no pivots, with what is carried along."""
        result = Combination(dict(form.groups), dict(form.coordinates), dict(form.offsets))
        for pivot in reversed(self.order(form.groups)):
            c = result.groups.pop(pivot, 0)
            if c:
                result.add(self.definitions[pivot], c)
        return result

    def order(self, wanted: Iterable[int]) -> list[int]:
        """The pivots that some unknowns depend on, each after those that its definition names."""
        return dependency_order(wanted, self.definitions, lambda pivot: self.definitions[pivot].groups)


def dependency_order(
    wanted: Iterable[int], defined: Container[int], sources: Callable[[int], Iterable[int]]
) -> list[int]:
    """Topological order by depth-first search: the defined ones that `wanted` depend on, each after its sources.

    In a circle one of them comes before its sources.
    """
    done: dict[int, None] = {}
    entered: set[int] = set()
    for start in wanted:
        stack = [(start, False)]
        while stack:
            x, ready = stack.pop()
            if ready:
                done[x] = None
            elif x in defined and x not in entered:
                entered.add(x)
                stack.append((x, True))
                stack.extend((source, False) for source in sources(x))
    return list(done)
