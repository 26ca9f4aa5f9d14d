"""The equation of a periodic orbit over a parameter:  F(u) = P_q^m(y) - y = 0,  u = (z, (q - q_0)/Q),  y = y_0 + S R z.

S: sizes of the states; R: directions apart from neutral ones, along which nothing is asked: a train may turn as one piece. F
by z and by q, whose period follows the parameter, from tangents: right across corners, impacts and events of time. Knows
nothing of branches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.neutral import Neutral, scaled
from gearblocks.analysis.regimes.orbit import CLOSED
from gearblocks.analysis.regimes.sizes import sized as sized_at
from gearblocks.analysis.regimes.small_multipliers import with_small_ones
from gearblocks.analysis.regimes.strobe import Change, Followed, Strobe
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]

_MOST = 8  # steps of Newton's method
_SETTLED = 1e-5  # step of that: next to a branch point a point off the branch closes, too
_PARTS = 16  # of a period, that sizes are told from
_GROWN = 2.0  # times: sizes that are taken anew
_ROUNDING = 30.0  # tolerances that a closed orbit is off by


@final
@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A point u of a branch. value, seen, y: parameter, model there, states at the section; run: the map from y; jacobian: of F
    by u, shape (m, m + 1); tangent: of the branch, a unit vector; directions: of y by z, shape (n, m); steps: those of Newton's
    method."""

    u: Array
    value: float
    seen: Strobe
    y: Array
    run: Followed
    jacobian: Array
    tangent: Array
    directions: Array
    multipliers: NDArray[np.complex128]
    steps: int

    @property
    def outside(self) -> int:
        """Multipliers outside the unit circle."""
        return int((np.abs(self.multipliers) > 1.0).sum())


@final
@dataclass(frozen=True, slots=True, eq=False)
class OrbitEquation:
    """at: the model at a value of the parameter; change: derivatives by it, in units of a size; base, value, size: y_0, q_0 and
    Q; sized: the model that sizes are taken from; periods: m."""

    at: Callable[[float], Strobe]
    change: Callable[[Strobe, float], Change]
    sized: Strobe
    neutral: Neutral
    base: Array
    value: float
    size: float
    periods: int

    def parameter(self, u: Array) -> float:
        """q."""
        return self.value + self.size * float(u[-1])

    def states(self, u: Array) -> Array:
        """y."""
        return self.sized.moved(self.base, self.neutral.rest @ u[:-1])

    def coordinates(self, y: Array, value: float) -> Array:
        """u."""
        return np.append(self.neutral.apart((y - self.base) / self.sized.scale), (value - self.value) / self.size)

    def resized(self, point: Solved) -> tuple[OrbitEquation, Solved]:
        """The same with the sizes of the orbit at a point where these have grown, and the point in them."""
        states = np.abs(point.seen.follow(point.y, self.periods, parts=_PARTS).states).max(axis=0)
        if ((states < _GROWN * self.sized.scale) | (self.sized.turns > 0.0)).all():
            return self, point
        sized = sized_at(point.seen, point.y, 0)
        sized = replace(sized, scale=np.maximum(sized.scale, self.sized.scale))
        neutral = self.neutral.resized(sized.scale / self.sized.scale)
        other = replace(self, sized=sized, neutral=neutral, base=point.y)
        along = point.directions @ point.tangent[:-1]
        normal = np.append(other.neutral.apart(along / sized.scale), point.tangent[-1])
        u = other.coordinates(point.y, point.value)
        return other, other.point(u, normal / np.linalg.norm(normal))

    def point(self, u: Array, normal: Array) -> Solved:
        """A point that is known to lie on a branch. Raises SimulationError."""
        seen, run = self._mapped(u)
        return self._point(u, seen, run, self._jacobian(u, seen, run), normal, 0)

    def solved(self, start: Array, normal: Array) -> Solved | None:
        """The point of F = 0 in the plane through `start` with this normal, by Newton's method; None where there is none near
        it. Its tangent leads along the normal."""
        u = start
        for steps in range(_MOST):
            try:
                seen, run = self._mapped(u)
                miss = self.neutral.apart(seen.off(run.states[-1], self.states(u)))
                jacobian = self._jacobian(u, seen, run)
            except SimulationError:
                return None
            step = np.linalg.lstsq(np.vstack([jacobian, normal]), -np.append(miss, normal @ (u - start)), rcond=None)[0]
            if np.abs(miss).max() <= max(CLOSED, _ROUNDING * seen.rtol) and np.abs(step).max() <= _SETTLED:
                return self._point(u, seen, run, jacobian, normal, steps)
            if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
                return None
            u = u + step
        return None

    def _point(
        self, u: Array, seen: Strobe, run: Followed, jacobian: Array, normal: Array, steps: int
    ) -> Solved:  # fmt: skip
        tangent = np.linalg.svd(jacobian)[2][-1]
        tangent = tangent if tangent @ normal >= 0 else -tangent
        y, whole = self.states(u), scaled(seen, run.maps[-1])
        multipliers, _ = with_small_ones(seen, y, self.periods, self.neutral, whole, self.neutral.multipliers(whole))
        directions = self.sized.scale[:, None] * self.neutral.rest
        return Solved(u, self.parameter(u), seen, y, run, jacobian, tangent, directions, multipliers, steps)

    def _seen(self, value: float) -> Strobe:
        sized = self.sized
        step = sized.told_finely.max_step  # an orbit at rest limits no step by its own motion
        return replace(self.at(value), scale=sized.scale, turns=sized.turns, max_step=step, fading=sized.fading)

    def _mapped(self, u: Array) -> tuple[Strobe, Followed]:
        seen = self._seen(self.parameter(u))
        return seen, seen.map(self.states(u), self.periods, by=self.change(seen, self._unit(u)))

    def _unit(self, u: Array) -> float:
        """What of the parameter is a small part of itself."""
        return min(abs(self.parameter(u)), self.size) or self.size

    def _jacobian(self, u: Array, seen: Strobe, run: Followed) -> Array:
        rest = self.neutral.rest
        assert run.slope is not None
        by_parameter = self.neutral.apart(run.slope * (self.size / self._unit(u)) / seen.scale)
        by_states = rest.T @ scaled(seen, run.maps[-1]) @ rest - np.eye(rest.shape[1])
        return np.column_stack([by_states, by_parameter])
