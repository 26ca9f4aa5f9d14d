"""Geometry of involute teeth against constructions made by hand, and the stiffness of the standard against numbers."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from gearblocks.geometry.involute import ToothPair, inverse_involute, iso_problems, mesh_stiffness, single_stiffness

pytestmark = pytest.mark.numeric

DATA = Path(__file__).parents[2] / "data"
ANGLE = math.radians(20)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.01, 0.3, 0.9, 1.4])
def test_the_involute_function_is_inverted(angle: float) -> None:
    y = math.tan(angle) - angle
    # y itself is a difference of two numbers of the size of the angle
    assert inverse_involute(y) == pytest.approx(angle, rel=1e-14, abs=3e-16 / angle**2 if angle > 1e-3 else 1)
    assert inverse_involute(0.0) == 0.0
    assert math.isnan(inverse_involute(-1e-9))


def _path_by_hand(z1: int, z2: int, internal: bool, shifts: tuple[float, float], m: float = 1.0) -> tuple[float, float]:
    """Approach and recess: where the tip circles cut the line of action, in the plane; pinion at the origin."""
    x1, x2 = shifts
    sign = -1 if internal else 1
    target = math.tan(ANGLE) - ANGLE + 2 * (x1 + x2) * math.tan(ANGLE) / (z1 + sign * z2)
    aw = brentq(lambda a: math.tan(a) - a - target, 1e-3, 1.2, xtol=1e-15)
    centre = m * abs(z1 + sign * z2) / 2 * math.cos(ANGLE) / math.cos(aw)
    other = np.array([0.0, sign * centre])  # the wheel's centre; the pitch point lies above the pinion
    pitch_point = np.array([0.0, m * z1 / 2 * math.cos(ANGLE) / math.cos(aw)])
    along = np.array([math.cos(aw), math.sin(aw) * -1.0])
    tips = m * (z1 / 2 + 1 + x1), m * (z2 / 2 + sign * (1 + x2))

    def reach(center: np.ndarray, tip: float, direction: float) -> float:
        far = 6.0 * m
        return float(
            brentq(lambda s: np.hypot(*(pitch_point + direction * s * along - center)) - tip, 0, far, xtol=1e-14)
        )

    # along the line to one side the pinion's radius grows, to the other that of the wheel (falls, when internal)
    to_tip = 1.0 if np.hypot(*(pitch_point + 0.1 * along)) > np.hypot(*pitch_point) else -1.0
    return reach(other, tips[1], -to_tip), reach(np.zeros(2), tips[0], to_tip)


@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.3, 0.1), (0.4, -0.2)])
@pytest.mark.parametrize(("z1", "z2", "internal"), [(23, 41, False), (17, 17, False), (20, 73, True)])
def test_the_path_of_contact_is_cut_off_by_the_tip_circles(
    z1: int, z2: int, internal: bool, shifts: tuple[float, float]
) -> None:
    pair = ToothPair(z1, -z2 if internal else z2, 2e-3, ANGLE, shifts=shifts)
    assert pair.path == pytest.approx([2e-3 * s for s in _path_by_hand(z1, z2, internal, shifts)], rel=1e-11)
    assert pair.base_pitch == pytest.approx(2 * math.pi * pair.base_radii[0] / z1, rel=1e-15)
    assert pair.contact_ratio == pytest.approx(sum(pair.path) / (math.pi * 2e-3 * math.cos(ANGLE)), rel=1e-14)


def test_lever_arms_at_the_pitch_point_are_the_radii_of_curvature() -> None:
    pair = ToothPair(23, 41, 3e-3, ANGLE)
    assert pair.lever_arms == pytest.approx([3e-3 * z / 2 * math.sin(ANGLE) for z in (23, 41)], rel=1e-15)
    inside = ToothPair(23, -61, 3e-3, ANGLE)
    assert inside.lever_arms[1] == pytest.approx(-3e-3 * 61 / 2 * math.sin(ANGLE), rel=1e-15)


def test_a_helix_acts_through_the_transverse_section() -> None:
    helix = math.radians(25)
    slanted = ToothPair(23, 41, 3e-3, ANGLE, helix)
    same = ToothPair(
        23, 41, 3e-3 / math.cos(helix), math.atan(math.tan(ANGLE) / math.cos(helix)), addendum=math.cos(helix)
    )
    assert slanted.contact_ratio == pytest.approx(same.contact_ratio, rel=1e-14)


def test_the_flexibility_of_a_tooth_pair_is_that_of_the_reference() -> None:
    """The reference has no factor of the basic rack: an addendum of 0.95 modules and 20 degrees make it 1."""
    with (DATA / "noncircular_stiffness.csv").open() as file:
        for row in csv.DictReader(file):
            pair = ToothPair(float(row["Ze1"]), float(row["Ze2"]), 4e-3, ANGLE, addendum=0.95)
            # the tooth numbers are printed with 12 digits
            assert single_stiffness(pair) == pytest.approx(0.8e9 / float(row["q_mm_um_per_N"]), rel=1e-11)
            assert 30e-3 * single_stiffness(pair) == pytest.approx(1e6 * float(row["k_N_per_um"]), rel=1e-11)


def test_the_mesh_stiffness_grows_with_width_and_contact_ratio() -> None:
    pair = ToothPair(23, 41, 3e-3, ANGLE)
    assert 12e9 < single_stiffness(pair) < 14e9  # the standard: about 14 N/(mm um), less by the rack's factor 0.975
    assert mesh_stiffness(pair, 0.02) == pytest.approx(
        0.02 * single_stiffness(pair) * (0.75 * pair.contact_ratio + 0.25)
    )
    assert single_stiffness(ToothPair(41, 23, 3e-3, ANGLE), False) == single_stiffness(pair)
    rack = ToothPair(23, 10**12, 3e-3, ANGLE)
    assert single_stiffness(ToothPair(23, -61, 3e-3, ANGLE)) == pytest.approx(single_stiffness(rack), rel=1e-11)


def test_values_outside_of_the_standard_are_named() -> None:
    for pair, words in (
        (ToothPair(23, 41, 3e-3, ANGLE, shifts=(0.0, 0.3)), "x1 = 0 of the smaller gear must be >= x2 = 0.3"),
        (ToothPair(23, 41, 3e-3, ANGLE, shifts=(1.9, 0.3)), "x1 + x2 = 2.2 must lie between"),
        (ToothPair(23, 41, 3e-3, ANGLE, math.radians(31)), "helix_angle = 31 degrees must be <= 30"),
        (ToothPair(23, 41, 3e-3, ANGLE, addendum=0.5), "contact ratio is 0.892 and must be >= 1.2"),
    ):
        assert any(words in problem for problem in iso_problems(pair, True)), iso_problems(pair, True)
    assert iso_problems(ToothPair(23, 41, 3e-3, ANGLE), True) == []
