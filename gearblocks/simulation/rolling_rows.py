"""Rows of a train that rolls, taken one by one, and which given values stand in one connected part.

Knows nothing of which rows there are, nor in which order they are taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from gearblocks.codegen.program import Program, RigidRow
from gearblocks.errors import ParameterError
from gearblocks.solver.rigid_motion import AGREES, RigidMotion
from gearblocks.train.disjoint_sets import DisjointSets


@dataclass(slots=True)
class RowsTaken:
    """Rows that were taken, and which given values stand in one connected part."""

    program: Program
    what: str
    motion: RigidMotion = field(default_factory=RigidMotion)
    joined: DisjointSets[int] = field(default_factory=DisjointSets)
    named: list[tuple[str, int]] = field(default_factory=list)

    def take(self, row: RigidRow, wanted: float) -> bool:
        """Whether a row said something new."""
        for other in row.groups[1:]:
            self.joined.join(other, row.groups[0])
        return self.motion.take(self.factors(row), wanted)

    @staticmethod
    def factors(row: RigidRow) -> dict[int, float]:
        """The factors by group."""
        return dict(zip(row.groups, row.factors, strict=True))

    def give(self, name: str, row: RigidRow, wanted: float) -> None:
        """Takes a given value. ParameterError where another one follows from those before."""
        if not self.take(row, wanted):
            follows = self.motion.left(self.factors(row))[1]
            if abs(follows - wanted) > AGREES * max(abs(follows), abs(wanted)):
                raise ParameterError(
                    f"initial: '{name}' = {wanted:.9g} contradicts the {follows:.9g} that follows from "
                    f"{self.sources(row) or 'what moves or holds it'}, where {self.what}; leave one of them out"
                )
        elif row.groups:
            self.named.append((name, row.groups[0]))

    def told(self) -> set[int]:
        """The connected parts that a given value stands in."""
        return {self.joined.root(group) for _, group in self.named}

    def reached(self, rows: list[RigidRow]) -> set[int]:
        """The connected parts that a given value stands in, and those that rows join with them."""
        beyond = DisjointSets[int]()
        for row in rows:
            for g in row.groups[1:]:
                beyond.join(self.joined.root(g), self.joined.root(row.groups[0]))
        told = {beyond.root(part) for part in self.told()}
        return {
            part for row in rows for g in row.groups if beyond.root(part := self.joined.root(g)) in told
        } | self.told()

    def is_told(self, row: RigidRow, told: set[int]) -> bool:
        """Whether a row touches one of them."""
        return any(self.joined.root(g) in told for g in row.groups)

    def sources(self, row: RigidRow) -> str:
        """The given values that a row is joined with."""
        if not row.groups:
            return ""
        root = self.joined.root(row.groups[0])
        return ", ".join(f"'{name}'" for name, group in self.named if self.joined.root(group) == root)

    def values(self, free: Mapping[int, float] | None = None) -> list[float]:
        """The value of every group, free ones as given, else 0."""
        free, found = free or {}, []
        for g in range(len(self.program.groups)):
            factors, constant = self.motion.definitions.get(g, ({g: 1.0}, 0.0))
            found.append(constant + sum(c * free[x] for x, c in factors.items() if x in free))
        return found
