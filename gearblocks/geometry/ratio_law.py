"""Ratio laws (transmission functions) of non-circular gear pairs: F(phi) and m = F'(phi) = w2/w1 > 0.

Knows nothing of blocks, trains or loads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearblocks.errors import ParameterError, arguments_told
from gearblocks.geometry.pitch_curves import PitchPair
from gearblocks.geometry.planet_assembly import PlanetAssembly, planet_assembly
from gearblocks.geometry.ratio_curves import TURN, Array, Curve, Ellipse, Extremes, RatioLawError, extremes
from gearblocks.geometry.ratio_fit import Fit, driver_angle, from_function, from_table, largest_segment, segments
from gearblocks.geometry.ratio_inverse import inverse_fit, joints_of
from gearblocks.language.expression import finite_number
from gearblocks.language.tidy import Tidy


@arguments_told
@dataclass(frozen=True, eq=False)
class RatioLaw(metaclass=Tidy):
    """The angle F(phi) of gear 2 over the angle phi of gear 1 (both from the carrier, F(0) = 0) and m = F' > 0.

        F(phi) = n1/n2 phi + ripple(phi)        n1, n2: how often the law repeats in a turn of gear 1 and of gear 2

    Made by `segments`, `ellipse`, `from_function` and `from_table`; equal where it was made from the same values.
    recipe: the way it was made and its values. fit_error: the largest error of m against the function that it was
    fitted to (0: exact). scaled: the factor on m that closed the curves (1: none was needed).
    """

    recipe: tuple[str, tuple[Any, ...]]
    n1: int
    n2: int
    curve: Curve
    fit_error: float = 0.0
    scaled: float = 1.0

    def __post_init__(self) -> None:
        low = self.m_range
        if low.smallest <= 0:
            message = f"m = {low.smallest:.9g} at phi = {math.degrees(low.smallest_at):.6g} deg, but m must stay > 0"
            raise RatioLawError(f"{self!r}: {message}", low.smallest, low.smallest_at)

    # -- how laws are made ---------------------------------------------------------------------------------------------

    @staticmethod
    def segments(k: float, b: float, X: float, T: float = TURN, G: float = TURN) -> RatioLaw:
        """m = k phi + b on [0, X], and a transition on [X, T] that makes m, m' and m'' continuous and F(T) = G.

        k in 1/rad; X, T, G in rad. The joints 0 and X are located in a run (m''' jumps there). Raises RatioLawError.
        """
        fit = segments(*(finite_number(f"RatioLaw: {n}", v) for n, v in zip("kbXTG", (k, b, X, T, G), strict=True)))
        try:
            return RatioLaw._of(fit)
        except RatioLawError as error:
            largest = largest_segment(k, b, fit.n1, fit.n2)
            way_out = (
                "no working segment is possible with this k and b"
                if largest is None
                else f"with this k and b the largest feasible X is {math.degrees(largest):.2f} deg"
            )
            raise RatioLawError(f"{error}; {way_out}", error.m_min, error.at, largest) from None

    @staticmethod
    def ellipse(e: float, order: int = 1) -> RatioLaw:
        """Two equal ellipses about a focus (order 1), or their relatives with `order` lobes: tan(F/2) = K tan(phi/2).

        e: eccentricity, 0 <= e < 1; K = (1 + e)/(1 - e); m runs from 1/K to K. The pitch curve is
        r = p/(1 - e cos(order phi)) and the centre distance 2 p/(1 - e^2): with any other distance the mate is no equal
        one, and does not even close (see `from_function`).
        """
        e = finite_number("RatioLaw.ellipse: e", e)
        if not 0 <= e < 1:
            raise RatioLawError(f"RatioLaw.ellipse: e = {e!r} must be >= 0 and < 1")
        if isinstance(order, bool) or not isinstance(order, int) or order < 1:
            raise RatioLawError(f"RatioLaw.ellipse: order = {order!r} must be a whole number >= 1")
        return RatioLaw(("ellipse", (e, order)), order, order, Ellipse(e, order))

    @staticmethod
    def from_function(m: Any, T: float = TURN, normalise: bool = False) -> RatioLaw:
        """m as an expression of gb.driver_angle (or a sympy expression of one symbol), with the period T [rad].

        Sums of sines and cosines are integrated exactly; anything else smooth becomes polynomials (see fit_error).
        Gear 2 must close: the gain of F over a period must be 2 pi over a whole number. normalise=True scales m to the
        nearest such gain (see scaled). Raises RatioLawError.
        """
        return RatioLaw._of(from_function(m, finite_number("RatioLaw.from_function: T", T), bool(normalise)))

    @staticmethod
    def from_table(phi: ArrayLike, m: ArrayLike, normalise: bool = False) -> RatioLaw:
        """Points (phi [rad], m) of one period, joined by a cubic spline; m[-1] = m[0]. The points are located in a run.

        Gear 2 must close, as for `from_function`. Raises RatioLawError.
        """
        return RatioLaw._of(from_table(phi, m, bool(normalise)))

    @staticmethod
    def _of(fit: Fit) -> RatioLaw:
        return RatioLaw(fit.recipe, fit.n1, fit.n2, fit.curve, fit.fit_error, fit.scaled)

    # -- values --------------------------------------------------------------------------------------------------------

    @property
    def ratio(self) -> float:
        """Mean ratio n1/n2, turns of gear 2 per turn of gear 1."""
        return self.n1 / self.n2

    @property
    def period(self) -> float:
        """Angle of gear 1 [rad] after which the law repeats."""
        return TURN / self.n1

    @property
    def gain(self) -> float:
        """Angle of gear 2 [rad] over one period."""
        return TURN / self.n2

    def F(self, phi: ArrayLike) -> Array:
        """Angle of gear 2 [rad] at the angle phi [rad] of gear 1, of any shape. See `split` for large angles."""
        phi = np.asarray(phi, dtype=float)
        return np.asarray(self.ratio * phi + self.curve.value(phi))

    def m(self, phi: ArrayLike) -> Array:
        """Ratio w2/w1 at phi [rad]."""
        return self.ratio + self.curve.value(phi, 1)

    def dm(self, phi: ArrayLike, order: int = 1) -> Array:
        """Derivative of m by phi (order 1 to 3)."""
        return self.curve.value(phi, order + 1)

    def split(self, phi: ArrayLike, turns: ArrayLike = 0) -> tuple[Array, Array]:
        """Whole turns of gear 2 and the angle [rad] in [0, 2 pi) beyond them.

        Gear 1 stands at `turns` whole turns and phi beside. However many turns, the rest is as good as F(phi).
        """
        lobes = np.asarray(turns, dtype=np.int64) * self.n1
        angle = self.F(phi) + (lobes % self.n2) * self.gain
        more = np.floor(angle / TURN)
        return np.asarray(lobes // self.n2 + more, dtype=float), np.asarray(angle - more * TURN)

    def inverse(self, angle: ArrayLike) -> Array:
        """Angle of gear 1 [rad] at which gear 2 stands at the given angle [rad]: Newton's method inside of bounds."""
        angle = np.asarray(angle, dtype=float)
        whole = np.floor(angle / self.gain)
        rest = angle - whole * self.gain
        low, high = np.zeros_like(rest), np.full_like(rest, self.period)
        phi = 0.5 * (low + high)
        for _ in range(60):
            wrong = self.F(phi) - rest
            low, high = np.where(wrong < 0, phi, low), np.where(wrong < 0, high, phi)
            step = phi - wrong / self.m(phi)
            phi = np.where((step >= low) & (step <= high), step, 0.5 * (low + high))
        return np.asarray(phi + whole * self.period)

    @cached_property
    def inverted(self) -> RatioLaw:
        """The law of the same pair with gear 2 as the driver: its F is the inverse of this one's.

        Exact for ellipses, else fitted to rounding (see fit_error). Raises RatioLawError or ParameterError where m changes too
        fast.
        """
        fit = Fit(self.recipe, self.n1, self.n2, self.curve, self.fit_error, self.scaled)
        joints = joints_of(self.curve, self.period, self.F)
        return RatioLaw._of(inverse_fit(fit, lambda y: 1 / self.m(self.inverse(y)), self.gain, joints))

    @cached_property
    def m_range(self) -> Extremes:
        """Smallest and largest m."""
        return extremes(self.m, self.dm, self.period)

    def pressure_angle_increment(self, phi: ArrayLike) -> Array:
        """atan(m'/(m (1 + m))) [rad]: what an external pair adds to the pressure angle of its teeth."""
        m = self.m(phi)
        return np.asarray(np.arctan2(self.dm(phi), m * (1 + m)))

    def pair(self, distance: float) -> PitchPair:
        """The pitch curves of an external pair with the centre distance [m], their curvature, teeth and limits."""
        distance = finite_number("RatioLaw.pair: distance", distance)
        if distance <= 0:
            raise ParameterError(f"RatioLaw.pair: distance = {distance!r} m must be > 0")
        return PitchPair(self, distance)

    def planet_assembly(self, row_phase: float, spacing: float) -> PlanetAssembly:
        """Whether a second planet, `spacing` [rad] further on, fits beside one whose two rows turn suns by this law, row 2
        ahead by row_phase [rad]; print it for a sentence."""
        return planet_assembly(self, row_phase, spacing)

    # -- identity ------------------------------------------------------------------------------------------------------

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RatioLaw) and self.recipe == other.recipe

    def __hash__(self) -> int:
        return hash(self.recipe)

    def __repr__(self) -> str:
        how, values = self.recipe
        return f"RatioLaw.{how}({', '.join(repr(v) for v in values)})"


__all__ = ["Extremes", "RatioLaw", "RatioLawError", "driver_angle", "extremes"]
