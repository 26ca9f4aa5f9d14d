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

_FAILED = "#e6e6e6"
_SHARES = (
    0.55,
    0.25,
    0.85,
)  # of the colours, in the cells: of the first attractors that have them, of those after them
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
    """Basins over both paths, and where runs failed; points of the attractors where the paths are outputs that were looked
    at."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    count = len(found.attractors)
    colours = [COLOURS[i % len(COLOURS)] for i in range(count)]
    cells = [_mixed(colour, _SHARES[i // len(COLOURS) % len(_SHARES)]) for i, colour in enumerate(colours)]
    order = np.where(found.numbers == -1, count - 1, found.numbers)  # what does not repeat stands last
    failed = order < 0
    with style():
        figure, (axis,) = new_figure(path, size=(6.6, 5.0))
        shown = np.where(failed, 0, order + 1).T
        axis.pcolormesh(
            *found.levels, shown, cmap=ListedColormap([_FAILED, *cells]), vmin=-0.5, vmax=count + 0.5, shading="nearest",
            rasterized=True, linewidth=0,
        )  # fmt: skip
        drawn = all(p in found.names for p in found.paths)
        places = [found.names.index(p) for p in found.paths] if drawn else []
        for one, colour in zip(found.attractors, colours, strict=True) if drawn else ():
            axis.plot(
                *one.points[-_DRAWN:, places].T, "o" if one.period else ".", color=colour, markeredgecolor="black",
                markeredgewidth=0.6, markersize=6, linestyle="none",
            )  # fmt: skip
        axis.set_xlim(*_edges(found.levels[0]))
        axis.set_ylim(*_edges(found.levels[1]))
        axis.grid(visible=False)
        axis.set_xlabel(label(found.paths[0], found.units[0]))
        axis.set_ylabel(label(found.paths[1], found.units[1]))
        listed = [
            Patch(color=cell, label=f"{one.label}: {100 * one.share:.3g} %")
            for one, cell in zip(found.attractors, cells, strict=True)
        ]
        if failed.any():
            listed.append(Patch(color=_FAILED, label=f"run failed: {100 * failed.mean():.3g} %"))
        axis.legend(handles=listed, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return finished(figure, path)


def _edges(levels: Array) -> tuple[float, float]:
    """Where the cells of levels begin and end."""
    half = 0.5 * np.diff(levels)
    return float(levels[0] - half[0]), float(levels[-1] + half[-1])


def _mixed(colour: str, share: float) -> str:
    """A colour with white."""
    from matplotlib.colors import to_hex, to_rgb

    return str(to_hex([1 - share * (1 - x) for x in to_rgb(colour)]))
