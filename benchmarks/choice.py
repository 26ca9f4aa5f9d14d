"""`python -m benchmarks.choice [TRAIN ...]`: what method="auto" costs beside each method at the error that it reaches.

Errors of states at samples against the same train at 1e-12 with another method of order 8 or 4; CPU time in the solver. The
best method's time is interpolated between its tolerances on logarithmic axes.
"""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable

import numpy as np

import gearblocks as gb
from benchmarks.cases import P1, P2, P3, P4, Array, Problem
from benchmarks.measure import machine, relative_error
from benchmarks.problems import columns, train

RTOLS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
METHODS = ("dp5", "dp8", "rodas")
ENOUGH = 10.0  # s of CPU time for a train
Case = tuple[Callable[[], gb.Drivetrain], tuple[str, ...], Array, str]


def _problem(problem: Problem, t_end: float, fine: str) -> Case:
    names = tuple(name for name, _ in columns(problem))
    return lambda: train(problem), names, np.linspace(0.0, t_end, 101)[1:], fine


def _model(name: str, outputs: tuple[str, ...], t_end: float) -> Case:
    made: Callable[[], gb.Drivetrain] = importlib.import_module(f"models.{name}").build
    return made, outputs, np.linspace(0.0, t_end, 101)[1:], "dp8"


CASES: dict[str, Case] = {
    "P1, 0.02 s": _problem(P1(), 0.02, "dp8"),
    "P2, 100 periods": _problem(P2(), 100 * P2().period, "dp8"),
    "P3, 0.02 s": _problem(P3(), 0.02, "dp8"),
    "P4, N = 100": _problem(P4(100), 1.0, "rodas"),
    "automatic gearbox, 2 s": _model("automatic_gearbox", ("*.w",), 2.0),
}


def outputs_of(model: gb.Model, outputs: tuple[str, ...], t: Array, method: str, rtol: float) -> tuple[float, Array]:
    """CPU seconds in the solver, and the outputs."""
    run = gb.simulate(model, t=t, method=method, rtol=rtol, outputs=list(outputs))
    return run.stats.cpu_seconds, np.column_stack([run[name] for name in run.names])


def table(name: str) -> None:
    """One train: a line for each tolerance of auto. Methods take turns, so that a busy machine is as busy for each."""
    make, outputs, t, fine = CASES[name]
    model = gb.build(make())
    known = outputs_of(model, outputs, t, fine, 1e-12)[1]
    moves = np.abs(known).max(axis=0) > 0
    best = {(method, rtol): (1e-14, float("inf")) for method in (*METHODS, "auto") for rtol in RTOLS}
    began = time.process_time()
    for turn in range(10):
        if turn > 1 and time.process_time() - began > ENOUGH:
            break
        for method, rtol in best:
            seconds, y = outputs_of(model, outputs, t, method, rtol)
            error = max(relative_error(y[:, moves], known[:, moves]), 1e-14)
            best[method, rtol] = error, min(seconds, best[method, rtol][1])
    for rtol in RTOLS:
        error, seconds = best["auto", rtol]
        others = [_at([best[method, other] for other in RTOLS], error) for method in METHODS]
        ratios = " | ".join(f"{other * 1e3:.3g}" for other in others)
        print(f"| {name} | {rtol:.0e} | {error:.1e} | {seconds * 1e3:.3g} | {ratios} | {seconds / min(others):.2f} |")


def _at(rows: list[tuple[float, float]], error: float) -> float:
    """The time that a method takes for an error."""
    errors, seconds = np.log(np.array(sorted(rows)).T)
    return float(np.exp(np.interp(np.log(error), errors, seconds)))


def main() -> None:
    """Prints the table."""
    print(machine(), "\n")
    print(f"| train | rtol | error of auto | auto ms | {' ms | '.join(METHODS)} ms | auto / best |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name in CASES:
        if not sys.argv[1:] or any(name.startswith(word) for word in sys.argv[1:]):
            table(name)


if __name__ == "__main__":
    main()
