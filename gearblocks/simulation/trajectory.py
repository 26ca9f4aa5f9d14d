"""The result of a run: arrays by name, events, counters and the energy ledger. Nothing in it can be changed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import ArrayLike

from gearblocks.errors import ParameterError, UnknownNameError, arguments_told, did_you_mean, missing_attribute
from gearblocks.language.units import check_unit
from gearblocks.model.listing import matches
from gearblocks.pages import small_table
from gearblocks.simulation.case import Case
from gearblocks.simulation.energy import EnergyBalance
from gearblocks.simulation.events import Event, Events
from gearblocks.simulation.records import Array, Content, EnergyLedger, FinalState, Stats, frozen
from gearblocks.simulation.samples import Outputs
from gearblocks.simulation.solution import Extremes, Spectrum
from gearblocks.simulation.watched_effects import NOTHING, Watched

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from gearblocks.simulation.run_explanation import RunExplanation

__all__ = ["EnergyLedger", "Event", "Events", "FinalState", "Stats", "Trajectory"]

RESERVED = ("t", "event_t", "event_component", "event_kind", "event_before", "event_after")
"""Names that columns cannot have: stored runs use them."""


@final
@arguments_told
class Trajectory:
    """One run: `run.t` [s] and `run["mesh.force"]`, both float64 arrays that cannot be written to.

    columns: a mapping from names to arrays as long as t, or the pair (names, array of shape (len(t), len(names)));
    arrays are taken over, not copied. meta holds what is known of the run: train, parameters, method, rtol,
    complete (False where the run was stopped early) and the like. watched: which effects that were left out of the train
    would have acted. case: what the run follows from, where it was made in this process and came to its end. Files keep
    neither of the two, pickles not the case.
    """

    __slots__ = ("_columns", "_energy", "_events", "_final", "_stats", "case", "meta", "t", "units", "watched")

    t: Array
    _columns: Mapping[str, Array]
    units: Mapping[str, str]
    _events: Events | Callable[[], Events]
    _stats: Stats | Callable[[], Stats]
    _energy: EnergyLedger | EnergyBalance
    meta: Mapping[str, Any]
    _final: FinalState | Callable[[], FinalState] | None
    case: Case | None
    watched: Watched

    def __init__(
        self, t: ArrayLike, columns: Outputs | Mapping[str, ArrayLike] | tuple[Sequence[str], ArrayLike],
        units: Mapping[str, str] | None = None, *, events: Sequence[Event] | Callable[[], Events] = (),
        stats: Stats | Callable[[], Stats] | None = None, energy: EnergyLedger | EnergyBalance | None = None,
        meta: Mapping[str, Any] | None = None, final_state: FinalState | Callable[[], FinalState] | None = None,
        case: Case | None = None, watched: Watched | None = None,
    ) -> None:  # fmt: skip
        time, known, outputs = frozen(t), units or {}, columns
        if not isinstance(outputs, Outputs):
            outputs = _by_name(outputs)
            _check(time, outputs)
        if len(known) != len(outputs) or not isinstance(outputs, Outputs):
            known = {name: known.get(name, "") for name in outputs}
        put = object.__setattr__
        put(self, "t", time)
        put(self, "_columns", outputs)
        put(self, "units", known if isinstance(known, MappingProxyType) else MappingProxyType(known))
        put(self, "_events", events if callable(events) else Events.of(events))
        put(self, "_stats", stats or Stats())
        put(self, "_energy", energy or EnergyLedger())
        put(self, "meta", MappingProxyType(dict(meta or {})))
        put(self, "_final", final_state)
        put(self, "case", case)
        put(self, "watched", NOTHING if watched is None else watched)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a run cannot be changed (attribute '{name}')")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a run cannot be changed (attribute '{name}')")

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_content, (self.content(),)

    def content(self, *names: str) -> Content:
        """Plain fields of the run, with all outputs or the named ones only."""
        chosen = names or self.names
        columns = self._columns
        return Content(
            t=self.t,
            columns=columns.only(chosen) if isinstance(columns, Outputs) else {name: columns[name] for name in chosen},
            units={name: self.units[name] for name in chosen},
            events=self.events,
            stats=self.stats,
            energy=self.energy,
            meta=dict(self.meta),
            final_state=self.final_state,
            watched=self.watched,
        )

    @property
    def energy(self) -> EnergyLedger:
        """Where the energy went; made from the samples when it is first asked for."""
        if isinstance(self._energy, EnergyBalance):
            object.__setattr__(self, "_energy", self._energy.ledger())
        assert isinstance(self._energy, EnergyLedger)
        return self._energy

    @property
    def final_state(self) -> FinalState | None:
        """Where the run ended; made from its last sample when it is first asked for."""
        if callable(self._final):
            object.__setattr__(self, "_final", self._final())
        assert not callable(self._final)
        return self._final

    @property
    def events(self) -> Events:
        """What switched, in the order of time."""
        if not isinstance(self._events, Events):
            object.__setattr__(self, "_events", self._events())
        assert isinstance(self._events, Events)
        return self._events

    @property
    def stats(self) -> Stats:
        """What the solver counted."""
        if not isinstance(self._stats, Stats):
            object.__setattr__(self, "_stats", self._stats())
        assert isinstance(self._stats, Stats)
        return self._stats

    # -- reading ------------------------------------------------------------------------------------------------
    @property
    def names(self) -> tuple[str, ...]:
        """Names of all recorded outputs."""
        return tuple(self._columns)

    @property
    def name(self) -> str:
        """Name of the train."""
        return str(self.meta.get("train", ""))

    @property
    def complete(self) -> bool:
        """False where the run was stopped before its end."""
        return bool(self.meta.get("complete", True))

    def __getitem__(self, name: str) -> Array:
        if name == "t":
            return self.t
        try:
            return self._columns[name]
        except (KeyError, TypeError):
            raise UnknownNameError(self._unknown("output", name)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise missing_attribute(self, name, outputs=() if name.startswith("_") else self._columns)

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to(self, name: str, unit: str) -> Array:
        """An output in a unit of its measure, shape of `t`: run.to("mesh.deflection", "um").

        Raises ParameterError for a unit that is not known or measures something else, UnknownNameError as run[name] does.
        """
        values, wanted = self[name], check_unit(f"'{name}'", unit)
        known = check_unit(f"'{name}'", "s" if name == "t" else self.units[name])
        if not known.measures(wanted):
            own = known.text or "1"
            raise ParameterError(
                f"'{name}' is in {own}, which '{unit}' does not measure; ask for {own} or a multiple of it{wanted.doubt(known)}"
            )
        return values / wanted.factor

    def find(self, *patterns: str) -> tuple[str, ...]:
        """Names that match any of the patterns, in the order of the run; `*` crosses dots.

        Raises UnknownNameError for a pattern that matches nothing.
        """
        hits: set[str] = set()
        for pattern in patterns:
            if not isinstance(pattern, str):
                raise ParameterError(f"outputs are given one by one as text, such as 'mesh.*', not {pattern!r:.80}")
            found = [name for name in self._columns if matches(name, pattern)]
            if not found:
                raise UnknownNameError(self._unknown("output", pattern))
            hits.update(found)
        return tuple(name for name in self._columns if name in hits)

    def select(self, *patterns: str) -> Trajectory:
        """The same run with only the outputs that match, e.g. `run.select("mesh.*", "wheel.w")`."""
        return _from_content(self.content(*self.find(*patterns)), self.case)

    def _unknown(self, what: str, name: object) -> str:
        if not self._columns:
            return f"the run has no {what} {name!r}: it has no outputs at all"
        if isinstance(name, (tuple, list)):
            return f"{list(name)!r:.80} are asked for at once: write run[name] for each, or run.select(*names)"
        way = (
            f"; write run.select({name!r})"
            if isinstance(name, str) and any(matches(n, name) for n in self.names)
            else ""
        )
        return f"the run has no {what} {name!r}{way or _hint(str(name), self.names)}"

    # -- between the samples ----------------------------------------------------------------------------------
    def extremes(self, name: str, *, after: float | str | None = None, before: float | str | None = None) -> Extremes:
        """(low, low_at, high, high_at): the lowest and the highest value of an output [its unit] and their times [s], located
        on the solution between the samples, in a window [s]. Equal to gb.trough and gb.peak. Raises UnknownNameError,
        ParameterError."""
        from gearblocks.simulation import solution

        return solution.extremes(self, self.case, self._known(name), solution.window_of(self, after, before))

    def rms(self, name: str, *, after: float | str | None = None, before: float | str | None = None) -> float:
        """Root mean square of an output [its unit] over time, integrated; equal to gb.rms."""
        return self._along("rms", name, after, before)

    def mean(self, name: str, *, after: float | str | None = None, before: float | str | None = None) -> float:
        """Mean of an output [its unit] over time, integrated; equal to gb.mean."""
        return self._along("mean", name, after, before)

    def spectrum(
        self, name: str, *, after: float | str | None = None, before: float | str | None = None, samples: int | None = None,
    ) -> Spectrum:  # fmt: skip
        """(frequency [Hz], amplitude [unit of the output]): Fourier's transform of the solution at `samples` equal distances
        under the window of Hann (whose lines are two distances of frequency wide); a part a cos(2 pi f t) has the amplitude
        a."""
        from gearblocks.simulation import solution

        window = solution.window_of(self, after, before)
        return solution.spectrum(self, self.case, self._known(name), self.units.get(name, "1"), window, samples)

    def between(self, t0: float | str, t1: float | str, *, samples: int = 1001) -> Trajectory:
        """The part from t0 to t1 [s] at so many equal distances, found by running it again; events as they were."""
        from gearblocks.simulation import solution

        window = solution.window_of(self, t0, t1)
        if not isinstance(samples, int) or samples < 2:
            raise ParameterError(f"samples = {samples!r} must be a whole number >= 2")
        times = np.linspace(*window, samples)
        table = solution.values_at(self, self.case, self.names, times)
        events = [event for event in self.events if window[0] <= event.t <= window[1]]
        return Trajectory(times, (self.names, table), self.units, events=events, meta=self.meta)

    def explain(self) -> RunExplanation:
        """What limited the steps, where refused trials and events come from, and what would help; found by doing the run again.
        Raises ParameterError for a run that was loaded, or stopped early."""
        if self.case is None or self.case.explained is None:
            raise ParameterError(
                "this run cannot be explained: it was stopped or comes from a file and cannot be done again; run it once more"
            )
        return self.case.explained(self.name, self.stats.method, self.case, self.events)

    def _along(self, kind: str, name: str, after: float | str | None, before: float | str | None) -> float:
        from gearblocks.simulation import solution

        return solution.along(self, self.case, (kind,), self._known(name), solution.window_of(self, after, before))[0]

    def _known(self, name: str) -> str:
        if name not in self:
            raise UnknownNameError(self._unknown("output", name))
        return name

    # -- elsewhere ----------------------------------------------------------------------------------------------
    def plot(self, *names: str, path: str | os.PathLike[str] | None = None) -> Figure:
        """Figure of outputs (names or patterns, else all) over time, one panel per unit; saved to `path`. Between the samples
        curves follow the solution; what takes whole numbers only is drawn in steps; ticks at the foot are events."""
        from gearblocks.simulation import plotting, solution

        chosen = dict.fromkeys(item for pattern in names or ("*",) for item in self.find(pattern))
        t, columns = solution.drawn(self, self.case, tuple(chosen))
        series = [(name, self.units[name], columns[name]) for name in chosen]
        return plotting.over_time(t, series, title=self.name, path=path, events=solution.event_times(self, chosen))

    def to_dataframe(self) -> pandas.DataFrame:
        """One column per output over the index `t`; both sides of an event are two rows of the same t."""
        import pandas

        frame = pandas.DataFrame(self.content().arrays(), index=pandas.Index(np.array(self.t), name="t"))
        frame.attrs["units"] = {"t": "s", **self.units}
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """One variable per output over the coordinate `t`, with units; events along the dimension `event`."""
        from gearblocks.simulation import storage

        return storage.to_dataset(self.content())

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Comma-separated text: a line of names, then rows in full precision. Raises StorageError."""
        from gearblocks.simulation import storage

        storage.write_csv(self.content(), path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Store everything in a `.nc` (netCDF) or `.json` file, or the outputs in a `.csv` one. Raises StorageError."""
        from gearblocks.simulation import storage

        storage.save(self.content(), path)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Trajectory:
        """The run that `save` put into a `.nc` or `.json` file, bit for bit. Raises StorageError."""
        from gearblocks.simulation import storage

        return _from_content(storage.load(path))

    def __repr__(self) -> str:
        if not len(self.t):
            return f"<run of '{self.name}': empty>"
        head = f"<run of '{self.name}': {self.t[0]:.6g} .. {self.t[-1]:.6g} s, {len(self.t)} samples"
        head += "" if self.complete else ", stopped early"
        listed = _few(self.names, 6) + (f" ({len(self)} outputs)" if len(self) > 6 else "")
        if not self.stats.method:  # a part of a run: what the solver counted belongs to the whole
            return f"{head}\n  {listed}>"
        return f"{head}\n  {self.stats}\n  energy residual {self.energy.residual:.1e}\n  {listed}>"

    def _repr_html_(self) -> str:
        if not len(self.t):
            return small_table(f"Run of '{self.name}'", (), notes=["empty"])
        switched = [f"{name}: {number:,}" for name, number in self.events.counts().items()]
        rows = [
            ("time", f"{self.t[0]:.6g} .. {self.t[-1]:.6g} s{'' if self.complete else ', stopped early'}"),
            ("samples", f"{len(self.t):,}"),
            ("outputs", f"{len(self):,}: {_few(self.names, 8)}"),
            ("events", f"{len(self.events):,}{': ' if switched else ''}{_few(switched, 8)}"),
            ("energy residual", f"{self.energy.residual:.1e} of a turnover of {self.energy.turnover:.6g} J"),
        ]
        if not self.stats.method:
            return small_table(f"Run of '{self.name}'", rows[:-1])
        kept = (row for row in self.stats.table() if row[0] != "events")
        return small_table(f"Run of '{self.name}'", [*rows, *kept], notes=[self.stats.why] if self.stats.why else ())


def _few(words: Sequence[str], most: int) -> str:
    return ", ".join(words[:most]) + (", ..." if len(words) > most else "")


def _from_content(content: Content, case: Case | None = None) -> Trajectory:
    return Trajectory(
        content.t,
        content.columns,
        content.units,
        events=content.events,
        stats=content.stats,
        energy=content.energy,
        meta=content.meta,
        final_state=content.final_state,
        case=case,
        watched=content.watched,
    )


def _hint(name: str, names: Sequence[str]) -> str:
    return f"; it has {_few(names, 12)}{did_you_mean('t' if name == 'time' else name, [*names, 't'])}"


def _by_name(columns: Mapping[str, ArrayLike] | tuple[Sequence[str], ArrayLike]) -> dict[str, Array]:
    if isinstance(columns, Mapping):
        return {str(name): frozen(values) for name, values in columns.items()}
    names, values = columns
    table = frozen(values)
    if table.ndim != 2 or table.shape[1] != len(names):
        raise ParameterError(f"{len(names)} names do not fit a table of shape {table.shape}")
    return {name: table[:, column] for column, name in enumerate(names)}


def _check(t: Array, columns: dict[str, Array]) -> None:
    if t.ndim != 1:
        raise ParameterError(f"the times of a run are one row of numbers, not an array of shape {t.shape}")
    for name, values in columns.items():
        if values.shape != t.shape:
            raise ParameterError(f"output '{name}' has shape {values.shape}; the run has {len(t)} samples")
        if name in RESERVED:
            raise ParameterError(f"an output cannot be named '{name}'")
