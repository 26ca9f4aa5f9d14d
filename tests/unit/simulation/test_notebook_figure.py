"""A figure of a notebook is shown once, whichever way it comes to be shown first."""

from __future__ import annotations

import pickle

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

from gearblocks.simulation.notebook_figure import NotebookFigure
from gearblocks.simulation.plotting import over_time, style

T = np.linspace(0.0, 1.0, 11)


def figure() -> NotebookFigure:
    made = over_time(T, [("mesh.force", "N", T)])
    assert isinstance(made, NotebookFigure)
    return made


def test_a_figure_that_a_cell_shows_is_no_longer_one_of_pyplot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mpl, "get_backend", lambda: "module://matplotlib_inline.backend_inline")
    before = pyplot.get_fignums()
    first, second = figure(), figure()
    with pytest.raises(NotImplementedError):  # which asks IPython for the usual picture
        first._ipython_display_()
    assert pyplot.get_fignums() == [*before, second.number]
    pyplot.close(second)


def test_a_figure_in_a_window_stays_one_of_pyplot() -> None:
    made = figure()
    with pytest.raises(NotImplementedError):
        made._ipython_display_()
    assert made.number in pyplot.get_fignums()
    pyplot.close(made)


def test_what_a_notebook_turns_on_with_its_first_figure_stays_on() -> None:
    before = mpl.is_interactive()
    try:
        with style():
            mpl.interactive(True)
        assert mpl.is_interactive()
    finally:
        mpl.interactive(before)


def test_a_figure_can_be_pickled() -> None:
    made = figure()
    pyplot.close(made)
    assert len(pickle.loads(pickle.dumps(made)).axes) == 1
