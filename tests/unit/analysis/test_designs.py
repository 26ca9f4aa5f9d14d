"""Designs of studies: which points are run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis import designs


def test_a_grid_has_every_combination_the_last_path_fastest() -> None:
    made = designs.grid({"a": [1, 2], "b": (10.0, 20.0, 30.0)})
    assert made.shape == (2, 3)
    assert made.points.tolist() == [[1, 10], [1, 20], [1, 30], [2, 10], [2, 20], [2, 30]]


def test_cases_are_rows_or_columns() -> None:
    rows = designs.cases([{"a": 1, "b": 2}, {"b": 4, "a": 3}])
    columns = designs.cases({"a": np.array([1, 3]), "b": [2, 4]})
    assert rows.points.tolist() == columns.points.tolist() == [[1, 2], [3, 4]]
    assert rows.levels is None and rows.shape == (2,)


def test_a_latin_hypercube_has_one_value_in_every_slice_and_repeats_itself() -> None:
    made = gb.latin_hypercube({"a": (-1.0, 1.0), "b": (10.0, 30.0)}, 50, seed=3)
    assert sorted(np.floor((made["a"] + 1) / 2 * 50).tolist()) == list(range(50))
    assert sorted(np.floor((made["b"] - 10) / 20 * 50).tolist()) == list(range(50))
    again = gb.latin_hypercube({"a": (-1.0, 1.0), "b": (10.0, 30.0)}, 50, seed=3)
    assert all((made[path] == again[path]).all() for path in made)
    assert (made["a"] != gb.latin_hypercube({"a": (-1.0, 1.0), "b": (10.0, 30.0)}, 50, seed=4)["a"]).any()


def test_random_cases_lie_within_their_bounds_and_repeat_themselves() -> None:
    made = gb.random_cases({"a": (2.0, 5.0)}, 1000, seed=1)["a"]
    assert made.shape == (1000,) and 2.0 <= made.min() < 2.1 and 4.9 < made.max() <= 5.0
    assert made.mean() == pytest.approx(3.5, abs=0.1)  # three standard deviations of the mean are 0.08
    assert (made == gb.random_cases({"a": (2.0, 5.0)}, 1000, seed=1)["a"]).all()


@pytest.mark.parametrize(
    ("make", "given", "words"),
    [
        (designs.grid, {}, "at least one path"),
        (designs.grid, {"a": []}, "shape (0,)"),
        (designs.grid, {"a": 3.0}, "a row of numbers"),
        (designs.grid, {"a": [1, float("nan")]}, "value [1] = nan must be a finite number"),
        (designs.grid, {"a": ["x"]}, "must be a row of numbers"),
        (designs.grid, {3: [1.0]}, "must be text"),
        (designs.grid, [1, 2], "must be a dict"),
        (designs.cases, {"a": [1, 2], "b": [1]}, "equal length, not a: 2, b: 1"),
        (designs.cases, [], "at least one case"),
        (designs.cases, [{"a": 1}, {"b": 1}], "case 1 and case 0 differ in a, b"),
        (designs.cases, [1, 2], "must be a dict"),
        (designs.cases, 5, "must be a list of dicts"),
        (lambda given: gb.latin_hypercube(given, 3), {"a": 2.0}, "the pair (low, high)"),
        (lambda given: gb.latin_hypercube(given, 3), {"a": (2.0, 2.0)}, "must be below"),
        (lambda given: gb.random_cases(given, 0), {"a": (1.0, 2.0)}, "number = 0"),
    ],
)
def test_bad_designs_are_refused_by_name(make: Any, given: Any, words: str) -> None:
    with pytest.raises(gb.ParameterError) as caught:
        make(given)
    assert words in str(caught.value)
