"""Ripples of ratio laws: the periodic part F(phi) - n1/n2 phi of the angle of gear 2, with derivatives up to order 4.

Piecewise polynomials, ellipses, Fourier sums. Knows nothing of how they are fitted, nor of gears.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from math import comb
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import ParameterError

Array: TypeAlias = NDArray[np.float64]
ORDERS = 4
"""Derivatives up to this order are evaluated."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """A polynomial per segment between `x`, repeated with the period x[-1] - x[0].

    x: joints, shape (n,); y: coefficients, shape (n - 1, degree + 1), over the local coordinate v in [-1, 1] of the
    segment (v = 0 in its middle: powers of an angle itself would lose up to 9 digits). joints: whether derivatives jump
    at the joints, which a run then locates.
    """

    x: Array
    y: Array
    joints: bool
    kind: str = "pieces"
    periodic: bool = True

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            value = np.array(getattr(self, name), dtype=float)
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return int(self.y.shape[1]) - 1

    def digest(self) -> str:
        """A short hash of the content."""
        return hashlib.sha256(self.x.tobytes() + self.y.tobytes() + bytes([self.joints])).hexdigest()[:12]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pieces) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    def __repr__(self) -> str:
        return f"Pieces({len(self.y)} segments, {self.digest()})"

    def value(self, phi: ArrayLike, order: int = 0) -> Array:
        """The derivative of the given order (0: the value itself) at phi [rad], of any shape."""
        s = np.asarray(phi, dtype=float)
        s = s - np.floor((s - self.x[0]) / (self.x[-1] - self.x[0])) * (self.x[-1] - self.x[0])
        i = np.clip(np.searchsorted(self.x, s, side="right") - 1, 0, len(self.y) - 1)
        half = 0.5 * (self.x[i + 1] - self.x[i])
        v = (s - self.x[i] - half) / half
        rows = derivatives(self.y, order)[i]
        result = np.zeros_like(v)
        for j in range(rows.shape[-1] - 1, -1, -1):
            result = result * v + rows[..., j]
        return np.asarray(result / half**order)


def derivatives(y: Array, order: int) -> Array:
    """Coefficients of the derivative by the local coordinate."""
    for _ in range(order):
        y = y[:, 1:] * np.arange(1, y.shape[1])
        if y.shape[1] == 0:
            return np.zeros((len(y), 1))
    return y


@dataclass(frozen=True)
class Ellipse:
    """2/n atan(e sin(n phi)/(1 - e cos(n phi))): the lead of the mate of an ellipse that turns about its focus.

    The same as tan(n F/2) = (1 + e)/(1 - e) tan(n phi/2), without the jumps of the tangent.
    """

    e: float
    n: int

    def value(self, phi: ArrayLike, order: int = 0) -> Array:
        """The derivative of the given order at phi [rad]."""
        n, e, x = self.n, self.e, self.n * np.asarray(phi, dtype=float)
        if order == 0:
            return np.asarray(2 / n * np.arctan2(e * np.sin(x), 1 - e * np.cos(x)))
        # derivatives of w/d with w = 1 - e^2, d = 1 + e^2 - 2 e cos x, by Leibniz' rule on d m = w
        d = [1 + e * e - 2 * e * np.cos(x), 2 * e * np.sin(x), 2 * e * np.cos(x), -2 * e * np.sin(x)]
        m = [(1 - e * e) / d[0]]
        for k in range(1, order):
            m.append(-sum(comb(k, j) * d[j] * m[k - j] for j in range(1, k + 1)) / d[0])
        return np.asarray(n ** (order - 1) * m[order - 1] - (1 if order == 1 else 0))


@dataclass(frozen=True)
class Waves:
    """sum_j cos[j] (cos(w_j phi) - 1) + sin[j] sin(w_j phi), w_j = (j + 1) frequency. Zero at 0, as F is."""

    frequency: int
    cos: tuple[float, ...]
    sin: tuple[float, ...]

    def value(self, phi: ArrayLike, order: int = 0) -> Array:
        """The derivative of the given order at phi [rad]."""
        phi = np.asarray(phi, dtype=float)
        result = np.full_like(phi, -sum(self.cos) if order == 0 else 0.0)
        for j, (a, b) in enumerate(zip(self.cos, self.sin, strict=True), 1):
            w = j * self.frequency
            x = w * phi
            # the derivative of order n is the wave a quarter turn further, n times
            c, s = np.cos(x), np.sin(x)
            cosine, sine = ((c, s), (-s, c), (-c, -s), (s, -c))[order % 4]
            result = result + w**order * (a * cosine + b * sine)
        return np.asarray(result)

    def symbolic(self, x: Any) -> Any:
        """The value at a sympy expression."""
        import sympy as sp

        total = sp.Float(-sum(self.cos)) if any(self.cos) else sp.Integer(0)
        for j, (a, b) in enumerate(zip(self.cos, self.sin, strict=True), 1):
            w = sp.Integer(j * self.frequency)
            total += (sp.Float(a) * sp.cos(w * x) if a else 0) + (sp.Float(b) * sp.sin(w * x) if b else 0)
        return total


Curve: TypeAlias = Pieces | Ellipse | Waves


TURN = 2 * math.pi


class RatioLawError(ParameterError):
    """A ratio law that no pair of gears can have.

    m_min, at: the smallest ratio and where it lies [rad]; largest_X: the longest working segment [rad] that the same
    k and b allow. None where the refusal has another reason.
    """

    def __init__(
        self, message: str, m_min: float | None = None, at: float | None = None, largest_X: float | None = None
    ) -> None:
        self.message, self.m_min, self.at, self.largest_X = message, m_min, at, largest_X
        super().__init__(message, m_min, at, largest_X)

    def __str__(self) -> str:
        return self.message


@dataclass(frozen=True, slots=True)
class Extremes:
    """Smallest and largest value over a turn, and the angles of gear 1 [rad] where they are."""

    smallest: float
    smallest_at: float
    largest: float
    largest_at: float


def extremes(value: Any, slope: Any, period: float, points: int = 4096) -> Extremes:
    """Extremes of a smooth periodic function of the angle: the best of a grid, refined between its neighbours."""
    step = period / points
    phi = step * np.arange(points)
    values = value(phi)

    def refined(i: int, sign: float) -> tuple[float, float]:
        low, high = phi[i] - step, phi[i] + step
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if sign * float(slope(middle)) < 0 else (low, middle)
        best = min((float(value(x)) * sign, x) for x in (low, phi[i]))
        return best[0] * sign, float(best[1] % period)

    return Extremes(*refined(int(values.argmin()), 1.0), *refined(int(values.argmax()), -1.0))
