"""What a study found as arrays, files and pictures."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import gearblocks as gb

QUANTITIES = (gb.peak("shaft.torque"), gb.energy_lost("clutch"), gb.event_time("clutch", number=5))


@pytest.fixture(scope="module")
def grid(clutch_model: gb.Model) -> gb.Study:
    """Two dimensions; a gain of 1e4 fails, and no clutch locks six times."""
    values = {"gain": [0.0, 1e4, 0.02], "shaft.k": [200.0, 150.0]}
    return gb.sweep(clutch_model, values, quantity=QUANTITIES, t_end=0.5)


@pytest.fixture(scope="module")
def cases(clutch_model: gb.Model) -> gb.Study:
    columns = gb.latin_hypercube({"shaft.k": (100, 200), "clutch.capacity": (5, 9)}, 6, seed=2)
    return gb.study(clutch_model, columns, quantity=QUANTITIES[:2], t_end=0.5)


@pytest.fixture(scope="module")
def sections(clutch_model: gb.Model) -> gb.Study:
    """Six points of a section at each of four values."""
    rig = gb.Drivetrain("driven")
    speed = gb.Parameter("speed", 40.0, "rad/s")
    drive, body = rig.add("drive", gb.Torque(tau=gb.cos(speed * gb.time))), rig.add("body", gb.Inertia(J=1.0))
    rig.chain(drive, body, rig.add("damper", gb.Damper(c=3.0)), rig.add("ground", gb.Fixed()))
    return gb.sweep(
        rig, {"speed": [10.0, 20.0, 30.0, 40.0]}, quantity=[gb.points("body.w"), gb.last("body.w")],
        section=gb.stroboscopic("speed"), transient=2, keep=6,
    )  # fmt: skip


def test_xarray_has_units_coordinates_and_the_shape_of_the_grid(grid: gb.Study) -> None:
    data = grid.to_xarray()
    assert data["peak(shaft.torque)"].dims == ("gain", "shaft.k")
    assert data["peak(shaft.torque)"].attrs == {"units": "N m", "long_name": "peak(shaft.torque)"}
    assert data["shaft.k"].attrs["units"] == "N m/rad"
    assert float(data["energy_lost(clutch)"].sel({"gain": 0.02, "shaft.k": 150.0})) == grid["energy_lost(clutch)"][2, 1]
    assert np.isnan(data["peak(shaft.torque)"].sel({"gain": 1e4})).all()


def test_cases_are_one_dimension_with_their_values_along_it(cases: gb.Study) -> None:
    data = cases.to_xarray()
    assert data["peak(shaft.torque)"].dims == ("case",)
    assert (data["clutch.capacity"].values == cases.points[:, 1]).all()


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
@pytest.mark.parametrize("which", ["grid", "cases", "sections"])
@pytest.mark.few(3)
def test_files_keep_everything(which: str, ending: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    if ending == ".zarr":
        pytest.importorskip("zarr")
    found: gb.Study = request.getfixturevalue(which)
    found.save(tmp_path / f"study{ending}")
    again = gb.Study.load(tmp_path / f"study{ending}")
    assert again.values.tobytes() == found.values.tobytes() and again.points.tobytes() == found.points.tobytes()
    assert (again.names, again.units, again.shape, again.meta) == (
        found.names,
        found.units,
        found.shape,
        dict(found.meta),
    )
    assert again.failures == found.failures and repr(again) == repr(found)


def test_csv_has_a_line_per_point_with_all_digits(grid: gb.Study, sections: gb.Study, tmp_path: Path) -> None:
    grid.to_csv(tmp_path / "grid.csv")
    rows = [*csv.reader((tmp_path / "grid.csv").read_text().splitlines())]
    assert rows[0] == ["gain", "shaft.k", *(q.name for q in QUANTITIES), "message"]
    assert [float(x) for x in rows[1][:4]] == [*grid.points[0].tolist(), *grid.values[0, :2].tolist()]
    assert rows[3][-1] == grid.failures[0].message
    sections.save(tmp_path / "sections.csv")
    head = (tmp_path / "sections.csv").read_text().splitlines()[0]
    assert head == "speed," + ",".join(f"points(body.w)[{i}]" for i in range(6)) + ",last(body.w),message"


def test_names_that_are_not_there_are_refused(grid: gb.Study) -> None:
    with pytest.raises(gb.UnknownNameError, match="did you mean 'peak"):
        grid["peak(shaft.torqe)"]
    with pytest.raises(gb.UnknownNameError):
        grid.plot("rms(load.w)")


def test_a_result_cannot_be_written_to(grid: gb.Study) -> None:
    with pytest.raises(ValueError, match="read-only"):
        grid.values[0, 0] = 1.0


@pytest.mark.parametrize("name", ["study.txt", "study", "no/folder/study.nc"])
def test_places_that_cannot_hold_a_study_are_refused(grid: gb.Study, name: str, tmp_path: Path) -> None:
    with pytest.raises(gb.errors.StorageError):
        grid.save(tmp_path / name)


def test_files_that_are_no_study_are_refused(clutch_model: gb.Model, tmp_path: Path) -> None:
    gb.simulate(clutch_model, t_end=0.01).save(tmp_path / "run.nc")
    (tmp_path / "noise.nc").write_bytes(b"nothing")
    for name, words in (
        ("run.nc", "its format is 'gearblocks run"),
        ("noise.nc", "damaged"),
        ("none.nc", "no such file"),
    ):
        with pytest.raises(gb.errors.StorageError, match=words):
            gb.Study.load(tmp_path / name)


def test_pictures_have_a_panel_per_quantity(
    grid: gb.Study, cases: gb.Study, sections: gb.Study, tmp_path: Path
) -> None:
    figures = []
    for found, panels in ((grid, 3), (cases, 2), (sections, 2)):
        figure = found.plot(path=tmp_path / "picture.png")
        figures.append(figure)
        named = {
            axis.get_title(loc="left") or axis.get_ylabel().split("\n")[0].split(" in ")[0] for axis in figure.axes
        }
        assert set(found.names) <= named and len(found.names) == panels
        assert (tmp_path / "picture.png").stat().st_size > 10_000
    crosses = [line for axis in figures[0].axes for line in axis.lines if line.get_marker() == "x"]
    assert len(crosses[0].get_xdata()) == 2  # type: ignore[arg-type]
    assert [line.get_label() for line in crosses] == ["failed", "failed", "failed, or none"]


def test_a_picture_has_two_dimensions_at_most(clutch_model: gb.Model) -> None:
    values = {"gain": [0.0, 0.1], "shaft.k": [1.0, 2.0], "shaft.c": [0.0, 0.1]}
    with pytest.raises(gb.ParameterError, match="one or two dimensions, this study 3"):
        gb.sweep(clutch_model, values, quantity=gb.last("load.w"), t_end=0.01).plot()


def _made(paths: dict[str, list[float]], shape: tuple[int, ...], *quantities: NDArray[np.float64]) -> gb.Study:
    """A study of these values, whose quantities are q0, q1, ..."""
    n, m = len(next(iter(paths.values()))), len(quantities)
    return gb.Study(
        tuple(paths), ("",) * len(paths), np.array([*paths.values()]).T, shape, tuple(f"q{i}" for i in range(m)), ("1",) * m,
        (1,) * m, np.array(quantities).T, np.ones(n, dtype=np.bool_),
    )  # fmt: skip


@pytest.mark.parametrize(("count", "quantities"), [(2, 1), (3, 2), (5, 1)])
@pytest.mark.few(1)
def test_cases_are_drawn_over_each_value_that_varies_in_them(count: int, quantities: int) -> None:
    values = np.random.default_rng(3).uniform(1.0, 2.0, (count, 40))
    values[1] *= 1e-3
    found = [values[0] ** (i + 2) for i in range(quantities)]
    found[0][7] = np.nan
    figure = _made({f"p{i}": [*row] for i, row in enumerate(values)}, (), *found).plot()
    assert len(figure.axes) == count * quantities
    for number, axis in enumerate(figure.axes):
        row, column = divmod(number, count)
        x, y = axis.lines[0].get_data()
        assert sorted(x) == pytest.approx(sorted(values[column]))
        assert dict(zip(x, y, strict=True)) == pytest.approx(
            dict(zip(values[column], found[row], strict=True)), nan_ok=True
        )
        assert bool(axis.get_ylabel()) == (column == 0)
        assert axis.get_xlabel() == (f"p{column}" if row == quantities - 1 else "")
        assert [len(line.get_xdata()) for line in axis.lines if line.get_marker() == "x"] == [1] * (row == 0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("row", "places"),
    [
        ([20.0, 50.0, 100.0, 200.0, 400.0], [0, 1, 2, 3, 4]), ([1.0, 10.0, 100.0], [0, 1, 2]),
        ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), ([0.1, 0.2, 0.30000000000000004], [0.1, 0.2, 0.3]), ([7.0, 9.0], [7.0, 9.0]),
    ],
)  # fmt: skip
def test_cells_are_alike_and_have_their_values_at_the_axis(row: list[float], places: list[float]) -> None:
    other = [1.0, 2.0]
    points = {"a": [x for x in row for _ in other], "b": [*other] * len(row)}
    figure = _made(points, (len(row), 2), np.arange(2.0 * len(row))).plot()
    axis = figure.axes[0]
    assert axis.get_xticks() == pytest.approx(places)
    assert [float(label.get_text()) for label in axis.get_xticklabels()] == pytest.approx(row)
    assert [label.get_text() for label in axis.get_yticklabels()] == ["1", "2"]
    half = (places[1] - places[0]) / 2
    assert axis.get_xlim() == pytest.approx((places[0] - half, places[-1] + half))


def test_many_uneven_values_have_some_of_them_at_the_axis() -> None:
    row = [*np.geomspace(1.0, 1e4, 30)]
    figure = _made({"a": [x for x in row for _ in (0, 1)], "b": [0.0, 1.0] * 30}, (30, 2), np.arange(60.0)).plot()
    assert [float(label.get_text()) for label in figure.axes[0].get_xticklabels()] == pytest.approx(row[::3], rel=1e-5)


@pytest.mark.parametrize("values", [612.2 + 1e-4 * np.arange(5), 1e6 + np.arange(5), -3.0 - 1e-9 * np.arange(5)])
@pytest.mark.few(1)
def test_axes_have_whole_numbers_and_no_offset(values: NDArray[np.float64]) -> None:
    figure = _made({"a": [*range(5)]}, (5,), values).plot()
    figure.canvas.draw()
    assert figure.axes[0].yaxis.get_offset_text().get_text() in ("", "1e6")


@pytest.mark.parametrize(("count", "rows"), [(3, 3), (11, 11), (12, 11), (200, 11)])
def test_a_printed_study_shows_its_first_and_last_points(count: int, rows: int) -> None:
    values = np.linspace(1.0, 2.0, count)
    found = _made(
        {"a": [*values], "bb": [*(10 * values)]}, (), values**2, np.where(values == values[1], np.nan, values)
    )
    head, *table = str(found).split("\n\n")[1].splitlines()
    assert head.split() == ["a", "bb", "q0", "q1"]
    assert len(table) == rows
    numbers = [line.split() for line in table]
    assert [float(row[0]) for row in (numbers[0], numbers[-1])] == [1.0, 2.0]
    assert numbers[1][3] == "none"  # the run is there, and another quantity has its value
    assert f"q1: 1 .. 2, none at 1 of {count} points" in str(found)
    assert (["..."] * 4 in numbers) == (count > 11)
    assert "1 point failed" not in str(found)
    assert repr(found).startswith("<study of")


def test_columns_that_do_not_fit_are_counted_and_points_that_are_not_reached_said() -> None:
    found = _made({f"a_long_path.of_a_value_{i}": [1.0, 2.0] for i in range(9)}, (), np.array([np.nan, 3.0]))
    found.done[0] = False
    lines = str(found).splitlines()
    assert max(map(len, lines[-4:])) <= 110
    assert lines[-1] == "and 6 more columns: to_xarray() or to_csv() has all"
    short = _made({"a": [1.0, 2.0]}, (2,), np.array([np.nan, 3.0]))
    short.done[0] = False
    assert "not done" in str(short)


def test_the_values_of_a_path_have_the_shape_of_the_grid(grid: gb.Study, cases: gb.Study) -> None:
    assert grid["gain"].tolist() == [[0.0, 0.0], [1e4, 1e4], [0.02, 0.02]]
    assert grid["shaft.k"].shape == grid["peak(shaft.torque)"].shape
    assert grid["shaft.k"][np.unravel_index(np.nanargmax(grid["peak(shaft.torque)"]), grid.shape)] in (150.0, 200.0)
    assert cases["clutch.capacity"].tolist() == cases.points[:, 1].tolist()
    with pytest.raises(gb.UnknownNameError, match=r"no 'shaft\.c'; it has .*shaft\.k - did you mean 'shaft\.k'"):
        grid["shaft.c"]


@pytest.mark.parametrize(
    ("name", "way"),
    [
        ("gain", r"write study\['gain'\]"), ("k", r"write study\['shaft\.k'\]"), ("valus", "did you mean 'values'"),
        ("dataset", r"write study\.to_xarray"), ("best", "study.names and study.paths"),
    ],
)  # fmt: skip
def test_an_attribute_that_a_study_has_not_says_where_it_is(grid: gb.Study, name: str, way: str) -> None:
    with pytest.raises(AttributeError, match=rf"a Study has no attribute '{name}'.*{way}"):
        getattr(grid, name)


def test_one_column_that_does_not_fit_is_one() -> None:
    lines = str(
        _made({f"a_longer_path.of_a_value_{i}": [1.0, 2.0] for i in range(4)}, (), np.array([1.0, 3.0]))
    ).splitlines()
    assert lines[-1] == "and 1 more column: to_xarray() or to_csv() has all"


def test_a_trough_that_is_rounding_beside_the_peak_is_zero() -> None:
    values = np.array([[100.0, -1.3e-23], [200.0, 2e-24]])
    names, units = ("peak(shaft.torque)", "trough(shaft.torque)"), ("N m", "N m")
    found = gb.Study(
        ("k",), ("",), np.array([[1.0], [2.0]]), (2,), names, units, (1, 1), values, np.ones(2, dtype=np.bool_)
    )
    assert "trough(shaft.torque): 0 N m" in str(found) and "e-2" not in str(found)
    alone = gb.Study(("k",), ("",), found.points, (2,), names[1:], units[1:], (1,), values[:, 1:], found.done)
    assert "-1.3e-23" in str(alone)
