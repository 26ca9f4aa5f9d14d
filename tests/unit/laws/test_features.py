"""Arguments of narrow functions, in widths of the part that is not flat."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.laws.derivation import derive
from gearblocks.laws.features import narrow_features

W = gb.sense("i.w")


def features(block) -> list[tuple[str, bool]]:
    return sorted((str(f.argument), f.bounded) for f in narrow_features(derive(block, frozenset({"housing"}))))


def test_a_stribeck_rise_is_as_wide_as_its_speed():
    block = gb.BearingFriction(coulomb=1.0, stribeck=gb.Stribeck(rise=1.0, speed=0.5))
    (found,) = features(block)
    assert "w_a" in found[0]
    assert "stribeck.speed" in found[0] or "speed" in found[0]
    assert found[1]


@pytest.mark.parametrize(
    "block",
    [gb.BearingFriction(coulomb=1.0, viscous=0.1), gb.Inertia(J=1.0), gb.Torque(tau=3 + W**2 - gb.sin(gb.time))],
)
def test_what_is_smooth_on_its_own_scale_has_none(block):
    assert features(block) == []


def test_squares_are_completed():
    (found,) = features(gb.Torque(tau=np.exp(-4 * (W**2 - 6 * W))))
    assert found == ("2*i.w - 6", True)


def test_a_sum_of_squares_has_each_of_them():
    found = features(gb.Torque(tau=np.exp(-(W**2) - 9 * (gb.time - 1) ** 2)))
    assert [x for x, _ in found] == ["3*t - 3", "i.w"]


def test_a_root_with_a_constant_is_narrow_about_its_zero():
    (found,) = features(gb.Torque(tau=W / np.sqrt(W**2 + 0.01)))
    assert found == ("10*i.w", True) or found == ("10.0*i.w", True)


@pytest.mark.parametrize(
    ("law", "width"),
    [
        (lambda u: 1 / np.sqrt(1 + 36 * u**2 / (W**2 + 4)), "6*(i.w - 3)/sqrt(i.w**2 + 4)"),
        (lambda u: np.exp(-16 * u**4 / (W**2 + 4) ** 2), "2*(i.w - 3)/sqrt(i.w**2 + 4)"),
        (lambda u: 1 / (1 + 9 * u**2 * (W**2 + 1) ** 2), "3*(i.w - 3)*(i.w**2 + 1)"),
    ],
)
def test_a_slip_relative_to_what_is_never_zero_is_narrow_as_itself(law, width):
    assert width in [x for x, _ in features(gb.Torque(tau=law(W - 3)))]


@pytest.mark.parametrize("tau", [1 / (1 + (W - 3) ** 2 / W), 1 / (1 + (W - 3) ** 2 * (W - 1))])
def test_what_is_no_even_power_is_no_width(tau):
    assert features(gb.Torque(tau=tau)) == []


def test_an_angle_in_a_narrow_function_goes_on_for_ever():
    found = features(gb.Torque(tau=np.exp(50 * (gb.cos(3 * gb.sense("i.phi")) - 1))))
    assert ("3*i.phi", False) in found
    assert len(found) == 2
