"""Signals, leaves of expressions: Parameter, Input, Table, `time`, feedback by `sense`.

Knows nothing of blocks, nor of when a signal is evaluated.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import GearblocksError, ParameterError, arguments_told, by_name_only
from gearblocks.language.expression import FUNCTIONS, Expr, as_expr, evaluate
from gearblocks.language.numpy_calls import numpy_call
from gearblocks.language.refusals import NoWholeNumbers
from gearblocks.language.tidy import Tidy
from gearblocks.language.units import check_unit, in_unit, parse_unit

time = Expr("time")  # time in s, for expressions
twist = Expr("local", "twist")  # phi_b - phi_a in rad, for the torque of a Shaft
distance = Expr("local", "distance")  # that a vehicle has gone, in m, for its slope, wind and rolling resistance
temperature = Expr("local", "temperature")  # in K, of an element with a heat port
slip = Expr("local", "slip")  # abs(w_rel) in rad/s, or m/s on sliders, for laws of friction


class SympyExpression(Protocol):
    """An expression of sympy, as type checkers see it."""

    @property
    def free_symbols(self) -> Any: ...


class PintQuantity(Protocol):
    """A quantity of pint, as type checkers see it."""

    @property
    def magnitude(self) -> Any: ...


Value: TypeAlias = "float | str | Parameter | Expr | SympyExpression | PintQuantity"
_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*")

Signal: TypeAlias = "float | str | Parameter | Input | Table | Expr | SympyExpression | PintQuantity"


class _Leaf(NoWholeNumbers):
    """Arithmetic of a leaf is that of its expression."""

    __slots__ = ()

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Arithmetic with numpy scalars, and np.sin(signal) and its like."""
        return numpy_call(as_expr, FUNCTIONS, ufunc, method, inputs)

    def __float__(self) -> float:
        return float(self._expr_())

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


@arguments_told
@dataclass(frozen=True, slots=True)
class Parameter(_Leaf, metaclass=Tidy):
    """One tunable value that may stand in any numeric field or expression of a train.

    name: how it is set; value: in `unit`, such as "N m/rad" or "rpm", and so are the values that a run gives it.
    si: the value in SI and radians, which laws read. Two Parameters of one name in a train must be equal.
    """

    name: str
    value: float
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_name("Parameter", self.name)
        object.__setattr__(self, "value", _in_its_unit("Parameter", self.name, "value", self.value, self.unit))

    @property
    def si(self) -> float:
        """The value in SI and radians."""
        return parse_unit(self.unit).in_si(self.value)

    def _expr_(self) -> Expr:
        return Expr("parameter", self)


@arguments_told
@dataclass(frozen=True, slots=True)
class Input(_Leaf, metaclass=Tidy):
    """A value from outside: a number, Table or callable given to simulate, a variable of the FMU.

    start: its value while nothing is connected, in `unit`, in which runs give theirs. Inputs of one name are one input.
    """

    name: str
    start: float = 0.0
    unit: str = "1"

    def __post_init__(self) -> None:
        _check_name("Input", self.name)
        object.__setattr__(self, "start", _in_its_unit("Input", self.name, "start", self.start, self.unit))

    @property
    def si(self) -> float:
        """The start value in SI and radians."""
        return parse_unit(self.unit).in_si(self.start)

    def _expr_(self) -> Expr:
        return Expr("input", self)


def _in_its_unit(kind: str, name: str, field: str, value: Any, unit: str) -> float:
    """The number that a Parameter or an Input begins with, in its unit."""
    try:
        return in_unit(f"{kind} '{name}': {field}", value, check_unit(f"{kind} '{name}'", unit))
    except ParameterError as error:
        if unit != "1" or not isinstance(value, str):
            raise
        raise ParameterError(f"{error}: give the {kind} its unit, as gb.{kind}('n', 3000, 'rpm') has it") from None


def _check_name(kind: str, name: str) -> None:
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ParameterError(
            f"{kind} name {name!r} must be words of letters, digits and '_' joined by '.', each beginning with a letter"
        )


def _row(name: str, values: Any) -> NDArray[np.float64]:
    """One axis of a table as numbers."""
    try:
        if isinstance(values, str) or np.iscomplexobj(values):
            raise TypeError
        return np.array(values, dtype=float)
    except (TypeError, ValueError, GearblocksError):
        raise ParameterError(f"Table: {name} = {values!r:.80} must be a row of numbers{points_in_si(values)}") from None


def points_in_si(values: Any) -> str:
    """The way out where points of a table are complex, or texts: which of two units belongs to them, it does not know."""
    points = [values] if isinstance(values, str) else np.asarray(values, dtype=object).ravel().tolist()
    if any(isinstance(x, complex) for x in points):
        return ", which complex ones are not: take .real, .imag or abs(...)"
    words = ", not of texts: points are in SI and radians (those of an Input in its unit): convert them before, as gb.rpm(x), "
    return f"{words}np.deg2rad(x) and 1e-6 * y do" if any(isinstance(x, str) for x in points) else ""


def check_increasing(name: str, values: NDArray[np.float64]) -> None:
    """ParameterError where a row of numbers does not increase, with the first number that is not above the one before."""
    wrong = np.flatnonzero(np.diff(values) <= 0)
    if len(wrong):
        i = int(wrong[0]) + 1
        raise ParameterError(
            f"{name} must increase, but {name.split()[-1]}[{i}] = {values[i]} follows {values[i - 1]}; "
            "sort the points and drop repeated ones"
        )


def _check_jumps(x: NDArray[np.float64]) -> None:
    """ParameterError where x falls, or stands more than twice."""
    steps = np.diff(x)
    thrice = np.flatnonzero((steps[1:] == 0) & (steps[:-1] == 0))
    if len(thrice):
        raise ParameterError(
            f"Table: x = {x[thrice[0]]} stands three times or more; twice is a jump, from the first y to the last"
        )
    check_increasing("Table: x", x if not steps.any() else x[np.concatenate([[True], steps != 0])])


_FAR = 1e9  # of the reach of a table: where the lines of one that is extrapolated end


@arguments_told
@dataclass(frozen=True, eq=False)
class Table(_Leaf, metaclass=Tidy):
    """Points (x, y) joined by straight lines ("linear"), a spline ("cubic") or held from the left ("step").

    x: increasing, shape (n,), n >= 2; y: shape (n,). Over time where a signal is wanted; over twist or slip where a
    law asks for it. Outside the end values are held, or the table repeats when `periodic` (y[-1] must then equal y[0] but
    for rounding; not of "step"), or with extrapolate="linear" a table of straight lines goes on as its first and last one
    do (Modelica's friction and loss tables). Each joint is a located switch. ends: of a spline that is not periodic
    "not-a-knot" (one cubic over the first two segments, and over the last two: of order 4 up to the ends, where its slope
    jumps to 0), or "flat" (slope 0 there: what moves on smoothly when it is held, such as a prescribed angle). A linear
    table that is not periodic may have an x twice: it jumps there, and its value is the second one.
    """

    x: NDArray[np.float64] | Sequence[float]
    y: NDArray[np.float64] | Sequence[float]
    kind: str = "linear"
    periodic: bool = False
    ends: str = "not-a-knot"
    extrapolate: str = "hold"
    second: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        x, y = _row("x", self.x), _row("y", self.y)
        if x.ndim != 1 or x.shape != y.shape or len(x) < 2:
            raise ParameterError(
                f"Table: x {x.shape} and y {y.shape} must be two lists of the same length >= 2; give one y for each x"
            )
        for name, row in (("x", x), ("y", y)):
            if not np.isfinite(row).all():
                i = int(np.argmin(np.isfinite(row)))
                raise ParameterError(
                    f"Table: {name}[{i}] = {row[i]} must be a finite number; drop the point or repair it"
                )
        if self.kind == "linear" and not self.periodic:
            _check_jumps(x)
        else:
            doubled = self.kind != "step" and bool((np.diff(x) == 0).any())
            why = f" ({'periodic' if self.periodic else self.kind}, which cannot jump)" if doubled else ""
            check_increasing(f"Table{why}: x", x)
        if self.kind not in ("linear", "cubic", "step"):
            raise ParameterError(f"Table: kind = {self.kind!r} must be 'linear', 'cubic' or 'step'")
        if self.ends not in ("not-a-knot", "flat"):
            raise ParameterError(f"Table: ends = {self.ends!r} must be 'not-a-knot' or 'flat'")
        if self.extrapolate not in ("hold", "linear"):
            raise ParameterError(f"Table: extrapolate = {self.extrapolate!r} must be 'hold' or 'linear'")
        if self.extrapolate == "linear" and (self.kind != "linear" or self.periodic):
            what = "a periodic table" if self.periodic else f"kind = {self.kind!r}"
            raise ParameterError(
                f"Table: {what} has no lines to go on with: extrapolate='linear' goes with kind='linear'"
            )
        if self.extrapolate == "linear" and (x[0] == x[1] or x[-1] == x[-2]):
            raise ParameterError("Table: it jumps at an end, where extrapolate='linear' needs a line to go on with")
        if self.periodic and self.kind != "step":
            if abs(y[0] - y[-1]) > 1e-12 * np.abs(y).max():
                raise GearblocksError(
                    f"Table: a periodic table must end where it starts, but y[0] = {y[0]}, y[-1] = {y[-1]}"
                )
            y[-1] = y[0]
        for name, value in (("x", x), ("y", y), ("second", self._second(x, y))):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def _second(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.kind != "cubic":
            return np.zeros_like(x)
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(
            x, y, bc_type="periodic" if self.periodic else "clamped" if self.ends == "flat" else "not-a-knot"
        )
        return np.asarray(spline(x, 2), dtype=float)

    @property
    def jumps(self) -> tuple[tuple[float, float], ...]:
        """(x, size) of each jump: where an x stands twice."""
        x, y = np.asarray(self.x), np.asarray(self.y)
        return tuple((float(x[i]), float(y[i + 1] - y[i])) for i in np.flatnonzero(np.diff(x) == 0))

    @property
    def continuous(self) -> Table:
        """The table without its jumps: table(x) = continuous(x) + sum of size H(x - where)."""
        x, y = np.asarray(self.x), np.asarray(self.y)
        again = np.concatenate([[False], np.diff(x) == 0])
        lower = y - np.cumsum(np.where(again, np.diff(y, prepend=y[0]), 0.0))
        return Table(x[~again], lower[~again], extrapolate=self.extrapolate)

    @property
    def reached(self) -> Table:
        """The table as laws read it, without jumps: with a joint far out on both sides where its lines go on."""
        if self.extrapolate == "hold":
            return self
        x, y = np.asarray(self.x), np.asarray(self.y)
        far = _FAR * (x[-1] - x[0] + np.abs(x).max())
        first, last = (y[1] - y[0]) / (x[1] - x[0]), (y[-1] - y[-2]) / (x[-1] - x[-2])
        return Table([x[0] - far, *x, x[-1] + far], [y[0] - far * first, *y, y[-1] + far * last])

    def values(self, x: ArrayLike) -> NDArray[np.float64]:
        """y at the quantities x, shape of x, as a run reads the table."""
        known, y, x = np.asarray(self.x), np.asarray(self.y), np.asarray(x, dtype=float)
        span = known[-1] - known[0]
        at = known[0] + np.mod(x - known[0], span) if self.periodic else x
        if self.extrapolate == "hold":
            at = np.clip(at, known[0], known[-1])
        i = np.clip(np.searchsorted(known, at, side="right") - 1, 0, len(known) - 2)
        if self.jumps:
            return self.continuous.values(x) + sum(size * (x >= where) for where, size in self.jumps)
        if self.kind == "step":
            return np.asarray(np.where(at >= known[-1], y[-1], y[i]))
        h, a, m = known[i + 1] - known[i], at - known[i], self.second
        slope = (y[i + 1] - y[i]) / h - h * (2 * m[i] + m[i + 1]) / 6
        return np.asarray(y[i] + a * (slope + a * (m[i] / 2 + a * (m[i + 1] - m[i]) / (6 * h))))

    def digest(self) -> str:
        """A short hash of the content, the table's name in printed expressions."""
        flat = (*(("flat",) if self.ends == "flat" else ()), *(("on",) if self.extrapolate == "linear" else ()))
        data = repr((list(self.x), list(self.y), self.kind, self.periodic, *flat)).encode()
        return hashlib.sha256(data).hexdigest()[:12]

    def __repr__(self) -> str:
        more = ", periodic" if self.periodic else ", extrapolated" if self.extrapolate == "linear" else ""
        return f"Table({len(self.x)} points, {self.kind}{more}, {self.digest()})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    def _expr_(self) -> Expr:
        return Expr("table", self, time)

    def __call__(self, x: Any) -> Expr:
        """The table over another quantity than time."""
        return Expr("table", self, as_expr(x))


@by_name_only
def sense(path: str) -> Expr:
    """An output of another block as a signal (feedback), for example sense("motor.w")."""
    if not isinstance(path, str) or not path:
        raise ParameterError(f"sense({path!r}): give the name of an output as text, such as gb.sense('motor.w')")
    return Expr("sense", path)


def constant_value(x: Any) -> float:
    """The number of a number, a Parameter or an expression of Parameters; NaN where it has none."""
    try:
        return evaluate(as_expr(x), lambda leaf: float(leaf.args[0].si))
    except (ArithmeticError, AttributeError, LookupError, ValueError, TypeError):
        return math.nan


def value_at(x: Any, t: float) -> float:
    """The number of a signal at a time [s], Inputs as they start; NaN where the motion decides."""

    def leaf(e: Expr) -> float:
        if e.op == "table":
            return float(e.args[0].values(evaluate(as_expr(e.args[1]), leaf)))
        return t if e.op == "time" else float(e.args[0].si)

    try:
        return evaluate(as_expr(x), leaf)
    except (ArithmeticError, AttributeError, LookupError, ValueError, TypeError):
        return math.nan


def number_or_zero(x: Any) -> float:
    """The same, and 0 where it has none."""
    value = constant_value(x)
    return 0.0 if math.isnan(value) else value
