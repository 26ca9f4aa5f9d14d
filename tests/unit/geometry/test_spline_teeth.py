"""Teeth with a gap of each: the closed form, its properties, and the frozen sample of the reference."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gearblocks.geometry.spline_teeth import deflection_at, engaged_teeth, force_at, segments, start_forces

pytestmark = pytest.mark.numeric

DATA = Path(__file__).parents[2] / "data"
CASE = json.loads((DATA / "spline_engaged_teeth.json").read_text())
GAPS = [b * 1e-6 for b in CASE["gap_drive_um"]]
KT, R = CASE["kt"], CASE["r2"]

gap_rows = st.lists(st.floats(0, 1e-3), min_size=1, max_size=12)
forces = st.floats(1e-3, 1e7)


def test_the_torques_at_which_teeth_start_are_those_of_the_reference() -> None:
    ours = [R * f for f in start_forces(GAPS, KT)]
    assert ours == pytest.approx(CASE["engage_torque_Nm"], rel=1e-12, abs=1e-9)


@pytest.mark.parametrize(
    "row", [row for rows in CASE["cycle"].values() for row in rows], ids=lambda r: f"{r['i']}-{r['r']}"
)
def test_engaged_teeth_over_a_cycle_are_those_of_the_reference(row: dict[str, float]) -> None:
    force = row["T"] / R
    assert engaged_teeth(force, GAPS, KT) == row["r"]
    assert deflection_at(force, GAPS, KT) == pytest.approx(row["s"], rel=1e-13)
    assert force_at(row["s"], GAPS, KT) == pytest.approx(force, rel=1e-12)


def test_a_larger_swing_of_the_torque_engages_a_wider_range_of_teeth() -> None:
    spread = {eps: {row["r"] for row in rows} for eps, rows in CASE["cycle"].items()}
    assert (min(spread["0.1"]), max(spread["0.1"])) == (15, 16)
    assert (min(spread["0.5"]), max(spread["0.5"])) == (10, 18)


@given(gap_rows, forces, forces)
def test_more_force_engages_no_fewer_teeth_and_bends_them_no_less(gaps: list[float], one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert engaged_teeth(low, gaps, KT) <= engaged_teeth(high, gaps, KT)
    assert deflection_at(low, gaps, KT) <= deflection_at(high, gaps, KT) * (1 + 1e-15)


@given(gap_rows, forces)
def test_force_and_deflection_are_inverse_to_each_other(gaps: list[float], force: float) -> None:
    s = deflection_at(force, gaps, KT)
    # the deflection is rounded at the size of the gaps: kt n eps (gap + s)
    assert force_at(s, gaps, KT) == pytest.approx(force, rel=1e-12, abs=4 * KT * len(gaps) * 2.3e-16 * (max(gaps) + s))


@given(gap_rows, st.floats(0, 2e-3), st.floats(0, 2e-3), st.floats(0, 1))
def test_the_load_is_convex_over_the_deflection(gaps: list[float], a: float, b: float, part: float) -> None:
    chord = (1 - part) * force_at(a, gaps, KT) + part * force_at(b, gaps, KT)
    assert force_at((1 - part) * a + part * b, gaps, KT) <= chord * (1 + 1e-12) + 1e-6  # rounding of 1e-19 m times kt


@given(
    st.lists(st.integers(0, 1000), min_size=1, max_size=12), st.integers(1, 10**6), st.sampled_from([0.5, 4.0, 1024.0])
)
def test_scaling_gaps_and_force_alike_leaves_the_number_of_engaged_teeth(
    gaps: list[int], force: int, scale: float
) -> None:
    assert engaged_teeth(force, gaps, 100.0) == engaged_teeth(scale * force, [scale * b for b in gaps], 100.0)


@given(gap_rows, gap_rows, st.floats(-2e-3, 2e-3))
def test_the_segments_tell_the_load_of_all_teeth_and_its_integral(
    drive: list[float], coast: list[float], x: float
) -> None:
    n = min(len(drive), len(coast))
    drive, coast = drive[:n], coast[:n]
    joints, (engaged, total, squares) = segments(drive, coast)
    assert joints == sorted(set(joints))
    i = next(i for i in range(len(joints)) if joints[i + 1] > x)
    load = sum(max(x - b, 0) for b in drive) - sum(max(-x - b, 0) for b in coast)
    stored = sum(max(x - b, 0) ** 2 for b in drive) / 2 + sum(max(-x - b, 0) ** 2 for b in coast) / 2
    assert abs(engaged[i]) * x - total[i] == pytest.approx(load, rel=1e-12, abs=1e-17)
    assert abs(engaged[i]) * x * x / 2 - total[i] * x + squares[i] / 2 == pytest.approx(stored, rel=1e-10, abs=1e-20)
