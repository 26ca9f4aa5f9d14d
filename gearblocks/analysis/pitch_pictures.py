"""Pictures of a non-circular pair: pitch curves that roll on each other, with their teeth, at several angles of gear 1."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearblocks.errors import ParameterError, by_name_only
from gearblocks.geometry.pitch_curves import Flanks, PitchPair
from gearblocks.simulation.plotting import COLOURS, finished, style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_POINTS = 721
_MOST = 12  # positions


@by_name_only
def draw_pitch_curves(
    pair: PitchPair, path: str | os.PathLike[str] | None = None, *, angles: Sequence[float] = (0.0, math.pi / 2, math.pi),
    flanks: tuple[Flanks | None, Flanks | None] = (None, None),
) -> Figure:  # fmt: skip
    """Pitch curves of both gears where gear 1 stands at these angles [rad], side by side; saved where a path is given.

    pair: as of law.pair(distance); flanks: the teeth of gear 1 and of gear 2, as of pair.flanks(...), or None. A dot is the
    pitch point, a stroke from each axis the angle that its gear has turned by.
    """
    if not isinstance(pair, PitchPair):
        raise ParameterError(f"draw_pitch_curves: pair = {pair!r:.80} must be a pair such as law.pair(0.2)")
    if not 1 <= len(angles) <= _MOST or not np.isfinite(np.asarray(angles, dtype=float)).all():
        raise ParameterError(f"draw_pitch_curves: angles = {angles!r:.80} must be 1 to {_MOST} angles in rad")
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(3.6 * len(angles), 3.4), layout="constrained")
        axes: Any = figure.subplots(1, len(angles), squeeze=False, sharex=True, sharey=True)[0]
        for axis, phi in zip(axes, angles, strict=True):
            _position(axis, pair, float(phi), flanks)
            axis.set_title(f"gear 1 at {math.degrees(phi):.4g} deg, gear 2 at {math.degrees(pair.law.F(phi)):.4g} deg")
            axis.set_xlabel("x in mm")
        axes[0].set_ylabel("y in mm")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower left", ncols=3)
        return finished(figure, path)


def _position(axis: Any, pair: PitchPair, phi: float, flanks: tuple[Flanks | None, Flanks | None]) -> None:
    for gear in (1, 2):
        turn = np.linspace(
            0.0, 2 * np.pi * (1 if gear == 1 else pair.law.n2 / math.gcd(pair.law.n1, pair.law.n2)), _POINTS
        )
        colour = COLOURS[gear - 1]
        x, y = pair.placed(phi, gear, *pair.points(turn, gear))
        axis.plot(1e3 * x, 1e3 * y, color=colour, linewidth=1.0, label=f"gear {gear}")
        teeth = flanks[gear - 1]
        if teeth is not None:
            x, y = pair.placed(phi, gear, teeth.x, teeth.y)
            axis.plot(1e3 * x.T, 1e3 * y.T, color=colour, linewidth=0.5)
        centre, mark = ((pair.distance * (gear - 1), 0.0), pair.placed(phi, gear, *pair.points(0.0, gear)))
        axis.plot(*(1e3 * np.array([centre[i], float(mark[i])]) for i in (0, 1)), color=colour, linewidth=0.6)
        axis.plot(1e3 * centre[0], 0.0, "+", color=colour, markersize=5)
    axis.plot(
        1e3 * float(pair.radii(phi)[0]), 0.0, ".", color="black", markersize=4, linestyle="none", label="pitch point"
    )
    axis.set_aspect("equal")
    axis.grid(visible=False)
