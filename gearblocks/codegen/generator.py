"""The parts of one program while it is being generated: what the stages fill and the template prints."""

from __future__ import annotations

from dataclasses import dataclass, field

from gearblocks.assembly.angle_wrapping import AngleWrapping
from gearblocks.assembly.tables import Assembly
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.function import Column, Function
from gearblocks.codegen.layout import Layout
from gearblocks.codegen.long_tables import LongTables
from gearblocks.codegen.operands import Operand, Statement
from gearblocks.codegen.output_list import OutputGroup, OutputList
from gearblocks.codegen.parts import (
    Band,
    DependentGroups,
    Enclosures,
    FeedbackSignal,
    Linear,
    Massless,
    Prediction,
    SwitchedConstraints,
)
from gearblocks.codegen.program import EnergyInfo, IntegralInfo, SwitchInfo
from gearblocks.language.signals import Table
from gearblocks.language.tables import Table2


@dataclass
class Generator:
    """Collects the parts of one program while offsets are handed out."""

    assembly: Assembly
    lay: Layout
    wrapping: AngleWrapping = field(default_factory=AngleWrapping)
    codes: list[BatchCode] = field(default_factory=list)
    feedback: dict[str, FeedbackSignal] = field(default_factory=dict)
    tables: dict[str, tuple[str, Table]] = field(default_factory=dict)
    maps: dict[str, tuple[str, Table2, list[str]]] = field(default_factory=dict)
    behind_motion: frozenset[str] = frozenset()
    n_par: int = 0
    n_time: int = 0
    shared: dict[tuple[int, str], Operand] = field(default_factory=dict)
    prepare_shared: list[Statement] = field(default_factory=list)
    times_shared: list[tuple[Operand, Statement]] = field(default_factory=list)
    of_rates: set[Operand] = field(default_factory=set)
    means_shared: list[Statement] = field(default_factory=list)
    sizes_shared: list[Statement] = field(default_factory=list)
    functions: dict[str, list[Function]] = field(default_factory=dict)
    output_groups: list[OutputGroup] = field(default_factory=list)
    energies: list[EnergyInfo] = field(default_factory=list)
    integrals: list[IntegralInfo] = field(default_factory=list)
    switches: list[SwitchInfo] = field(default_factory=list)
    exact: list[tuple[int, Column]] = field(default_factory=list)
    predictions: list[Prediction] = field(default_factory=list)
    table_switches: list[tuple[int, int, str]] = field(default_factory=list)
    slip_switches: list[int] = field(default_factory=list)
    exact_timed: list[int] = field(default_factory=list)
    exact_moving: list[int] = field(default_factory=list)
    strict_switches: list[tuple[int, int]] = field(default_factory=list)
    force_switches: list[int] = field(default_factory=list)
    bands: list[Band] = field(default_factory=list)
    features: list[bool] = field(default_factory=list)
    inverse_speeds: list[tuple[int, int]] = field(default_factory=list)
    n_affine: int = 0
    n_surfaces: int = 0
    inverse_mass: int = 0
    mass: int = 0
    dependent: DependentGroups | None = None
    constraints: SwitchedConstraints = field(default_factory=SwitchedConstraints)
    massless: Massless | None = None
    mobile: list[int] = field(default_factory=list)
    supply0: int = 0
    n_end: int = 0
    linear: Linear | None = None
    enclosures: Enclosures | None = None
    long_tables: LongTables = field(default_factory=LongTables)

    @property
    def outputs(self) -> OutputList:
        """The outputs so far."""
        return OutputList(self.output_groups)

    @property
    def energy_signs(self) -> list[int]:
        """Of the ledger's entries among the quadratures, 1 for a loss and -1 for what is supplied; ends at 0."""
        known = sorted((x for x in self.integrals if x.part != "angle"), key=lambda x: x.offset)
        return [*(1 if x.part == "loss" else -1 for x in known), 0]

    def shared_time_terms(self, outputs_only: bool) -> list[Statement]:
        """Shared time terms: those of the rates, or those that only outputs and energies read."""
        return [s for term, s in self.times_shared if (term in self.of_rates) is not outputs_only]

    def keep(self, what: str, function: Function) -> None:
        """Adds a function unless it does nothing."""
        if function.body:
            self.functions.setdefault(what, []).append(function)
