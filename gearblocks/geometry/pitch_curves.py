"""Pitch curves of non-circular gear pairs: r1 = E m/(1 + m), r2 = E/(1 + m), their curvature and arc length, and tooth flanks
as the envelope of a rack (Litvin and Fuentes, Gear Geometry and Applied Theory, 2004).

SI units, radians. Knows nothing of how a ratio law is made, nor of blocks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from gearblocks.errors import ParameterError
from gearblocks.geometry.noncircular_stiffness import equivalent_teeth, mesh_stiffness
from gearblocks.geometry.ratio_curves import TURN, Array, Curve
from gearblocks.language.expression import finite_number

GRID = 7200
"""Angles per turn at which extremes of curves are searched."""


@dataclass(frozen=True, slots=True)
class Curvature:
    """The curvature of a pitch curve [1/m], positive where it is convex.

    smallest, largest: over the turn, with the angles of gear 1 [rad] where they are; concave: share of the turn of
    gear 1 with a concave curve.
    """

    smallest: float
    smallest_at: float
    largest: float
    largest_at: float
    concave: float

    @property
    def is_convex(self) -> bool:
        """Whether the whole curve is convex."""
        return self.smallest >= 0


class TransmissionFunction(Protocol):
    """F(phi), m = F' and its derivatives, and how often they repeat: see `RatioLaw`."""

    @property
    def n1(self) -> int: ...
    @property
    def n2(self) -> int: ...
    @property
    def curve(self) -> Curve: ...
    @property
    def period(self) -> float: ...
    def F(self, phi: ArrayLike) -> Array: ...
    def m(self, phi: ArrayLike) -> Array: ...
    def dm(self, phi: ArrayLike, order: int = 1) -> Array: ...


@dataclass(frozen=True)
class PitchPair:
    """The pitch curves of an external pair: r1 + r2 = distance, r1 = distance m/(1 + m).

    Gear 1 turns by phi, gear 2 by F(phi) the other way; polar angles of the curves are -phi and F(phi) + pi in the frames
    of the gears. Concave curves are legal (a shaper cuts them, a rack does not).
    """

    law: TransmissionFunction
    distance: float

    def radii(self, phi: ArrayLike) -> tuple[Array, Array]:
        """(r1, r2) [m] at the angle phi [rad] of gear 1."""
        m = self.law.m(phi)
        return np.asarray(self.distance * m / (1 + m)), np.asarray(self.distance / (1 + m))

    def points(self, phi: ArrayLike, gear: int) -> tuple[Array, Array]:
        """(x, y) [m] of the pitch curve of gear 1 or 2 in its own frame, where gear 1 stands at phi [rad]."""
        r = self.radii(phi)[_index(gear)]
        polar = -np.asarray(phi, dtype=float) if gear == 1 else self.law.F(phi) + np.pi
        return np.asarray(r * np.cos(polar)), np.asarray(r * np.sin(polar))

    def curvature_at(self, phi: ArrayLike, gear: int) -> Array:
        """Curvature [1/m] of a pitch curve: of 1/r = u over the polar angle, (u + u'')/(1 + (u'/u)^2)^1.5."""
        m, dm, ddm = self.law.m(phi), self.law.dm(phi), self.law.dm(phi, 2)
        if _index(gear) == 0:
            u, du, ddu = 1 + 1 / m, -dm / m**2, 2 * dm**2 / m**3 - ddm / m**2
        else:
            u, du, ddu = 1 + m, dm / m, ddm / m**2 - dm**2 / m**3
        return np.asarray((u + ddu) / (1 + (du / u) ** 2) ** 1.5 / self.distance)

    @cached_property
    def curvatures(self) -> tuple[Curvature, Curvature]:
        """Curvatures of gear 1 and gear 2."""
        return self._curvature(1), self._curvature(2)

    def equivalent_teeth(self, phi: ArrayLike, gear: int, *, module: float) -> Array:
        """Tooth number 2 rho/module of the cylindrical gear that has the curvature of gear 1 or 2 at phi [rad]."""
        return equivalent_teeth(self, phi, _index(gear) + 1, module)

    def mesh_stiffness(
        self, phi: ArrayLike, *, module: float, face_width: float, shifts: tuple[float, float] = (0.0, 0.0),
        factor: float = 0.8,
    ) -> Array:  # fmt: skip
        """Stiffness of a tooth pair [N/m] along the line of action at phi [rad] of gear 1, after ISO 6336-1, method B, with the
        equivalent tooth numbers: k = factor face_width/q'. shifts: profile shifts over the module; factor: CM CR of the
        standard. Raises ParameterError where a pitch curve is concave."""
        return mesh_stiffness(self, phi, module, face_width, shifts, factor)

    def placed(self, phi: float, gear: int, x: ArrayLike, y: ArrayLike) -> tuple[Array, Array]:
        """Points (x, y) [m] of gear 1 or 2 from its own frame into that of the housing, where gear 1 has turned by phi [rad].
        Its axis is the origin, that of gear 2 lies at (distance, 0), and the pitch point between them."""
        turn = phi if _index(gear) == 0 else -float(self.law.F(phi))
        c, s, x, y = math.cos(turn), math.sin(turn), np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        return np.asarray(c * x - s * y + (gear - 1) * self.distance), np.asarray(s * x + c * y)

    def _curvature(self, gear: int) -> Curvature:
        from scipy.optimize import minimize_scalar

        step = TURN / GRID
        phi = step * np.arange(GRID)
        values = self.curvature_at(phi, gear)

        def best(i: int, sign: float) -> tuple[float, float]:
            found = minimize_scalar(
                lambda x: sign * float(self.curvature_at(x, gear)), bounds=(phi[i] - step, phi[i] + step),
                method="bounded", options={"xatol": 1e-12},
            )  # fmt: skip
            value, at = min((float(found.fun), float(found.x)), (sign * float(values[i]), float(phi[i])))
            return sign * value, at % TURN

        return Curvature(
            *best(int(values.argmin()), 1.0), *best(int(values.argmax()), -1.0), float((values < 0).mean())
        )

    @cached_property
    def length(self) -> float:
        """Length [m] of the pitch curve of gear 1 over a turn; that of gear 2 over the same turn is the same."""
        return float(self.arcs(np.array([TURN]))[0])

    def arcs(self, phi: ArrayLike) -> Array:
        """Length [m] of the pitch curves from 0 to each phi [rad], by Gauss's rule between joints and grid angles."""
        x, speed = self._grid
        phi = np.asarray(phi, dtype=float)
        turns = np.floor(phi / TURN)
        rest = phi - turns * TURN
        i = np.clip(np.searchsorted(x, rest, side="right") - 1, 0, len(x) - 2)
        return np.asarray(turns * speed[-1] + speed[i] + _gauss(self._speed, x[i], rest))

    @cached_property
    def _grid(self) -> tuple[Array, Array]:
        """Angles of a turn, joints among them, and the arc up to each."""
        joints = getattr(self.law.curve, "x", np.array([0.0]))
        repeated = (joints[None, :] + self.law.period * np.arange(self.law.n1)[:, None]).ravel()
        x = np.unique(np.concatenate([np.linspace(0.0, TURN, 721), repeated[repeated < TURN]]))
        return x, np.concatenate([[0.0], np.cumsum(_gauss(self._speed, x[:-1], x[1:]))])

    def _speed(self, phi: ArrayLike) -> Array:
        """Arc per angle of gear 1: sqrt(r1^2 + r1'^2)."""
        m, dm = self.law.m(phi), self.law.dm(phi)
        return np.asarray(self.distance / (1 + m) * np.hypot(m, dm / (1 + m)))

    def angles(self, arcs: ArrayLike) -> Array:
        """The angles phi [rad] at which the arcs [m] lie: the inverse of `arcs`, by Newton's method."""
        s = np.asarray(arcs, dtype=float)
        x, at = self._grid
        turns = np.floor(s / at[-1])
        phi = np.interp(s - turns * at[-1], at, x) + turns * TURN
        for _ in range(6):
            phi = phi - (self.arcs(phi) - s) / self._speed(phi)
        return np.asarray(phi)

    def largest_module(self, pressure_angle: float, addendum: float = 1.0, gear: int | None = None) -> float:
        """The largest module [m] that a rack of that pressure angle cuts without undercut on the convex parts.

        addendum: of the rack, in modules. The radius of curvature must be >= addendum module/sin^2(pressure_angle).
        gear: 1 or 2, or None for the smaller of both.
        """
        if not 0 < pressure_angle < math.pi / 2 or addendum <= 0:
            raise ParameterError(
                f"pressure_angle = {pressure_angle!r} rad must be > 0 and < pi/2, addendum = {addendum!r} > 0"
            )
        gears = (1, 2) if gear is None else (gear,)
        sharpest = max(self.curvatures[_index(g)].largest for g in gears)
        return math.sin(pressure_angle) ** 2 / addendum / sharpest

    def flanks(
        self, module: float, teeth: int, *, pressure_angle: float, gear: int = 1, addendum: float = 1.0, points: int = 21
    ) -> Flanks:  # fmt: skip
        """Tooth flanks as the envelope of a rack with straight flanks that rolls on the pitch curve.

        addendum: in modules, the straight part of the rack beyond and below its pitch line. The pitch of the teeth is
        the length over their number; what module and teeth miss is the `defect`. Flank 2 i and 2 i + 1 bound tooth i.
        """
        values = {"module": module, "pressure_angle": pressure_angle, "addendum": addendum}
        for name, value in values.items():
            if finite_number(f"flanks: {name}", value) <= 0:
                raise ParameterError(f"flanks: {name} = {value!r} must be > 0")
        if isinstance(teeth, bool) or not isinstance(teeth, int) or teeth < 1:
            raise ParameterError(f"flanks: teeth = {teeth!r} must be a whole number >= 1")
        length = self.length if gear == 1 else self.length * self.law.n2 / self.law.n1
        return _generate(self, gear, length, teeth, (module, pressure_angle, addendum, points))


@dataclass(frozen=True, eq=False)
class Flanks:
    """Tooth flanks of one gear. x, y: [m] in its frame, shape (2 teeth, points), from root to tip.

    radius: radius of curvature [m] of the flanks there, positive where convex; <= 0 is undercut (or a concave pitch curve
    that a rack cannot roll on). defect: length of the pitch curve less pi module teeth [m].
    """

    x: Array
    y: Array
    radius: Array
    teeth: int
    defect: float

    @property
    def undercut(self) -> Array:
        """Whether each flank is undercut."""
        return np.asarray((self.radius <= 0).any(axis=1))

    @property
    def smallest_radius(self) -> float:
        """The smallest radius of curvature [m]."""
        return float(self.radius.min())


def _generate(
    pair: PitchPair, gear: int, length: float, teeth: int, rack: tuple[float, float, float, int]
) -> Flanks:  # fmt: skip
    """Flank k crosses the pitch curve at arc s_k. While the rack touches at arc s, its flank crosses the tangent s_k - s
    ahead; the foot of the normal from the pitch point lies (s_k - s) cos(alpha) along the line of action, and there the
    flank has the radius rho sin(alpha) + depth/sin(alpha) (Euler-Savary, Litvin and Fuentes 2004, ch. 6)."""
    module, alpha, addendum, points = rack
    depth = np.linspace(-addendum, addendum, points) * module  # from root to tip
    crossings = length / teeth / 2 * (np.arange(2 * teeth) - 0.5)
    side = np.where(np.arange(2 * teeth) % 2 == 0, -1.0, 1.0)  # teeth grow thinner towards the tip
    ahead = side[:, None] * depth / (math.sin(alpha) * math.cos(alpha))
    phi = pair.angles(crossings[:, None] - ahead)
    x, y = pair.points(phi, gear)
    tangent = _tangent(pair, phi, gear)
    # a curve that runs clockwise has its outside on the left
    outward = np.array([-tangent[1], tangent[0]]) * (1.0 if gear == 1 else -1.0)
    along = ahead * math.cos(alpha) ** 2
    rho = 1 / pair.curvature_at(phi, gear)
    return Flanks(
        x + along * tangent[0] + depth * outward[0], y + along * tangent[1] + depth * outward[1],
        rho * math.sin(alpha) + depth / math.sin(alpha), teeth, length - math.pi * module * teeth,
    )  # fmt: skip


def _tangent(pair: PitchPair, phi: Array, gear: int) -> Array:
    """Unit tangent of a pitch curve in the direction of rising phi."""
    m, dm = pair.law.m(phi), pair.law.dm(phi)
    if gear == 1:
        polar, r, dr = -phi, m, dm / (1 + m)
        turn = -r
    else:
        polar, r, dr = pair.law.F(phi) + np.pi, np.ones_like(m), -dm / (1 + m)
        turn = r * m
    size = np.hypot(dr, turn)
    c, s = np.cos(polar), np.sin(polar)
    return np.array([dr * c - turn * s, dr * s + turn * c]) / size


def _gauss(f: object, a: Array, b: Array) -> Array:
    """Integrals of f from a to b by Gauss's rule of 8 points."""
    assert callable(f)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    middle, half = (a + b) / 2, (b - a) / 2
    return np.asarray(half * (f(middle[..., None] + half[..., None] * nodes) @ weights))


def _index(gear: int) -> int:
    if gear not in (1, 2):
        raise ParameterError(f"gear = {gear!r} must be 1 or 2")
    return gear - 1
