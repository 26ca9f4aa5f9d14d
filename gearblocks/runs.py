"""Running a model: options, inputs and start values go in, a trajectory comes out, whatever happens on the way."""

from __future__ import annotations

import math
import time as _time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.core import Array, Code, Kind, Method, Options, Simulation
from gearblocks.errors import (
    GearblocksError,
    ParameterError,
    SimulationError,
    UnknownNameError,
    by_name,
    did_you_mean,
)  # fmt: skip
from gearblocks.expression import finite_number
from gearblocks.library import Model
from gearblocks.program import Program
from gearblocks.records import EnergyLedger, Event, FinalState, Stats
from gearblocks.signals import Table
from gearblocks.trajectory import Trajectory, matches

InputSource: TypeAlias = "float | Table | Callable[[float], float]"
METHODS = {"rk4": Method.RK4, "dp5": Method.DP5, "dp8": Method.DP8}


def run_model(
    model: Model, *, t_end: float | None = None, t: ArrayLike | None = None, t_start: float | None = None,
    method: str = "auto", rtol: float = 1e-6, step: float | None = None, max_step: float | None = None,
    locate: bool = True, inputs: Mapping[str, InputSource] | None = None,
    parameters: Mapping[str, float] | None = None, initial: Mapping[str, float] | Trajectory | str | None = None,
    outputs: str | Sequence[str] = "*", progress: Callable[[float], None] | None = None,
) -> Trajectory:  # fmt: skip
    """Runs a model; see `gearblocks.simulate` for the arguments."""
    program = model.program
    if progress is not None and not callable(progress):
        raise ParameterError(f"progress = {progress!r:.80} must be a function of the share done")
    begin = _begin(t_start, initial)
    samples, end = _times(begin, t_end, t)
    options, why = method_options(method, rtol, step, max_step, locate, end)
    pick = _picked(program, outputs)
    with model.library.open() as sim:
        sim.parameters[:] = parameter_vector(program, model.values, parameters or {}, initial)
        _set_inputs(sim, program, inputs or {})
        run = _Run(model, sim, samples, end, pick, progress, meta={
            "train": program.name, "method": Method(options.method).name.lower(), "rtol": rtol, "step": step,
            "parameters": {p.path: float(v) for p, v in zip(program.parameters, sim.parameters, strict=True)},
        })  # fmt: skip
        y0 = start_state(program, initial)
        return run.go(options, begin, y0, why)


ARGUMENTS = frozenset(run_model.__annotations__) - {"model", "return"}
"""The names that `run_model` takes."""


# -- arguments --------------------------------------------------------------------------------------------------------


def _begin(t_start: float | None, initial: Any) -> float:
    if t_start is not None:
        return finite_number("t_start", t_start)
    if isinstance(initial, Trajectory) and initial.final_state is not None:
        return initial.final_state.t
    return 0.0


def _times(begin: float, t_end: float | None, t: ArrayLike | None) -> tuple[Array | None, float]:
    """The samples (None: every accepted step) and the end of the run."""
    if (t is None) == (t_end is None):
        raise ParameterError("give either t_end (records every step) or t (an array of sample times)")
    if t is None:
        assert t_end is not None
        end = finite_number("t_end", t_end)
        if end <= begin:
            raise ParameterError(f"t_end = {end!r} s must be later than the start at {begin!r} s")
        return None, end
    try:
        samples = np.ascontiguousarray(t, dtype=np.float64)
    except (TypeError, ValueError, ParameterError):
        raise ParameterError(f"t = {t!r:.80} must be a row of numbers") from None
    if samples.ndim != 1 or len(samples) == 0 or not np.isfinite(samples).all():
        raise ParameterError(f"t must be a row of finite times, not an array of shape {samples.shape}")
    if (np.diff(samples) <= 0).any() or samples[0] < begin:
        raise ParameterError(f"t must increase and not begin before the start at {begin!r} s")
    return samples, float(samples[-1])


def method_options(
    method: str, rtol: float, step: float | None, max_step: float | None, locate: bool, end: float
) -> tuple[Options, str]:  # fmt: skip
    if method not in ("auto", *METHODS):
        raise ParameterError(
            f"method = {method!r} must be 'auto', {', '.join(map(repr, METHODS))}{did_you_mean(method, METHODS)}"
        )
    rtol = finite_number("rtol", rtol)
    if not 1e-14 <= rtol <= 0.1:
        raise ParameterError(f"rtol = {rtol!r} must lie between 1e-14 and 0.1")
    for name, value in (("step", step), ("max_step", max_step)):
        if value is not None and finite_number(name, value) <= 0:
            raise ParameterError(f"{name} = {value!r} s must be > 0")
    if not isinstance(locate, (bool, np.bool_)):
        raise ParameterError(f"locate = {locate!r} must be True or False")
    if method == "rk4" and step is None:
        raise ParameterError("method 'rk4' has a fixed step: give step= in s, or take 'dp5' or 'dp8'")
    why = "chosen by the user"
    if method == "auto":
        method = "dp8" if rtol <= 1e-4 else "dp5"
        why = f"rtol = {rtol:g}: order 8 pays from 1e-4 down, order 5 above; no stiff method is available"
    return Options(METHODS[method], int(locate), rtol, step or 0.0, max_step or math.inf, end), why


def _picked(program: Program, outputs: str | Sequence[str]) -> list[int]:
    """Numbers of the outputs that match; UnknownNameError for a pattern that matches nothing."""
    patterns = [outputs] if isinstance(outputs, str) or not isinstance(outputs, Iterable) else list(outputs)
    if not all(isinstance(pattern, str) for pattern in patterns):
        raise ParameterError(f"outputs = {outputs!r:.80} must be a pattern or a list of patterns, such as ['mesh.*']")
    if patterns == ["*"]:
        return list(range(len(program.outputs)))
    names = {q.name: i for i, q in enumerate(program.outputs)}
    chosen: dict[int, None] = {}
    for pattern in patterns:
        if pattern in names:
            chosen[names[pattern]] = None
            continue
        found = [i for name, i in names.items() if matches(name, pattern)]
        if not found:
            raise UnknownNameError(
                f"no output matches '{pattern}'{did_you_mean(pattern, names)}; list them with rig.describe()"
            )
        chosen.update(dict.fromkeys(found))
    return sorted(chosen)


def resolve(wanted: str, names: Mapping[str, int], what: str) -> int:
    """The number of a name, or of the only one that ends with it."""
    if not isinstance(wanted, str):
        raise UnknownNameError(f"the name of the {what} must be text, not {wanted!r}")
    if wanted in names:
        return names[wanted]
    ends = [name for name in names if name.endswith("." + wanted)]
    if len(ends) == 1:
        return names[ends[0]]
    if ends:
        raise UnknownNameError(f"{what} '{wanted}' is not unique: it could be {', '.join(sorted(ends))}")
    raise UnknownNameError(f"there is no {what} '{wanted}'{did_you_mean(wanted, names)}")


def parameter_vector(program: Program, values: Array, changed: Mapping[str, float], initial: Any) -> Array:
    """The parameter vector with changed parameters and start values."""
    result = np.array(values)
    names = {p.path: i for i, p in enumerate(program.parameters)}
    structural = {path for path, _ in program.structural}
    for path, value in by_name("parameters", changed).items():
        i = resolve(path, names, "parameter")
        info = program.parameters[i]
        if info.path in structural:
            raise ParameterError(
                f"'{info.path}' enters a ratio, which is structural: make a new train with rig.set(...)"
            )
        result[i] = checked(info.path, value, info.unit, info.lower, info.upper)
    if isinstance(initial, Mapping):
        _initial(program, result, initial)
    elif not (initial is None or isinstance(initial, Trajectory)):
        raise ParameterError(
            f"initial = {initial!r:.80} is not available; give start values such as {{'motor.w': 100.0}}"
        )
    return result


def _initial(program: Program, result: Array, initial: Mapping[str, float]) -> None:
    starts = {s.name: i for i, s in enumerate(program.starts)}
    given: dict[int, tuple[str, float]] = {}
    for name, value in initial.items():
        info = program.starts[resolve(name, starts, "initial value")]
        number = checked(info.name, value, "", None, None) * info.factor
        before = given.setdefault(info.place, (name, number))
        if abs(before[1] - number) > 1e-12 * max(abs(number), abs(before[1])):
            raise ParameterError(
                f"the initial values of '{before[0]}' and '{name}' contradict each other through their ties"
            )
        result[info.place] = number


def checked(name: str, value: float, unit: str, lower: float | None, upper: float | None) -> float:
    """A finite number within its bounds, or ParameterError by name."""
    number = finite_number(name, value)
    words = f"{name} = {number!r}{' ' + unit if unit not in ('', '1') else ''}"
    if lower is not None and number < lower:
        raise ParameterError(f"{words} must be >= {lower:g}")
    if upper is not None and number > upper:
        raise ParameterError(f"{words} must be <= {upper:g}")
    return number


def _set_inputs(sim: Simulation, program: Program, sources: Mapping[str, InputSource]) -> None:
    names = {x.name: i for i, x in enumerate(program.inputs)}
    sim.inputs[:] = [x.start for x in program.inputs]
    for name, source in by_name("inputs", sources).items():
        i = resolve(name, names, "input")
        info = program.inputs[i]
        if isinstance(source, Table):
            period = float(source.x[-1] - source.x[0]) if source.periodic else 0.0
            kind = {"linear": Kind.LINEAR, "step": Kind.STEP, "cubic": Kind.CUBIC}[source.kind]
            sim.set_table(i, kind, np.asarray(source.x), np.asarray(source.y), source.second, period)
        elif callable(source):
            sim.set_function(i, source)
        else:
            sim.inputs[i] = checked(f"input '{info.name}'", source, info.unit, None, None)


def start_state(program: Program, initial: Any) -> Array | None:
    """The state vector of an earlier run, the ledger at zero."""
    if not isinstance(initial, Trajectory):
        return None
    final = initial.final_state
    if final is None or final.key != program.key:
        raise ParameterError("initial: the earlier run is of another train; continue a run with the same model")
    y = np.array(final.y)
    for entry in program.integrals:
        if entry.part != "angle":
            y[entry.place] = 0.0
    return y


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
    meta: dict[str, Any]
    times: list[Array] = field(default_factory=list)
    values: list[Array] = field(default_factory=list)
    events: list[NDArray[np.void]] = field(default_factory=list)
    largest: float = 0.0
    cpu: float = 0.0
    last: Array | None = None

    def go(self, options: Options, begin: float, y0: Array | None, why: str) -> Trajectory:
        """Runs to the end, to an error or to Ctrl-C."""
        code = self.sim.start(options, begin, y0)
        if code < 0:
            raise self._failure(code, None)
        try:
            first = self.sim.state(), self.sim.energies()
        except RuntimeError:
            if self.sim.error is not None and not isinstance(self.sim.error, Exception):
                raise self.sim.error from None
            raise self._failure(Code(self.sim.report.code), None) from self.sim.error
        self.largest = float(first[1].sum())
        complete = False
        try:
            code = self._loop(begin)
            complete = code == Code.DONE
        except KeyboardInterrupt:
            code = Code.PAUSE
        if isinstance(self.sim.error, KeyboardInterrupt):
            code = Code.PAUSE
        result = self._result(first, complete, why)
        if code < 0:
            raise self._failure(code, result) from self.sim.error
        return result

    def _loop(self, begin: float) -> Code:
        width = 1 + self.model.program.n_total + len(self.model.program.switches)
        record = self.sim.record(rows=max(64, min(8192, 2_000_000 // width)), events=16384)
        shown = _time.monotonic()
        while True:
            before = _time.thread_time()
            code = self.sim.run(self.samples, self.end, record)
            self.cpu += _time.thread_time() - before
            taken = self._take(*record.take())
            if code in (Code.DONE,) or min(code, taken) < 0:
                return code if code < 0 else taken
            if self.progress is not None and _time.monotonic() - shown > 0.2:
                shown = _time.monotonic()
                self.progress((self.sim.counters.t - begin) / (self.end - begin))

    def _take(self, rows: Array, events: NDArray[np.void]) -> Code:
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

    def _result(self, first: tuple[Array, Array], complete: bool, why: str) -> Trajectory:
        program, counters = self.model.program, self.sim.counters
        t = np.concatenate(self.times) if self.times else np.empty(0)
        table = np.concatenate(self.values) if self.values else np.empty((0, len(self.pick)))
        names = [program.outputs[i].name for i in self.pick]
        final = None
        if self.last is not None:
            y = self.last[1 : 1 + program.n_total].copy()
            modes = self.last[1 + program.n_total : 1 + program.n_total + len(program.switches)].copy()
            final = FinalState(float(self.last[0]), y, modes, program.key)
        stats = Stats(
            steps=counters.steps, rejected=counters.rejected, rhs_calls=counters.rhs_calls, events=counters.events,
            cpu_seconds=self.cpu, method=str(self.meta["method"]), why=why,
        )  # fmt: skip
        return Trajectory(
            t, (names, table), {n: program.outputs[i].unit for n, i in zip(names, self.pick, strict=True)},
            events=self._events(), stats=stats, energy=self._energy(first, final), final_state=final,
            meta={**self.meta, "complete": complete},
        )  # fmt: skip

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
                before, after = (_shown(switch.low, switch.high, float(event[k])) for k in ("before", "after"))
                found.append(Event(float(event["t"]), switch.component, switch.kind, before, after))
        return found

    def _energy(self, first: tuple[Array, Array], final: FinalState | None) -> EnergyLedger:
        program = self.model.program
        if final is None or self.last is None:
            return EnergyLedger()
        _, _, energy = self.sim.evaluate(self.last[None, :], np.zeros(0, dtype=np.intc), energies=True)
        parts: dict[str, dict[str, float]] = {"stored": {}, "loss": {}, "supplied": {}}
        for entry in program.energies:
            parts["stored"][entry.component] = parts["stored"].get(entry.component, 0.0) + float(energy[0, entry.place])
        for item in program.integrals:
            if item.part != "angle":
                parts[item.part][item.component] = float(final.y[item.place] - first[0][item.place])
        return EnergyLedger(
            stored=parts["stored"], start=float(first[1].sum()), dissipated=parts["loss"], supplied=parts["supplied"],
            exchanged=float(self.sim.counters.turnover), largest_stored=self.largest,
        )  # fmt: skip

    # -- failures -----------------------------------------------------------------------------------------------------

    def _failure(self, code: Code, run: Trajectory | None) -> GearblocksError:
        """The error of a return code, with the name of the thing and the way out."""
        report, program = self.sim.report, self.model.program
        name = _place(program, code, report.index)
        cause, remedy = _CAUSES.get(code, (f"the solver answered {code.name}", ""))
        return SimulationError(report.t, name, cause, remedy, run)


def _shown(low: float, high: float, mode: float) -> float:
    return {0.0: low, 1.0: high}.get(mode, mode)


_CAUSES: dict[Code, tuple[str, str]] = {
    Code.ERR_STEP: (
        "the step size fell below rounding", "the train may be stiff there or have a discontinuity that no switch locates"
    ),
    Code.ERR_NAN_RATE: ("a derivative became NaN or infinite", "look at the law and the values of this component"),
    Code.ERR_NAN_INPUT: ("the input became NaN or infinite", "the input must give a finite number at every time"),
    Code.ERR_NAN_START: ("a start value or parameter is NaN or infinite", "give it a finite number"),
    Code.ERR_CHATTER: (
        "a switch goes back and forth without progress of time",
        "the element sticks here (as dry friction does at rest) and this law cannot hold it",
    ),
    Code.ERR_BRANCH: ("no set of modes fits the state", "the conditions of this component contradict each other"),
    Code.ERR_MEMORY: ("there is not enough memory", ""),
    Code.ERR_CALLBACK: ("the input function raised an exception", "see the exception above"),
}  # fmt: skip


def _place(program: Program, code: Code, index: int) -> str:
    """The component or input that a code's index means."""
    if code in (Code.ERR_NAN_INPUT, Code.ERR_CALLBACK):
        return program.inputs[index].name if 0 <= index < len(program.inputs) else ""
    if code in (Code.ERR_CHATTER, Code.ERR_BRANCH):
        if not 0 <= index < len(program.switches):
            return ""
        switch = program.switches[index]
        return switch.component.removesuffix(f".{switch.name}")
    if 0 <= index < len(program.states):
        return program.states[index].name.rsplit(".", 1)[0]
    if code == Code.ERR_NAN_START and index >= program.n:
        return program.parameters[index - program.n].path
    return ""
