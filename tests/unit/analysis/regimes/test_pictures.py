"""Pictures of the laboratory: their legends list what is drawn, all of it, in words and looks of its own."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.colors import to_rgba

from gearblocks.analysis.regimes.basin_picture import draw_basins
from gearblocks.analysis.regimes.carried import Jump
from gearblocks.analysis.regimes.order_map import OrderMap
from gearblocks.analysis.regimes.order_pictures import draw_lines
from gearblocks.analysis.regimes.pictures import draw_bifurcation, draw_history
from gearblocks.analysis.regimes.response_pictures import draw_branch, draw_sweep

VALUES = np.linspace(1.0, 2.0, 5)
NOTHING = np.full(5, np.nan)
OVER = {"path": "w", "unit": "rad/s", "values": VALUES, "of": "mesh.force", "of_unit": "N"}


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    """Figures that pyplot keeps are given back."""
    yield
    pyplot.close("all")


def _words(axis: Any) -> list[str]:
    listed = axis.get_legend()
    return [] if listed is None else [text.get_text() for text in listed.get_texts()]


def _branch(stable: list[bool]) -> Any:
    marks = [SimpleNamespace(kind="fold", value=1.5, number=2)] if not all(stable) else []
    found: Any = SimpleNamespace(**OVER, rms=VALUES**2, stable=np.array(stable), marks=marks)
    (axis,) = draw_branch(found, None).axes
    return axis


@pytest.mark.parametrize(
    ("stable", "words"),
    [
        ([True] * 5, ["stable"]),
        ([False] * 5, ["unstable", "fold"]),
        ([True, True, False, False, True], ["stable", "unstable", "fold"]),
        ([False, False, True, False, False], ["stable", "unstable", "fold"]),
    ],
)
def test_a_branch_lists_the_stability_that_it_has(stable: list[bool], words: list[str]) -> None:
    assert _words(_branch(stable)) == words


def test_a_stable_orbit_between_unstable_ones_is_a_dot() -> None:
    line = _branch([False, False, True, False, False]).lines[0]
    assert line.get_marker() == "." and line.get_markevery() == [2] and np.isfinite(line.get_ydata()).sum() == 1
    assert _branch([True, True, False, True, True]).lines[0].get_marker() == ""


@pytest.mark.parametrize(("up", "down", "words"), [(VALUES, NOTHING, ["up"]), (VALUES, VALUES, ["down", "up"])])
def test_a_way_that_failed_altogether_is_not_listed(up: Any, down: Any, words: list[str]) -> None:
    rows: Any = np.array([up, down])
    swept: Any = SimpleNamespace(**OVER, rms=rows, peak_to_peak=3 * rows, jumps=())
    assert _words(draw_sweep(swept, None).axes[0]) == words
    points: Any = SimpleNamespace(**OVER, points=rows[..., None], directions=("up", "down"))
    assert _words(draw_bifurcation(points, None).axes[0]) == words


def test_jumps_of_each_way_are_listed_once_beside_axes_of_their_own_words() -> None:
    rows = np.array([VALUES, VALUES])
    jumps = [Jump("up", 1.2, 1.21, 1.0, 2.0), Jump("up", 1.5, 1.51, 1.0, 2.0), Jump("down", 1.4, 1.39, 2.0, 1.0)]
    swept: Any = SimpleNamespace(**OVER, rms=rows, peak_to_peak=3 * rows, jumps=jumps)
    upper, lower = draw_sweep(swept, None).axes
    assert _words(upper) == ["down", "up", "jump on the way up", "jump on the way down"]
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("rms in N", "peak-to-peak in N")


@pytest.mark.parametrize("count", [1, 8, 11])
def test_exponents_are_listed_with_their_errors(count: int) -> None:
    values = np.linspace(1.0, -3.0, count)
    found: Any = SimpleNamespace(history=np.tile(values, (50, 1)), values=values, errors=np.full(count, 0.01))
    (axis,) = draw_history(found, None).axes
    shown = min(count, 8)
    assert _words(axis) == [f"{value:.4g} \N{PLUS-MINUS SIGN} 0.03" for value in values[:shown]]
    assert [line.get_color() for line in axis.get_legend().get_lines()] == [x.get_color() for x in axis.lines[:shown]]
    title = axis.get_legend().get_title().get_text()
    assert title == ("first 8 of 11,\n" if count > shown else "") + "in 1/s, \N{PLUS-MINUS SIGN} 3 errors"


def _orders(amplitude: dict[float, float], skirt: float = 0.0) -> OrderMap:
    """Lines of Hann's window at orders, and what falls away beside them as it does where amplitudes change within a part."""
    order = np.arange(60 * 8 + 1) / 8
    far = np.abs(order[:, None] - np.array([*amplitude])) * 8
    sizes = np.array([*amplitude.values()])
    line = np.where(far < 0.5, 1.0, np.where(far < 1.5, 0.5, skirt / np.maximum(far, 1.0) ** 3)) @ sizes
    return OrderMap(np.ones(2), np.array([1.0, 2.0]), order, np.tile(line, (2, 1)), "f", "N", "w", "rad/s", 8)


def test_what_falls_away_beside_an_order_is_no_order() -> None:
    found = _orders({23.0: 1000.0, 46.0: 100.0}, skirt=5.0)
    assert found.amplitude[0, found.order == 23.625] > 30.0  # the fifth line beside
    assert found.largest(6)[:2] == [23.0, 46.0] and not any(abs(order - 23.0) < 3 for order in found.largest(6)[1:])
    near = _orders({23.0: 1000.0, 24.0: 100.0, 22.375: 300.0}, skirt=0.02)
    assert near.largest(3) == [23.0, 22.375, 24.0]


def test_orders_are_listed_where_their_curves_are_seen() -> None:
    figure = _orders({7.0: 100.0, 23.0: 1000.0, 46.0: 2.0}).plot()
    right = figure.axes[1]
    assert _words(right) == ["order 23", "order 7"] and len(right.lines) == 2
    tops = [float(np.max(line.get_ydata())) for line in right.lines]
    assert min(tops) > 0.01 * max(tops)


def test_lines_end_where_none_is_seen_any_more() -> None:
    found: Any = SimpleNamespace(
        order=np.arange(100.0), amplitude=np.exp(-0.5 * np.arange(100.0)), of="f", unit="N", speed=None
    )
    (axis,) = draw_lines(found, None).axes
    (lines,) = axis.collections
    heights = [segment[1, 1] for segment in lines.get_segments()]
    assert len(heights) == 10 and min(heights) > 0.01 * max(heights)


def _basins(numbers: Any, count: int, outputs: bool = True) -> Any:
    points = np.array([[0.1, 0.2]])
    attractors = [SimpleNamespace(label=f"kind {i}", period=1, points=points, share=0.1) for i in range(count)]
    found: Any = SimpleNamespace(
        paths=("a", "b"), units=("rad", "rad/s"), levels=(np.arange(3.0), np.arange(4.0)), numbers=np.array(numbers),
        names=("a", "b") if outputs else ("c",), attractors=attractors,
    )  # fmt: skip
    return draw_basins(found, None).axes[0]


def test_failed_runs_are_listed_in_their_colour_where_there_are_any() -> None:
    axis = _basins([[0, 0, 1, 1], [-2, -2, -2, 0], [1, 1, -1, -1]], 3)
    assert _words(axis) == ["kind 0: 10 %", "kind 1: 10 %", "kind 2: 10 %", "run failed: 25 %"]
    (cells,) = axis.collections
    shown = cells.to_rgba(cells.get_array()).reshape(4, 3, 4)
    listed = [patch.get_facecolor() for patch in axis.get_legend().get_patches()]
    for start, number in (((0, 0), 0), ((0, 2), 1), ((2, 2), 2), ((1, 0), 3)):
        assert tuple(shown[start[::-1]]) == pytest.approx(listed[number], abs=0.01)
    assert "run failed" not in " ".join(_words(_basins(np.zeros((3, 4), dtype=int), 1)))


def test_no_two_basins_look_alike_and_none_like_failed_runs() -> None:
    numbers = (np.arange(12) - 1).reshape(3, 4)
    axis = _basins(np.where(numbers < 0, -2, numbers), 17, outputs=False)
    listed = {tuple(np.round(patch.get_facecolor(), 3)) for patch in axis.get_legend().get_patches()}
    assert len(listed) == 18 == len(_words(axis)) and to_rgba("white") not in listed


def test_the_cells_at_the_border_of_a_grid_are_whole() -> None:
    axis = _basins(np.zeros((3, 4), dtype=int), 1)
    assert axis.get_xlim() == (-0.5, 2.5) and axis.get_ylim() == (-0.5, 3.5)
