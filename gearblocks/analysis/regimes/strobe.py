"""A driven train seen once per period of its drive: states at the section, and derivatives of them by the state before.

    y_k = P^k(y_0),   M = dP^k/dy_0      (c/gb_tangents.h: through corners, impacts, sticking and events of time)

Knows nothing of what is looked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.stuck import as_held
from gearblocks.analysis.regimes.turns import without_turns
from gearblocks.analysis.sections import Section, check_frequency, section_period
from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.language.starts import is_rolling
from gearblocks.simulation.arguments import is_static, method_options, parameter_vector, set_inputs
from gearblocks.simulation.failures import component_of, reason
from gearblocks.simulation.records import FinalState, NamedValues
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.start_states import start_state
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Code, Method, Options
from gearblocks.solver.switched_constraints import ConstraintKind
from gearblocks.solver.tangents import Tangents

Array = NDArray[np.float64]

_AROUND = 8  # periods of a motion that goes round, after which its run begins anew
_BESIDE = 1e-4  # of the sizes
_ROUNDING = 1e-14  # of the sizes
_FADES = 4.0  # logarithms in a part of a period
_MOST_PARTS = 2048
_FINE = 0.25  # of the longest step: within it what fades fastest is told to 1e-8
GROWS = (Code.ERR_ESCAPE, Code.ERR_NAN_RATE)
"""How a run ends whose motion grows without bound."""


class GrowthError(SimulationError):
    """The motion grows without bound."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """A run over k periods. states: the n states after each, shape (k, n); maps: derivatives of each by the start, (k, n, m);
    logs: logarithms by which the columns grew in each, (k, m); corner: where no derivative exists, in words, or ""; events:
    how many there were; columns: those at the end, (n, m); slope: derivative of the last states by a parameter, (n,), where one
    was asked for."""

    states: Array
    maps: Array
    logs: Array
    corner: str
    events: int
    columns: Array
    slope: Array | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """Derivatives by a parameter: of the parameters of a model, and of the period of its section [s]."""

    parameters: Array
    period: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class Strobe:
    """A model at values of its parameters. period [s]; scale: sizes of the n states, in which distances are told; max_step [s]:
    the longest step in which derivatives are told, too; fading: the fastest rate at which motions beside fade [1/s]; turns: by
    how much each state may be turned so that nothing changes [rad], 0 where there is no such angle, shape (n,); begun: periods
    that have passed where nothing else is said: more than none where something acts on the train that ends before (a ramp)."""

    model: Model
    parameters: Array
    period: float
    rtol: float
    scale: Array
    turns: Array
    max_step: float = np.inf
    fading: float = 0.0
    begun: int = 0

    @property
    def n(self) -> int:
        """States."""
        return int(self.model.program.n)

    @property
    def parts(self) -> int:
        """Of a period, in each of which no motion beside fades by much more than exp(-4)."""
        return int(np.clip(np.ceil(self.period * self.fading / _FADES), 1, _MOST_PARTS))

    @property
    def told_finely(self) -> Strobe:
        """The same in steps in which derivatives along the fastest motion are told to 1e-8."""
        return replace(self, max_step=_FINE * self.max_step)

    def finer(self, rtol: float) -> Strobe:
        """The same at another tolerance."""
        return replace(self, rtol=rtol)

    def start(self, initial: Any) -> Array:
        """The n states that a run begins with."""
        program = self.model.program
        with self.model.library.reopen() as sim:
            self._set(sim)
            y0 = start_state(program, initial)
            if is_static(initial):
                from gearblocks.simulation.equilibrium import static_state

                y0 = static_state(sim, program, 0.0, means=initial == "static")
            self._begin(sim, 0.0, y0)
            return sim.state()[: self.n]

    def follow(
        self, y: Array, periods: int, columns: Array | None = None, *, after: int | None = None, maps: bool = False,
        fixed: Array | None = None, parts: int = 1, by: Change | None = None,
    ) -> Followed:  # fmt: skip
        """A run from the states y over so many periods; columns: of derivatives beside it, shape (n, m), which with fixed
        directions, shape (n, p), are made orthonormal to these and each other after each period; after: periods that have
        passed before (default: `begun`); parts: of each period, after which what is found is kept; by: a parameter, with the
        period of the section following it (not with `after`). Raises SimulationError."""
        after = self.begun if after is None else after
        if not self.turns.any() or by is not None:
            return self._follow(y, periods, columns, after, maps, fixed, parts, by)
        found: list[Followed] = []  # begun again near 0 now and then: a run is told to a part of its largest angle
        for passed in range(0, max(periods, 1), _AROUND):
            near = self.near(y)
            run = self._follow(near, min(_AROUND, periods - passed), columns, after + passed, maps, fixed, parts, None)
            found.append(replace(run, states=run.states + (y - near)))
            y, columns = found[-1].states[-1], run.columns
        corners = [run.corner for run in found if run.corner]
        states, maps_there, logs = (
            np.concatenate([getattr(run, x) for run in found]) for x in ("states", "maps", "logs")
        )
        events = sum(run.events for run in found)
        return Followed(states, maps_there, logs, corners[0] if corners else "", events, found[-1].columns)

    def near(self, y: Array) -> Array:
        """The states, shape (..., n), turned back by the whole turns of the last of them."""
        last = y if y.ndim == 1 else y[-1]
        found: Array = y - (last - without_turns(last, self.turns))
        return found

    def _follow(
        self, y: Array, periods: int, columns: Array | None, after: int, maps: bool, fixed: Array | None, parts: int,
        by: Change | None,
    ) -> Followed:  # fmt: skip
        program = self.model.program
        with self.model.library.reopen() as sim:
            self._set(sim)
            full = np.zeros(program.n_total)
            full[: self.n] = y
            self._begin(sim, after * self.period, full)
            none = np.empty((self.n, 0))
            columns, wanted = none if columns is None else as_held(sim, program, columns), fixed is not None
            given, change = columns.shape[1], None if by is None else by.parameters
            if change is not None:
                columns = np.column_stack([columns, self._begun(y, change)])
            tangents = Tangents(sim, program.n_total, columns, self.scale, none if fixed is None else fixed, change)
            times: Array = self.period * (after + np.arange(1.0, parts * periods + 1) / parts)
            tangents.begin(times, maps=maps, logs=wanted)
            while (code := tangents.run()) != Code.DONE:
                if code < 0:
                    raise self._failure(sim, code)
            where = tangents.undefined
            corner = self._corner(where.switch, where.t) if where.events else ""
            states = tangents.states[:, : self.n].copy()
            counts = [i for i, q in enumerate(program.states) if q.name.endswith(".impacts")]
            states[:, counts] = y[counts]  # what stops count grows for ever, and no law reads it
            slope = None if by is None else self._slope(sim, tangents, times[-1], periods * by.period)
            at_end = tangents.columns[:, :given]
            return Followed(
                states, tangents.maps[:, :, :given], tangents.logs, corner, sim.counters.events, at_end, slope
            )

    def map(self, y: Array, periods: int, *, after: int | None = None, by: Change | None = None) -> Followed:
        """The same with all derivatives by the states."""
        return self.follow(y, periods, np.eye(self.n), after=after, maps=True, by=by)

    def pieces(self, y: Array, periods: int) -> Array:
        """Derivatives by the states over each part of each period of the run from y, in units of the sizes, shape
        (parts * periods, n, n): M of the whole is their product. Raises SimulationError."""
        program, none, found = self.model.program, np.empty((self.n, 0)), []
        with self.told_finely.opened(y) as sim:
            for t in self.period * (self.begun + np.arange(1, self.parts * periods + 1) / self.parts):
                columns = as_held(sim, program, np.diag(self.scale))
                tangents = Tangents(sim, program.n_total, columns, self.scale, none)
                tangents.begin(np.array([t]), maps=True)
                while (code := tangents.run()) != Code.DONE:
                    if code < 0:
                        raise self._failure(sim, code)
                found.append(tangents.maps[0] / self.scale[:, None])
        return np.array(found)

    def _begun(self, y: Array, change: Array) -> Array:
        """Derivative by a parameter of the states that a run from y begins with: what friction holds and what has no
        inertia stand in a balance that may read it."""
        ends = []
        for step in (-_BESIDE, _BESIDE):
            with replace(self, parameters=self.parameters + step * change).opened(y) as sim:
                ends.append(sim.state()[: self.n])
        found: Array = (ends[1] - ends[0]) / (2 * _BESIDE)
        return found

    def _slope(self, sim: Simulation, tangents: Tangents, t: float, later: float) -> Array:
        """Derivative of the last states by the parameter; later: that of their instant t. Raises SimulationError."""
        rates = sim.probe(t, tangents.states[-1], None, "rates")[: self.n]
        found: Array = tangents.columns[:, -1] + later * rates
        if not np.isfinite(found).all():
            raise SimulationError(
                t, "", "the motion has no derivative by the parameter", "give a span in which its laws are smooth", None
            )
        return found

    def ties(self, y: Array) -> Array:
        """Rows over the n states that lossy gears hold at zero at the states y, whatever moves: shape (ties, n)."""
        full = np.zeros(self.model.program.n_total)
        full[: self.n] = y
        with self.opened(y) as sim:
            known = sim.constraints()
            tied = [i for i, one in enumerate(known.constraints) if one.kind is ConstraintKind.TIE]
            rows = np.zeros((len(tied), self.n))
            if tied:
                rows[:, self.n - known.n_speeds :] = sim.constraints_at(self.period * self.begun, full, None).rows[tied]
        return rows

    def moved(self, y: Array, step: Array) -> Array:
        """States that lie beside y by a step in their sizes; what is rounding of its size is none, since differences are
        taken in sizes that a motion has had."""
        found: Array = y + self.scale * step
        found[np.abs(found) < _ROUNDING * self.scale] = 0.0
        return found

    def off(self, y: Array, other: Array) -> Array:
        """Differences of states, shape (..., n), in their sizes, whatever whole turns lie between."""
        found: Array = without_turns(y - other, self.turns) / self.scale
        return found

    def distance(self, y: Array, other: Array) -> float:
        """How far apart two states are, in their sizes."""
        return float(np.abs(self.off(y, other)).max())

    @contextmanager
    def opened(self, y: Array, t: float | None = None) -> Iterator[Simulation]:
        """A simulation that stands at the states y, at t (by default as `begun`)."""
        full = np.zeros(self.model.program.n_total)
        full[: self.n] = y
        with self.model.library.reopen() as sim:
            self._set(sim)
            self._begin(sim, self.period * self.begun if t is None else t, full)
            yield sim

    def standing(self, y: Array, later: int = 0) -> FinalState:
        """What a run that begins in the states y, so many periods later than `begun`, begins with. One that cannot begin there
        says why when it is asked for."""
        t, full = (self.begun + later) * self.period, np.zeros(self.model.program.n_total)
        full[: self.n] = y
        modes = np.zeros(len(self.model.program.switches))
        with self.model.library.reopen() as sim:
            self._set(sim)
            try:
                self._begin(sim, t, full)
                full, modes = sim.state(), sim.modes()
            except SimulationError:
                pass
        return FinalState(t, full, modes, self.model.program.key)

    @property
    def values(self) -> NamedValues:
        """The parameters by path."""
        return NamedValues(self.model.program.parameter_numbers, self.parameters)

    def _set(self, sim: Simulation) -> None:
        sim.parameters[:] = self.parameters
        set_inputs(sim, self.model.program, {})

    def _begin(self, sim: Simulation, t: float, y: Array | None) -> None:
        options = Options(Method.DP8, 1, self.rtol, 0.0, self.max_step, np.inf)
        if (code := sim.start(options, t, y)) < 0:
            raise self._failure(sim, code)

    def _failure(self, sim: Simulation, code: Code) -> GearblocksError:
        kind = GrowthError if code in GROWS else SimulationError
        return kind(sim.report.t, *reason(self.model.program, code, sim))

    def _corner(self, switch: int, t: float) -> str:
        name = component_of(self.model.program, Code.ERR_CHATTER, switch)
        return f"no derivative exists at t = {t:.6g} s" + (f", at a switch of '{name}'" if name else "")


def change_of(seen: Strobe, section: Section, number: int, size: float) -> Change:
    """By parameter `number` of the model, in units of `size`."""
    unit = np.zeros(len(seen.parameters))
    unit[number] = size
    names, ends = seen.model.program.parameter_numbers, []
    for step in (-2 * _BESIDE, -_BESIDE, _BESIDE, 2 * _BESIDE):
        ends.append(section_period(section, NamedValues(names, seen.parameters + step * unit)))
    return Change(unit, (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * _BESIDE))


def strobe(
    model: Model, section: Section, parameters: Mapping[str, float | str] | None, initial: Any, rtol: float
) -> Strobe:
    """Of a model and a section, with parameters and start values as for `simulate`. Raises ParameterError."""
    method_options("dp8", rtol, None, None, True, np.inf)
    vector = parameter_vector(model, parameters or {}, initial)
    if is_rolling(initial):
        with model.library.reopen() as sim:
            sim.parameters[:] = vector
            set_inputs(sim, model.program, {})
            vector = rolled(model, sim, 0.0, initial)
    check_frequency(section, model.program)
    period = section_period(section, NamedValues(model.program.parameter_numbers, vector))
    n = model.program.n
    return Strobe(model, vector, period, rtol, np.ones(n), np.zeros(n))
