"""Pictures of studies: lines over one dimension, colours over two, cases over each value, points of a section as dots."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError
from gearblocks.simulation.plotting import COLOURS, NO_UNIT, finished, legend, new_figure, prefixed, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_TICKED = 12
"""Values of an axis of cells that are written at it."""


class Study(Protocol):
    """What is drawn of a study (`study_result.py`)."""

    @property
    def paths(self) -> tuple[str, ...]: ...
    @property
    def failed(self) -> NDArray[np.bool_]: ...
    @property
    def units(self) -> tuple[str, ...]: ...
    @property
    def points(self) -> Array: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def names(self) -> tuple[str, ...]: ...
    @property
    def name_units(self) -> tuple[str, ...]: ...
    @property
    def done(self) -> NDArray[np.bool_]: ...
    @property
    def meta(self) -> Mapping[str, Any]: ...
    def __getitem__(self, name: str) -> Array: ...


def picture(study: Study, names: Sequence[str], path: str | os.PathLike[str] | None) -> Figure:
    """One panel per quantity; saved to `path` where given."""
    plane = len(study.shape) == 2
    if len(study.shape) > 2:
        raise ParameterError(
            f"a picture has one or two dimensions, this study {len(study.shape)}: take one out of to_xarray()"
        )
    if not study.shape and len(study.paths) > 1:
        return _design(study, names, path)
    columns = min(2, len(names)) if plane else 1
    rows = math.ceil(len(names) / columns)
    size = (4.4 * columns + 0.6, 3.4 * rows) if plane else (7.2, 0.9 + 2.0 * rows)
    with style():
        figure, axes = new_figure(path, rows=rows, columns=columns, size=size)
        for axis, name in zip(axes, names, strict=False):
            if plane:
                _colours(figure, axis, study, name)
            else:
                _line(axis, study, name, 0)
        for axis in axes[len(names) :]:
            axis.set_axis_off()
        if not plane:
            axes[-1].set_xlabel(_label(*_over(study, 0)[:2]))
        figure.suptitle(str(study.meta.get("train", "")), x=0.01, ha="left", fontsize=10)
        return finished(figure, path)


def _design(study: Study, names: Sequence[str], path: str | os.PathLike[str] | None) -> Figure:
    """Cases over each of the values that vary in them: a row per quantity, a column per path."""
    rows, columns = len(names), len(study.paths)
    with style():
        size = (max(7.2, 1.0 + 2.4 * columns), 0.9 + 2.0 * rows)
        figure, axes = new_figure(path, rows=rows, columns=columns, size=size)
        for number, axis in enumerate(axes):
            row, column = divmod(number, columns)
            _line(axis, study, names[row], column)
            if column:
                if (listed := axis.get_legend()) is not None:
                    listed.remove()
                axis.set_ylabel("")
                axis.tick_params(labelleft=False)
            axis.tick_params(labelbottom=row == rows - 1)
            axis.locator_params(axis="x", nbins=4)
        for axis, (name, unit, _) in zip(axes[-columns:], (_over(study, i) for i in range(columns)), strict=True):
            axis.set_xlabel(_label(name, unit))
        figure.suptitle(str(study.meta.get("train", "")), x=0.01, ha="left", fontsize=10)
        return finished(figure, path)


def _over(study: Study, i: int) -> tuple[str, str, Any]:
    """Name, unit and values of the horizontal axis of lines."""
    factor, unit = prefixed([study.points[:, i]], study.units[i])
    return study.paths[i], unit, study.points[:, i] * factor


def _line(axis: Axes, study: Study, name: str, over: int) -> None:
    """A quantity over one of the values that vary."""
    x, values = _over(study, over)[2], study[name]
    factor, unit = prefixed([values.ravel()], study.name_units[study.names.index(name)])
    shown = values * factor
    if shown.ndim > 1:
        axis.plot(x, shown, linestyle="none", marker=".", markersize=2.5, color=COLOURS[0], markeredgecolor="none")
        missing = np.isnan(shown).all(axis=1)
    else:
        order = np.argsort(x, kind="stable")
        joined = bool(study.shape)
        axis.plot(
            x[order], shown[order], linestyle="-" if joined else "none", marker="o", markersize=3, color=COLOURS[0]
        )
        missing = np.isnan(shown)
    missing &= study.done
    if missing.any():
        low = axis.get_ylim()[0]
        label = _missing_words(study, missing)
        axis.plot(x[missing], np.full(int(missing.sum()), low), "x", color=COLOURS[1], label=label, clip_on=False)
        legend(axis)
    axis.set_ylabel(_label(name, unit))


def _missing_words(study: Study, missing: NDArray[np.bool_]) -> str:
    """What points without a value are: failed, or runs that have no such value."""
    failed = study.failed[missing]
    return "failed" if failed.all() else "failed, or none" if failed.any() else "none"


def _colours(figure: Figure, axis: Axes, study: Study, name: str) -> None:
    values = study[name]
    if values.ndim > 2:
        raise ParameterError(f"'{name}' has several points in each cell of the plane: draw a study over one dimension")
    factor, unit = prefixed([values.ravel()], study.name_units[study.names.index(name)])
    levels, labels = [], []
    for i in range(2):
        column = study.points[:, i].reshape(study.shape)
        row = column[:, 0] if i == 0 else column[0]
        scale, shown_unit = prefixed([row], study.units[i])
        levels.append(row * scale)
        labels.append(_label(study.paths[i], shown_unit))
    orders = [np.argsort(row, kind="stable") for row in levels]
    levels = [row[order] for row, order in zip(levels, orders, strict=True)]
    x, y = map(_places, levels)
    shown = (values * factor)[np.ix_(*orders)].T
    mesh = axis.pcolormesh(x, y, np.ma.masked_invalid(shown), shading="nearest", cmap="viridis", rasterized=True)
    figure.colorbar(mesh, ax=axis, label=unit if unit not in NO_UNIT else "")
    lost = np.isnan(values) & study.done.reshape(study.shape)
    if lost.any():
        rows, columns = np.nonzero(lost[np.ix_(*orders)].T)
        axis.plot(x[columns], y[rows], "x", color=COLOURS[1], label=_missing_words(study, lost.ravel()))
        legend(axis)
    axis.grid(visible=False)
    for ticks, row, places in ((axis.set_xticks, levels[0], x), (axis.set_yticks, levels[1], y)):
        if len(row) <= _TICKED or places is not row:
            shown_at = slice(None, None, -(-len(row) // _TICKED))
            ticks(places[shown_at], [f"{value:.6g}" for value in row[shown_at]])
    axis.set_title(name)
    axis.set_xlabel(labels[0])
    axis.set_ylabel(labels[1])


def _places(row: Array) -> Array:
    """Where cells stand: at their values, of uneven values side by side, as a cell is no wider than another then."""
    steps = np.diff(row)
    even = len(row) < 3 or bool(np.ptp(steps) <= 1e-6 * np.abs(steps).max())
    return row if even else np.arange(len(row), dtype=float)


def _label(words: str, unit: str) -> str:
    return words if unit in NO_UNIT else f"{words}\nin {unit}" if len(words) > 18 else f"{words} in {unit}"
