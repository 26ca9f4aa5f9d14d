"""Picture of work and precision: CPU time against the error of each quantity, a line per method."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.reference import Reference
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.analysis.scenes.work_precision_points import Point
from gearblocks.errors import ParameterError
from gearblocks.simulation.plotting import COLOURS, MARKERS, finished, legend, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_LEAST = 1e-16  # an error that is drawn


class Drawn(Protocol):
    """What is drawn (`work_precision_result.py`)."""

    @property
    def scene(self) -> Scene: ...
    @property
    def reference(self) -> Reference: ...
    def lines(self) -> list[list[Point]]: ...


def picture(found: Drawn, path: str | os.PathLike[str] | None) -> Figure:
    """A panel for each quantity; dashed lines: events not located. Grey: what the reference does not tell."""
    names = found.scene.names
    if not found.lines():
        raise ParameterError(f"{found.scene.name}: no run came to its end, so there is nothing to draw")
    with style():
        figure, panels = new_figure(path, columns=len(names), size=(3.4 + 3.8 * len(names), 4.2))
        for i, (axis, name) in enumerate(zip(panels, names, strict=True)):
            _panel(axis, found, i)
            axis.set_xlabel(f"relative error of\n{name}")
        panels[0].set_ylabel("CPU time in ms")
        legend(panels[-1], *panels[:-1], loc="upper left", bbox_to_anchor=(1.0, 1.0))
        figure.suptitle(
            f"{found.scene.name}, {found.scene.begin:g} to {found.scene.end:g} s", x=0.01, ha="left", fontsize=10
        )
        return finished(figure, path)


def _panel(axis: Axes, found: Drawn, i: int) -> None:
    methods = [*dict.fromkeys(line[0].effort.method for line in found.lines())]
    for line in found.lines():
        points = [p for p in line if not p.failure and np.isfinite(p.errors[i])]
        method, located = line[0].effort.method, line[0].effort.locate
        number = methods.index(method)
        axis.loglog(
            [max(float(p.errors[i]), _LEAST) for p in points],
            [1e3 * p.seconds for p in points],
            label=method + ("" if located else ", not located"),
            color=COLOURS[number],
            linestyle="-" if located else "--",
            marker=MARKERS[number],
            markersize=4.5,
            markerfacecolor=COLOURS[number] if located else "white",
        )
    axis.axvspan(axis.get_xlim()[0], max(float(found.reference.noise[i]), _LEAST), color="#eeeeee", zorder=0)
    axis.axvline(found.scene.within, color="#555555", linewidth=0.8, linestyle=":")
