"""The parts of one program while it is being generated: what the stages of `codegen` fill and `views` prints."""

from __future__ import annotations

from dataclasses import dataclass, field

from gearblocks.assembly.angle_wrapping import Turns
from gearblocks.assembly.assemble import Assembly
from gearblocks.codegen.batch import BatchCode, Function, Statement
from gearblocks.codegen.feedback import Sense
from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.codegen.layout import Column, Layout
from gearblocks.codegen.mass_matrix import Motions
from gearblocks.codegen.massless_groups import Massless
from gearblocks.codegen.program import EnergyInfo, IntegralInfo, Quantity, SwitchInfo
from gearblocks.codegen.switched_constraints import Locks
from gearblocks.language.signals import Table
from gearblocks.language.tables import Table2
from gearblocks.laws.rational import Exact


@dataclass(slots=True)
class Prediction:
    """How a time switch is foretold: the C function of gb_table.h, its constant arguments, its place."""

    name: str
    predictor: str
    args: list[str]
    prologue: list[tuple[str, str]]
    first: int
    count: int
    table: str


@dataclass(slots=True)
class Band:
    """A switch whose mode is a side of a band: the function that holds its half width, and its first place."""

    function: Function
    first: int


@dataclass(slots=True)
class SenseCode:
    """The functions of one sensed output for implicit methods and the numbers of its instance: slopes, and change."""

    slope: Function
    slope_args: str
    change: Function
    change_args: str


@dataclass(frozen=True, slots=True)
class Following:
    """Rows by group over unknowns: the speed of each, that of those with inertia, the equations that its torque and (with
    by_rate) the rate of its torque belong to; and how defined angles change with those of groups and with y."""

    speeds: list[dict[int, Exact]]
    heavy: list[dict[int, Exact]]
    torques: list[dict[int, Exact]]
    growths: list[dict[int, Exact]]
    by_rate: bool
    tilts: list[dict[int, Exact]]
    state_tilts: list[dict[int, Exact]]


@dataclass(slots=True)
class Computed:
    """Where rows are computed (varying.py): values that numbers start with, places of g and of gains (by number of the
    gain), steps, rows of equations with inertia; entries of dG/ds as (unknown, simple state); B over unknowns.

    first_surplus, first_carried, rates: further rows of the spreading table; carried: groups of the second.
    """

    start: list[float]
    g: int
    gains: list[tuple[int, int]]
    steps: list[tuple[int, int, int]]
    heavy: list[dict[int, int]]
    entries: list[tuple[int, int]]
    simple: list[dict[int, Exact]]
    carried: list[int]
    first_surplus: int = 0
    first_carried: int = 0
    rates: int = 0


@dataclass(slots=True)
class Linear:
    """What implicit methods need. first_speed: the unknown of the first speed; n_kept: numbers that jacobian keeps.

    following: where some groups follow others; computed: where their gains change. spread, or then terms: rows of the
    table that spreads entries; those of the inertias begin at first_mass. senses: in the order of their calls.
    """

    pattern: Pattern
    n_simple: int
    first_speed: int
    n_kept: int
    n_slopes: int
    following: Following | None = None
    computed: Computed | None = None
    functions: dict[str, list[Function]] = field(default_factory=dict)
    senses: list[SenseCode] = field(default_factory=list)
    spread: list[dict[int, Exact]] = field(default_factory=list)
    terms: list[list[tuple[int, int, int]]] = field(default_factory=list)
    first_mass: int = 0

    def keep(self, what: str, function: Function) -> None:
        """Adds a function unless it does nothing."""
        if function.body:
            self.functions.setdefault(what, []).append(function)


@dataclass
class Generator:
    """Collects the parts of one program while offsets are handed out."""

    assembly: Assembly
    lay: Layout
    turns: Turns = field(default_factory=Turns)
    codes: list[BatchCode] = field(default_factory=list)
    senses: dict[str, Sense] = field(default_factory=dict)
    tables: dict[str, tuple[str, Table]] = field(default_factory=dict)
    maps: dict[str, tuple[str, Table2, list[str]]] = field(default_factory=dict)
    n_par: int = 0
    n_time: int = 0
    shared: dict[tuple[int, str], str] = field(default_factory=dict)
    prepare_shared: list[Statement] = field(default_factory=list)
    times_shared: list[Statement] = field(default_factory=list)
    early: set[str] = field(default_factory=set)
    means_shared: list[Statement] = field(default_factory=list)
    functions: dict[str, list[Function]] = field(default_factory=dict)
    outputs: list[Quantity] = field(default_factory=list)
    energies: list[EnergyInfo] = field(default_factory=list)
    integrals: list[IntegralInfo] = field(default_factory=list)
    switches: list[SwitchInfo] = field(default_factory=list)
    exact: list[tuple[int, Column]] = field(default_factory=list)
    predictions: list[Prediction] = field(default_factory=list)
    table_switches: list[tuple[int, int, str]] = field(default_factory=list)
    bands: list[Band] = field(default_factory=list)
    n_affine: int = 0
    n_surfaces: int = 0
    inverse_mass: int = 0
    mass: int = 0
    motion: Motions | None = None
    locks: Locks = field(default_factory=Locks)
    massless: Massless | None = None
    mobile: list[int] = field(default_factory=list)
    supply0: int = 0
    tail: int = 0
    linear: Linear | None = None

    def shared_times(self, late: bool) -> list[Statement]:
        """Shared columns of time: those of the rates, or those that only outputs and energies read."""
        return [s for s in self.times_shared if (f"{s.lhs[:-5]}]" in self.early) is not late]

    def keep(self, what: str, function: Function) -> None:
        """Adds a function unless it does nothing."""
        if function.body:
            self.functions.setdefault(what, []).append(function)
