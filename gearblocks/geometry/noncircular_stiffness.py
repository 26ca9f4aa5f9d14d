"""Mesh stiffness of a non-circular pair over the angle: ISO 6336-1, method B, with equivalent tooth numbers.

    Ze = 2 rho/module,    k = CM CR b/q'(1/Ze1, 1/Ze2, x1, x2)

rho: radius of curvature of the pitch curve at the pitch point, where a cylindrical gear of that radius stands for the
non-circular one. k is that of one tooth pair; how many share the load does not enter. Knows nothing of blocks.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import ParameterError
from gearblocks.geometry.involute import flexibility
from gearblocks.language.expression import finite_number

Array = NDArray[np.float64]


class Curved(Protocol):
    """A pair of pitch curves, as far as their curvature goes (`PitchPair`)."""

    def curvature_at(self, phi: ArrayLike, gear: int) -> Array: ...


def equivalent_teeth(pair: Curved, phi: ArrayLike, gear: int, module: float) -> Array:
    """Ze of gear 1 or 2 where gear 1 stands at phi [rad]; negative where the pitch curve is concave (an internal gear)."""
    if finite_number("equivalent_teeth: module", module) <= 0:
        raise ParameterError(f"equivalent_teeth: module = {module!r} m must be > 0")
    with np.errstate(divide="ignore"):
        return np.asarray(2 / (pair.curvature_at(phi, gear) * module))


def mesh_stiffness(
    pair: Curved, phi: ArrayLike, module: float, face_width: float, shifts: tuple[float, float], factor: float
) -> Array:  # fmt: skip
    """k [N/m] along the line of action where gear 1 stands at phi [rad]; factor: CM CR, b: face_width [m]."""
    for name, value in (("face_width", face_width), ("factor", factor)):
        if finite_number(f"mesh_stiffness: {name}", value) <= 0:
            raise ParameterError(f"mesh_stiffness: {name} = {value!r} must be > 0")
    inverse: list[Any] = [1 / equivalent_teeth(pair, phi, gear, module) for gear in (1, 2)]
    if min(np.min(one) for one in inverse) < 0:
        worst = 1 + int(np.argmin([np.min(one) for one in inverse]))
        raise ParameterError(
            f"mesh_stiffness: the pitch curve of gear {worst} is concave where it meshes, and ISO 6336-1 knows no gear that "
            "stands for it; pair.curvatures says where, and a longer transition makes it convex"
        )
    q = flexibility((inverse[0], inverse[1]), shifts)
    return np.asarray(1e9 * factor * face_width / q)
