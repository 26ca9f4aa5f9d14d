"""What is recorded of a run besides its outputs: events, counters, energy, and where it ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.pages import small_table
from gearblocks.plurals import singular
from gearblocks.simulation.events import Events
from gearblocks.simulation.samples import Outputs
from gearblocks.simulation.watched_effects import NOTHING, Watched

Array = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """`values` as doubles that cannot be written to; not copied where they are doubles already."""
    if type(values) is np.ndarray and values.dtype == np.float64 and not values.flags.writeable:
        return values
    array = np.asarray(values, dtype=np.float64).view()
    array.flags.writeable = False
    return array


@final
class NamedValues(Mapping[str, float]):
    """Numbers of a vector by name; the names are shared by all vectors of a model."""

    __slots__ = ("numbers", "vector")

    def __init__(self, numbers: Mapping[str, int], vector: ArrayLike) -> None:
        self.numbers, self.vector = numbers, frozen(vector)

    def __getitem__(self, name: str) -> float:
        return float(self.vector[self.numbers[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)

    def __repr__(self) -> str:
        return repr(dict(self))

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (dict(self),)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Stats:
    """Counters of a run. cpu_seconds: processor time inside the solver; why: the reason for the method."""

    steps: int = 0
    rejected: int = 0
    rhs_calls: int = 0
    jacobians: int = 0
    events: int = 0
    cpu_seconds: float = 0.0
    method: str = ""
    why: str = ""

    def __str__(self) -> str:
        words = f"{self.method}: {self.steps} steps, {self.rejected} rejected, {self.rhs_calls} right-hand sides"
        words += f", {self.jacobians} Jacobians" if self.jacobians else ""
        return singular(f"{words}, {self.events} events, {1e3 * self.cpu_seconds:.3g} ms of CPU time")

    def table(self) -> list[tuple[str, str]]:
        """Words and numbers of every counter."""
        counts = {
            "steps": self.steps, "rejected": self.rejected, "right-hand sides": self.rhs_calls, "Jacobians": self.jacobians,
            "events": self.events,
        }  # fmt: skip
        shown = [(words, f"{count:,}") for words, count in counts.items()]
        return [("method", self.method), *shown, ("CPU time", f"{1e3 * self.cpu_seconds:.3g} ms")]

    def _repr_html_(self) -> str:
        return small_table("Counters of the solver", self.table(), numbers=(1,), notes=[self.why] if self.why else ())


_ROUNDING = 1e-11
"""Of the turnover: amounts below it are sums of rounding errors, or as good as none."""

_HEAT = ("heat", "heat_stored", "heat_passed")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class EnergyLedger:
    """Where the energy of a run went [J].

    stored: per element at the end of the run; start: their sum at its beginning;
    dissipated, supplied: per element over the run (parametric work counts as supplied);
    exchanged: sum of all amounts that went in or out, each step without its sign;
    largest_stored: greatest total during the run;
    rounding: where all motion was rounding of forces that balance, an energy of which nothing can be told; else 0;
    unbalanced: where the residual is above 10 rtol, what the balance of each element misses over the first steps of the run
    (what it stored, lost and passed on more than it was supplied with), largest first;
    heat, heat_stored, heat_passed: the thermal column, over the run: heat of elements to thermal masses (part of what they
    dissipated), heat stored in each mass, heat through each conductance to surroundings.
    """

    stored: Mapping[str, float] = field(default_factory=dict)
    start: float = 0.0
    dissipated: Mapping[str, float] = field(default_factory=dict)
    supplied: Mapping[str, float] = field(default_factory=dict)
    exchanged: float = 0.0
    largest_stored: float = 0.0
    unbalanced: Mapping[str, float] = field(default_factory=dict)
    rounding: float = 0.0
    heat: Mapping[str, float] = field(default_factory=dict)
    heat_stored: Mapping[str, float] = field(default_factory=dict)
    heat_passed: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("stored", "dissipated", "supplied", "unbalanced", *_HEAT):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __reduce__(self) -> tuple[Any, ...]:
        return _ledger, (self.to_dict(),)

    @property
    def end(self) -> float:
        """Energy stored in all elements at the end of the run [J]."""
        return float(sum(self.stored.values()))

    @property
    def imbalance(self) -> float:
        """What was stored more than came in and did not go out [J]: an error of integration, 0 at best."""
        return self.end - self.start - sum(self.supplied.values()) + sum(self.dissipated.values())

    @property
    def turnover(self) -> float:
        """Largest stored energy + everything exchanged [J]: the yardstick of the residual."""
        return self.largest_stored + self.exchanged

    @property
    def residual(self) -> float:
        """Size of the imbalance, as far as it is more than rounding, relative to the turnover."""
        missing = max(abs(self.imbalance) - self.rounding, 0.0)
        return missing / self.turnover if self.turnover > 0 else missing

    @property
    def heat_imbalance(self) -> float:
        """What elements with a heat port dissipated more than masses stored and surroundings took [J]: 0 at best."""
        lost = sum(self.dissipated.get(name, 0.0) for name in self.heat)
        return lost - sum(self.heat_stored.values()) - sum(self.heat_passed.values())

    @property
    def heat_residual(self) -> float:
        """Size of that imbalance relative to the heat that was given off, stored and passed on."""
        columns = (self.heat, self.heat_stored, self.heat_passed)
        moved = sum(abs(x) for column in columns for x in column.values())
        return abs(self.heat_imbalance) / moved if moved > 0 else abs(self.heat_imbalance)

    def to_dict(self) -> dict[str, Any]:
        """Plain fields, as the constructor takes them."""
        return {
            "stored": dict(self.stored),
            "start": self.start,
            "dissipated": dict(self.dissipated),
            "supplied": dict(self.supplied),
            "exchanged": self.exchanged,
            "largest_stored": self.largest_stored,
            **({"unbalanced": dict(self.unbalanced)} if self.unbalanced else {}),
            **({"rounding": self.rounding} if self.rounding else {}),
            **{name: dict(column) for name in _HEAT if (column := getattr(self, name))},
        }

    @property
    def culprit(self) -> str:
        """The element whose own balance misses most, where the residual is above 10 rtol and it could be found; else ""."""
        return next(iter(self.unbalanced), "")

    def __repr__(self) -> str:
        counts = f"{len(self.stored)} stored, {len(self.supplied)} supplied, {len(self.dissipated)} dissipated"
        most = f", most of it in '{self.culprit}'" if self.culprit else ""
        return f"<EnergyLedger: {counts}; residual {self.residual:.1e} of a turnover of {self.turnover:.6g} J{most}>"

    def _rows(self) -> list[tuple[str, float]]:
        """Amounts for people: what is rounding beside the turnover reads 0."""
        least = max(_ROUNDING * self.turnover, self.rounding)
        return [
            (words, 0.0 if abs(value) <= least and "left over" not in words else value) for words, value in self._all()
        ]

    def _all(self) -> list[tuple[str, float]]:
        rows = [("stored at the start", self.start), ("stored at the end", self.end)]
        rows += [(f"supplied by {name}", value) for name, value in self.supplied.items()]
        rows += [(f"dissipated in {name}", value) for name, value in self.dissipated.items()]
        rows.append(("left over", self.imbalance))
        rows += [(f"of these as heat from {name}", value) for name, value in self.heat.items()]
        rows += [(f"heat stored in {name}", value) for name, value in self.heat_stored.items()]
        rows += [(f"heat to surroundings by {name}", value) for name, value in self.heat_passed.items()]
        return [*rows, ("heat left over", self.heat_imbalance)] if self.heat_stored else rows

    def _culprit_words(self) -> list[str]:
        missing = f"misses {self.unbalanced[self.culprit]:.2g} J in the first steps" if self.culprit else ""
        return [f"the balance of '{self.culprit}' {missing}"] if missing else []

    def _repr_html_(self) -> str:
        rows = [(words, f"{value:.6e}", "J") for words, value in self._rows()]
        residual = f"residual {self.residual:.1e} of a turnover of {self.turnover:.6g} J"
        return small_table("Energy of the run", rows, numbers=(1,), notes=[residual, *self._culprit_words()])

    def __str__(self) -> str:
        rows = self._rows()
        width = max(len(words) for words, _ in rows)
        lines = [f"{words:<{width}}  {value: .6e} J" for words, value in rows]
        lines.append(f"{'residual':<{width}}  {self.residual: .1e} of a turnover of {self.turnover:.6e} J")
        return "\n".join([*lines, *self._culprit_words()])


def _ledger(fields: dict[str, Any]) -> EnergyLedger:
    return EnergyLedger(**fields)


@final
@dataclass(frozen=True, slots=True, eq=False)
class FinalState:
    """Where a run ended, for one that continues it: time, whole state vector, modes, key of the program."""

    t: float
    y: Array
    modes: Array
    key: str

    def __repr__(self) -> str:
        return singular(f"<FinalState at t = {self.t:g} s: {len(self.y)} states, {len(self.modes)} modes>")

    def __post_init__(self) -> None:
        object.__setattr__(self, "y", frozen(self.y))
        object.__setattr__(self, "modes", frozen(self.modes))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Content:
    """Everything that a run consists of, by plain fields: what is stored, sent and put together again.

    columns: outputs by name, each as long as t [s]; units: by name of the output; meta: JSON-like values.
    """

    t: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    events: Events
    stats: Stats
    energy: EnergyLedger
    meta: Mapping[str, Any]
    final_state: FinalState | None
    watched: Watched = NOTHING

    def arrays(self) -> dict[str, Array]:
        """All columns as arrays; those that are still to be evaluated in one pass."""
        if isinstance(self.columns, Outputs):
            self.columns.read([*self.columns])
        return dict(self.columns)

    def tables(self) -> Iterator[Array]:
        """All columns side by side behind t, shape (rows, 1 + columns), in batches of rows."""
        if not isinstance(self.columns, Outputs):
            yield np.column_stack([self.t, *self.columns.values()])
            return
        row = 0
        for outputs in self.columns.batches():
            yield np.column_stack([self.t[row : row + len(outputs)], outputs])
            row += len(outputs)

    def __repr__(self) -> str:
        return singular(
            f"<Content of a run: {len(self.t)} samples, {len(self.columns)} outputs, {len(self.events)} events>"
        )
