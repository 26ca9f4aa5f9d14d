"""Plots of a run: written, returned, refused by name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gearblocks.errors import StorageError, UnknownNameError
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
