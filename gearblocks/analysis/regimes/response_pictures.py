"""Pictures of responses over a parameter: sweeps with their jumps, branches of orbits with what is marked on them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.carried import Jump
from gearblocks.analysis.regimes.pictures import OverParameter, label
from gearblocks.simulation.plotting import COLOURS, MARKERS, finished, legend, new_figure, prefixed, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


class Sweep(OverParameter, Protocol):
    """What is drawn (`swept_speed.py`)."""

    @property
    def rms(self) -> Array: ...
    @property
    def peak_to_peak(self) -> Array: ...
    @property
    def jumps(self) -> Sequence[Jump]: ...


def draw_sweep(found: Sweep, path: str | os.PathLike[str] | None) -> Figure:
    """Root mean square and peak-to-peak, each way in its colour, jumps as bands."""
    with style():
        figure, axes = new_figure(path, rows=2, size=(7.2, 5.2))
        for axis, words, values in zip(axes, ("rms", "peak-to-peak"), (found.rms, found.peak_to_peak), strict=True):
            factor, unit = prefixed([values], found.of_unit)
            for i, way in ((1, "down"), (0, "up")):
                axis.plot(found.values, values[i] * factor, ".-", markersize=4 + 4 * i, color=COLOURS[i], label=way)
            for i, jump in enumerate(found.jumps):
                colour = COLOURS[jump.direction == "down"]
                first = jump.direction not in {other.direction for other in found.jumps[:i]}
                axis.axvspan(
                    jump.last, jump.first, color=colour, alpha=0.4, linewidth=1.2, zorder=0,
                    label=f"jump on the way {jump.direction}" if first else None,
                )  # fmt: skip
            axis.set_ylabel(label(words, unit))
        legend(axes[0])
        axes[0].set_title(found.of)
        axes[1].set_xlabel(label(found.path, found.unit))
        return finished(figure, path)


class Branch(OverParameter, Protocol):
    """What is drawn (`branch.py`)."""

    @property
    def rms(self) -> Array: ...
    @property
    def stable(self) -> NDArray[np.bool_]: ...
    @property
    def marks(self) -> Sequence[Marked]: ...


class Marked(Protocol):
    """What is marked on a branch."""

    @property
    def kind(self) -> str: ...
    @property
    def value(self) -> float: ...
    @property
    def number(self) -> int: ...


def draw_branch(found: Branch, path: str | os.PathLike[str] | None) -> Figure:
    """Root mean square over the parameter: stable orbits as a line, others dashed; a mark where something happens."""
    with style():
        figure, (axis,) = new_figure(path, size=(7.2, 4.2))
        factor, unit = prefixed([found.rms], found.of_unit)
        rms, stable = found.rms * factor, found.stable
        for kept, dashes, words in ((stable, "-", "stable"), (~stable, "--", "unstable")):
            joined = kept.copy()
            if words == "unstable":  # drawn up to the stable orbits beside; an orbit between these is a dot
                joined[1:] |= kept[:-1]
                joined[:-1] |= kept[1:]
            alone = joined & ~np.append(joined[1:], False) & ~np.append(False, joined[:-1])
            axis.plot(
                found.values, np.where(joined, rms, np.nan), dashes, color=COLOURS[0], marker="." if alone.any() else "",
                markevery=np.flatnonzero(alone).tolist(), label=words,
            )  # fmt: skip
        kinds = dict.fromkeys(mark.kind for mark in found.marks)
        for i, kind in enumerate(kinds):
            values = [mark.value for mark in found.marks if mark.kind == kind]
            heights = [rms[mark.number : mark.number + 2].mean() for mark in found.marks if mark.kind == kind]
            axis.plot(values, heights, MARKERS[i], color=COLOURS[1 + i], markersize=6, linestyle="none", label=kind)
        axis.set_xlabel(label(found.path, found.unit))
        axis.set_ylabel(label(f"rms of {found.of}", unit))
        legend(axis)
        return finished(figure, path)
