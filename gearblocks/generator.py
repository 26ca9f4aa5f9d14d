"""The parts of one program while it is being generated: what the stages of `codegen` fill and `views` prints."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from gearblocks.assemble import Assembly
from gearblocks.batchcode import BatchCode, Function, Statement
from gearblocks.layout import Column, Layout
from gearblocks.massless import Massless
from gearblocks.motions import Motions
from gearblocks.program import EnergyInfo, IntegralInfo, Quantity, SwitchInfo
from gearblocks.senses import Sense
from gearblocks.turns import Turns


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


@dataclass
class Generator:
    """Collects the parts of one program while offsets are handed out."""

    assembly: Assembly
    lay: Layout
    turns: Turns = field(default_factory=Turns)
    codes: list[BatchCode] = field(default_factory=list)
    senses: dict[str, Sense] = field(default_factory=dict)
    tables: dict[str, Any] = field(default_factory=dict)
    n_par: int = 0
    n_time: int = 0
    shared: dict[tuple[int, str], str] = field(default_factory=dict)
    prepare_shared: list[Statement] = field(default_factory=list)
    times_shared: list[Statement] = field(default_factory=list)
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
    massless: Massless | None = None
    mobile: list[int] = field(default_factory=list)
    supply0: int = 0
    tail: int = 0

    def keep(self, what: str, function: Function) -> None:
        """Adds a function unless it does nothing."""
        if function.body:
            self.functions.setdefault(what, []).append(function)
