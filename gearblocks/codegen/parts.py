"""Parts of one program while it is generated: what each stage of code generation fills and the template prints."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from gearblocks.assembly.kinematics import DependentGroup
from gearblocks.codegen.function import Function, Names
from gearblocks.codegen.jacobian.sparsity import Pattern, eliminate
from gearblocks.codegen.operands import Role
from gearblocks.laws.rational import Exact

if TYPE_CHECKING:
    from gearblocks.laws.switched_constraints import ConstraintLaw

VALUES = 5
"""Numbers per switched constraint that the solver asks for at an event: force bounds, sliding forces, engaged."""


@dataclass(slots=True)
class SwitchedConstraint:
    """One switched constraint: its component, its row over the groups, its switches and state offsets (-1: none; heat:
    one more than the offset, 0: none)."""

    path: str
    law: ConstraintLaw
    row: dict[int, float]
    slip: int = -1
    active: int = -1
    free: int = -1
    impulse: int = -1
    impacts: int = -1
    loss: int = -1
    partner: int = -1
    heat: int = 0

    @property
    def kind(self) -> str:
        """Name of its kind in C."""
        return f"GB_{self.law.kind.upper()}"


@dataclass(slots=True)
class SwitchedConstraints:
    """All switched constraints of a train. rows: G over the speeds that they reach (values count where gains do not change
    with the position); speeds: by column. matrix0: offset of the Delassus matrix in par[], where it is constant; pattern: of
    its factors, where it is sparse and symmetric."""

    members: list[SwitchedConstraint] = field(default_factory=list)
    first: dict[tuple[int, str], int] = field(default_factory=dict)
    rows: list[dict[int, float]] = field(default_factory=list)
    speeds: list[int] = field(default_factory=list)
    dynamic: bool = False
    prescribed: bool = False
    driven: bool = False
    lossy: bool = False
    matrix0: int = 0
    pattern: Pattern | None = None

    @property
    def size(self) -> int:
        """Doubles of the active set behind the modes (gb_active_saved in gb_constraint_rows.h)."""
        return 1 + 2 * len(self.members) if self.members else 0

    @property
    def matrix_size(self) -> int:
        """Doubles of the Delassus matrix (gb_delassus_size in gb_delassus.h)."""
        n = len(self.members)
        return n * n if self.pattern is None else n + len(self.pattern.row)

    @property
    def n_reduced(self) -> int:
        """Most entries of the reduced rows besides their pivots: a row of two speeds stays one, whatever is taken off it."""
        pairs = all(len(row) <= 2 for row in self.rows) and not self.dynamic
        return len(self.rows) * (1 if pairs else max(len(self.speeds) - 1, 1))

    @property
    def n_factors(self) -> int:
        """Most factors of the reduction, which slips with a bias need."""
        n = len(self.members)
        return n * (n - 1) // 2 if self.prescribed else 0


MasslessRows = dict[int, dict[int, Exact]]
"""By group: factors of its speed on those of massless groups, by their number."""


@dataclass(slots=True)
class Balance:
    """Torques of one batch on groups that may be massless, and their derivatives.

    torques, torque_rates: torque on a flange and its rate; damping_entries, stiffness_entries: derivatives of a torque by the
    speed and by the angle of a flange, by (flange, flange).
    """

    torques: dict[str, Any] = field(default_factory=dict)
    torque_rates: dict[str, Any] = field(default_factory=dict)
    damping_entries: dict[tuple[str, str], Any] = field(default_factory=dict)
    stiffness_entries: dict[tuple[str, str], Any] = field(default_factory=dict)


@dataclass(slots=True)
class Massless:
    """Massless groups by number. floating_bases: those that stand for several; damped: or not; free_start: whether the
    angle at the start is one of balance. by_mode: groups beside friction, which springs alone hold where it slides and nothing
    damps them. pattern: of their coupling; affine: whether one Newton step gives the speeds;
    switched: whether the laws have modes, whose frozen branch may have no balance beyond the crossing that ends it.
    shifts: by state, what an angle moves it.
    """

    rows: MasslessRows
    floating_bases: frozenset[int]
    damped: list[bool]
    free_start: list[bool]
    pattern: Pattern
    affine: bool
    shifts: list[dict[int, Exact]]
    by_mode: frozenset[int] = frozenset()
    switched: bool = False

    @property
    def rules(self) -> list[int]:
        """By group 1: damped, 0: held by springs alone, 2: either, by the modes."""
        return [2 if i in self.by_mode else int(damped) for i, damped in enumerate(self.damped)]

    @property
    def n_entries(self) -> int:
        """Diagonal, lower and upper entries and one for what goes nowhere."""
        return len(self.pattern.order) + 2 * len(self.pattern.row) + 1

    def entry(self, one: int, other: int) -> int:
        """Offset of the entry (one, other)."""
        n, places = len(self.pattern.order), len(self.pattern.row)
        if one == other:
            return self.pattern.steps[one]
        return n + self.pattern.place(one, other) + (0 if self.pattern.is_lower(one, other) else places)

    @property
    def entry_rows(self) -> list[int]:
        """The massless group whose balance each entry belongs to."""
        rows = [-1] * self.n_entries
        n, places = len(self.pattern.order), len(self.pattern.row)
        rows[:n] = self.pattern.order
        for k in range(n):
            for p in range(self.pattern.start[k], self.pattern.start[k + 1]):
                rows[n + p] = self.pattern.order[self.pattern.row[p]]
                rows[n + places + p] = self.pattern.order[k]
        return rows


@dataclass(slots=True)
class DependentGroups:
    """w of group i = velocity bias + sum gain w: entries [start[i], start[i + 1]) of index (group) and value (gain; 0 where it
    changes with the position).

    gain_index: by member and flange, of gains that change. supplied: members whose prescribed motion supplies power. rows:
    by dependent group with inertia: (speed number -> offset in the array of row entries). steps: how these entries are
    computed, (target, gain, source entry or -1); products: what they add to the mass matrix, (target: offset, or -1 - step
    for the diagonal; entry; entry; group).
    """

    members: list[DependentGroup]
    start: list[int] = field(default_factory=lambda: [0])
    index: list[int] = field(default_factory=list)
    value: list[float] = field(default_factory=list)
    gain_index: dict[tuple[int, str], int] = field(default_factory=dict)
    rows: dict[int, dict[int, int]] = field(default_factory=dict)
    steps: list[tuple[int, int, int]] = field(default_factory=list)
    products: list[tuple[int, int, int, int]] = field(default_factory=list)
    pattern: Pattern = field(default_factory=lambda: eliminate(0, ()))
    dynamic: bool = False
    driven: bool = False  # time moves some of them, whatever the others do
    n_entries: int = 0
    calls: dict[int, Call] = field(default_factory=dict)
    supplied: list[int] = field(default_factory=list)

    @property
    def prescribed(self) -> bool:
        """Whether a prescribed motion has velocity or acceleration biases."""
        return any(f.prescribed is not None for f in self.members)


class Call(NamedTuple):
    """The call of a function for one instance."""

    function: Function
    instance: int

    def __str__(self) -> str:
        return self.function.call(self.instance)


@dataclass(slots=True)
class Enclosures:
    """Enclosures of the event functions of a program.

    first: offsets in the arguments of what they consist of; used: arguments that some enclosure reads. switches: (first,
    count) of those that are enclosed. feedback: calls, each of which reads only earlier ones. forces: whether torques and
    force bounds are enclosed too, and with them the constraint forces.
    """

    first: dict[str, int]
    used: set[int] = field(default_factory=set)
    switches: list[tuple[int, int]] = field(default_factory=list)
    feedback: list[Call] = field(default_factory=list)
    forces: bool = False

    def flags(self, first: int, end: int) -> list[int]:
        """Of the switches [first, end): 1 where it is enclosed."""
        enclosed = {i + e for i, count in self.switches for e in range(count)}
        return [int(i in enclosed) for i in range(first, end)]


@dataclass(slots=True)
class FeedbackSignal:
    """An output that a signal reads: its index in feedback[], where it is shown, and the call that fills it."""

    path: str
    index: int
    batch: int = 0
    instance: int = 0
    expr: Any = None
    call: Call | None = None


@dataclass(slots=True)
class Prediction:
    """Prediction of the crossings of a switch of time: the C function of gb_table.h or gb_timed_crossing.h, its constant
    arguments, the first switch."""

    names: Names
    predictor: str
    args: list[str]
    first: int
    count: int
    table: str


@dataclass(slots=True)
class Band:
    """A switch whose mode is a side of a band: C of its half width, the first switch."""

    names: Names
    half_width: str
    first: int
    count: int


@dataclass(slots=True)
class SignalDerivatives:
    """Calls for one feedback signal in implicit methods: its slopes, and its change."""

    slope: Call
    change: Call


@dataclass(frozen=True, slots=True)
class GroupRows:
    """Rows by group over unknowns: the speed of each, that of those with inertia, the equations that its torque and (with
    by_rate) the rate of its torque belong to; and how defined angles change with those of groups and with y."""

    speeds: list[dict[int, Exact]]
    with_inertia: list[dict[int, Exact]]
    torques: list[dict[int, Exact]]
    torque_rates: list[dict[int, Exact]]
    by_rate: bool
    tilts: list[dict[int, Exact]]
    state_tilts: list[dict[int, Exact]]

    def by_states(self, first_speed: int) -> list[dict[int, Exact]]:
        """What states of blocks alone add to the speed of each group."""
        return [{x: c for x, c in row.items() if x < first_speed} for row in self.speeds]


@dataclass(slots=True)
class Computed:
    """Where rows are computed (unknowns_varying.py): values that numbers start with, places of g and of gains (by number of the
    gain), steps, rows of equations with inertia, changes of accelerations by group; entries of dG/ds as (unknown, kinematic
    state); B over unknowns.

    first_acceleration_bias, first_reduced, rates: further rows of the spreading table; reduced: groups of the second.
    """

    start: list[float]
    g: int
    gains: list[tuple[int, int]]
    steps: list[tuple[int, int, int]]
    with_inertia: list[dict[int, int]]
    accelerations: list[dict[int, int]]
    entries: list[tuple[int, int]]
    kinematic_rates: list[dict[int, Exact]]
    reduced: list[int]
    first_acceleration_bias: int = 0
    first_reduced: int = 0
    rates: int = 0


@dataclass(slots=True)
class Linear:
    """What implicit methods need. first_speed: the unknown of the first speed; n_kinematic_terms: numbers that jacobian keeps.

    group_rows: where some groups are dependent; computed: where their gains change. spread, or then terms: rows of the
    table that spreads entries; those of the inertias begin at first_mass. feedback: in the order of the calls.
    """

    pattern: Pattern
    n_kinematic: int
    first_speed: int
    n_kinematic_terms: int
    n_slopes: int
    group_rows: GroupRows | None = None
    computed: Computed | None = None
    functions: dict[str, list[Function]] = field(default_factory=dict)
    feedback: list[SignalDerivatives] = field(default_factory=list)
    spread: list[dict[int, Exact]] = field(default_factory=list)
    terms: list[list[tuple[int, int, int]]] = field(default_factory=list)
    first_mass: int = 0

    @property
    def reads_forces(self) -> bool:
        """Whether the matrix reads constraint forces."""
        return any(Role.CONSTRAINT_FORCES in f.read for f in self.functions.get("step_matrix", []))

    def keep(self, what: str, function: Function) -> None:
        """Adds a function unless it does nothing."""
        if function.body:
            self.functions.setdefault(what, []).append(function)
