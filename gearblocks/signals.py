"""What may stand where a value is wanted: Parameter, Input, Table, `time`, `sense`."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import GearblocksError
from gearblocks.expression import Expr, as_expr

time = Expr("time")  # time in s, for expressions
twist = Expr("local", "twist")  # phi_b - phi_a in rad, for the torque of a Shaft

Value: TypeAlias = "float | Parameter | Expr"
Signal: TypeAlias = "float | Parameter | Input | Table | Expr"


class _Leaf:
    """Arithmetic of a leaf is that of its expression."""

    __slots__ = ()
    __array_ufunc__ = None

    def _expr_(self) -> Expr:
        raise TypeError

    def _sympy_(self) -> Any:
        return self._expr_()._sympy_()

    def __add__(self, other: Any) -> Any:
        return self._expr_() + other

    def __radd__(self, other: Any) -> Any:
        return other + self._expr_()

    def __sub__(self, other: Any) -> Any:
        return self._expr_() - other

    def __rsub__(self, other: Any) -> Any:
        return other - self._expr_()

    def __mul__(self, other: Any) -> Any:
        return self._expr_() * other

    def __rmul__(self, other: Any) -> Any:
        return other * self._expr_()

    def __truediv__(self, other: Any) -> Any:
        return self._expr_() / other

    def __rtruediv__(self, other: Any) -> Any:
        return other / self._expr_()

    def __pow__(self, other: Any) -> Any:
        return self._expr_() ** other

    def __neg__(self) -> Expr:
        return -self._expr_()

    def __abs__(self) -> Expr:
        return abs(self._expr_())

    def __lt__(self, other: Any) -> Any:
        return self._expr_() < other

    def __le__(self, other: Any) -> Any:
        return self._expr_() <= other

    def __gt__(self, other: Any) -> Any:
        return self._expr_() > other

    def __ge__(self, other: Any) -> Any:
        return self._expr_() >= other


@dataclass(frozen=True, slots=True)
class Parameter(_Leaf):
    """One tunable value that may stand in any numeric field or expression of a train.

    name: how it is set; value: in `unit` (SI, radians). Two Parameters of one name in a train must be equal.
    """

    name: str
    value: float
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_name("Parameter", self.name)
        if not math.isfinite(self.value):
            raise GearblocksError(f"Parameter '{self.name}': {self.value!r} is not a finite number")

    def _expr_(self) -> Expr:
        return Expr("parameter", self)


@dataclass(frozen=True, slots=True)
class Input(_Leaf):
    """A value from outside: a number, Table or callable given to simulate, a variable of the FMU.

    start: its value as long as nothing is connected. Inputs of one name are one input.
    """

    name: str
    start: float = 0.0
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_name("Input", self.name)
        if not math.isfinite(self.start):
            raise GearblocksError(f"Input '{self.name}': start = {self.start!r} is not a finite number")

    def _expr_(self) -> Expr:
        return Expr("input", self)


def _check_name(kind: str, name: str) -> None:
    if not isinstance(name, str) or not name.replace("_", "a").replace(".", "a").isalnum():
        raise GearblocksError(f"{kind} name {name!r} must consist of letters, digits, '_' and '.'")


@dataclass(frozen=True, eq=False)
class Table(_Leaf):
    """Points (x, y) joined by straight lines ("linear"), a spline ("cubic") or held from the left ("step").

    x: increasing, shape (n,), n >= 2; y: shape (n,). Over time where a signal is wanted; over twist or slip where a
    law asks for it. Outside: the end values are held ("step", "linear": flat; "cubic": flat), or repeated when
    `periodic` (then y[-1] must equal y[0], but for "step"). Each joint is a located switch.
    """

    x: NDArray[np.float64] | Sequence[float]
    y: NDArray[np.float64] | Sequence[float]
    kind: str = "linear"
    periodic: bool = False
    second: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        x, y = np.array(self.x, dtype=float), np.array(self.y, dtype=float)
        if x.ndim != 1 or x.shape != y.shape or len(x) < 2:
            raise GearblocksError(f"Table: x {x.shape} and y {y.shape} must be two lists of the same length >= 2")
        if not (np.isfinite(x).all() and np.isfinite(y).all()):
            raise GearblocksError("Table: x and y must be finite numbers")
        if not (np.diff(x) > 0).all():
            raise GearblocksError("Table: x must increase; sort the points and drop repeated ones")
        if self.kind not in ("linear", "cubic", "step"):
            raise GearblocksError(f"Table: kind = {self.kind!r} must be 'linear', 'cubic' or 'step'")
        if self.periodic and self.kind != "step" and y[0] != y[-1]:
            raise GearblocksError(
                f"Table: a periodic table must end where it starts, but y[0] = {y[0]}, y[-1] = {y[-1]}"
            )
        for name, value in (("x", x), ("y", y), ("second", self._second(x, y))):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def _second(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.kind != "cubic":
            return np.zeros_like(x)
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(x, y, bc_type="periodic" if self.periodic else "clamped")
        return np.asarray(spline(x, 2), dtype=float)

    def digest(self) -> str:
        """A short hash of the content, the table's name in printed expressions."""
        data = repr((list(self.x), list(self.y), self.kind, self.periodic)).encode()
        return hashlib.sha256(data).hexdigest()[:12]

    def __repr__(self) -> str:
        return f"Table({len(self.x)} points, {self.kind}{', periodic' if self.periodic else ''}, {self.digest()})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    def _expr_(self) -> Expr:
        return Expr("table", self, time)

    def __call__(self, x: Any) -> Expr:
        """The table over another quantity than time."""
        return Expr("table", self, as_expr(x))


def sense(path: str) -> Expr:
    """An output of another block as a signal (feedback), for example sense("motor.w")."""
    return Expr("sense", path)
