"""Tables of the equations of a train: groups, relative coordinates, dependent groups, and batches of equal kinds.

Numbers of parameters are not in them: what is here decides the form of the equations. Knows nothing of how they are found.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.kinematics import DependentGroup, PrescribedRow
from gearblocks.assembly.rigid_constraints import Groups
from gearblocks.laws.law import Law
from gearblocks.laws.rational import Exact
from gearblocks.train.graph import Train

GROUND_GROUP = -1
"""Group number of a grounded flange."""


@dataclass(slots=True)
class ExactValues:
    """Fractions of the symbols that enter ratios of one component, and which float parameters became structural."""

    values: dict[Any, Exact]
    structural: list[tuple[str, float]]


@dataclass(slots=True)
class Batch:
    """Instances of one kind that share code: the law, and one table column per flange and coordinate.

    flanges: names of the flanges that are not the ground; groups and gains: one entry per instance (GROUND_GROUP: grounded).
    sources: per coordinate of the law and instance, the number of a coordinate, or of a dependent combination.
    """

    name: str
    law: Law
    components: list[int] = field(default_factory=list)
    flanges: tuple[str, ...] = ()
    groups: dict[str, list[int]] = field(default_factory=dict)
    gains: dict[str, list[Exact]] = field(default_factory=dict)
    nodes: dict[str, list[int]] = field(default_factory=dict)
    sources: list[list[int]] = field(default_factory=list)
    dependent: tuple[bool, ...] = ()
    exact: dict[Any, list[Exact]] = field(default_factory=dict)
    used: tuple[bool, ...] = ()


@dataclass(slots=True)
class StartValues:
    """Where the start angle and speed of a group come from: the component and the gain of its node."""

    phi0: str
    phi0_gain: Exact
    w0: str
    w0_gain: Exact


@dataclass(slots=True)
class Assembly:
    """Tables of a train's equations.

    Groups are numbered: independent ones (n_speeds), massless ones (n_massless), those whose speed alone is prescribed
    (n_prescribed), then the other dependent ones. rows[i]: coordinate i as a form of group angles; dependents: dependent
    coordinates, combinations that close loops; angles: groups whose absolute angle is a state; definitions (in order, with
    prescribed motions in between): the other group angles. in_law: a law reads angles. steady: groups whose speeds
    are fixed combinations; n_steady: coordinates at the front whose rates are. with_inertia: groups with inertia. floating:
    massless groups that are a part of another (massless_groups.py), with that other; floating_bases: numbers of those
    that stand for several. inverted: components whose relation is solved for its other flange. force_unknowns: massless
    groups whose speeds are constraint forces (laws/algebraic_friction.py). speed_ties: pairs of groups, with factors, whose
    speeds such a force ties.
    """

    train: Train
    batches: list[Batch]
    groups: Groups
    group_of_node: list[tuple[int, Exact]] = field(default_factory=list)
    ground_offset: dict[int, str | None] = field(default_factory=dict)
    n_groups: int = 0
    n_speeds: int = 0
    n_massless: int = 0
    n_prescribed: int = 0
    floating: dict[int, int] = field(default_factory=dict)
    floating_bases: frozenset[int] = frozenset()
    dependent_groups: list[DependentGroup] = field(default_factory=list)
    with_inertia: frozenset[int] = frozenset()
    rows: list[dict[int, Exact]] = field(default_factory=list)
    row_offsets: list[dict[str, Exact]] = field(default_factory=list)
    dependents: list[Combination] = field(default_factory=list)
    angles: list[int] = field(default_factory=list)
    definitions: list[tuple[int, Combination | PrescribedRow]] = field(default_factory=list)
    starts: list[StartValues] = field(default_factory=list)
    steady: frozenset[int] = frozenset()
    n_steady: int = 0
    in_law: bool = False
    structural: tuple[tuple[str, float], ...] = ()
    inverted: frozenset[int] = frozenset()
    force_unknowns: frozenset[int] = frozenset()
    speed_ties: tuple[tuple[tuple[int, Exact], ...], ...] = ()

    def __repr__(self) -> str:
        counts = f"{self.n_groups} groups, {self.n_speeds} of them with a speed of their own"
        return f"<Assembly of '{self.train.name}': {counts}, {len(self.rows)} coordinates, {len(self.batches)} batches>"

    @property
    def plain(self) -> bool:
        """Whether every group is independent."""
        return self.n_groups == self.n_speeds

    @property
    def has_prescribed_angles(self) -> bool:
        """Whether an angle is prescribed."""
        return any(isinstance(row, PrescribedRow) for _, row in self.definitions)
