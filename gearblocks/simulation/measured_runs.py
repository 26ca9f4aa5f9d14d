"""Runs of which a few numbers are kept: outputs at times, energy lost, events, and what an output is along the run.

A peak, a mean and a root mean square are those of the solution between the steps (c/gb_quantity.h), not of samples. Points
are run one after the other by one call of the core. Knows nothing of what is made of the numbers.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from time import thread_time
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import Program
from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.simulation.arguments import set_inputs
from gearblocks.simulation.case import Case
from gearblocks.simulation.events import Events, net_events, shown
from gearblocks.simulation.failures import reason
from gearblocks.simulation.needs import Along, Needs
from gearblocks.simulation.recorded_memory import memory_limit
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import Array, Code
from gearblocks.solver.study_runs import Points, QuantityKind, StudyRuns, Wanted

_CORES = os.cpu_count() or 1
_SLICE = 0.05  # seconds between looks at whether to go on
_ROOM = 1 << 22  # numbers that a block of points may take


class StoppedError(Exception):
    """The solver could not go on: its code; or None where the caller asked to stop."""

    def __init__(self, code: Code | None) -> None:
        super().__init__(code)
        self.code = code


@final
@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """What is kept of one run. values: outputs and losses at the times, shape (T, outputs + losses); start: losses at the
    begin; turnover and what is missing in the energy balance [J]; static: outputs in the static equilibrium, or why there is
    none."""

    program: Program
    needs: Needs
    begin: float
    times: Array
    values: Array
    start: Array
    along: Array
    turnover: float
    missing: float
    recorded: NDArray[np.void]  # events with what stands for modes
    static: Array | GearblocksError

    @cached_property
    def events(self) -> Events:
        """The events of the run."""
        return net_events(self.program.event_table, self.recorded)

    def value(self, output: str, time: float) -> float:
        """The output at one of the times that were asked for, or at the end."""
        return float(self.values[self.times.searchsorted(time), self.needs.outputs.index(output)])

    def table(self, outputs: Sequence[str], times: Array) -> Array:
        """Outputs at times that were asked for, shape (times, outputs)."""
        picks = [self.needs.outputs.index(output) for output in outputs]
        found: Array = self.values[self.times.searchsorted(times)][:, picks]
        return found

    def lost(self, component: str, time: float) -> float:
        """What the losses of a component have come to at the begin, at one of the times, or at the end [J]."""
        i = self.needs.losses.index(component)
        if time <= self.begin:
            return float(self.start[i])
        return float(self.values[self.times.searchsorted(time), len(self.needs.outputs) + i])

    def along_run(self, wanted: Along) -> float:
        """What an output is along the run."""
        return float(self.along[self.needs.along.index(wanted)])

    def static_value(self, output: str) -> float:
        """The output in the static equilibrium. Raises what says why there is none."""
        if isinstance(self.static, GearblocksError):
            raise self.static
        return float(self.static[self.needs.static.index(output)])


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Runs of one model, P of them. parameters: (P, n_parameters); ends [s]: (P,); needs: one for each, alike but for their
    times, or one for all, which then end together; the rest as Points has it. case: what all have in common."""

    case: Case
    parameters: Array
    ends: Array
    needs: Sequence[Needs]
    inputs: Array | None = None
    steps: Array | None = None
    start: Array | None = None

    def part(self, which: slice) -> Runs:
        """Some of them."""
        needs = self.needs if len(self.needs) == 1 else self.needs[which]
        inputs, steps = (None if x is None else x[which] for x in (self.inputs, self.steps))
        start = self.start if self.start is None or self.start.ndim == 1 else self.start[which]
        return Runs(self.case, self.parameters[which], self.ends[which], needs, inputs, steps, start)

    def times(self) -> list[Array]:
        """Times at which values are kept, of each or of all."""
        ends = self.ends[:1] if len(self.needs) == 1 else self.ends
        return [np.array(sorted({*need.times, end})) for need, end in zip(self.needs, ends.tolist(), strict=True)]


@dataclass(slots=True, eq=False)
class Measuring:
    """Runs of a simulation whose inputs are set. failed: called with the number of a run that could not go on and the code,
    while the simulation can still say why; stop: whether to give up (StoppedError). seconds: CPU time in the solver."""

    sim: Simulation
    program: Program
    failed: Callable[[int, Code], None]
    stop: Callable[[], bool] | None = None
    seconds: float = field(default=0.0, init=False)

    def measured(self, runs: Runs) -> Iterator[tuple[int, MeasuredRun]]:
        """Each run that came to its end, with its number."""
        times = runs.times()
        lengths = np.array([len(t) for t in times])
        width = 1 + self.program.n_total // 8 + runs.parameters.shape[1] + int(lengths.max()) * _width(runs.needs[0])
        most = max(1, _ROOM // width)
        count, first = len(runs.parameters), 0
        while first < count:
            last = min(first + most, count)
            if len(times) > 1:  # as many as have as many times
                others = np.flatnonzero(lengths[first:last] != lengths[first])
                last = first + int(others[0]) if len(others) else last
            which = slice(first, last)
            chosen = times * (last - first) if len(times) == 1 else times[which]
            yield from self._block(runs.part(which), np.array(chosen), first)
            first = last

    def _block(self, runs: Runs, times: Array, number: int) -> Iterator[tuple[int, MeasuredRun]]:
        needs = list(runs.needs) * (len(times) if len(runs.needs) == 1 else 1)
        windows = np.array([[(one.after, one.before) for one in need.along] for need in needs], dtype=np.float64)
        case = runs.case
        static = [self._static(runs, i, need) for i, need in enumerate(needs)]
        points = Points(
            case.options, case.begin, runs.parameters, times, windows, runs.inputs, runs.steps, runs.start
        )  # fmt: skip
        study = StudyRuns(self.sim, self.program, points, _wanted(self.program, needs[0]))
        lost, events = self._go(study, number)
        ends = [0, *study.ends.tolist()]
        energy = study.balance
        missing = np.abs(energy[:, 1] - energy[:, 0] + energy[:, 2])
        turnover = np.maximum(energy[:, 0], energy[:, 1]) + energy[:, 3]
        n_losses = len(needs[0].losses)
        for i in range(len(times)):
            if i not in lost:
                yield (
                    number + i,
                    MeasuredRun(
                        self.program, needs[i], case.begin, times[i], study.values[i], study.start_states[i, :n_losses],
                        study.quantities[i], float(turnover[i]), float(missing[i]),
                        events[ends[i] : ends[i + 1]], static[i],
                    ),
                )  # fmt: skip

    def _static(self, runs: Runs, i: int, needs: Needs) -> Array | GearblocksError:
        """Outputs of a run's train in its static equilibrium, or why there is none."""
        if not needs.static:
            return np.empty(0)
        from gearblocks.simulation.equilibrium import static_outputs

        sim = self.sim
        sim.parameters[:] = runs.parameters[i]
        if runs.inputs is not None:
            sim.inputs[:] = runs.inputs[i]
        try:
            return static_outputs(sim, self.program, runs.case.begin, needs.static)
        except GearblocksError as error:
            sim.raise_end()
            return error
        except RuntimeError:
            return SimulationError(sim.report.t, *reason(self.program, Code(sim.report.code), sim))

    def _go(self, study: StudyRuns, number: int) -> tuple[set[int], NDArray[np.void]]:
        """Runs all of a block: those that could not go on, and the events of all."""
        pieces: list[NDArray[np.void]] = []
        lost: set[int] = set()
        code, room, point = Code.PAUSE, memory_limit(True) / _CORES, -1
        while code != Code.DONE:
            before = thread_time()
            code = study.run(_SLICE)
            self.seconds += thread_time() - before
            if self.stop is not None and self.stop():
                raise StoppedError(None)
            if code == Code.FULL:
                room = room if study.point == point else memory_limit(True) / _CORES
                point = study.point
                pieces.append(study.take_events())
                room -= pieces[-1].nbytes
                code = Code.ERR_MEMORY if room < 0 else code
            if code < 0:
                lost.add(study.point)
                self.failed(number + study.point, code)
                study.skip()
        pieces.append(study.take_events())
        return lost, shown(self.program.event_table, np.concatenate(pieces))


@contextmanager
def run_again(case: Case, needs: Needs) -> Iterator[MeasuredRun]:
    """A run done again, to the bit, for what is needed of it. Raises SimulationError."""
    program = case.library.program
    with case.library.open() as sim:
        set_inputs(sim, program, case.inputs)
        try:
            yield measured_run(sim, case, needs)
        except StoppedError as stopped:
            code = stopped.code or Code.ERR_MEMORY
            raise SimulationError(sim.report.t, *reason(program, code, sim)) from None


def measured_run(sim: Simulation, case: Case, needs: Needs, stop: Callable[[], bool] | None = None) -> MeasuredRun:
    """What is kept of one run of a simulation whose inputs are set. Raises StoppedError, without a code where `stop`, asked
    every now and then, answers True."""

    def failed(_number: int, code: Code) -> None:
        raise StoppedError(code)

    runs = Runs(case, case.parameters[None], np.array([case.end]), (needs,), start=case.y0)
    return next(found for _, found in Measuring(sim, case.library.program, failed, stop).measured(runs))


def merged(program: Program, needs: Sequence[Needs]) -> Needs:
    """All that is needed, nothing twice; outputs in the order of the program."""
    numbers: Mapping[str, int] = program.output_numbers
    outputs = dict.fromkeys(name for need in needs for name in need.outputs)
    return Needs(
        tuple(sorted(outputs, key=numbers.__getitem__)),
        tuple(sorted({time for need in needs for time in need.times})),
        tuple(dict.fromkeys(name for need in needs for name in need.losses)),
        tuple(dict.fromkeys(one for need in needs for one in need.along)),
        tuple(dict.fromkeys(name for need in needs for name in need.static)),
    )


def _width(needs: Needs) -> int:
    return len(needs.outputs) + len(needs.losses)


def _wanted(program: Program, needs: Needs) -> Wanted:
    numbers = program.output_numbers
    names, offsets = program.integral_components["loss"]
    places = dict(zip(names, offsets.tolist(), strict=True)) if needs.losses else {}
    return Wanted(
        np.array([numbers[name] for name in needs.outputs], dtype=np.intc),
        np.array([places[name] for name in needs.losses], dtype=np.intc),
        tuple(QuantityKind[one.kind.upper()] for one in needs.along),
        np.array([numbers[one.output] for one in needs.along], dtype=np.intc),
        np.array([numbers.get(one.factor, -1) for one in needs.along], dtype=np.intc),
    )
