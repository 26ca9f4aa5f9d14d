"""Pictures of the published systems: what is drawn is explained in them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from gearblocks.cli import scripts

pytestmark = pytest.mark.long


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Figures that are saved."""
    kept: list[Figure] = []
    monkeypatch.setattr(Figure, "savefig", lambda self, path, **more: kept.append(self))
    return kept


def _model(name: str) -> Any:
    return scripts.load(scripts.shipped()[name])


def test_the_timing_of_the_transmission_names_its_lines_and_bands(drawn: list[Figure], tmp_path: Path) -> None:
    model = _model("noncircular_cvt")
    model.picture(tmp_path / "timing.png")
    (figure,) = drawn
    (listed,) = figure.legends
    words = [text.get_text() for text in listed.get_texts()]
    assert words == ["speed", "even speed, k delta of the input's", "both windows open"]
    for axis in figure.axes[1::2]:
        even = next(line for line in axis.lines if line.get_label() == words[1])
        assert even.get_ydata()[0] == pytest.approx(model.SPEED * model.i_out(np.pi / 3))
        assert even.get_color() == listed.get_lines()[1].get_color()


def test_the_dynamic_factor_says_which_backlash_it_is_drawn_with(drawn: list[Figure], tmp_path: Path) -> None:
    _model("spline_coupling").picture_kv(tmp_path / "kv.png")
    left, right = drawn[0].axes
    # systems/spline_coupling.md: b is half of the backlash
    assert left.get_xlabel() == "mean torque in N m (half of the backlash: 0.396 mm)"
    assert right.get_xlabel() == "half of the backlash in mm (2600 N m)"
    # kv depends on torque over backlash alone: each curve reads the other one
    for a, b in zip(left.lines, right.lines, strict=True):
        half = 0.396 * 2600 / a.get_xdata()
        known = (half >= 0.1) & (half <= 0.55)
        assert a.get_ydata()[known] == pytest.approx(np.interp(half[known], *b.get_data()), rel=0.02)
