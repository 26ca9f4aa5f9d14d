"""Values as rig.describe() tells them: digits that were meant, each with its unit, nothing of the code."""

from __future__ import annotations

import math

import pytest

import gearblocks as gb
from gearblocks.train.summary import expression_text, number_text, span_text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (20000.0, "20000"), (0.3, "0.3"), (4e-5, "4e-5"), (2e8, "2e8"), (-1.5e-7, "-1.5e-7"), (0.0, "0"), (0.1 + 0.2, "0.3"),
        (1e-4, "0.0001"), (999999.0, "999999"), (1e6, "1e6"), (math.inf, "inf"),
    ],
)  # fmt: skip
def test_numbers_have_the_digits_that_were_meant(value: float, text: str) -> None:
    assert number_text(value) == text
    assert float(text) == pytest.approx(value)


def _line(**parts: gb.Block) -> str:
    rig = gb.Drivetrain("train")
    for name, part in parts.items():
        rig.add(name, part)
    return next(line for line in str(rig.describe()).splitlines() if f" {next(iter(parts))} " in line)


def test_effects_are_told_like_fields_with_units_and_without_defaults() -> None:
    mesh = gb.GearMesh(
        teeth=(23, 41), module="3 mm", pressure_angle="20 deg", external=True, k=2e8, damping_ratio=0.05,
        backlash=gb.Backlash(half_gap=4e-5), transmission_error=gb.Harmonic(cos=(5e-6, "2 um")),
        stiffness_variation=gb.Fourier(cos=(0.2,)),
    )  # fmt: skip
    line = _line(mesh=mesh)
    assert "backlash: Backlash(half_gap = 4e-5 m)" in line
    assert "Harmonic(cos = (5e-6 m, 2 um))" in line and "Fourier(cos = (0.2,))" in line
    assert "k = 2e8 N/m" in line and "teeth = (23, 41)," in line


def test_numbers_of_a_row_over_powers_have_each_its_unit() -> None:
    assert "coeffs = (0 N m, 0.5 N m s/rad, 4e-5 N m s2/rad2)" in _line(load=gb.SpeedLoad(coeffs=(0.0, 0.5, 4e-5)))


def test_expressions_and_tables_are_told_without_what_the_code_calls_them() -> None:
    table = gb.Table([0.0, 1.0], [0.0, 40.0])
    assert "tau = Table(2 points, linear) N m" in _line(drive=gb.Torque(tau=table))
    tau = 0.1 * 3 * table(gb.time + 1) - gb.Parameter("p", 2.0) / gb.time
    assert "tau = 0.3*table(time + 1) - p/time N m" in _line(drive=gb.Torque(tau=tau))
    assert expression_text(1 / gb.time) == "1/time"


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(-1.687e-12, 1424.38, "0 .. 1424.38"), (-2.0, 3e-15, "-2 .. 0"), (1e-20, 2e-20, "1e-20 .. 2e-20")],
)
def test_an_end_of_a_range_that_is_rounding_beside_the_other_one_is_zero(low: float, high: float, text: str) -> None:
    assert span_text(low, high) == text
