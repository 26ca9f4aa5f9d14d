"""Inputs given as samples: pairs (t, y) and Series of pandas, told by name where they are no function of time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas
import pytest

import gearblocks as gb

T = np.array([0.0, 0.1, 0.3, 0.5])
Y = np.array([0.0, 4.0, -2.0, 1.0])
NAN = float("nan")


@pytest.fixture(scope="module")
def model() -> gb.Model:
    rig = gb.Drivetrain("rig")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", unit="N m")))
    fan = rig.add("fan", gb.Torque(tau=-1e-3 * gb.Input("speed", unit="rpm")))
    rig.chain(drive, fan, rig.add("disc", gb.Inertia(J=0.2)))
    return gb.build(rig)


@pytest.mark.parametrize(
    "series",
    [
        pytest.param((T, Y), id="arrays"),
        pytest.param((T.tolist(), tuple(Y)), id="rows"),
        pytest.param(pandas.Series(Y, index=T), id="series"),
        pytest.param(pandas.Series(Y, index=pandas.to_timedelta(T, unit="s")), id="durations"),
        pytest.param((pandas.Index(T), pandas.Series(Y)), id="columns"),
    ],
)
def test_samples_are_a_table_of_straight_lines(model: gb.Model, series: Any) -> None:
    wanted = gb.simulate(model, t_end=0.6, inputs={"tau": gb.Table(T, Y)})
    found = gb.simulate(model, t_end=0.6, inputs={"tau": series})
    assert np.array_equal(found.t, wanted.t) and np.array_equal(found["disc.w"], wanted["disc.w"])


def test_samples_of_an_input_are_in_its_unit(model: gb.Model) -> None:
    wanted = gb.simulate(model, t_end=0.6, inputs={"speed": gb.Table(T, Y)})["disc.w"]
    found = gb.simulate(model, t_end=0.6, inputs={"speed": (T, Y)})["disc.w"]
    assert np.array_equal(found, wanted) and found[-1] != 0.0


def test_a_run_keeps_its_samples_when_the_array_changes(model: gb.Model) -> None:
    t, y = T.copy(), Y.copy()
    run = gb.simulate(model, t_end=0.6, inputs={"tau": (t, y)})
    before = gb.simulate(model, t_end=0.6, inputs={"tau": (T, Y)}).extremes("disc.w")
    y[:] = 100.0
    assert run.extremes("disc.w") == before


def test_studies_and_linear_tools_take_samples(model: gb.Model) -> None:
    quantity, values = gb.peak("disc.w"), {"disc.J": [0.2, 0.4]}
    found = gb.sweep(model, values, quantity=quantity, t_end=0.6, inputs={"tau": (T, Y)})
    wanted = gb.sweep(model, values, quantity=quantity, t_end=0.6, inputs={"tau": gb.Table(T, Y)})
    assert np.array_equal(found.values, wanted.values)
    assert gb.linearize(model, at={}, inputs={"tau": (T, Y)}).inputs == ("tau",)


@pytest.mark.parametrize(
    ("series", "words"),
    [
        ((T[::-1], Y), r"input 'tau': t must increase, but t\[1\] = 0.3 follows 0.5; sort the points"),
        (([0.0, 0.1, 0.1, 0.2], Y), r"but t\[2\] = 0.1 follows 0.1; sort the points and drop repeated ones"),
        ((T, Y[:3]), "input 'tau': t has 4 numbers and y has 3; give one value for each time"),
        ((T, [0.0, NAN, 1.0, 2.0]), r"input 'tau': y\[1\] = nan must be a finite number; drop the point or repair it"),
        (([0.0, NAN, 1.0, 2.0], Y), r"input 'tau': t\[1\] = nan must be a finite number"),
        ((T, "rising"), "input 'tau': y = 'rising' must be a row of numbers"),
        ((T, np.ones((4, 2))), r"input 'tau': y of shape \(4, 2\) must be a row of numbers; give one column"),
        (([0.0], [1.0]), "input 'tau' is a series of 1 points: give two at least, or a number"),
        ((T, Y, Y), r"input 'tau' is given as a tuple of 3: give the pair \(t, y\)"),
        (pandas.Series(Y, index=pandas.date_range("2026-01-01", periods=4)), "are dates: give seconds since the start"),
        (pandas.Series(Y, index=list("abcd")), "input 'tau': t = .* must be a row of numbers"),
        (pandas.DataFrame({"a": Y, "b": Y}, index=T), r"input 'tau': y of shape \(4, 2\) must be a row"),
    ],
)  # fmt: skip
def test_samples_that_are_no_function_of_time_are_refused_by_name(model: gb.Model, series: Any, words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        gb.simulate(model, t_end=0.6, inputs={"tau": series})
