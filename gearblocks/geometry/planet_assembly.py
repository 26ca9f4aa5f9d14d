"""Assembly of double-row non-circular planets (W-W) between two suns: do several of them fit at once?

Row 1 of a planet meshes with the fixed sun 1, row 2, ahead by the row phase beta, with sun 2. Over the angle psi of the carrier

    F(chi) = F(psi) + beta,    sun 2 turns by  psi - [chi(psi) - chi(0)]

A planet further on by an angle d on the carrier asks of sun 2 the same with psi + d. Both fit where the difference is constant.
Knows nothing of teeth, nor of blocks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import ParameterError
from gearblocks.language.expression import finite_number

Array = NDArray[np.float64]

_GRID = 1440  # angles of a turn
_ALIKE = 1e-9  # [rad]


class Turning(Protocol):
    """F(phi) and its inverse (`RatioLaw`)."""

    def F(self, phi: ArrayLike) -> Array: ...
    def inverse(self, angle: ArrayLike) -> Array: ...


@dataclass(frozen=True, slots=True)
class PlanetAssembly:
    """Whether a second planet fits. mismatch [rad]: how far, from peak to peak, the angles of sun 2 differ that the two ask for
    over a turn of the carrier; least [rad]: the smallest mismatch of any row phase of the second planet, which is then
    `nearest` [rad]; swing [rad]: of sun 2, from peak to peak."""

    row_phase: float
    spacing: float
    mismatch: float
    least: float
    nearest: float
    swing: float

    @property
    def fits(self) -> bool:
        """Whether two equal planets can be assembled."""
        return self.mismatch <= _ALIKE

    def __str__(self) -> str:
        apart = f"two planets {math.degrees(self.spacing):g} deg apart with a row phase of {math.degrees(self.row_phase):g} deg"
        if self.fits:
            return f"{apart} can be assembled"
        mismatch, least, nearest = (math.degrees(x) for x in (self.mismatch, self.least, self.nearest))
        return (
            f"{apart} cannot be assembled: they ask of the second sun angles that differ by {mismatch:.1f} deg; with a row "
            f"phase of {nearest:.3g} deg for the second one {least:.1f} deg are left. Give each planet suns of its own, turned "
            "by the same angle, or a row phase of 0 (no swing)"
        )


def planet_assembly(law: Turning, row_phase: float, spacing: float) -> PlanetAssembly:
    """Whether a planet `spacing` [rad] further on fits beside one with the row phase beta [rad]."""
    from scipy.optimize import minimize_scalar

    for name, value in (("row_phase", row_phase), ("spacing", spacing)):
        if not math.isfinite(finite_number(f"planet_assembly: {name}", value)):
            raise ParameterError(f"planet_assembly: {name} = {value!r} rad must be a number")
    psi = 2 * np.pi * np.arange(_GRID + 1) / _GRID
    first = law.inverse(law.F(psi) + row_phase)
    ahead = law.F(psi + spacing)

    def mismatch(phase: float, every: int = 1) -> float:
        return float(np.ptp(law.inverse(ahead[::every] + phase) - first[::every]))

    step = 2 * np.pi / 72
    phases = step * np.arange(72) - np.pi
    near = float(phases[int(np.argmin([mismatch(phase, 20) for phase in phases]))])
    best = minimize_scalar(mismatch, bounds=(near - step, near + step), method="bounded", options={"xatol": 1e-6})
    candidates = [(float(best.fun), float(best.x)), (mismatch(row_phase), row_phase)]
    least, nearest = min(candidates)
    return PlanetAssembly(row_phase, spacing, candidates[1][0], least, nearest, float(np.ptp(psi - first)))
