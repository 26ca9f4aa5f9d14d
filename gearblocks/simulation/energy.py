"""The ledger of a run as vectors: what is looked at after every run, and the ledger by element where it is asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np

from gearblocks.codegen.program import Program
from gearblocks.simulation.records import EnergyLedger
from gearblocks.simulation.samples import Samples
from gearblocks.solver.structures import Array

_FEW = 32  # numbers that Python adds up faster than numpy


@final
@dataclass(slots=True, kw_only=True, eq=False)
class EnergyBalance:
    """State vector (with the quadratures) and energies [J] before a run, and at its end; energies in the order of the program.
    exchanged: all amounts that went in or out, each step without its sign.

    largest: the most that was stored at samples that are not kept (-inf without such).

    rounding: energy [J] of rounding, where all motion is that of forces that balance; turnover: what it is at least [J], as the
    samples between the ends may have stored more; bound: the residual relative to that.
    """

    program: Program
    before: tuple[Array, Array]
    state: Array
    last: Array
    exchanged: float
    samples: Samples
    largest: float
    unbalanced: Mapping[str, float] = field(default_factory=dict)
    rounding: float = 0.0
    turnover: float = field(init=False)
    bound: float = field(init=False)

    def __post_init__(self) -> None:
        place, sign = self.program.ledger_integrals
        start, end = _sum(self.before[1]), _sum(self.last)
        missing = abs(end - start + _sum(sign * self.change[place]))  # no BLAS: it wakes threads
        missing = max(missing - self.rounding, 0.0)
        self.turnover = max(start, end) + self.exchanged
        self.bound = missing / self.turnover if self.turnover > 0 else missing

    @property
    def start(self) -> float:
        """Energy stored at the start [J]."""
        return float(np.add.reduce(self.before[1]))

    @property
    def change(self) -> Array:
        """Of the state vector."""
        return self.state - self.before[0]

    def residual(self, enough: float) -> float:
        """The residual, or where it is no more than `enough` a bound of it that does not look at the samples."""
        return self.bound if self.bound <= enough else self.ledger().residual

    def ledger(self) -> EnergyLedger:
        """By element."""
        names, of, place = self.program.energy_components
        start, change = self.start, self.change
        stored = np.zeros(len(names))
        np.add.at(stored, of, self.last[place])
        loss, supplied = (self.program.integral_components[part] for part in ("loss", "supplied"))
        return EnergyLedger(
            stored=dict(zip(names, stored.tolist(), strict=True)),
            start=start,
            dissipated=dict(zip(loss[0], change[loss[1]].tolist(), strict=True)),
            supplied=dict(zip(supplied[0], change[supplied[1]].tolist(), strict=True)),
            exchanged=self.exchanged,
            largest_stored=max(start, self.largest, self.samples.largest_energy()),
            unbalanced=self.unbalanced,
            rounding=self.rounding,
            **self._heat(change),
        )

    def _heat(self, change: Array) -> dict[str, dict[str, float]]:
        """The thermal column: given off by elements, stored in masses, passed to surroundings."""
        given: dict[str, float] = {}
        stored: dict[str, float] = {}
        passed: dict[str, float] = {}
        for item in self.program.heat:
            amount = float(change[item.offset])
            if item.is_loss:
                given[item.component] = amount
            elif not (item.source and item.sink):
                passed[item.component] = amount if item.source else -amount
            for mass, sign in ((item.sink, 1.0), (item.source, -1.0)):
                if mass:
                    stored[mass] = stored.get(mass, 0.0) + sign * amount
        return {"heat": given, "heat_stored": stored, "heat_passed": passed}


def _sum(values: Array) -> float:
    """The sum up to rounding, by the quicker way for so many."""
    return sum(values.tolist()) if len(values) < _FEW else float(np.add.reduce(values))
