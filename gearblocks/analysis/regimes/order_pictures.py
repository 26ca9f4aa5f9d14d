"""Pictures of orders: lines of a steady motion; amplitudes over order and speed."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.pictures import label
from gearblocks.simulation.plotting import COLOURS, finished, legend, new_figure, prefixed, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_SMALL = 1e-3  # of the largest amplitude, where colours begin
_SEEN = 1e-2  # of the largest line or track: what is drawn, two pixels high
_TRACKS = 4


class Lines(Protocol):
    """What is drawn of a steady motion (`line_spectrum.py`)."""

    @property
    def order(self) -> Array: ...
    @property
    def amplitude(self) -> Array: ...
    @property
    def of(self) -> str: ...
    @property
    def unit(self) -> str: ...


class Orders(Protocol):
    """What is drawn of a run-up (`order_map.py`)."""

    @property
    def order(self) -> Array: ...
    @property
    def speed(self) -> Array: ...
    @property
    def amplitude(self) -> Array: ...
    @property
    def of(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def speed_name(self) -> str: ...
    @property
    def speed_unit(self) -> str: ...
    def track(self, order: float) -> Array: ...
    def largest(self, count: int) -> list[float]: ...


def draw_lines(found: Lines, path: str | os.PathLike[str] | None) -> Figure:
    """A line for each order but the mean, up to where all are small."""
    large = np.flatnonzero(found.amplitude[1:] > _SEEN * found.amplitude[1:].max(initial=0.0))
    shown = slice(1, 2 + int(large[-1]) if len(large) else None)
    factor, unit = prefixed([found.amplitude[shown]], found.unit)
    with style():
        figure, (axis,) = new_figure(path, size=(7.2, 2.8))
        axis.vlines(found.order[shown], 0.0, found.amplitude[shown] * factor, color=COLOURS[0], linewidth=1.6)
        axis.set_ylim(bottom=0.0)
        axis.set_xlabel("order: times the frequency of the section")
        axis.set_ylabel(label(found.of, unit))
        return finished(figure, path)


def draw_orders(found: Orders, path: str | os.PathLike[str] | None) -> Figure:
    """Waterfall: amplitudes over order and speed in colours; and the largest orders that are seen as curves over the speed."""
    factor, unit = prefixed([found.amplitude], found.unit)
    from matplotlib.colors import LogNorm

    shown = found.amplitude * factor
    top = float(shown[:, 1:].max(initial=0.0)) or 1.0  # but the mean
    with style():
        figure, (left, right) = new_figure(path, columns=2, size=(10.0, 4.0))
        mesh = left.pcolormesh(
            found.order, found.speed, np.maximum(shown, _SMALL * top), shading="nearest", cmap="viridis", rasterized=True,
            norm=LogNorm(_SMALL * top, top),
        )  # fmt: skip
        figure.colorbar(mesh, ax=left, label=label(found.of, unit))
        left.grid(visible=False)
        left.set_xlabel("order")
        left.set_ylabel(label(found.speed_name, found.speed_unit))
        tracks = {order: found.track(order) * factor for order in found.largest(_TRACKS)}
        least = _SEEN * max((float(track.max()) for track in tracks.values()), default=0.0)
        for colour, (order, track) in zip(COLOURS, tracks.items(), strict=False):
            if track.max() > least:
                right.plot(found.speed, track, color=colour, label=f"order {order:.4g}")
        right.set_xlabel(label(found.speed_name, found.speed_unit))
        right.set_ylabel(label(found.of, unit))
        legend(right)
        return finished(figure, path)
