"""`python -m benchmarks.studies [POINTS]`: studies against the solver time of their points, and a loop over simulate."""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import gearblocks as gb
from benchmarks.cases import P2, Array
from benchmarks.measure import machine
from benchmarks.problems import model
from gearblocks.simulation.arguments import method_options

PROBLEM = P2()
T_END = PROBLEM.periods * PROBLEM.period
WORK: dict[str, list[Any]] = {
    "last, energy_lost, count": [gb.last("mesh.deflection"), gb.energy_lost("mesh"), gb.count("mesh")],
    "rms": [gb.rms("mesh.force")],
    "peak, energy_lost, rms": [gb.peak("mesh.force"), gb.energy_lost("mesh"), gb.rms("mesh.force")],
}


def grid() -> dict[str, Array]:
    """The levels of both parameters."""
    count = int(sys.argv[1]) if sys.argv[1:] else 200
    levels = round((count / 2) ** 0.5)
    return {"mesh.k": np.linspace(0.8, 1.2, count // levels), "mesh.c": np.linspace(0.05, 0.2, levels)}


def points() -> Array:
    """All points of the grid."""
    return np.array([*itertools.product(*grid().values())])


def bare() -> None:
    """The solver alone: one simulation, every point from its start to its end, nothing recorded but the last sample."""
    built = model(PROBLEM)
    options, _ = method_options("auto", 1e-6, None, None, True, T_END)
    numbers = [built.program.parameter_numbers[path] for path in grid()]
    end = np.array([T_END])
    with built.library.open() as sim:
        for point in points():
            sim.parameters[:] = built.values
            sim.parameters[numbers] = point
            sim.start(options, 0.0)
            record = sim.record(1)
            while sim.run(end, T_END, record) != 0:
                record.take()


def loop() -> None:
    """What a user would write without studies."""
    for point in points():
        run = gb.simulate(model(PROBLEM), t_end=T_END, parameters=dict(zip(grid(), point.tolist(), strict=True)))
        float(run["mesh.force"].max()), float(np.sqrt((run["mesh.force"] ** 2).mean())), run.energy.dissipated["mesh"]


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """CPU and wall seconds of the quickest of three calls."""
    found = []
    for _ in range(3):
        cpu, wall = time.process_time(), time.perf_counter()
        work()
        found.append((time.process_time() - cpu, time.perf_counter() - wall))
    return min(found)


def main() -> None:
    """Prints the table."""
    print(machine(), "\n")
    count = len(points())
    base, wall = timed(bare)
    print(f"P2 over {PROBLEM.periods} periods at 1e-6, {count} points of {' and '.join(grid())}; per point\n")
    print("| what | CPU us | of the solver | wall us |\n|---|---|---|---|")

    def row(what: str, cpu: float, wall: float) -> None:
        print(f"| {what} | {1e6 * cpu / count:.0f} | {cpu / base:.2f} | {1e6 * wall / count:.0f} |")

    row("the solver alone", base, wall)
    for what, quantities in WORK.items():
        for threads in (1, 2):
            row(
                f"sweep of {what}, threads: {threads}",
                *timed(lambda: gb.sweep(model(PROBLEM), grid(), quantity=quantities, t_end=T_END, threads=threads)),  # noqa: B023
            )
    row("loop over simulate (peak, rms of samples, energy lost)", *timed(loop))


if __name__ == "__main__":
    main()
