"""Units are read from their text."""

import math

import numpy as np
import pytest

from gearblocks.errors import ParameterError
from gearblocks.language.functions import rpm
from gearblocks.language.units import base_exponents, frequencies_in_si, number_in_si, parse_unit


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


@pytest.mark.parametrize(
    "unit", ["furlong", "N m/deg2x", "kg m2.5", "mkg", "kkg", "mrpm", "m^", "N m rad-", "3", "N m/(rad/s)", "banana"]
)
def test_what_is_no_unit_is_refused_by_name(unit: str) -> None:
    with pytest.raises(ParameterError, match=r"no unit known here|one slash"):
        parse_unit(unit)


@pytest.mark.parametrize(
    ("unit", "factor", "si"),
    [
        ("rpm", math.pi / 30, "rad/s"), ("deg", math.pi / 180, "rad"), ("kN m", 1e3, "N m"), ("mm", 1e-3, "m"),
        ("km/h", 1 / 3.6, "m/s"), ("um", 1e-6, "m"), ("N m/rpm", 30 / math.pi, "N m s/rad"), ("MN/m", 1e6, "N/m"),
        ("kNm/deg", 180e3 / math.pi, "N m/rad"), ("N/mm2", 1e6, "N/m2"), ("l/min", 1e-3 / 60, "m3/s"), ("1/min", 1 / 60, "1/s"),
        ("PS", 735.49875, "W"), ("hp", 745.69987158227022, "W"),
        ("lbf ft", 1.3558179483314004, "N m"), ("g mm2", 1e-9, "kg m2"),
        ("rpm/s", math.pi / 30, "rad/s s"), ("%", 0.01, "1"), ("rev", 2 * math.pi, "rad"), ("\N{MICRO SIGN}m", 1e-6, "m"),
        ("N\N{MIDDLE DOT}m", 1.0, "N m"), ("kHz", 1e3, "Hz"), ("mph", 0.44704, "m/s"), ("arcsec", math.pi / 648000, "rad"),
        ("GPa", 1e9, "Pa"), ("bar", 1e5, "Pa"), ("N m/rad", 1.0, "N m/rad"), ("t", 1e3, "kg"), ("", 1.0, ""),
    ],
)  # fmt: skip
def test_a_unit_is_so_many_of_the_one_of_si(unit: str, factor: float, si: str) -> None:
    found = parse_unit(unit)
    assert found.factor == pytest.approx(factor, rel=2e-16) and found.si == si
    behind = parse_unit(si)
    assert behind.is_coherent and behind.exponents == found.exponents and found.measures(behind)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("3000 1/min", "rad/s"), ("3000 min-1", "rad/s"), ("3000 min⁻¹", "rad/s"), ("5 1/h", "rad/s"), ("60 1/min2", "rad/s2"),
        ("2 N m min", "N m s/rad"), ("5 m/m min", "rad/s"), ("3000 rpm", "1/min"), ("1 rad/s", "1/h"),
    ],
)  # fmt: skip
def test_what_is_counted_per_minute_or_hour_may_be_turns(text: str, unit: str) -> None:
    with pytest.raises(ParameterError, match="does not say whether it counts turns or radians: write rpm"):
        number_in_si("w", text, unit)


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("50 1/s", "rad/s", 50.0), ("50 s-1", "rad/s", 50.0), ("2 1/ms", "rad/s", 2e3), ("60 rad/min", "rad/s", 1.0),
        ("60 rev/h", "rad/s", math.pi / 30), ("3000 1/min", "Hz", 50.0), ("3000 1/min", "1/s", 50.0), ("6 kJ/min", "W", 100.0),
        ("30 N m min/rad", "N m s/rad", 1800.0), ("2 kW h", "J", 7.2e6), ("30 m/min", "m/s", 0.5),
    ],
)  # fmt: skip
def test_per_second_is_si_and_minutes_beside_a_named_angle_or_none_at_all_are_no_doubt(
    text: str, unit: str, number: float
) -> None:
    assert number_in_si("x", text, unit) == pytest.approx(number, rel=4e-16)


@pytest.mark.parametrize("text", ["0.02 kg*m**2", "0.02 kg m^2", "0.02 kg·m²", "20 g*m**2"])
def test_powers_are_read_as_python_and_people_write_them(text: str) -> None:
    assert number_in_si("J", text, "kg m2") == 0.02


def test_digits_are_taken_as_decimals() -> None:
    assert parse_unit("mm").in_si(0.1) == 1e-4 and parse_unit("um").in_si(3.3) == 3.3e-6
    assert number_in_si("k", "0.07 GN/m", "N/m") == 7e7
    for unit, value in (("rpm", 3000.0), ("deg", 30.0), ("km/h", 130.0), ("mm", 0.1)):
        assert parse_unit(unit).of_si(parse_unit(unit).in_si(value)) == pytest.approx(value, rel=4e-16)
    assert math.isnan(parse_unit("mm").in_si(math.nan)) and parse_unit("mm").in_si(math.inf) == math.inf


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("200 MN/m", "N/m", 2e8), ("200MN/m", "N/m", 2e8), (" 3 kN m ", "N m/rad", 3e3),
        ("-2.5e-3 deg", "rad", -math.pi / 72000),
        (".5 m", "m", 0.5), ("5 %", "1", 0.05), ("50 Hz", "1/s", 50.0),
        ("3000rpm", "rad/s", 100 * math.pi), ("\N{MINUS SIGN}1 mm", "m", -1e-3),
    ],
)  # fmt: skip
def test_a_value_brings_its_unit(text: str, unit: str, number: float) -> None:
    assert number_in_si("k", text, unit) == pytest.approx(number, rel=4e-16)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("3 kN", "N m", r"k = '3 kN' is in kN \(N\), but what belongs here is in N m"), ("50 Hz", "rad/s", "give rad/s or rpm"),
        ("5", "N", "with its unit such as '3 N'"), ("abc", "N", "must be a number"), ("3 banana", "N", "'banana' is no unit"),
        ("5 m2", "m", "in m2"), ("", "1", "must be a number"), ("1,5 mm", "m", "without commas: '1.5 mm'"),
        ("0,02", "1", "without commas: '0.02'"), ("1,000.5 kg m2", "kg m2", "'1000.5 kg m2'"),
        ("nan m", "m", "must be a number"),
    ],
)  # fmt: skip
def test_what_measures_something_else_is_refused_by_both_names(text: str, unit: str, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        number_in_si("k", text, unit)


class Foreign:
    """A quantity as packages for units have it: millimetres per second, a frequency."""

    def __init__(self, magnitude: float, units: str, base: "Foreign | None" = None) -> None:
        self.magnitude, self.units, self.base = magnitude, _Units(units), base

    def to_base_units(self) -> "Foreign":
        return self.base or self


class _Units(str):
    def __format__(self, spec: str) -> str:
        assert spec == "~C"
        return str(self)


def test_quantities_of_other_packages_are_taken() -> None:
    stiffness = Foreign(200.0, "MN/m", Foreign(2e8, "kg/s**2"))
    assert number_in_si("k", stiffness, "N/m") == 2e8
    with pytest.raises(ParameterError, match="belongs here is in N m"):
        number_in_si("k", stiffness, "N m")
    with pytest.raises(ParameterError, match="Hz counts cycles"):
        number_in_si("w", Foreign(50.0, "Hz", Foreign(50.0, "1/s")), "rad/s")
    with pytest.raises(ParameterError, match="counts turns or radians"):
        number_in_si("w", Foreign(3000.0, "1/min", Foreign(50.0, "1/s")), "rad/s")
    assert number_in_si("w", Foreign(3000.0, "m/mm", Foreign(3e6, "1/s")), "rad/s") == 3e6


def test_quantities_of_pint_are_taken() -> None:
    pint = pytest.importorskip("pint")
    quantity = pint.UnitRegistry().Quantity
    assert number_in_si("k", quantity(200, "MN/m"), "N/m") == pytest.approx(2e8, rel=1e-15)
    assert number_in_si("w", quantity(3000, "rpm"), "rad/s") == pytest.approx(100 * math.pi, rel=1e-15)
    assert number_in_si("k", quantity(3, "kN*m/deg"), "N m/rad") == pytest.approx(540e3 / math.pi, rel=1e-15)
    with pytest.raises(ParameterError, match="Hz counts cycles"):
        number_in_si("w", quantity(50, "Hz"), "rad/s")


def test_sixty_revolutions_per_minute_are_one_turn_per_second() -> None:
    assert rpm(60) == 2 * math.pi
    assert np.array_equal(rpm(np.array([0.0, 60.0])), [0.0, 2 * math.pi])
    assert np.array_equal(rpm([30.0]), [math.pi])


@pytest.mark.parametrize("unit", ["rpm", "deg", "mm", "km/h", "kN m", "um"])
def test_a_value_in_a_unit_and_back_is_the_value(unit):
    found = parse_unit(unit)
    for value in (*range(1, 400), *(n / 10 for n in range(1, 200)), 3500, 500, 1e-7, 123456.789):
        assert found.of_si(found.in_si(float(value))) == value


def test_a_frequency_in_hertz_is_one_of_an_oscillation() -> None:
    found = frequencies_in_si("frequencies", ["50 Hz", "3000 rpm", 3.0, "1 kHz", "2 rad/s", "3 1/s"])
    assert found.tolist() == [100 * math.pi, 100 * math.pi, 3.0, 2000 * math.pi, 2.0, 3.0]
    assert frequencies_in_si("frequencies", "50 Hz").tolist() == [100 * math.pi]
    assert frequencies_in_si("frequencies", np.array([1.0, 2.0])).tolist() == [1.0, 2.0]
    with pytest.raises(ParameterError, match="frequencies = '3 mm' is in mm"):
        frequencies_in_si("frequencies", "3 mm")
