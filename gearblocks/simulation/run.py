"""Running a model: options, inputs and start values go in, a trajectory comes out, whatever happens on the way."""

from __future__ import annotations

import os
import sys
import time as _time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import (
    GearblocksError,
    GearblocksWarning,
    ParameterError,
    SimulationError,
)  # fmt: skip
from gearblocks.language.expression import finite_number
from gearblocks.simulation.arguments import (
    InputSource,
    begin_of,
    is_static,
    method_options,
    method_words,
    parameter_vector,
    picked_outputs,
    sample_times,
    set_inputs,
    start_state,
)
from gearblocks.simulation.element_balance import Rerun, element_imbalances
from gearblocks.simulation.failures import component_of, reason
from gearblocks.simulation.records import EnergyLedger, Event, FinalState, Stats
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array, Code, Method, Options


def run_model(
    model: Model, *, t_end: float | None = None, t: ArrayLike | None = None, t_start: float | None = None,
    method: str = "auto", rtol: float = 1e-6, step: float | None = None, max_step: float | None = None,
    locate: bool = True, inputs: Mapping[str, InputSource] | None = None,
    parameters: Mapping[str, float] | None = None, initial: Mapping[str, float] | Trajectory | str | None = None,
    outputs: str | Sequence[str] = "*", progress: Callable[[float], None] | None = None,
    residual: float | None = None,
) -> Trajectory:  # fmt: skip
    """Runs a model; see `gearblocks.simulate` for the arguments."""
    program = model.program
    if progress is not None and not callable(progress):
        raise ParameterError(f"progress = {progress!r:.80} must be a function of the share done")
    if residual is not None and finite_number("residual", residual) <= 0:
        raise ParameterError(f"residual = {residual!r} must be > 0")
    begin = begin_of(t_start, initial)
    samples, end = sample_times(begin, t_end, t)
    options, why = method_options(method, rtol, step, max_step, locate, end)
    pick = picked_outputs(program, outputs)
    with model.library.open() as sim:
        sim.parameters[:] = parameter_vector(program, model.values, parameters or {}, initial)
        if options.method == Method.RODAS and not sim.has_jacobian:
            raise ParameterError(
                f"method = 'rodas' needs the Jacobian, which '{program.name}' does not give: take 'dp8'"
            )
        set_inputs(sim, program, inputs or {})
        run = _Run(model, sim, samples, end, pick, progress, residual, meta={
            "train": program.name, "method": Method(options.method).name.lower(), "rtol": rtol, "step": step,
            "parameters": {p.path: float(v) for p, v in zip(program.parameters, sim.parameters, strict=True)},
        })  # fmt: skip
        y0 = run.balanced(begin, initial) if is_static(initial) else start_state(program, initial)
        return run.go(options, begin, y0, why)


RESIDUAL = 1e-2
"""The energy residual above which a finished run is warned about."""
STILL = 1e-12
"""Turnover [J] below which what moves is rounding: a train that stands still has no balance to warn about."""
ARGUMENTS = frozenset(run_model.__annotations__) - {"model", "return"}
"""The names that `run_model` takes."""


# -- the run ----------------------------------------------------------------------------------------------------------


@dataclass
class _Run:
    """One run in progress: what was recorded so far."""

    model: Model
    sim: Simulation
    samples: Array | None
    end: float
    pick: list[int]
    progress: Callable[[float], None] | None
    residual: float | None
    meta: dict[str, Any]
    times: list[Array] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)
    events: list[NDArray[np.void]] = field(default_factory=list)
    largest: float = 0.0
    cpu: float = 0.0
    last: Array | None = None
    size: int = 0
    rerun: Rerun | None = None

    def balanced(self, begin: float, initial: Any) -> Array:
        """The state of the static equilibrium."""
        from gearblocks.simulation.equilibrium import static_state

        try:
            return static_state(self.sim, self.model.program, begin, means=initial == "static")
        except RuntimeError:
            raise self._stopped(Code(self.sim.report.code)) from self.sim.error

    def go(self, options: Options, begin: float, y0: Array | None, why: str) -> Trajectory:
        """Runs to the end, to an error or to Ctrl-C."""
        code = self.sim.start(options, begin, y0)
        if code < 0:
            raise self._stopped(code) from self.sim.error
        try:
            first = self.sim.state(), self.sim.energies()
        except RuntimeError:
            raise self._stopped(Code(self.sim.report.code)) from self.sim.error
        self.largest = float(first[1].sum())
        self.rerun = Rerun(self.sim, self.model.program, options, begin, y0)
        complete = False
        try:
            code = self._loop(begin, first)
            complete = code == Code.DONE
        except KeyboardInterrupt:
            code = Code.PAUSE
        if isinstance(self.sim.error, KeyboardInterrupt):
            code = Code.PAUSE
        result = self._result(first, complete, why, named=code >= 0)
        if code < 0:
            raise self._failure(code, result) from self.sim.error
        if self.residual is not None and not result.energy.residual <= self.residual:
            words = f"the energy residual is {result.energy.residual:.2g}, above the {self.residual:g} asked for,"
            raise SimulationError(float(result.t[-1]), result.energy.culprit, words, "give a smaller rtol", result)
        if complete and result.energy.turnover > STILL and not result.energy.residual <= RESIDUAL:
            culprit = result.energy.culprit
            where = f", most of it is missing in '{culprit}'" if culprit else ""
            warnings.warn(
                f"run of '{self.model.program.name}': its energy is balanced to {result.energy.residual:.2g} of the turnover "
                f"only{where}: {'a shorter step' if options.step else 'a smaller rtol'} makes it better; "
                f"residual={RESIDUAL:g} makes it an error",
                GearblocksWarning,
                stacklevel=4,
            )
        return result

    def _lost(self, first: tuple[Array, Array]) -> bool:
        """Whether the energy residual at the last sample is above the one asked for."""
        return self.residual is not None and not self._energy(first, self._final()).residual <= self.residual

    def _loop(self, begin: float, first: tuple[Array, Array]) -> Code:
        width = 1 + self.model.program.n_total + len(self.model.program.switches)
        record = self.sim.record(rows=max(64, min(8192, 2_000_000 // width)), events=16384)
        shown = _time.monotonic()
        tell = self.progress or _Line(self.model.program.name)
        while True:
            before = _time.thread_time()
            code = self.sim.run(self.samples, self.end, record)
            self.cpu += _time.thread_time() - before
            taken = self._take(*record.take())
            if code in (Code.DONE,) or min(code, taken) < 0:
                if isinstance(tell, _Line):
                    tell.close()
                return code if code < 0 else taken
            if self._lost(first):
                return Code.PAUSE
            if _time.monotonic() - shown > 0.2:
                shown = _time.monotonic()
                tell((self.sim.counters.t - begin) / (self.end - begin))

    def _take(self, rows: Array, events: NDArray[np.void]) -> Code:
        self.size += 256 * len(events) + rows.itemsize * len(rows) * (1 + len(self.pick))
        if self.size > memory_limit(self.samples is not None):
            return Code.ERR_MEMORY
        if len(events):
            self.events.append(events)
        if not len(rows):
            return Code.DONE
        code, out, energy = self.sim.evaluate(rows, np.array(self.pick, dtype=np.intc), energies=True)
        if code < 0:
            return code
        self.times.append(rows[:, 0].copy())
        self.values.append(out)
        self.last = rows[-1]
        if energy.shape[1]:
            with np.errstate(invalid="ignore", over="ignore"):  # a run that blows up
                self.largest = max(self.largest, float(energy.sum(axis=1).max()))
        return Code.DONE

    def _result(self, first: tuple[Array, Array], complete: bool, why: str, *, named: bool) -> Trajectory:
        program, counters = self.model.program, self.sim.counters
        t = np.concatenate(self.times) if self.times else np.empty(0)
        table = np.concatenate(self.values) if self.values else np.empty((0, len(self.pick)))
        names = [program.outputs[i].name for i in self.pick]
        final = self._final()
        method, reason = method_words(counters, why)
        self.meta["method"] = method
        events, energy = self._events(), self._energy(first, final)
        stats = Stats(
            steps=counters.steps, rejected=counters.rejected, rhs_calls=counters.rhs_calls,
            jacobians=counters.jacobians, events=counters.events, cpu_seconds=self.cpu, method=method, why=reason,
        )  # fmt: skip
        return Trajectory(
            t, (names, table), {n: program.outputs[i].unit for n, i in zip(names, self.pick, strict=True)},
            events=events, stats=stats, energy=self._named(energy) if named else energy, final_state=final,
            meta={**self.meta, "complete": complete},
        )  # fmt: skip

    def _final(self) -> FinalState | None:
        if self.last is None:
            return None
        n_total, program = self.model.program.n_total, self.model.program
        y, modes = self.last[1 : 1 + n_total], self.last[1 + n_total : 1 + n_total + len(program.switches)]
        return FinalState(float(self.last[0]), y.copy(), modes.copy(), program.key)

    def _events(self) -> list[Event]:
        program = self.model.program
        found = []
        for chunk in self.events:
            for event in chunk:
                i = int(event["index"])
                if i >= len(program.switches):
                    name, before, after = (
                        program.inputs[i - len(program.switches)].name,
                        event["before"],
                        event["after"],
                    )
                    found.append(Event(float(event["t"]), name, "time", float(before), float(after)))
                    continue
                switch = program.switches[i]
                if event["kind"] == 2:
                    speeds = float(event["before"]), float(event["after"])
                    found.append(Event(float(event["t"]), switch.component, "impact", *speeds))
                    continue
                before, after = (_shown(switch.low, switch.high, float(event[k])) for k in ("before", "after"))
                found.append(Event(float(event["t"]), switch.component, switch.kind, before, after))
        return _net(found)

    def _energy(self, first: tuple[Array, Array], final: FinalState | None) -> EnergyLedger:
        program = self.model.program
        if final is None or self.last is None:
            return EnergyLedger()
        _, _, energy = self.sim.evaluate(self.last[None, :], np.zeros(0, dtype=np.intc), energies=True)
        parts: dict[str, dict[str, float]] = {"stored": {}, "loss": {}, "supplied": {}}
        for entry in program.energies:
            before = parts["stored"].get(entry.component, 0.0)
            parts["stored"][entry.component] = before + float(energy[0, entry.offset])
        for item in program.integrals:
            if item.part != "angle":
                parts[item.part][item.component] = float(final.y[item.offset] - first[0][item.offset])
        return EnergyLedger(
            stored=parts["stored"], start=float(first[1].sum()), dissipated=parts["loss"], supplied=parts["supplied"],
            exchanged=float(self.sim.counters.turnover), largest_stored=self.largest,
        )  # fmt: skip

    def _named(self, energy: EnergyLedger) -> EnergyLedger:
        """The ledger with what the balances of the elements miss, where it does not close as far as the run promises it: to
        10 rtol, with steps of its own choice and located events. The simulation is at its start afterwards."""
        rtol, run = float(self.meta["rtol"]), self.rerun
        promised = self.meta["step"] is None and run is not None and run.options.locate
        if run is None or not promised or self.sim.error is not None or not energy.residual > 10 * rtol + 1e-12:
            return energy
        found = element_imbalances(run, float(self.times[-1][-1]))
        return replace(energy, unbalanced=dict(sorted(found.items(), key=lambda item: -abs(item[1]))))

    # -- failures -----------------------------------------------------------------------------------------------------

    def _stopped(self, code: Code) -> BaseException:
        """Why a run does not begin: what an input function raised to end the program (Ctrl-C), or the solver's reason."""
        raised = self.sim.error
        return raised if raised is not None and not isinstance(raised, Exception) else self._failure(code, None)

    def _failure(self, code: Code, run: Trajectory | None) -> GearblocksError:
        """The error of a return code, with the name of the thing and the way out."""
        report, program = self.sim.report, self.model.program
        t, (name, cause, remedy) = report.t, reason(program, code, report, self.sim.parameters)
        if self.size > memory_limit(self.samples is not None):
            t = float(self.sim.counters.t)
            counts = Counter(np.concatenate(self.events)["index"].tolist()) if self.events else Counter()
            name = component_of(program, Code.ERR_CHATTER, max(counts, key=counts.__getitem__, default=-1))
            steps = self.sim.counters.steps
            cause = f"the record of {steps} steps and {counts.total()} events fills the memory that it may take"
            remedy = "give times t or fewer outputs; look for what switches so often, or grows without bound"
        return SimulationError(t, name, cause, remedy, run)


class _Line:
    """One line on a terminal about a run that takes longer than two seconds: share done and time left."""

    def __init__(self, name: str) -> None:
        self._name, self._start, self._open = name, _time.monotonic(), False

    def __call__(self, share: float) -> None:
        spent = _time.monotonic() - self._start
        if spent > 2.0 and share > 0 and sys.stderr.isatty():
            self._open = True
            left = spent * (1 - share) / share
            sys.stderr.write(
                f"\r{self._name}: {100 * share:.0f} % done, {left:.0f} s left (Ctrl-C keeps what is done) "
            )
            sys.stderr.flush()

    def close(self) -> None:
        """Clears the line."""
        if self._open:
            sys.stderr.write("\r" + " " * 79 + "\r")


def _net(events: list[Event]) -> list[Event]:
    """Changes of one component that follow on each other at one instant as one, or none where it ends as it began."""
    found: list[Event] = []
    for e in events:
        last = found[-1] if found else None
        if e.kind == "state" and last and last[:3] + last[4:] == (*e[:3], e.before):
            found.pop()
            if last.before != e.after:
                found.append(e._replace(before=last.before))
        else:
            found.append(e)
    return found


def _shown(low: float, high: float, mode: float) -> float:
    return {0.0: low, 1.0: high}.get(mode, mode)


def memory_limit(sampled: bool) -> int:
    """Bytes that the record of a run may take: half of the memory (4 GiB where that is not known) with sample times, whose
    number is known, and no more than 2 GiB with every step."""
    try:
        half = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, ValueError, OSError):
        half = 1 << 32
    return half if sampled else min(half, 2 << 30)
