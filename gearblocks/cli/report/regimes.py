"""One speed of the coupling: trace, phase plane, points once per turn."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearblocks.running import simulate
from gearblocks.simulation.plotting import Plane, over_time
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model

Array = NDArray[np.float64]

SAMPLES = 400


@dataclass(frozen=True, slots=True)
class Coupling:
    """The model and the names by which the demo speaks of it: the speed [rad/s], the spline, the shafts' twists."""

    model: Model
    speed: str
    spline: str
    half_gap_path: str
    half_gap: float
    relative: tuple[str, ...]

    @property
    def shown(self) -> tuple[str, ...]:
        """Outputs of the pictures."""
        return (f"{self.spline}.deflection", f"{self.spline}.deflection_rate", f"{self.spline}.force")


@dataclass(frozen=True, slots=True)
class Answer:
    """What the coupling does at one speed: one point per turn once it has settled, and the last turns in full."""

    rpm: float
    points: tuple[Array, Array]
    last: Trajectory

    @property
    def turn(self) -> float:
        """Duration of one turn [s]."""
        return 60.0 / self.rpm


def answer(coupling: Coupling, rpm: float, *, transient: int, keep: int, turns: int) -> Answer:
    """Run `transient` turns, keep a point of each of the next `keep`, and the last `turns` of these in full."""
    turn = 60.0 / rpm
    total = transient + keep
    strobe = turn * np.arange(total + 1)
    fine = turn * (total - turns + np.arange(turns * SAMPLES + 1) / SAMPLES)
    t = np.union1d(strobe, fine)
    run = simulate(
        coupling.model,
        t=t,
        rtol=1e-10,
        parameters={coupling.speed: 2.0 * math.pi / turn},
        outputs=coupling.shown,
    )
    x, rate, _ = (run[name] for name in coupling.shown)
    once = np.searchsorted(t, strobe[transient + 1 :])
    shown = slice(int(np.searchsorted(t, fine[0])), None)
    columns = {name: run[name][shown] for name in coupling.shown}
    last = Trajectory(t[shown], columns, run.units, stats=run.stats, energy=run.energy, meta=run.meta)
    return Answer(rpm, (x[once], rate[once]), last)


def traces(coupling: Coupling, found: Answer, path: str | os.PathLike[str]) -> None:
    """Picture of deflection and tooth force over the last turns."""
    x, _, force = coupling.shown
    last = found.last
    series = [(name, last.units[name], last[name]) for name in (x, force)]
    over_time(last.t, series, title=f"{found.rpm:g} rpm, the last turns", path=path)


def phase(coupling: Coupling, found: Answer, label: str) -> Plane:
    """Deflection against its rate with the points of the same turns."""
    x, rate, _ = coupling.shown
    last = found.last
    return Plane(
        title=f"{found.rpm:g} rpm: {label}",
        x=(x, last.units[x], last[x]),
        y=(rate, last.units[rate], last[rate]),
        points=found.points,
        edges=(-coupling.half_gap, coupling.half_gap),
    )


def section(coupling: Coupling, found: Answer, label: str) -> Plane:
    """The points alone."""
    x, rate, _ = coupling.shown
    empty: Array = np.empty(0)
    units = found.last.units
    return Plane(f"{found.rpm:g} rpm: {label}", (x, units[x], empty), (rate, units[rate], empty), found.points)
