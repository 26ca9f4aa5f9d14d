"""Energy balance of each element of a run: change of stored energy + loss - supply + work through its flanges = 0.

    imbalance_e = change of (stored_e + loss_e - supplied_e) + integral of sum_f tau_f w_f

The work through flanges is no state: it is integrated by points of Gauss and Legendre inside the accepted steps, for which
the run is done once more from its start, as far as so many steps go. At an instant (an impact, a switch) flanges pass on
impulses; what does not balance there in the whole train is that of the component that switches. Asked for where the total
does not close. Knows nothing of tolerances.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearblocks.codegen.program import POWER_INTO_FLANGE, Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.structures import EVENT, Array, Code, Options

_MOST = 2000  # steps that are looked at
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, slots=True)
class Rerun:
    """What it takes to do a run again: the simulation with its parameters and inputs, and what it was started with."""

    sim: Simulation
    program: Program
    options: Options
    begin: float
    y0: Array | None


def element_imbalances(run: Rerun, end: float) -> dict[str, float]:
    """Imbalance by element [J] over the first steps of a run up to `end`; empty where it cannot be done again."""
    rows, events = _rows(run, None, end)
    if len(rows) < 2:
        return {}
    starts, ends = rows[:-1, 0], rows[1:, 0]
    smooth = ends > starts
    mid, half = (starts + ends)[smooth] / 2, (ends - starts)[smooth] / 2
    inner, _ = _rows(run, (mid[:, None] + half[:, None] * _NODES).ravel(), end)
    if len(inner) != len(mid) * len(_NODES):
        return {}
    found: dict[str, float] = defaultdict(float)
    for path, change in _changes(run, rows).items():
        found[path] += float(change[smooth].sum())
    for path, power in _powers(run, inner).items():
        found[path] += float(half @ (np.nan_to_num(power).reshape(-1, len(_NODES)) @ _WEIGHTS))
    jumps = sum(_changes(run, rows).values(), np.zeros(len(smooth)))
    for i in np.flatnonzero(~smooth):
        if jumps[i] != 0.0 and (path := _switching(run.program, events, starts[i])):
            found[path] += float(jumps[i])
    return {path: x for path, x in found.items() if x != 0.0}


def _rows(run: Rerun, samples: Array | None, end: float) -> tuple[Array, NDArray[np.void]]:
    """Rows and events of the run: of its first accepted steps, or of all samples."""
    most = _MOST if samples is None else len(samples)
    record = run.sim.record(None if samples is None else len(samples))
    rows, events, count = [], [], 0
    code = run.sim.start(run.options, run.begin, run.y0)
    while code >= 0 and count < most:
        code = run.sim.run(samples, end, record)
        more, happened = record.take()
        rows.append(more)
        events.append(happened)
        count += len(more)
        if code == Code.DONE:
            break
    return (
        (np.concatenate(rows)[:most], np.concatenate(events)) if rows else (np.empty((0, 1)), np.empty(0, dtype=EVENT))
    )


def _changes(run: Rerun, rows: Array) -> dict[str, Array]:
    """By element: stored energy and loss less supply, from row to row."""
    _, _, energy = run.sim.evaluate(rows, np.zeros(0, dtype=np.intc), energies=True)
    found: dict[str, Array] = defaultdict(lambda: np.zeros(len(rows) - 1))
    for entry in run.program.energies:
        found[entry.component] += np.diff(energy[:, entry.offset])
    for item in run.program.integrals:
        if item.part != "angle":
            sign = 1.0 if item.part == "loss" else -1.0
            found[item.component] += sign * np.diff(rows[:, 1 + item.offset])
    return found


def _powers(run: Rerun, rows: Array) -> dict[str, Array]:
    """By element: power that it gives through its flanges."""
    pick = [i for i, q in enumerate(run.program.outputs) if q.words == POWER_INTO_FLANGE]
    _, power, _ = run.sim.evaluate(rows, np.array(pick, dtype=np.intc))
    found: dict[str, Array] = defaultdict(lambda: np.zeros(len(rows)))
    for column, i in enumerate(pick):
        found[run.program.outputs[i].name.rsplit(".", 2)[0]] += power[:, column]
    return found


def _switching(program: Program, events: NDArray[np.void], t: float) -> str:
    """The component of the first event at an instant."""
    for event in events[events["t"] == t] if len(events) else ():
        if int(event["index"]) < len(program.switches):
            switch = program.switches[int(event["index"])]
            return switch.component.removesuffix(f".{switch.name}")
    return ""
