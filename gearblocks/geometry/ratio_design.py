"""Design of a non-circular gear pair whose ratio is m = k phi + b on [0, X] with a transition that closes the curve.

Knows nothing of blocks, nor of loads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gearblocks.errors import by_name_only
from gearblocks.geometry.pitch_curves import GRID, PitchPair
from gearblocks.geometry.ratio_curves import TURN
from gearblocks.geometry.ratio_law import RatioLaw


@dataclass(frozen=True, slots=True)
class RatioDesign:
    """A law of `RatioLaw.segments` with what a designer asks first. Angles in rad, lengths in m.

    pressure_angle_increment: the largest; module: the largest without undercut at 20 deg and a rack addendum of 1.15.
    """

    law: RatioLaw
    pair: PitchPair
    transition: float
    pressure_angle_increment: float
    pressure_angle_increment_at: float
    module: float


@by_name_only
def design_ratio(k: float, b: float, X: float, E: float, n: float = 1.0) -> RatioDesign:
    """The law m = k phi + b on [0, X] with the mean ratio n, and its pair with the centre distance E [m].

    transition: the C of the transition (see RatioLaw.segments). Raises RatioLawError where no such pair exists.
    """
    from gearblocks.geometry.ratio_fit import transition_size

    law = RatioLaw.segments(k, b, X, TURN, n * TURN)
    pair = law.pair(E)
    phi = np.linspace(0.0, TURN, GRID + 1)
    coarse = np.abs(law.pressure_angle_increment(phi))
    near = np.linspace(-1, 1, 2001) * TURN / GRID + phi[int(coarse.argmax())]
    fine = np.abs(law.pressure_angle_increment(near))
    best = int(fine.argmax())
    return RatioDesign(
        law, pair, transition_size(k, b, X, TURN, n * TURN), float(fine[best]), float(near[best]),
        pair.largest_module(math.radians(20), 1.15),
    )  # fmt: skip
