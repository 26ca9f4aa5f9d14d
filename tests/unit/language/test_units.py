"""Units are read from their text."""

import math

import numpy as np
import pytest

from gearblocks.errors import ParameterError
from gearblocks.language.units import base_exponents, rpm


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("", {}),
        ("1", {}),
        ("rad", {"rad": 1}),
        ("rad/s", {"s": -1, "rad": 1}),
        ("rad/s2", {"s": -2, "rad": 1}),
        ("1/s", {"s": -1}),
        ("kg m2", {"kg": 1, "m": 2}),
        ("kg m^2", {"kg": 1, "m": 2}),
        ("N m", {"kg": 1, "m": 2, "s": -2}),
        ("N m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}),
        ("N m s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("N/m", {"kg": 1, "s": -2}),
        ("N s/m", {"kg": 1, "s": -1}),
        ("J", {"kg": 1, "m": 2, "s": -2}),
        ("W", {"kg": 1, "m": 2, "s": -3}),
        ("V s/rad", {"kg": 1, "m": 2, "s": -2, "A": -1, "rad": -1}),
        ("W/(m2 K)", {"kg": 1, "s": -3, "K": -1}),
        ("m s-2", {"m": 1, "s": -2}),
    ],
)
def test_the_exponents_follow_from_the_text(unit: str, exponents: dict[str, int]) -> None:
    assert base_exponents(unit) == exponents


@pytest.mark.parametrize("unit", ["furlong", "N m/deg", "kg m2.5", "mm"])
def test_what_is_not_si_is_refused_by_name(unit: str) -> None:
    with pytest.raises(ParameterError, match="no SI unit"):
        base_exponents(unit)


def test_sixty_revolutions_per_minute_are_one_turn_per_second() -> None:
    assert rpm(60) == 2 * math.pi
    assert np.array_equal(rpm(np.array([0.0, 60.0])), [0.0, 2 * math.pi])
    assert np.array_equal(rpm([30.0]), [math.pi])
