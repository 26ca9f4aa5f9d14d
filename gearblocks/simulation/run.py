"""Running a model: options, inputs and start values go in, a trajectory comes out, whatever happens on the way."""

from __future__ import annotations

import time as _time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from logging import DEBUG
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import GearblocksError, ParameterError, SimulationError, log, warn
from gearblocks.language.expression import finite_number
from gearblocks.language.starts import is_rolling
from gearblocks.progress import Progress
from gearblocks.simulation.arguments import (
    METHOD_NAMES,
    InputSource,
    Start,
    begin_of,
    check_jacobian,
    is_static,
    method_options,
    method_words,
    parameter_vector,
    picked_outputs,
    sample_times,
    set_inputs,
)
from gearblocks.simulation.case import Case
from gearblocks.simulation.element_balance import Rerun, element_imbalances
from gearblocks.simulation.energy import EnergyBalance
from gearblocks.simulation.events import events_of
from gearblocks.simulation.explaining import explained
from gearblocks.simulation.failures import component_of, reason, remedy_beside_jumps, too_long
from gearblocks.simulation.input_series import with_tables
from gearblocks.simulation.measured_runs import run_again
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.simulation.recorded_memory import memory_limit
from gearblocks.simulation.records import FinalState, NamedValues, Stats
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.samples import Outputs, Samples
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.simulation.watched_effects import NOTHING, Watched
from gearblocks.simulation.watching import Watching
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.record import Record
from gearblocks.solver.structures import Array, Code, Counters, Options


def run_model(
    model: Model, *, t_end: float | str | None = None, t: ArrayLike | None = None,
    t_start: float | str | None = None,
    method: str = "auto", rtol: float = 1e-6, step: float | str | None = None, max_step: float | str | None = None,
    locate: bool = True, inputs: Mapping[str, InputSource] | None = None,
    parameters: Mapping[str, float | str] | None = None, initial: Start = None,
    outputs: str | Sequence[str] = "*", progress: Callable[[float], None] | None = None,
    residual: float | None = None, watch: bool = True,
) -> Trajectory:  # fmt: skip
    """Runs a model; see `gearblocks.simulate` for the arguments."""
    program = model.program
    if progress is not None and not callable(progress):
        raise ParameterError(f"progress = {progress!r:.80} must be a function of the share done")
    if residual is not None and finite_number("residual", residual) <= 0:
        raise ParameterError(f"residual = {residual!r} must be > 0")
    begin = begin_of(t_start, initial)
    samples, end = sample_times(begin, t_end, t)
    inputs = with_tables(inputs)
    options, why = method_options(method, rtol, step, max_step, locate, end)
    pick = picked_outputs(program, outputs)
    with model.library.reopen() as sim:
        values = sim.parameters[:] = parameter_vector(model, parameters or {}, initial)
        warn_of_parameters(model, parameters)
        check_jacobian(options, program, sim.has_jacobian)
        set_inputs(sim, program, inputs)
        if is_rolling(initial):
            values = sim.parameters[:] = rolled(model, sim, begin, initial)
        meta = _meta(program, options, values)
        run = _Run(model, sim, samples, end, pick, values, progress, residual, meta)
        y0 = run.balanced(begin, initial) if is_static(initial) else start_state(program, initial)
        run.watching = Watching(model, sim) if watch and model.left_out is not None else None
        run.case = Case(model.library, values, dict(inputs), options, begin, end, y0, run_again, explained)
        return run.go(options, begin, y0, why)


def run_case(
    model: Model, case: Case, why: str, *, t: ArrayLike | None = None, outputs: str | Sequence[str] = "*"
) -> Trajectory:
    """A run from what it follows from, with samples at every step or at the times t [s], which end with the case; why: the
    reason for its method. It tells nobody how far it is. Raises SimulationError."""
    program = model.program
    samples = None if t is None else sample_times(case.begin, None, t)[0]
    with model.library.reopen() as sim:
        sim.parameters[:] = case.parameters
        set_inputs(sim, program, case.inputs)
        pick, meta = picked_outputs(program, outputs), _meta(program, case.options, case.parameters)
        run = _Run(model, sim, samples, case.end, pick, case.parameters, silent, None, meta, case=case)
        return run.go(case.options, case.begin, case.y0, why)


def silent(share: float) -> None:
    """Whoever asked for many runs says how far they are."""


def _meta(program: Program, options: Options, values: Array) -> dict[str, Any]:
    return {
        "train": program.name, "method": METHOD_NAMES[options.method], "rtol": options.rtol, "step": options.step or None,
        "parameters": NamedValues(program.parameter_numbers, values),
    }  # fmt: skip


RESIDUAL = 1e-2
"""The energy residual above which a finished run is warned about."""
STILL = 1e-12
"""Turnover [J] below which what moves is rounding: a train that stands still has no balance to warn about."""
BALANCED = 1e-12
"""The energy residual from which on it is asked whether all motion was rounding."""
WIDE = 1000
"""Numbers in a row from which on a run with few outputs evaluates them as it goes."""


# -- the run ----------------------------------------------------------------------------------------------------------


@dataclass
class _Run:
    """One run in progress: what was recorded so far."""

    model: Model
    sim: Simulation
    samples: Array | None
    end: float
    pick: Mapping[str, int]
    parameters: Array
    progress: Callable[[float], None] | None
    residual: float | None
    meta: dict[str, Any]
    rows: list[Array] = field(default_factory=list)
    table: list[Array] = field(default_factory=list)
    largest: float = -np.inf
    events: list[NDArray[np.void]] = field(default_factory=list)
    cpu: float = 0.0
    size: int = 0
    counters: Counters = field(init=False)
    case: Case | None = None
    watching: Watching | None = None
    watched: Watched = NOTHING

    def balanced(self, begin: float, initial: Any) -> Array:
        """The state of the static equilibrium."""
        from gearblocks.simulation.equilibrium import static_point
        from gearblocks.simulation.friction_at_rest import accelerated_by

        try:
            point = static_point(self.sim, self.model.program, begin, means=initial == "static")
            for name, words in accelerated_by(point):
                warn(
                    f"initial='{initial}': '{name}' slips with {words}, and what is beside it is accelerated from the start; "
                    "start both of its sides at one speed, or with it released (capacity or engagement 0)"
                )
            return point.y
        except RuntimeError:
            raise self._failure(Code(self.sim.report.code), None) from self.sim.error

    def go(self, options: Options, begin: float, y0: Array | None, why: str) -> Trajectory:
        """Runs to the end, to an error or to Ctrl-C."""
        code = self.sim.start(options, begin, y0)
        if code < 0:
            raise self._failure(code, None) from self.sim.error
        try:
            first = self.sim.state(), self.sim.energies()
        except RuntimeError:
            raise self._failure(Code(self.sim.report.code), None) from self.sim.error
        complete = False
        try:
            code = self._loop(begin, first)
            complete = code == Code.DONE
        except KeyboardInterrupt:
            code = Code.PAUSE
        if isinstance(self.sim.error, KeyboardInterrupt):
            code = Code.PAUSE
        else:
            self.sim.raise_end()
        self.counters = self.sim.counters  # before anything is run once more
        if self.watching is not None:
            self.watched = self.watching.ended(self.parameters, self.rows)
        balance = self._energy(first, named=code >= 0)
        result = self._result(balance, complete, why)
        if code < 0:
            raise self._failure(code, result) from self.sim.error
        self._judged(result, balance, complete)
        if (words := self.watched.warning()) and not self._stands_still(result, balance):
            warn(f"run of '{result.name}': {words}; run.watched says more, watch=False nothing")
        if log.isEnabledFor(DEBUG):
            log.debug("run of '%s' to t = %g s: %s", result.name, result.t[-1], result.stats)
        return result

    def _judged(self, result: Trajectory, balance: EnergyBalance | None, complete: bool) -> None:
        """Raises or warns where the energy of a run does not balance; the ledger is made only where it may not."""
        limit = min(self.residual or RESIDUAL, RESIDUAL)
        if balance is None or balance.residual(limit) <= limit:
            return
        energy = result.energy
        if self.residual is not None and not energy.residual <= self.residual:
            words = f"the energy residual is {energy.residual:.2g}, above the {self.residual:g} asked for,"
            raise SimulationError(float(result.t[-1]), energy.culprit, words, "give a smaller rtol", result)
        if complete and energy.turnover > STILL and not energy.residual <= RESIDUAL:
            where = f", most of it is missing in '{energy.culprit}'" if energy.culprit else ""
            warn(
                f"run of '{self.model.program.name}': its energy is balanced to {energy.residual:.2g} of the turnover "
                f"only{where}: {'a shorter step' if self.meta['step'] else 'a smaller rtol'} makes it better; "
                f"residual={RESIDUAL:g} makes it an error",
            )

    def _stands_still(self, result: Trajectory, balance: EnergyBalance | None) -> bool:
        """Whether all that moves is rounding; the ledger is made only where that may be."""
        return (balance is None or balance.turnover <= STILL) and result.energy.turnover <= STILL

    def _lost(self, first: tuple[Array, Array]) -> bool:
        """Whether the energy residual at the last sample is above the one asked for."""
        if self.residual is None:
            return False
        balance = self._balance(first, self.sim.counters)
        return balance is not None and not balance.residual(self.residual) <= self.residual

    def _loop(self, begin: float, first: tuple[Array, Array]) -> Code:
        record = self.sim.record(None if self.samples is None else len(self.samples))
        if self.watching is not None:
            self.watching.enter(record)
        tell = self.progress or Progress(self.model.program.name, " (Ctrl-C keeps what is done)")
        try:
            return self._advanced(begin, first, record, tell)
        finally:
            if isinstance(tell, Progress):
                tell.close()

    def _advanced(
        self, begin: float, first: tuple[Array, Array], record: Record, tell: Callable[[float], None]
    ) -> Code:
        shown = _time.monotonic()
        while True:
            before = _time.thread_time()
            code = self.sim.run(self.samples, self.end, record)
            self.cpu += _time.thread_time() - before
            taken = self._take(*record.take())
            if code == Code.DONE or min(code, taken) < 0:
                self.sim.give(record)
                return code if code < 0 else taken
            if self._lost(first):
                return Code.PAUSE
            if _time.monotonic() - shown > 0.2:
                shown = _time.monotonic()
                tell((self.sim.counters.t - begin) / (self.end - begin))

    @property
    def few(self) -> bool:
        """Whether few outputs of a long train were asked for: its states would take more memory than these."""
        width = 1 + self.model.program.n_total
        return width > WIDE and 4 * len(self.pick) < width

    def _take(self, rows: Array, events: NDArray[np.void]) -> Code:
        if self.few and len(rows):
            rows = self._evaluated(rows)
        self.size += rows.nbytes + events.nbytes
        if self.size > memory_limit(self.samples is not None):
            return Code.ERR_MEMORY
        if len(events):
            self.events.append(events)
        if len(rows):
            self.rows.append(rows)
        return Code.DONE

    def _evaluated(self, rows: Array) -> Array:
        """The last of the rows; all are in the table: t and the outputs that were asked for."""
        _, out, energy = self.sim.evaluate(rows, np.array([*self.pick.values()], dtype=np.intc), energies=True)
        self.table.append(np.column_stack([rows[:, 0], out]))
        self.size += self.table[-1].nbytes - sum(piece.nbytes for piece in self.rows)
        self.rows.clear()
        with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
            self.largest = max(self.largest, float(energy.sum(axis=1).max(initial=-np.inf)))
        return rows[-1:].copy()

    def _result(self, balance: EnergyBalance | None, complete: bool, why: str) -> Trajectory:
        program, counters, cpu, events = self.model.program, self.counters, self.cpu, self.events
        method, reason = method_words(counters, why)
        self.meta["method"] = method
        samples = self._samples() if balance is None else balance.samples
        t: Array = samples.times()
        columns: Outputs | dict[str, Array] = Outputs(samples, self.pick)
        if self.table:
            table = np.concatenate(self.table)
            t, columns = table[:, 0].copy(), dict(zip(self.pick, table.T[1:].copy(), strict=True))
        return Trajectory(
            t, columns, program.output_units,
            events=lambda: events_of(program.event_table, events), stats=lambda: stats_of(counters, cpu, method, reason),
            energy=balance, final_state=self._final() if self.rows else None, meta={**self.meta, "complete": complete},
            case=self.case if complete else None, watched=self.watched,
        )  # fmt: skip

    def _samples(self) -> Samples:
        return Samples(self.model.library, self.parameters, tuple(self.rows))

    def _final(self) -> Callable[[], FinalState]:
        """What makes the state at the last sample."""
        last, program = self.rows[-1][-1], self.model.program
        return lambda: _final_state(program, last)

    def _balance(self, first: tuple[Array, Array], counters: Counters) -> EnergyBalance | None:
        """Energies at the last sample beside those at the start; None where there is no sample."""
        if not self.rows:
            return None
        last, program = self.rows[-1][-1], self.model.program
        balance = EnergyBalance(
            program=program, before=first, last=self.sim.energies_of(last), state=last[1 : 1 + program.n_total],
            exchanged=counters.turnover, samples=self._samples(), largest=self.largest,
        )  # fmt: skip
        return balance if balance.bound <= BALANCED else replace(balance, rounding=self.sim.rounding_energy())

    def _energy(self, first: tuple[Array, Array], *, named: bool) -> EnergyBalance | None:
        """The balance, with what those of the elements miss where it does not close as far as the run promises it: to 10 rtol,
        with steps of its own choice and located events. The simulation is at its start afterwards."""
        balance, limit = self._balance(first, self.counters), 10 * float(self.meta["rtol"]) + 1e-12
        case = self.case
        promised = self.meta["step"] is None and case is not None and case.options.locate and self.sim.error is None
        if balance is None or case is None or not (named and promised) or not balance.residual(limit) > limit:
            return balance
        rerun = Rerun(self.sim, self.model.program, case.options, case.begin, case.y0)
        found = element_imbalances(rerun, float(self.rows[-1][-1, 0]))
        return replace(balance, unbalanced=dict(sorted(found.items(), key=lambda item: -abs(item[1]))))

    # -- failures -----------------------------------------------------------------------------------------------------

    def _failure(self, code: Code, run: Trajectory | None) -> GearblocksError:
        """The error of a return code, with the name of the thing and the way out. Raises what ended the program."""
        report, program = self.sim.report, self.model.program
        t, (name, cause, remedy) = report.t, reason(program, code, self.sim)
        if code == Code.ERR_UNSTABLE and run is not None:
            name, cause, remedy = too_long(self.sim, program, run.meta["step"], self.rows, (name, cause, remedy))
        if code == Code.ERR_CHATTER and run is not None:
            remedy = remedy_beside_jumps(name, remedy, {e.component: e.after for e in run.events})
        if self.size > memory_limit(self.samples is not None):
            t = float(self.sim.counters.t)
            counts = Counter(np.concatenate(self.events)["index"].tolist()) if self.events else Counter()
            name = component_of(program, Code.ERR_CHATTER, max(counts, key=counts.__getitem__, default=-1))
            steps = self.sim.counters.steps
            cause = f"the record of {steps} steps and {counts.total()} events fills the memory that it may take"
            remedy = "give times t; look for what switches so often, or grows without bound"
        return SimulationError(t, name, cause, remedy, run)


def stats_of(counters: Counters, cpu: float, method: str, why: str) -> Stats:
    """What the solver counted in a run of so many seconds of CPU time, by these methods and for this reason."""
    return Stats(
        steps=counters.steps, rejected=counters.rejected, rhs_calls=counters.rhs_calls, jacobians=counters.jacobians,
        events=counters.events, cpu_seconds=cpu, method=method, why=why,
    )  # fmt: skip


def _final_state(program: Program, row: Array) -> FinalState:
    end = 1 + program.n_total
    return FinalState(float(row[0]), row[1:end].copy(), row[end : end + len(program.switches)].copy(), program.key)
