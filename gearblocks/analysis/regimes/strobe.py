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

_SIZED, _PARTS = 4, 16  # periods that sizes are told from, and parts of each
_LOOKS = 8  # points at which the fastest motion is looked for
_BESIDE = 1e-4  # of the sizes
_UNSEEN = 1e-6  # of the largest state with the same unit: steps of differences are told from no less
_LEAST = 1e-3  # of what the states beside it carry into a state: less is their rounding, and no size of its own
_ROUNDING = 1e-14  # of the sizes
_TERMS = 6  # of the series of exp over an eighth of the fastest motion
_FADES = 4.0  # logarithms in a part of a period
_MOST_PARTS = 2048
_FINE = 0.25  # of the longest step: within it what fades fastest is told to 1e-8
REACH = 2.0  # a step times the fastest rate: there order 8 is stable and right to 1e-3 in each step
GROWS = (Code.ERR_ESCAPE, Code.ERR_NAN_RATE)
"""How a run ends whose motion grows without bound."""


class GrowthError(SimulationError):
    """The motion grows without bound."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """A run over k periods. states: the n states after each, shape (k, n); maps: derivatives of each by the start, (k, n, m);
    logs: logarithms by which the columns grew in each, (k, m); corner: where no derivative exists, in words, or ""; events:
    how many there were; slope: derivative of the last states by a parameter, (n,), where one was asked for."""

    states: Array
    maps: Array
    logs: Array
    corner: str
    events: int
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
    the longest step in which derivatives are told, too; fading: the fastest rate at which motions beside fade [1/s]."""

    model: Model
    parameters: Array
    period: float
    rtol: float
    scale: Array
    max_step: float = np.inf
    fading: float = 0.0

    @property
    def n(self) -> int:
        """States."""
        return int(self.model.program.n)

    @property
    def parts(self) -> int:
        """Of a period, in each of which no motion beside fades by much more than exp(-4)."""
        return int(np.clip(np.ceil(self.period * self.fading / _FADES), 1, _MOST_PARTS))

    def finer(self, rtol: float) -> Strobe:
        """The same at another tolerance."""
        return replace(self, rtol=rtol)

    def sized(self, y: Array, after: int) -> Strobe:
        """The same with the sizes that the states come to within a few periods from y on, and steps within which the fastest of
        the motions beside these is told: a run whose own motion is slow takes steps in which derivatives along a fast one
        grow. after: as of `follow`."""
        states = np.vstack([y, self.follow(y, _SIZED, after=after, parts=_PARTS).states])
        size = np.abs(states).max(axis=0)
        jacobians = self._jacobians(states, size)
        rates = np.array([np.linalg.eigvals(j) for j in jacobians])
        fastest, fading = float(np.abs(rates).max(initial=0.0)), float(-rates.real.min(initial=0.0))
        driven = np.max([_driven(j, size, self.period) for j in jacobians], axis=0)
        scale = np.maximum(size, _LEAST * driven)
        scale = np.where(scale > 0.0, scale, 1.0)
        return replace(self, scale=scale, max_step=REACH / max(fastest, 1e-300), fading=fading)

    def settled(self, initial: Any, transient: int) -> tuple[Strobe, Array]:
        """The same, sized by the motion after so many periods, and its states there."""
        y = self.start(initial)
        if transient:
            y = self.follow(y, transient).states[-1]
        return self.sized(y, transient), y

    def _jacobians(self, states: Array, size: Array) -> list[Array]:
        """Rates by the states [1/s], at points along a period."""
        units = [q.unit for q in self.model.program.states]
        alike = np.array([max(s for s, unit in zip(size, units, strict=True) if unit == own) for own in units])
        beside = _BESIDE * np.maximum(size, np.where(alike > 0.0, _UNSEEN * alike, 1.0))
        found = []
        full = np.zeros(self.model.program.n_total)
        for i, y in enumerate(states[:: len(states) // _LOOKS]):
            t = i * (len(states) // _LOOKS) / _PARTS * self.period
            full[: self.n] = y
            with self.opened(y) as sim:
                columns = []
                for j in range(self.n):
                    step = np.zeros_like(full)
                    step[j] = beside[j]
                    ends = [sim.probe(t, full + sign * step, None, "rates")[: self.n] for sign in (1, -1)]
                    columns.append((ends[0] - ends[1]) / (2 * step[j]))
            found.append(np.array(columns).reshape(self.n, self.n).T)
        return found

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
        self, y: Array, periods: int, columns: Array | None = None, *, after: int = 0, maps: bool = False,
        fixed: Array | None = None, parts: int = 1, by: Change | None = None,
    ) -> Followed:  # fmt: skip
        """A run from the states y over so many periods; columns: of derivatives beside it, shape (n, m), which with fixed
        directions, shape (n, p), are made orthonormal to these and each other after each period; after: periods that have
        passed before; parts: of each period, after which what is found is kept; by: a parameter, with the period of the section
        following it (not with `after`). Raises SimulationError."""
        program = self.model.program
        with self.model.library.reopen() as sim:
            self._set(sim)
            full = np.zeros(program.n_total)
            full[: self.n] = y
            self._begin(sim, after * self.period, full)
            none = np.empty((self.n, 0))
            columns, wanted = none if columns is None else columns, fixed is not None
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
            return Followed(states, tangents.maps[:, :, :given], tangents.logs, corner, sim.counters.events, slope)

    def map(self, y: Array, periods: int, *, after: int = 0, by: Change | None = None) -> Followed:
        """The same with all derivatives by the states."""
        return self.follow(y, periods, np.eye(self.n), after=after, maps=True, by=by)

    def pieces(self, y: Array, periods: int) -> Array:
        """Derivatives by the states over each part of each period of the run from y, in units of the sizes, shape
        (parts * periods, n, n): M of the whole is their product. Raises SimulationError."""
        program, none, found = self.model.program, np.empty((self.n, 0)), []
        with replace(self, max_step=_FINE * self.max_step).opened(y) as sim:
            for t in self.period * np.arange(1, self.parts * periods + 1) / self.parts:
                tangents = Tangents(sim, program.n_total, np.diag(self.scale), self.scale, none)
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
                rows[:, self.n - known.n_speeds :] = sim.constraints_at(0.0, full, None).rows[tied]
        return rows

    def moved(self, y: Array, step: Array) -> Array:
        """States that lie beside y by a step in their sizes; what is rounding of its size is none, since differences are
        taken in sizes that a motion has had."""
        found: Array = y + self.scale * step
        found[np.abs(found) < _ROUNDING * self.scale] = 0.0
        return found

    def distance(self, y: Array, other: Array) -> float:
        """How far apart two states are, in their sizes."""
        return float(np.abs((y - other) / self.scale).max())

    @contextmanager
    def opened(self, y: Array) -> Iterator[Simulation]:
        """A simulation that stands at the states y, at t = 0."""
        full = np.zeros(self.model.program.n_total)
        full[: self.n] = y
        with self.model.library.reopen() as sim:
            self._set(sim)
            self._begin(sim, 0.0, full)
            yield sim

    def standing(self, y: Array, after: int = 0) -> FinalState:
        """What a run that begins in the states y, after so many periods, begins with. One that cannot begin there says why
        when it is asked for."""
        t, full = after * self.period, np.zeros(self.model.program.n_total)
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


def _driven(jacobian: Array, size: Array, period: float) -> Array:
    """What a motion of these sizes carries into each state within a period: max |exp(J t)| size. Of one that grows by itself,
    in as long as it takes to grow by a factor of e."""
    values = np.linalg.eigvals(jacobian)
    end = period / max(1.0, period * float(values.real.max(initial=0.0)))
    halvings = max(0, int(np.ceil(np.log2(max(1.0, end * float(np.abs(values).max(initial=0.0)))))) + 2)
    step, found, flow = jacobian * end / 2.0**halvings, size, np.eye(len(size))
    for k in range(_TERMS, 0, -1):
        flow = np.eye(len(size)) + step @ flow / k
    for _ in range(halvings + 1):
        found = np.maximum(found, np.abs(flow) @ size)
        flow = flow @ flow
    return found


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
    return Strobe(model, vector, period, rtol, np.ones(model.program.n))
