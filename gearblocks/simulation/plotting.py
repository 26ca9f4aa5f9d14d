"""Pictures: traces over time, phase planes, stroboscopic points.

Colours are those of Okabe and Ito, which colour-blind readers tell apart; units get a prefix that fits the numbers.
"""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import StorageError
from gearblocks.files import as_path, write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Series = tuple[str, str, Array]
"""Name, unit and values of one quantity."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#A08C00")
DASHES = ("-", "--", ":", "-.")
"""Of the first curves that have the colours, of those after them, and so on."""
NO_UNIT = ("", "1")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")

_STYLE: dict[str, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.dpi": 110,
    "svg.hashsalt": "gearblocks",
}
_PREFIX = {-12: "p", -9: "n", -6: "\N{MICRO SIGN}", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_PREFIXED = ("m", "N", "s", "rad", "W", "J", "V", "A", "Pa", "Hz")
_KINDS = {
    "m": "distance",
    "rad": "angle",
    "rad/s": "speed",
    "m/s": "speed",
    "N": "force",
    "N m": "torque",
    "W": "power",
    "J": "energy",
}
_MOST_SAMPLES = 200_000
_MOST_EVENTS = 300
_NOTHING = ("None", "none", " ", "", None)  # as a marker or a line
_EDGE = 1.0  # pixels beyond the axes, where a marker still shows


@dataclass(frozen=True, slots=True)
class Plane:
    """Two quantities against each other: a curve, marked points on it, and vertical lines (edges of a gap)."""

    title: str
    x: Series
    y: Series
    points: tuple[Array, Array] | None = None
    edges: tuple[float, ...] = ()


def over_time(
    t: Array, series: Sequence[Series], *, title: str = "", path: str | os.PathLike[str] | None = None,
    events: Array | None = None,
) -> Figure:  # fmt: skip
    """Traces over time, those of one unit in one panel, names written beside them, equal ones together; whole numbers as steps;
    events: times of ticks at the foot; saved to `path` where given."""
    panels: dict[str, list[Series]] = {}
    for item in series:
        panels.setdefault(item[0].rpartition(".")[2] if item[1] in NO_UNIT else item[1], []).append(item)
    with style():
        figure, axes = new_figure(path, rows=max(1, len(panels)), size=(7.2, 0.9 + 1.7 * max(1, len(panels))))
        clock, clock_unit = prefixed([t], "s")
        for axis, group in zip(axes, panels.values(), strict=False):
            factor, unit = prefixed([values for _, _, values in group], group[0][1])
            curves = _distinct(group)
            for number, (label, values) in enumerate(curves):
                time, shown = _thinned(t * clock, values * factor)
                how = "steps-post" if _is_whole(group[0][1], values) else "default"
                dashes = DASHES[number // len(COLOURS) % len(DASHES)]
                axis.plot(
                    time, shown, color=COLOURS[number % len(COLOURS)], label=label, linestyle=dashes, drawstyle=how
                )
            if events is not None and 0 < len(events) <= _MOST_EVENTS:
                foot = axis.get_xaxis_transform()
                axis.plot(events * clock, np.zeros(len(events)), "|", color="#555555", markersize=10, transform=foot)
            if all(_is_whole(group[0][1], values) for _, values in curves):
                axis.locator_params(axis="y", integer=True)
            axis.set_ylabel(_axis_words(group, unit))
            if len(curves) > 1 or len(curves) < len(group):
                legend(axis, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        axes[-1].set_xlabel(f"time in {clock_unit}")
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=10)
        return finished(figure, path)


def spectrum_picture(
    frequency: Array, lines: Series, *, title: str = "", path: str | os.PathLike[str] | None = None
) -> Figure:
    """Amplitudes over the frequency [Hz], up to where no line is more than a hundredth of the largest. Those of the mean, which
    is two lines wide under the window, are left out."""
    name, unit, amplitude = lines
    large = np.flatnonzero(amplitude[2:] > 1e-2 * np.max(amplitude[2:], initial=0.0))
    shown = slice(2, 4 + int(large[-1]) * 21 // 20 if len(large) else None)
    f, a = frequency[shown], amplitude[shown]
    (f_factor, f_unit), (a_factor, a_unit) = prefixed([f], "Hz"), prefixed([a], unit)
    with style():
        figure, (axis,) = new_figure(path, size=(7.2, 2.6))
        axis.vlines(f * f_factor, 0.0, a * a_factor, color=COLOURS[0], linewidth=1.1)
        axis.set_ylim(bottom=0.0)
        axis.set_xlabel(f"frequency in {f_unit}")
        axis.set_ylabel(_label(name, a_unit))
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontsize=10)
        return finished(figure, path)


def _distinct(group: Sequence[Series]) -> list[tuple[str, Array]]:
    """(label, values) of each curve, those that are equal as one."""
    found: list[tuple[list[str], Array]] = []
    for name, _, values in group:
        same = next((names for names, other in found if np.array_equal(values, other, equal_nan=True)), None)
        if same is None:
            found.append(([name], values))
        else:
            same.append(name)
    return [(names[0] + _also(names[1:]), values) for names, values in found]


def _also(names: Sequence[str]) -> str:
    """Words for further names of a curve."""
    if not names:
        return ""
    return f" = {names[0]}" + (f" and {len(names) - 1} more" if len(names) > 1 else "")


def _is_whole(unit: str, values: Array) -> bool:
    """Whether a quantity without a unit takes a few whole numbers only: a mode, a side, a gear."""
    whole = unit in NO_UNIT and len(values) > 0 and bool((values == np.round(values)).all())
    return whole and float(np.ptp(values)) <= 20


def planes(items: Sequence[Plane], *, path: str | os.PathLike[str] | None = None, columns: int = 2) -> Figure:
    """Phase planes side by side, each with its own limits, all in the same units; saved to `path` where given."""
    rows = math.ceil(len(items) / columns)
    x_scale = prefixed([values for item in items for values in _extent(item, 0)], items[0].x[1])
    y_scale = prefixed([values for item in items for values in _extent(item, 1)], items[0].y[1])
    with style():
        figure, axes = new_figure(path, rows=rows, columns=columns, size=(3.6 * columns, 3.1 * rows))
        for axis, item in zip(axes, items, strict=False):
            _plane(axis, item, x_scale, y_scale)
        for axis in axes[len(items) :]:
            axis.set_axis_off()
        return finished(figure, path)


def prefixed(arrays: Sequence[Array], unit: str) -> tuple[float, str]:
    """Factor and unit with the SI prefix that brings the largest number to 1 .. 10,000."""
    head = unit.replace("/", " ").split(" ")[0] if unit else ""
    sizes = [float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)) for values in arrays]
    size = max(sizes, default=0.0)
    if head not in _PREFIXED or size == 0.0 or 1.0 <= size < 1e4:
        return 1.0, unit
    power = min(max(3 * math.floor(math.log10(size) / 3), -12), 9)
    return 10.0**-power, _PREFIX[power] + unit


def _extent(item: Plane, axis: int) -> tuple[Array, ...]:
    curve = (item.x, item.y)[axis][2]
    return (curve,) if item.points is None else (curve, item.points[axis])


def _plane(axis: Axes, item: Plane, x_scale: tuple[float, str], y_scale: tuple[float, str]) -> None:
    (x_name, _, x), (y_name, _, y) = item.x, item.y
    (x_factor, x_unit), (y_factor, y_unit) = x_scale, y_scale
    axis.plot(x * x_factor, y * y_factor, color=COLOURS[0], linewidth=0.7, alpha=0.9 if item.points is None else 0.45)
    if item.points is not None:
        few = len(np.unique(np.round(item.points[0] * x_factor, 6))) <= 60
        axis.plot(
            item.points[0] * x_factor, item.points[1] * y_factor, linestyle="none", marker="o" if few else ".",
            markersize=5 if few else 2.5, color=COLOURS[1], markeredgecolor="white" if few else "none",
            markeredgewidth=0.6, zorder=3,
        )  # fmt: skip
    if not len(x) and item.points is not None:
        axis.set_xlim(_limits(item.points[0] * x_factor))
        axis.set_ylim(_limits(item.points[1] * y_factor))
    for edge in item.edges:
        axis.axvline(edge * x_factor, color="#555555", linewidth=0.8, linestyle=":")
    axis.locator_params(axis="x", nbins=6)
    axis.set_xlabel(_label(x_name, x_unit))
    axis.set_ylabel(_label(y_name, y_unit))
    axis.set_title(item.title)


def _limits(values: Array) -> tuple[float, float]:
    """Limits about the values, never closer than 5 % of their size: a single point shall look like one."""
    low, high = float(values.min()), float(values.max())
    half = max(0.65 * (high - low), 0.05 * max(abs(low), abs(high)), 1e-12)
    return 0.5 * (low + high) - half, 0.5 * (low + high) + half


def _axis_words(group: Sequence[Series], unit: str) -> str:
    kinds = {name.rpartition(".")[2].replace("_", " ") for name, _, _ in group}
    words = group[0][0] if len(group) == 1 else kinds.pop() if len(kinds) == 1 else _KINDS.get(group[0][1], "")
    return _label(words, unit)


def _label(words: str, unit: str) -> str:
    if len(words) > 26:  # longer than a panel is high
        words = ".\n".join(words.rsplit(".", 1))
    if unit in NO_UNIT:
        return words
    return f"{words}\nin {unit}" if len(words) > 18 else f"{words} in {unit}" if words else f"in {unit}"


def _thinned(t: Array, values: Array) -> tuple[Array, Array]:
    """At most about _MOST_SAMPLES points that keep the extremes of every slice."""
    if len(t) <= _MOST_SAMPLES:
        return t, values
    width = -(-len(t) // (_MOST_SAMPLES // 2))
    starts = np.arange(0, len(t), width)
    low = np.array([start + int(np.argmin(values[start : start + width])) for start in starts])
    high = np.array([start + int(np.argmax(values[start : start + width])) for start in starts])
    kept = np.unique(np.concatenate([low, high]))
    return t[kept], values[kept]


@contextmanager
def style() -> Iterator[None]:
    """The look of all pictures, as a context."""
    import matplotlib as mpl

    with mpl.rc_context(_STYLE):
        yield
        interactive = mpl.is_interactive()  # a notebook turns it on with the first figure, in here
    mpl.interactive(interactive)


def new_figure(
    path: str | os.PathLike[str] | None, *, size: tuple[float, float], rows: int = 1, columns: int = 1
) -> tuple[Figure, list[Axes]]:
    """A figure known to pyplot (shown by notebooks and `plt.show()`) only where it is not written to a file."""
    if path is None:
        from matplotlib import pyplot

        from gearblocks.simulation.notebook_figure import NotebookFigure

        figure: Figure = pyplot.figure(figsize=size, layout="constrained", FigureClass=NotebookFigure)
    else:
        from matplotlib.figure import Figure as PlainFigure

        figure = PlainFigure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=columns == 1 and rows > 1)
    return figure, list(axes.flat)


def legend(axis: Axes, *beside: Axes, **options: Any) -> None:
    """A legend of what is seen in the axes or those beside: a curve without a value there, or beyond the limits, is not listed.

    To be called when everything is drawn.
    """
    seen: dict[str, Any] = {}
    for one in (axis, *beside):
        for handle, words in zip(*one.get_legend_handles_labels(), strict=True):
            if words not in seen and _is_seen(one, handle):
                seen[words] = handle
    if seen:
        axis.legend([*seen.values()], [*seen], **options)


def _is_seen(axis: Axes, artist: Any) -> bool:
    """Whether a point, a segment or an area of an artist lies within the axes. A point alone is nothing without a marker."""
    axis.get_xlim(), axis.get_ylim()  # which set what follows from the data
    if not hasattr(artist, "get_xydata"):
        area = artist.get_path().transformed(artist.get_transform()).get_extents()
        return _meets(axis, area.min[None], area.max[None])
    xy = artist.get_transform().transform(np.ma.filled(np.ma.asarray(artist.get_xydata(), dtype=float), np.nan))
    marked, joined = artist.get_marker() not in _NOTHING, artist.get_linestyle() not in _NOTHING
    return (marked and _meets(axis, xy, xy)) or (joined and _meets(axis, xy[:-1], xy[1:]))


def _meets(axis: Axes, a: Array, b: Array) -> bool:
    """Whether a rectangle with these corners, shape (k, 2), in pixels, lies in the axes in part."""
    low, high = np.asarray(axis.bbox.get_points())
    inside = (np.maximum(a, b) >= low - _EDGE) & (np.minimum(a, b) <= high + _EDGE)
    return bool((inside & np.isfinite(a + b)).all(axis=1).any())


def finished(figure: Figure, path: str | os.PathLike[str] | None) -> Figure:
    """The figure, written to `path` where given. Raises StorageError."""
    if path is not None:
        known = figure.canvas.get_supported_filetypes()
        form = as_path(path).suffix.lstrip(".").lower()
        if form not in known:
            raise StorageError(
                f"'{path}': a picture's ending must be one of {', '.join('.' + name for name in sorted(known))}"
            )
        picture = io.BytesIO()
        figure.savefig(picture, format=form)
        write_bytes(path, picture.getbuffer())
    return figure
