"""Symbolic elimination of a sparse matrix with symmetric pattern: order, fill and places, as gb_pattern wants them.

Knows nothing of what the matrix means. Linear in the size of a tree, which gets no fill.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush


@dataclass(frozen=True, slots=True)
class Pattern:
    """The factorisation L D U of a matrix, eliminated in the order given without pivoting.

    order: the unknown of each step; steps: the step of each unknown. Column k of L has its entries in the places
    start[k] .. start[k + 1], in the rows row[place] (steps, ascending). pair: for each pair of entries of a column the
    place that their product goes to, column by column. ahead: so many steps are of unknowns that no other equation reads:
    their columns of L are 0, and have no pairs.
    """

    order: tuple[int, ...]
    steps: tuple[int, ...]
    start: tuple[int, ...]
    row: tuple[int, ...]
    pair: tuple[int, ...]
    ahead: int = 0

    @property
    def is_tree(self) -> bool:
        """Whether no column behind those ahead has more than one entry, so that nothing is filled in."""
        return not self.pair

    def place(self, i: int, j: int) -> int:
        """The place of the entries (i, j) and (j, i), i != j. Raises KeyError where the pattern has none."""
        column, row = sorted((self.steps[i], self.steps[j]))
        end = self.start[column + 1]
        at = bisect_left(self.row, row, self.start[column], end)
        if at == end or self.row[at] != row:
            raise KeyError((i, j))
        return at

    def is_lower(self, i: int, j: int) -> bool:
        """Whether the entry (row i, column j), i != j, lies in L."""
        return self.steps[i] > self.steps[j]


def eliminate(
    n: int, coupled: Iterable[tuple[int, int]], last: frozenset[int] = frozenset(), ahead: Sequence[int] = ()
) -> Pattern:
    """The pattern of n unknowns of which these pairs are coupled (in any order, repeated or not).

    What hangs on by one coupling goes first, level by level from the outside: a chain is eliminated from both ends at
    once. What is left goes by the smallest number of neighbours. last: unknowns that go after all others, as their
    diagonal may be 0 until then. ahead: unknowns that no equation reads but their own and those of earlier ones of these:
    they go first, in this order, and couple nothing.
    """
    neighbours: list[set[int]] = [set() for _ in range(n)]
    for i, j in coupled:
        if i != j:
            neighbours[i].add(j)
            neighbours[j].add(i)
    columns: dict[int, list[int]] = {}
    for i in ahead:
        columns[i] = list(neighbours[i])
        for j in columns[i]:
            neighbours[j].discard(i)
    _peel(neighbours, columns, last)
    if last:
        _by_degree(neighbours, columns, last)
    _by_degree(neighbours, columns)
    return _numbered(columns, len(ahead))


def _peel(neighbours: list[set[int]], columns: dict[int, list[int]], last: frozenset[int]) -> None:
    """Takes leaves away until every unknown that is left has two neighbours at least, or is one of the last."""
    waiting = deque(i for i, around in enumerate(neighbours) if len(around) <= 1 and i not in last and i not in columns)
    while waiting:
        i = waiting.popleft()
        if i in columns:
            continue
        columns[i] = list(neighbours[i])
        for j in columns[i]:
            neighbours[j].discard(i)
            if len(neighbours[j]) == 1 and j not in last:
                waiting.append(j)


def _by_degree(
    neighbours: list[set[int]], columns: dict[int, list[int]], without: frozenset[int] = frozenset()
) -> None:  # fmt: skip
    """Eliminates the rest, fewest neighbours first; equal ones in turn, so that neighbours in the order are apart."""
    heap = [(len(around), 0, i) for i, around in enumerate(neighbours) if i not in columns and i not in without]
    heapify(heap)
    while heap:
        degree, turn, i = heappop(heap)
        if i in columns or i in without or degree != len(neighbours[i]):
            continue
        columns[i] = list(neighbours[i])
        for j in columns[i]:
            neighbours[j].update(columns[i])
            neighbours[j] -= {i, j}
            heappush(heap, (len(neighbours[j]), turn + 1, j))


def _numbered(columns: dict[int, list[int]], ahead: int) -> Pattern:
    order = list(columns)
    steps = [0] * len(order)
    for step, i in enumerate(order):
        steps[i] = step
    start, row = [0], []
    for i in order:
        row += sorted(steps[j] for j in columns[i])
        start.append(len(row))
    pair = []
    for k in range(ahead, len(order)):
        rows = row[start[k] : start[k + 1]]
        for a, inner in enumerate(rows[:-1]):
            pair += [bisect_left(row, outer, start[inner], start[inner + 1]) for outer in rows[a + 1 :]]
    return Pattern(tuple(order), tuple(steps), tuple(start), tuple(row), tuple(pair), ahead)


def read_by_none(coupled: Iterable[tuple[int, int]], among: Iterable[int]) -> list[int]:
    """Those of `among` that no equation reads but their own and those of earlier ones of these.

    coupled: (equation, unknown).
    """
    candidates = set(among)
    readers = dict.fromkeys(candidates, 0)
    reads: dict[int, list[int]] = {i: [] for i in candidates}
    for i, j in {pair for pair in coupled if pair[1] in candidates and pair[0] != pair[1]}:
        readers[j] += 1
        if i in candidates:
            reads[i].append(j)
    found = [i for i in sorted(candidates) if not readers[i]]
    for i in found:  # grows
        for j in reads[i]:
            readers[j] -= 1
            if not readers[j]:
                found.append(j)
    return found
