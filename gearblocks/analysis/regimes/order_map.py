"""Orders of a run-up: amplitudes over order and speed (a waterfall), from equal distances of the angle of a shaft.

    a(n) = 2/N |sum y(theta_j) h_j exp(-i n theta_j)|,   h: window of Hann over so many revolutions

Sampled by the angle, parts that go with the shaft stay in their line while the speed changes. Knows nothing of what turns.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError, UnknownNameError, by_name_only, did_you_mean
from gearblocks.language.expression import finite_number
from gearblocks.plurals import singular
from gearblocks.simulation.solution import values_at, window_of
from gearblocks.simulation.trajectory import Trajectory

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_NODES = (np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]) + 1) / 2  # Gauss, order 6, of an interval of 1
_WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18
_FINE = 16  # intervals of a revolution, over which the speed is integrated; more for orders above 8
_MOST = 1 << 20  # intervals
_STEPS = 6  # of Newton's method, from times to angles
_RISE = 2.0  # of the least between two orders
_SIDE, _POWER = 2, 1.5  # lines beside one that belong to it under Hann's window, and their power


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OrderMap:
    """Amplitudes of output `of` [unit] over the orders of a shaft, shape (speeds, orders). speed: means of output
    `speed_name` [speed_unit] over each part of the run; time: middles of the parts [s]; revolutions: in a part, so that
    lines lie 1/revolutions apart and two orders nearer than four lines are not told apart."""

    time: Array
    speed: Array
    order: Array
    amplitude: Array
    of: str
    unit: str
    speed_name: str
    speed_unit: str
    revolutions: int

    def track(self, order: float) -> Array:
        """Amplitude of the part at an order over the speeds, shape (speeds,), whether it stands on a line or between."""
        place = int(np.argmin(np.abs(self.order - order)))
        if abs(self.order[place] - order) > 1.0 / self.revolutions:
            raise ParameterError(f"order = {order!r} must lie between 0 and {self.order[-1]:g}")
        beside = self.amplitude[:, max(place - _SIDE, 0) : place + _SIDE + 1]
        found: Array = np.sqrt((beside**2).sum(axis=1) / _POWER)
        return found

    def largest(self, count: int) -> list[float]:
        """Orders that reach the largest amplitudes, apart from the mean, the largest first. What only falls away beside one,
        while its amplitude or the speed changes within a part, is none."""
        peaks = self.amplitude.max(axis=0)
        peaks[: 2 * _SIDE + 1] = 0.0
        left, found = peaks.copy(), list[float]()
        while len(found) < count and left.max(initial=0.0) > 0.0:
            place = int(np.argmax(left))
            found.append(float(self.order[place]))
            left[place - _falls(peaks[place::-1]) + 1 : place + _falls(peaks[place:])] = 0.0
        return found

    def __repr__(self) -> str:
        listed = ", ".join(f"{order:.4g}" for order in self.largest(3))
        span = f"{self.speed.min():.5g} .. {self.speed.max():.5g} {self.speed_unit}"
        return singular(f"<orders of {self.of} over {len(self.speed)} speeds, {span}: largest {listed}>")

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """The waterfall, and the largest orders over the speed; saved where a path is given."""
        from gearblocks.analysis.regimes.order_pictures import draw_orders

        return draw_orders(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Over speed and order, with units."""
        import xarray

        data = {
            "amplitude": (("speed", "order"), self.amplitude, {"units": self.unit}),
            "time": ("speed", self.time, {"units": "s"}),
        }
        coords = {"speed": ("speed", self.speed, {"units": self.speed_unit}), "order": self.order}
        return xarray.Dataset(data, coords, attrs={"of": self.of, "revolutions": self.revolutions})


def _falls(peaks: Array) -> int:
    """How many of these fall away from the first one: the lines that two orders must be apart, and those behind until they have
    risen again from the least by more than ripples do."""
    behind = peaks[_SIDE:]
    rises = np.flatnonzero(behind > _RISE * np.minimum.accumulate(behind))
    return max(2 * _SIDE + 1, _SIDE + int(rises[0])) if len(rises) else len(peaks)


@by_name_only
def orders(
    run: Trajectory, of: str, speed: str, *, highest: float = 32.0, revolutions: int = 16, overlap: float = 0.75,
    after: float | str | None = None, before: float | str | None = None,
) -> OrderMap:  # fmt: skip
    """Amplitudes of an output over the orders of the shaft whose speed [rad/s] is the output `speed`, along a run-up or -down.

    highest: order; revolutions: in each part of the run that is looked at; overlap: share of a part that the next one begins
    in; after, before: the window [s]. Raises ParameterError where the shaft does not turn one way, or too little.
    """
    start, end = window_of(run, after, before)
    for name in (of, speed):
        if name not in run.units and (run.case is None or name not in run.case.library.program.output_numbers):
            raise UnknownNameError(f"orders: there is no output '{name}'{did_you_mean(name, run.units)}")
    if not finite_number("highest", highest) > 0 or revolutions < 4 or not 0 <= finite_number("overlap", overlap) < 1:
        raise ParameterError(
            f"highest = {highest} must be > 0, revolutions = {revolutions} >= 4 and overlap = {overlap} in [0, 1)"
        )
    t, angle, rate = _angle(run, speed, start, end, highest)
    each = 1 << int(np.ceil(np.log2(4 * highest)))  # samples of a revolution
    count = int(abs(angle[-1]) / (2 * np.pi) * each)
    length, hop = revolutions * each, max(1, round(revolutions * each * (1 - overlap)))
    if count < length:
        turned = abs(angle[-1]) / (2 * np.pi)
        raise ParameterError(
            f"orders: '{speed}' turns {turned:.3g} times in the window, less than revolutions = {revolutions}"
        )
    times = _times(t, angle, rate, np.sign(angle[-1]) * 2 * np.pi * np.arange(count) / each)
    y = values_at(run, run.case, [of], times)[:, 0]
    shape = 1 - np.cos(2 * np.pi * np.arange(length) / length)
    parts = np.arange(0, count - length + 1, hop)
    lines = int(np.floor(highest * revolutions)) + 1
    table = np.array([np.abs(np.fft.rfft(y[a : a + length] * shape))[:lines] * 2 / length for a in parts])
    table[:, 0] /= 2
    ends = np.minimum(parts + length, count - 1)
    turned_by = 2 * np.pi * (ends - parts) / each
    units = run.units if run.case is None else run.case.library.program.output_units
    return OrderMap(
        0.5 * (times[parts] + times[ends]), turned_by / (times[ends] - times[parts]), np.arange(lines) / revolutions, table,
        of, units[of], speed, units[speed], revolutions,
    )  # fmt: skip


def _angle(run: Trajectory, speed: str, start: float, end: float, highest: float) -> tuple[Array, Array, Array]:
    """Times [s], the angle that the shaft has turned by at each [rad], and its speed there [rad/s]."""
    coarse = values_at(run, run.case, [speed], np.linspace(start, end, 257))[:, 0]
    turns = float(np.abs(coarse).max()) * (end - start) / (2 * np.pi)
    n = int(min(max(_FINE * turns * max(1.0, highest / 8), 1024), _MOST))
    t = np.linspace(start, end, n + 1)
    inner = (t[:-1, None] + (end - start) / n * _NODES).ravel()
    w = values_at(run, run.case, [speed], inner)[:, 0].reshape(n, 3)
    if not (w > 0).all() and not (w < 0).all():
        raise ParameterError(f"orders: '{speed}' must keep its sign in the window; give after= and before=")
    angle = np.concatenate([[0.0], np.cumsum(w @ _WEIGHTS) * (end - start) / n])
    return t, angle, values_at(run, run.case, [speed], t)[:, 0]


def _times(t: Array, angle: Array, rate: Array, wanted: Array) -> Array:
    """When the shaft has turned by the wanted angles: Hermite's cubic of each interval, by Newton's method."""
    i = np.clip(np.searchsorted(np.abs(angle), np.abs(wanted), side="right") - 1, 0, len(t) - 2)
    h, a, b = t[i + 1] - t[i], angle[i], angle[i + 1]
    u, v = rate[i] * h, rate[i + 1] * h
    s = (wanted - a) / (b - a)
    for _ in range(_STEPS):
        value = a + s * (u + s * (3 * (b - a) - 2 * u - v + s * (u + v - 2 * (b - a))))
        slope = u + s * (2 * (3 * (b - a) - 2 * u - v) + 3 * s * (u + v - 2 * (b - a)))
        s = np.clip(s - (value - wanted) / slope, 0.0, 1.0)
    found: Array = t[i] + s * h
    return found
