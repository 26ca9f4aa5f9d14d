"""A speed or acceleration that is given beside its angle must be its rate, where that is known before a run."""

import pytest

import gearblocks as gb
from gearblocks.blocks.given_rates import rate_problems
from gearblocks.errors import ModelError

t = gb.time


@pytest.mark.parametrize(
    ("value", "rate"),
    [
        (gb.sin(3 * t), 3 * gb.cos(3 * t)),
        (1.57 * gb.cos(19.7 * t), -1.57 * 19.7 * gb.sin(19.7 * t)),
        (gb.sin(640 * gb.pi * t), 640 * gb.pi * gb.cos(640 * gb.pi * t)),  # whole periods in every piece of 10 s
        (t + 1e-3 * gb.sin(2e4 * t), 1 + 20 * gb.cos(2e4 * t)),
        (gb.Parameter("a", 2.0) * t**2, 2 * gb.Parameter("a", 2.0) * t),
        (5.0, 0.0),
        (
            gb.piecewise((0.0, t < 0.33), (50 * (t - 0.33) ** 2, True)),
            gb.piecewise((0.0, t < 0.33), (100 * (t - 0.33), True)),
        ),
        (gb.Table([0.0, 1.0, 3.0], [0.0, 1.0, -1.0]), gb.piecewise((1.0, t < 1), (-1.0, t < 3), (0.0, True))),
        (gb.Input("u"), 7.0),  # not known before a run
    ],
)
def test_a_rate_that_is_one_is_no_problem(value, rate):
    assert list(rate_problems("x", value, "rate", rate)) == []


@pytest.mark.parametrize("rate", [gb.cos(3 * t), -3 * gb.cos(3 * t), 0.0, 180 / gb.pi * 3 * gb.cos(3 * t)])
def test_a_rate_that_is_none_is_told_with_both_changes(rate):
    (problem,) = rate_problems("phi", gb.sin(3 * t), "w", rate)
    assert problem.startswith("w is not the rate of phi: up to t = 0.1 s phi changes by 0.29552")


def test_a_rate_of_a_quick_vibration_is_told_where_it_can_be():
    (problem,) = rate_problems("phi", gb.sin(500 * t), "w", 400 * gb.cos(500 * t))
    assert problem.startswith("w is not the rate of phi: up to t = 0.0")


def test_an_angle_refuses_a_speed_that_is_not_its_own():
    rig = gb.Drivetrain("rig")
    with pytest.raises(ModelError, match="Angle 'drive': w is not the rate of phi: up to t"):
        rig.add("drive", gb.Angle(phi=gb.sin(3 * t), w=gb.cos(3 * t), alpha=-9 * gb.sin(3 * t)))
