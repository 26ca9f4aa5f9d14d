"""Involute gear pairs in the transverse section (ISO 21771), and their mesh stiffness after ISO 6336-1, method B.

Every function takes numbers, or symbols with the functions that go with them. Knows nothing of blocks, nor of sympy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

_C = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
"""C1 to C9 of ISO 6336-1 [mm um/N]."""


def inverse_involute(y: float) -> float:
    """The angle a [rad] with tan(a) - a = y, for 0 <= y; NaN for y < 0: there is no such angle."""
    if not y > 0.0:
        return 0.0 if y == 0.0 else math.nan
    a = min(math.cbrt(3.0 * y), 1.5)
    for _ in range(40):  # the function is convex: after one step Newton falls onto the root from above
        t = math.tan(a)
        step = (t - a - y) / (t * t)
        a -= step
        if abs(step) <= 1e-16:
            break
    return a


class Functions(NamedTuple):
    """Elementary functions that geometry computes with: of numbers, or of symbols."""

    sqrt: Callable[[Any], Any] = math.sqrt
    sin: Callable[[Any], Any] = math.sin
    cos: Callable[[Any], Any] = math.cos
    tan: Callable[[Any], Any] = math.tan
    atan: Callable[[Any], Any] = math.atan
    inverse_involute: Callable[[Any], Any] = inverse_involute
    pi: Any = math.pi


NUMBERS = Functions()


def unnamed(_symbol: str, quantity: Any, _words: str = "", _unit: str = "1") -> Any:
    """The quantity as it is: in computation, nothing has a name of its own."""
    return quantity


@dataclass(frozen=True, slots=True)
class ToothPair:
    """Two involute gears. z2 < 0: an internal gear (ISO 21771), whose radii are then negative too.

    module: normal module [m]; pressure_angle, helix_angle [rad]; shifts: profile shifts (x1, x2) over the module, positive
    towards the tip, None: none; addendum: over the module. Tips are not shortened. f: the functions to compute with; named:
    (symbol, quantity, words, unit) -> what stands for a quantity, which is its symbol in equations for people.
    """

    z1: Any
    z2: Any
    module: Any
    pressure_angle: Any
    helix_angle: Any = 0
    shifts: tuple[Any, Any] | None = None
    addendum: Any = 1
    f: Functions = NUMBERS
    named: Callable[..., Any] = unnamed

    @property
    def transverse_angle(self) -> Any:
        """Pressure angle in the transverse section at the reference circles [rad]."""
        if self.helix_angle == 0:
            return self.pressure_angle
        angle = self.f.atan(self.f.tan(self.pressure_angle) / self.f.cos(self.helix_angle))
        return self.named("alpha_t", angle, "transverse pressure angle", "rad")

    @property
    def working_angle(self) -> Any:
        """Working pressure angle [rad]: inv a_w = inv a_t + 2 tan(a_n) (x1 + x2) / (z1 + z2)."""
        angle = self.transverse_angle
        if self.shifts is None:
            return angle
        shift = 2 * self.f.tan(self.pressure_angle) * (self.shifts[0] + self.shifts[1]) / (self.z1 + self.z2)
        working = self.f.inverse_involute(self.f.tan(angle) - angle + shift)
        return self.named("alpha_w", working, "working pressure angle", "rad")

    @property
    def base_radii(self) -> tuple[Any, Any]:
        """Base radii [m], signed like z."""
        radius = self.module * self.z1 / (2 * self.f.cos(self.helix_angle)) * self.f.cos(self.transverse_angle)
        first = self.named("r_1", radius, "base radius of gear 1", "m")
        return first, self._of_gear_2("r_2", first * self.z2 / self.z1, "base radius of gear 2")

    @property
    def tip_radii(self) -> tuple[Any, Any]:
        """Tip radii [m], signed like z."""
        first, second = (
            self.module * z / (2 * self.f.cos(self.helix_angle)) + self.module * (self.addendum + shift)
            for z, shift in zip((self.z1, self.z2), self.shifts or (0, 0), strict=True)
        )
        words = "tip radius of gear"
        return self.named("r_a1", first, f"{words} 1", "m"), self._of_gear_2("r_a2", second, f"{words} 2")

    def _of_gear_2(self, symbol: str, radius: Any, words: str) -> Any:
        """A radius of gear 2; the name is that of its size."""
        return -self.named(symbol, -radius, words, "m") if self.is_internal else self.named(symbol, radius, words, "m")

    @property
    def base_pitch(self) -> Any:
        """Transverse base pitch [m]: the way along the line of action from one tooth to the next."""
        pitch = self.f.pi * self.module * self.f.cos(self.transverse_angle) / self.f.cos(self.helix_angle)
        return self.named("p_b", pitch, "transverse base pitch", "m")

    @property
    def lever_arms(self) -> tuple[Any, Any]:
        """Lever arms of friction at the pitch point [m]: radii of curvature r_b tan(a_w), signed like z."""
        t = self.f.tan(self.working_angle)
        first, second = (
            self.named(f"rho_{gear}", radius * t, f"lever arm of friction on gear {gear} at the pitch point", "m")
            for gear, radius in enumerate(self.base_radii, 1)
        )
        return first, second

    @property
    def path(self) -> tuple[Any, Any]:
        """(approach, recess): lengths of the path of contact before and after the pitch point [m], gear 1 driving."""
        reaches = [self.f.sqrt(tip**2 - base**2) for tip, base in zip(self.tip_radii, self.base_radii, strict=True)]
        arms = self.lever_arms
        approach = (-reaches[1] if self.is_internal else reaches[1]) - arms[1]
        words = "length of the path of contact, gear 1 driving"
        return (
            self.named("g_f", approach, f"{words}, before the pitch point", "m"),
            self.named("g_a", reaches[0] - arms[0], f"{words}, behind it", "m"),
        )

    @property
    def is_internal(self) -> bool:
        """Whether gear 2 is internal; symbols are asked for a minus sign in front."""
        return bool(self.z2 < 0) if isinstance(self.z2, (int, float)) else bool(self.z2.could_extract_minus_sign())

    @property
    def contact_ratio(self) -> Any:
        """Transverse contact ratio: how many tooth pairs are in contact on average."""
        approach, recess = self.path
        return self.named("epsilon_alpha", (approach + recess) / self.base_pitch, "transverse contact ratio")


def flexibility(inverse: tuple[Any, Any], x: tuple[Any, Any]) -> Any:
    """q' of ISO 6336-1 [mm um/N] of a tooth pair: inverse: (1/zn1, 1/zn2), x: profile shifts over the module."""
    q = _C[0] + _C[1] * inverse[0] + _C[2] * inverse[1] + _C[3] * x[0] + _C[4] * x[0] * inverse[0] + _C[5] * x[1]
    return q + _C[6] * x[1] * inverse[1] + _C[7] * x[0] ** 2 + _C[8] * x[1] ** 2


def single_stiffness(pair: ToothPair, first_is_smaller: bool = True) -> Any:
    """c' [N/m^2]: largest stiffness of one tooth pair per face width after ISO 6336-1, method B.

        c' = 0.8 CB cos(beta) / q',    CB = (1 + 0.5 (1.2 - (addendum + 0.25))) (1 - 0.02 (20 - a_n in degrees))
        q' = 0.04723 + 0.15551/zn1 + 0.25791/zn2 - 0.00635 x1 - 0.11654 x1/zn1 - 0.00193 x2 - 0.24188 x2/zn2
             + 0.00529 x1^2 + 0.00182 x2^2    [mm um/N],    zn = z/(cos^2(beta_b) cos(beta))

    Gear 1 of the formula is the smaller one; an internal gear counts as zn2 = infinity. Solid discs of steel, dedendum
    = addendum + 0.25 modules (ISO 53), x1 >= x2, -0.5 <= x1 + x2 <= 2, load of 100 N per mm of face width or more.
    """
    f, beta, named = pair.f, pair.helix_angle, pair.named
    normal = (1 - (f.sin(beta) * f.cos(pair.pressure_angle)) ** 2) * f.cos(beta)
    words = "virtual number of teeth of gear"
    inverse = [1 / named("z_n1", pair.z1 / normal, f"{words} 1")]
    inverse.append(0 if pair.is_internal else 1 / named("z_n2", pair.z2 / normal, f"{words} 2"))
    x = list(pair.shifts or (0, 0))
    if not first_is_smaller:
        inverse.reverse()
        x.reverse()
    q = flexibility((inverse[0], inverse[1]), (x[0], x[1]))
    q = named("q_pair", q, "flexibility of a tooth pair, q' of ISO 6336-1", "mm um/N")
    rack = (1 + 0.5 * (0.95 - pair.addendum)) * (1 - 0.02 * (20 - pair.pressure_angle * 180 / f.pi))
    return named("c_pair", 0.8e9 * rack * f.cos(beta) / q, "stiffness of a tooth pair, c' of ISO 6336-1", "N/m2")


def mesh_stiffness(pair: ToothPair, face_width: Any, first_is_smaller: bool = True) -> Any:
    """k [N/m] = c' (0.75 eps_alpha + 0.25) b after ISO 6336-1, method B: mean stiffness along the line of action.

    Valid for eps_alpha >= 1.2 and helix angles up to 30 degrees, and see `single_stiffness`.
    """
    return single_stiffness(pair, first_is_smaller) * (0.75 * pair.contact_ratio + 0.25) * face_width


def iso_problems(pair: ToothPair, first_is_smaller: bool) -> list[str]:
    """Problems of numbers outside of the range of the formula (ISO 6336-1, method B)."""
    found = []
    x = list(pair.shifts or (0.0, 0.0))
    if not first_is_smaller:
        x.reverse()
    if x[0] < x[1] and not pair.is_internal:
        found.append(f"x1 = {x[0]:g} of the smaller gear must be >= x2 = {x[1]:g} of the larger one")
    if not -0.5 <= x[0] + x[1] <= 2:
        found.append(f"x1 + x2 = {x[0] + x[1]:g} must lie between -0.5 and 2")
    if abs(pair.helix_angle) > math.radians(30) * (1 + 1e-12):
        found.append(f"helix_angle = {math.degrees(pair.helix_angle):g} degrees must be <= 30")
    ratio = contact_ratio_or_nan(pair)
    if not ratio >= 1.2:
        found.append(f"the transverse contact ratio is {ratio:.3g} and must be >= 1.2")
    return found


def contact_ratio_or_nan(pair: ToothPair) -> float:
    """The contact ratio of a pair given by numbers, NaN where the gears have none (tips inside of the base circles)."""
    try:
        return float(pair.contact_ratio)
    except (ValueError, ArithmeticError):
        return math.nan
