"""Plots of a run: written, returned, refused by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gearblocks.errors import StorageError, UnknownNameError
from gearblocks.simulation.plotting import COLOURS, DASHES, legend, new_figure, over_time, style
from gearblocks.simulation.trajectory import Trajectory


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
@pytest.mark.few(1)
def test_a_plot_is_written_and_returned(make_run: Callable[..., Trajectory], tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"bild{ending}"
    figure = make_run(columns={"mesh.force": np.arange(4.0), "a.w": np.ones(4)}).plot("mesh.*", "a.w", path=path)
    assert path.stat().st_size > 1000
    assert len(figure.axes) == 2


def test_a_plot_of_an_unknown_output_or_form_is_refused(make_run: Callable[..., Trajectory], tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"mesh\.torque"):
        make_run().plot("mesh.torque", path=tmp_path / "x.png")
    with pytest.raises(StorageError, match=r"\.png"):
        make_run().plot("wheel.w", path=tmp_path / "x.docx")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("count", [2, 8, 9, 17, 32])
def test_no_two_curves_of_a_panel_look_alike(count: int) -> None:
    t = np.linspace(0.0, 1.0, 5)
    figure = over_time(t, [(f"part{i}.torque", "N m", (i + 0.5) * t) for i in range(count)])
    (panel,) = figure.axes
    looks = [(line.get_color(), line.get_linestyle()) for line in panel.lines]
    assert len(set(looks)) == len(looks) == count <= len(COLOURS) * len(DASHES)


def test_a_legend_lists_what_lies_in_the_axes() -> None:
    with style():
        _, (axis, beside) = new_figure(None, rows=2, size=(4.0, 4.0))
    line, missing = np.array([0.0, 1.0, 2.0]), np.full(3, np.nan)
    axis.plot(line, line, label="line")
    axis.plot(line, missing, label="no value")
    axis.plot(line, np.array([np.nan, 1.0, np.nan]), label="a point without a marker")
    axis.plot(line, np.array([np.nan, 1.0, np.nan]), "o", label="a point")
    axis.plot([], [], "o", label="nothing")
    axis.plot(line, line + 90.0, label="beyond")
    axis.plot([-9.0, 9.0], [1.5, 1.5], label="across")
    axis.axvspan(0.5, 0.6, label="band")
    axis.axvspan(7.5, 7.6, label="band beyond")
    axis.set_xlim(0.0, 2.0)
    axis.set_ylim(0.0, 2.0)
    beside.plot(line, line, label="beside")
    beside.plot(line, line, label="no value")
    legend(axis)
    assert [text.get_text() for text in axis.get_legend().get_texts()] == ["line", "a point", "across", "band"]
    legend(axis, beside)
    assert [text.get_text() for text in axis.get_legend().get_texts()][4:] == ["beside", "no value"]


def test_there_is_no_legend_of_nothing() -> None:
    with style():
        _, (axis,) = new_figure(None, size=(4.0, 4.0))
    axis.semilogx([1.0, 2.0], [np.nan, np.nan], label="no value")
    legend(axis)
    assert axis.get_legend() is None
