"""The picture of modes: motion of the bodies and shares of the strain energy, a row for each mode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearblocks.simulation.plotting import COLOURS, finished, new_figure, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELLED = 30  # bodies or elements that still have room for their names


def shapes(modes: Any, path: Any, most: int) -> Figure:
    """One row per mode: motion of the bodies on the left, shares of the strain energy on the right."""
    chosen = range(modes.free, min(len(modes), modes.free + most)) or range(min(len(modes), most))
    with style():
        figure, axes = new_figure(
            path, rows=max(1, len(chosen)), columns=2, size=(9.0, 0.8 + 1.25 * max(1, len(chosen)))
        )
        for row, i in enumerate(chosen):
            left, right = axes[2 * row], axes[2 * row + 1]
            _shape(left, modes, i)
            _shares(right, modes, i)
            last = row == len(chosen) - 1
            _names(left, modes.bodies, last)
            _names(right, modes.elements, last)
        axes[0].set_title("motion of the bodies")
        axes[1].set_title("share of the strain energy")
        figure.suptitle(f"modes of {modes.name}", x=0.01, ha="left", fontsize=10)
        return finished(figure, path)


def _shape(axis: Axes, modes: Any, i: int) -> None:
    position = np.arange(len(modes.bodies))
    few = len(position) <= 60
    axis.axhline(0.0, color="#888888", linewidth=0.7)
    axis.plot(position, modes.shapes[i].real, color=COLOURS[0], marker="o" if few else "", markersize=4)
    axis.set_ylim(-1.15, 1.15)
    damping = f"\n{100 * modes.damping[i]:.2g} % damped" if modes.damping[i] > 1e-9 else ""
    axis.set_ylabel(f"{modes.hertz[i]:.5g} Hz{damping}", rotation=0, ha="right", va="center")


def _shares(axis: Axes, modes: Any, i: int) -> None:
    axis.bar(np.arange(len(modes.elements)), 100 * modes.strain[i], color=COLOURS[1], width=0.6)
    axis.set_ylim(0.0, 100.0)
    axis.set_ylabel("%")


def _names(axis: Axes, names: tuple[str, ...], last: bool) -> None:
    axis.set_xlim(-0.5, max(len(names) - 0.5, 0.5))
    if len(names) > _LABELLED:
        axis.locator_params(axis="x", integer=True)
        axis.set_xlabel("number in the list" if last else "")
        axis.tick_params(labelbottom=last)
        return
    long = len(names) > 6 or any(len(name) > 10 for name in names)
    turned: dict[str, Any] = {"rotation": 60, "ha": "right", "rotation_mode": "anchor"} if long else {}
    axis.set_xticks(np.arange(len(names)), names if last else [""] * len(names), **turned)
    axis.tick_params(axis="x", labelsize=7 if len(names) > 14 else 9)
