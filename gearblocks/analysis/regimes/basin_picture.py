"""Picture of basins of attraction: a colour for each attractor."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.pictures import label
from gearblocks.simulation.plotting import COLOURS, finished, new_figure, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_NONE = "#d9d9d9"  # where a run failed
_DRAWN = 400  # points of an attractor


class Attracting(Protocol):
    """An attractor."""

    @property
    def label(self) -> str: ...
    @property
    def period(self) -> int | None: ...
    @property
    def points(self) -> Array: ...
    @property
    def share(self) -> float: ...


class Found(Protocol):
    """What is drawn (`attraction.py`)."""

    @property
    def paths(self) -> tuple[str, str]: ...
    @property
    def units(self) -> tuple[str, str]: ...
    @property
    def levels(self) -> tuple[Array, Array]: ...
    @property
    def numbers(self) -> NDArray[np.int64]: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def attractors(self) -> Sequence[Attracting]: ...


def draw_basins(found: Found, path: str | os.PathLike[str] | None) -> Figure:
    """Basins over both paths; points of the attractors where the paths are outputs that were looked at."""
    from matplotlib.colors import ListedColormap

    count = len(found.attractors)
    colours = [COLOURS[i % len(COLOURS)] for i in range(count)]
    order = np.where(found.numbers == -1, count - 1, found.numbers)  # what does not repeat stands last
    with style():
        figure, (axis,) = new_figure(path, size=(6.6, 5.0))
        shown = np.where(order < 0, 0, order + 1).T
        axis.pcolormesh(
            *found.levels, shown, cmap=ListedColormap([_NONE, *colours]), vmin=-0.5, vmax=count + 0.5, alpha=0.55,
            shading="nearest", rasterized=True, linewidth=0,
        )  # fmt: skip
        drawn = all(p in found.names for p in found.paths)
        places = [found.names.index(p) for p in found.paths] if drawn else []
        for one, colour in zip(found.attractors, colours, strict=True):
            points = one.points[-_DRAWN:, places] if drawn else np.full((1, 2), np.nan)
            words = f"{one.label}: {100 * one.share:.3g} %"
            axis.plot(
                *points.T, "o" if one.period else ".", color=colour, markeredgecolor="black", markeredgewidth=0.6,
                markersize=6, linestyle="none", label=words,
            )  # fmt: skip
        axis.set_xlim(found.levels[0][0], found.levels[0][-1])
        axis.set_ylim(found.levels[1][0], found.levels[1][-1])
        axis.grid(visible=False)
        axis.set_xlabel(label(found.paths[0], found.units[0]))
        axis.set_ylabel(label(found.paths[1], found.units[1]))
        axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return finished(figure, path)
