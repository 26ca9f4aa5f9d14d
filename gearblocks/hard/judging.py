"""What a case is judged by, and what its runs cost."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

import gearblocks as gb
from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import Code, Counters, Options

RTOL = 1e-6
"""The default tolerance of a run."""
PATIENCE = 20.0
"""CPU time [s] after which a run is given up."""


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that must hold, with what was measured."""

    words: str
    holds: bool


Judge: TypeAlias = "Callable[[Meter], Iterable[Check]]"


def below(what: str, value: float, limit: float) -> Check:
    """A size that must stay below a limit; a NaN does not."""
    return Check(f"{what} {value:.2g} < {limit:g}", bool(value < limit))


def count(what: str, number: int, limit: int) -> Check:
    """A number of things, `limit` at most."""
    return Check(f"{what} {number}", number <= limit)


def fact(words: str, holds: bool) -> Check:
    """Something that is so or not."""
    return Check(words, bool(holds))


def largest(values: Any) -> float:
    """The greatest size among numbers; NaN where one is."""
    return float(np.abs(np.asarray(values, dtype=float)).max())


def refusal(train: Callable[[], Any], *words: str) -> Check:
    """Doing `train` must end in an error of the package whose message has all these words."""
    try:
        train()
    except GearblocksError as error:
        message = str(error)
        missing = [word for word in words if word not in message]
        return fact(f"refused: {message.splitlines()[0]:.160}", not missing)
    return fact(f"not refused, though wrong: {', '.join(words)}", False)


class Meter:
    """Runs the trains of a case and adds up what that took."""

    def __init__(self) -> None:
        self.steps = self.rhs_calls = self.events = 0
        self.seconds = 0.0

    def simulate(self, train: gb.Drivetrain | gb.Model, **arguments: Any) -> Trajectory:
        """gb.simulate, counted; a run stopped by Ctrl-C stops the case."""
        model = gb.build(train)
        try:
            run = gb.simulate(model, progress=_Patience(), **arguments)
        except SimulationError as error:
            if isinstance(error.trajectory, Trajectory):
                self._add(error.trajectory)
            raise
        self._add(run)
        if not run.complete:
            raise KeyboardInterrupt
        return run

    def _add(self, run: Trajectory) -> None:
        self.steps += run.stats.steps
        self.rhs_calls += run.stats.rhs_calls
        self.events += run.stats.events
        self.seconds += run.stats.cpu_seconds

    def count(self, counters: Counters, seconds: float = 0.0) -> None:
        """Adds the counters of a solver that was driven by hand."""
        self.steps += counters.steps
        self.rhs_calls += counters.rhs_calls
        self.events += counters.events
        self.seconds += seconds


class _Patience:
    """Takes the share done of a run, and ends the run where it would take for ever."""

    def __init__(self) -> None:
        self._began = time.process_time()

    def __call__(self, share: float) -> None:
        if time.process_time() - self._began > PATIENCE:
            raise GearblocksError(f"gave up after {PATIENCE:g} s of CPU time with {100 * share:.3g} % of the run done")


def started(model: gb.Model, end: float = math.inf) -> Simulation:
    """A solver of the model at its start, at the default tolerance and method, to be driven step by step."""
    from gearblocks.simulation.arguments import method_options, set_inputs

    sim = model.library.open()
    sim.parameters[:] = model.values
    set_inputs(sim, model.program, {})
    options, _ = method_options("auto", RTOL, None, None, True, end)
    expect(sim.start(Options(options.method, 1, RTOL, 0.0, math.inf, end), 0.0))
    return sim


def expect(code: Code) -> None:
    """GearblocksError where a call of the solver could not go on."""
    if code < 0:
        raise GearblocksError(f"the solver answered {code.name}")


def heat(sim: Simulation, model: gb.Model, component: str) -> float:
    """Energy that a component lost until now [J]."""
    state = sim.state()
    offsets = [x.offset for x in model.program.integrals if x.component == component and x.part == "loss"]
    return float(sum(state[i] for i in offsets))
