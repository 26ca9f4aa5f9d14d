"""Pictures of the laboratory: what exponents came to, period by period; points of a section over a parameter."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.simulation.plotting import COLOURS, NO_UNIT, finished, legend, new_figure, prefixed, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_DRAWN = 8  # exponents


class OverParameter(Protocol):
    """What is drawn over a parameter: its path and unit, its values, the output and its unit."""

    @property
    def path(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def values(self) -> Array: ...
    @property
    def of(self) -> str: ...
    @property
    def of_unit(self) -> str: ...


def label(words: str, unit: str) -> str:
    """Words of an axis."""
    return words if unit in NO_UNIT else f"{words} in {unit}"


class Diagram(OverParameter, Protocol):
    """What is drawn (`bifurcation.py`)."""

    @property
    def points(self) -> Array: ...
    @property
    def directions(self) -> tuple[str, ...]: ...


def draw_bifurcation(found: Diagram, path: str | os.PathLike[str] | None) -> Figure:
    """A dot for each point, those of the way up and of the way down in two colours."""
    with style():
        figure, (axis,) = new_figure(path, size=(7.2, 4.2))
        factor, unit = prefixed([found.points], found.of_unit)
        for i, words in reversed([*enumerate(found.directions)]):
            x = np.repeat(found.values, found.points.shape[2])
            axis.plot(
                x, found.points[i].ravel() * factor, ".", markersize=2.4 if i else 1.2, color=COLOURS[i], label=words
            )
        axis.set_xlabel(label(found.path, found.unit))
        axis.set_ylabel(label(found.of, unit))
        if len(found.directions) > 1:
            legend(axis, markerscale=6)
        return finished(figure, path)


class History(Protocol):
    """What is drawn (`exponents.py`)."""

    @property
    def history(self) -> Array: ...
    @property
    def values(self) -> Array: ...
    @property
    def errors(self) -> Array: ...


def draw_history(found: History, path: str | os.PathLike[str] | None) -> Figure:
    """A line for each exponent, and its value with three standard errors as a band and in words."""
    history = found.history
    with style():
        figure, (axis,) = new_figure(path, size=(7.4, 4.0))
        for j in range(min(history.shape[1], _DRAWN)):
            colour, value, error = COLOURS[j % len(COLOURS)], float(found.values[j]), 3 * float(found.errors[j])
            words = f"{value:.4g} \N{PLUS-MINUS SIGN} {error:.2g}"
            axis.semilogx(np.arange(1, len(history) + 1), history[:, j], color=colour, label=words)
            axis.axhspan(value - error, value + error, color=colour, alpha=0.2, linewidth=0)
        axis.axhline(0.0, color="0.5", linewidth=0.8)
        axis.set_xlabel("periods of the section")
        axis.set_ylabel("Lyapunov exponents in 1/s")
        title = "in 1/s, \N{PLUS-MINUS SIGN} 3 errors"
        if history.shape[1] > _DRAWN:
            title = f"first {_DRAWN} of {history.shape[1]},\n{title}"
        legend(axis, title=title, title_fontsize=8, alignment="left", loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return finished(figure, path)
