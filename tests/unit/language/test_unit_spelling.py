"""Units that are written otherwise than they are read: the message says the spelling that was meant."""

from __future__ import annotations

import pytest

import gearblocks as gb
from gearblocks.errors import ModelError, ParameterError
from gearblocks.language.units import number_in_si, parse_unit

MEANT = {
    "RPM": "rpm", "U/min": "rev/min", "KG M2": "kg m2", "kgm2": "kg m2", "kgm^2": "kg m^2", "kg*M**2": "kg m^2", "NM": "Nm",
    "micron": "um", "KN m/rad": "kN m/rad", "MPA": "MPa", "KHZ": "kHz", "N/MM": "N/mm", "Nms/rad": "Nm s/rad", "kmh": "km/h",
    "µM": "um", "degrees": "deg",
}  # fmt: skip


@pytest.mark.parametrize("written", MEANT)
def test_the_unit_that_was_meant_is_asked_for_and_can_be_read(written: str) -> None:
    with pytest.raises(ParameterError, match="is no unit known here") as raised:
        parse_unit(written)
    assert str(raised.value).endswith(f" - did you mean '{MEANT[written]}'?")
    parse_unit(MEANT[written])


@pytest.mark.parametrize("written", ["banana", "kNn/rad", "3 N", "qq m", "$"])
def test_nothing_is_asked_where_nothing_is_near(written: str) -> None:
    with pytest.raises(ParameterError, match="known are kg, m, s") as raised:
        parse_unit(written)
    assert "did you mean" not in str(raised.value)


def test_a_unit_in_the_letters_of_the_one_that_belongs_there_is_asked_about() -> None:
    with pytest.raises(ModelError, match=r"is in nm \(m\), .* in N m - did you mean 'N m'\?"):
        gb.Torque(tau="20 nm")
    with pytest.raises(ModelError, match=r"belongs here is in N m$"):
        gb.Torque(tau="20 mm")


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("20 000 N m", "20000 N m"), ("20'000 N m", "20000 N m"), ("20_000 N m", "20000 N m"),
        ("1 234 567.5 N m", "1234567.5 N m"),
    ],
)  # fmt: skip
def test_a_number_with_thousands_apart_is_told_in_one_piece(written: str, read: str) -> None:
    with pytest.raises(ParameterError, match=f"without blanks or signs between its digits: '{read}'"):
        number_in_si("torque", written, "N m")
    number_in_si("torque", read, "N m")


def test_what_only_looks_like_thousands_is_read_as_before() -> None:
    with pytest.raises(ParameterError, match="counts turns or radians"):
        number_in_si("speed", "3000 1/min", "rad/s")
    with pytest.raises(ParameterError, match="'3' is no unit known here"):
        number_in_si("force", "2 3 N", "N")
    assert number_in_si("rate", "3 1/s", "1/s") == 3.0


@pytest.mark.parametrize("text", ["25 degC", "25 °C", "25 deg C", "25 celsius"])
def test_degrees_celsius_are_refused_with_the_way_to_kelvin(text: str) -> None:
    with pytest.raises(ParameterError, match=r"temperatures are in K: 20 degrees Celsius are 293\.15 K"):
        number_in_si("T0", text, "K")


def test_a_slope_in_percent_is_no_angle() -> None:
    with pytest.raises(ParameterError, match=r"grade = '5 %' is in %.*sympy\.atan\(0\.05\)"):
        number_in_si("grade", "5 %", "rad")
    assert number_in_si("slip", "5 %", "1") == 0.05
