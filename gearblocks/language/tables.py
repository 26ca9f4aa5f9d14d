"""Tables of two variables: bilinear or bicubic interpolation on a grid, such as the torque of an engine over speed and
throttle.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, arguments_told
from gearblocks.language.expression import Expr, as_expr
from gearblocks.language.signals import Table, check_increasing, points_in_si
from gearblocks.language.tidy import Tidy

Grid = NDArray[np.float64]


@arguments_told
@dataclass(frozen=True, eq=False)
class Table2(metaclass=Tidy):
    """Points z over a grid of x and y, joined bilinearly ("linear") or by splines along both axes ("cubic").

    x, y: increasing, shapes (n,) and (m,), n, m >= 2; z: shape (n, m), z[i][j] at (x[i], y[j]). Outside, the value at
    the nearest edge is held; "cubic" has two continuous derivatives inside and leaves its edges flat. The lines
    between the cells are located switches. Called with two quantities it is a signal: table(gb.sense("motor.w"), u).
    """

    x: NDArray[np.float64] | Sequence[float]
    y: NDArray[np.float64] | Sequence[float]
    z: NDArray[np.float64] | Sequence[Sequence[float]]
    kind: str = "linear"
    axes: tuple[Table, Table] = field(init=False, repr=False)
    bends: tuple[Grid, Grid, Grid] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        x, y, z = (_numbers(name, getattr(self, name)) for name in ("x", "y", "z"))
        if x.ndim != 1 or y.ndim != 1 or min(x.size, y.size) < 2 or z.shape != (x.size, y.size):
            raise ParameterError(
                f"Table2: x {x.shape}, y {y.shape} and z {z.shape} must be rows of n and m >= 2 numbers and n rows of m"
            )
        for name, values in (("x", x), ("y", y), ("z", z)):
            if not np.isfinite(values).all():
                where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
                at = "".join(f"[{i}]" for i in where)
                raise ParameterError(
                    f"Table2: {name}{at} = {values[where]} must be a finite number; drop its row or column, or repair it"
                )
        for name, values in (("x", x), ("y", y)):
            check_increasing(f"Table2: {name}", values)
        if self.kind not in ("linear", "cubic"):
            raise ParameterError(f"Table2: kind = {self.kind!r} must be 'linear' or 'cubic'")
        for name, array in (("x", x), ("y", y), ("z", z)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "axes", tuple(Table(axis, np.zeros_like(axis)) for axis in (x, y)))
        object.__setattr__(self, "bends", self._bends(x, y, z))

    def _bends(self, x: Grid, y: Grid, z: Grid) -> tuple[Grid, Grid, Grid]:
        """Second derivatives by x, by y and by both at the points."""
        if self.kind == "linear":
            return np.zeros_like(z), np.zeros_like(z), np.zeros_like(z)
        from scipy.interpolate import CubicSpline

        by_x = np.asarray(CubicSpline(x, z, axis=0, bc_type="clamped")(x, 2), dtype=float)
        by_y, by_both = (
            np.asarray(CubicSpline(y, rows, axis=1, bc_type="clamped")(y, 2), dtype=float) for rows in (z, by_x)
        )
        return by_x, by_y, by_both

    def digest(self) -> str:
        """A short hash of the content, the table's name in printed expressions."""
        rows = (np.asarray(self.x).tolist(), np.asarray(self.y).tolist(), np.asarray(self.z).tolist())
        return hashlib.sha256(repr(("two", *rows, self.kind)).encode()).hexdigest()[:12]

    def __repr__(self) -> str:
        return f"Table2({len(self.x)} by {len(self.y)} points, {self.kind}, {self.digest()})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table2) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    def __call__(self, x: Any, y: Any) -> Expr:
        """The table over two quantities, as a signal."""
        return Expr("table2", self, as_expr(x), as_expr(y))


def _numbers(name: str, values: Any) -> Grid:
    try:
        if isinstance(values, str) or np.asarray(values).dtype.kind not in "iuf":
            raise TypeError
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ParameterError(f"Table2: {name} = {values!r:.80} must be rows of numbers{points_in_si(values)}") from None
