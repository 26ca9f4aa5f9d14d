"""Parameters and inputs: finite numbers under plain names."""

import math
import re
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

NAN, INF = float("nan"), float("inf")
P, U = gb.Parameter("P", 2.0), gb.Input("u", 3.0)


@pytest.mark.parametrize("value", [NAN, INF, "3", True, [1], None, 1j, gb.time, P, np.array([1.0, 2.0])])
def test_parameters_and_inputs_hold_finite_numbers(value: Any) -> None:
    for make in (gb.Parameter, gb.Input):
        with pytest.raises(gb.ParameterError, match=f"{make.__name__} 'p': (value|start) = "):
            make("p", value)


@pytest.mark.parametrize("name", ["", "a b", "1a", ".", "a..b", 3, None, "a-b"])
def test_parameters_and_inputs_have_plain_names(name: Any) -> None:
    for make in (gb.Parameter, gb.Input):
        with pytest.raises(gb.ParameterError, match=r"name .* must be words"):
            make(name, 1.0)
        with pytest.raises(gb.ParameterError, match="unit = 3 must be text"):
            make("p", 1.0, 3)


@pytest.mark.parametrize("unit", ["banana", "Nmm2x", "N m/(rad/s)", "kkg", "m^"])
def test_units_that_are_not_known_are_refused(unit: str) -> None:
    for make in (gb.Parameter, gb.Input):
        with pytest.raises(gb.ParameterError, match=rf"{make.__name__} 'p': unit '{re.escape(unit)}'"):
            make("p", 3000.0, unit)


@pytest.mark.parametrize(
    ("unit", "si"), [("rpm", 100 * math.pi), ("mm", 3.0), ("kN m", 3e6), ("1", 3000.0), ("N m/rad", 3000.0)]
)
def test_values_are_in_the_unit_that_is_given(unit: str, si: float) -> None:
    """3000 rpm ran at 3000 rad/s."""
    for make in (gb.Parameter, gb.Input):
        leaf = make("p", 3000.0, unit)
        assert leaf.si == si and float(getattr(leaf, "value", 3000.0)) == 3000.0 and leaf.unit == unit


# -- tables --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("points", [2, 3, 4, 13])
@pytest.mark.parametrize("ends", ["not-a-knot", "flat"])
def test_cubic_tables_are_scipys_splines_for_any_number_of_points(points: int, ends: str) -> None:
    from scipy.interpolate import CubicSpline

    x = np.linspace(0.0, 2.0, points) ** 1.5
    y = np.exp(-x) + 0.1 * np.cos(7 * x)
    at = np.linspace(x[0], x[-1], 97)
    known = CubicSpline(x, y, bc_type="clamped" if ends == "flat" else "not-a-knot")
    table = gb.Table(x, y, "cubic", ends=ends)
    assert table.values(at) == pytest.approx(known(at), rel=1e-12, abs=1e-13)
    assert table.values([x[0] - 1.0, x[-1] + 1.0]) == pytest.approx([y[0], y[-1]])
    assert gb.Table(x, y, "cubic") == gb.Table(x, y, "cubic", ends="not-a-knot") != gb.Table(x, y, "cubic", ends="flat")


def test_a_cubic_table_is_closer_to_a_friction_curve_than_straight_lines_are() -> None:
    def mu(slip: Any) -> Any:
        return 0.08 + 0.07 * np.exp(-slip / 0.4)

    x, at = np.linspace(0.0, 3.0, 13), np.linspace(0.0, 3.0, 1001)
    off = {kind: np.abs(gb.Table(x, mu(x), kind).values(at) - mu(at)).max() for kind in ("cubic", "linear")}
    assert off["cubic"] < off["linear"] / 10


@pytest.mark.parametrize("kind", ["linear", "cubic"])
@pytest.mark.parametrize("size", [1.0, 1e-5, 1e6])
def test_a_periodic_table_may_miss_its_start_by_rounding(kind: str, size: float) -> None:
    x = np.linspace(0.0, 1.0, 21)
    table = gb.Table(x, size * np.sin(2 * np.pi * x), kind, periodic=True)
    assert table.y[-1] == table.y[0] == 0.0
    assert table.values([2.25, -0.75]) == pytest.approx([size, size])
    with pytest.raises(gb.GearblocksError, match="must end where it starts"):
        gb.Table(x, size * (np.sin(2 * np.pi * x) + 1e-6 * x), kind, periodic=True)
    with pytest.raises(gb.ParameterError, match="ends = 'natural' must be 'not-a-knot' or 'flat'"):
        gb.Table(x, x, "cubic", ends="natural")


def test_a_table_of_losses_is_rows_in_any_form() -> None:
    rows = [[0.0, 0.6, 0.45, 0.2, 0.5], [10.0, 0.7, 0.5, 0.1, 0.4]]
    kept = gb.LossyGear(ratio=3, loss_table=tuple(map(tuple, rows)))
    for given in (rows, np.array(rows), tuple(rows), [np.array(row) for row in rows]):
        gear = gb.LossyGear(ratio=3, loss_table=given)  # type: ignore[arg-type]
        assert gear == kept
        gb.Drivetrain("x").add("gear", gear)
    assert gb.GearMesh(teeth=[20, 31], external=True, k=1e8, r_base=np.array([0.02, 0.031])).teeth == (20, 31)
