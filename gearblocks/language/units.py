"""Units: SI and radians inside, and a closed list of others that values may be given in. Their text is read, never guessed."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import ParameterError
from gearblocks.language.expression import finite_number
from gearblocks.language.unit_spelling import in_one_piece, near_unit, of_no_factor, same_letters

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""The base units of FMI, in its order."""

_SI: dict[str, dict[str, int]] = {
    **{name: {name: 1} for name in BASE},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Hz": {"s": -1},
    "C": {"A": 1, "s": 1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "F": {"kg": -1, "m": -2, "s": 4, "A": 2},
    "ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}
"""Coherent units of SI: a value in them is taken as it stands."""
_PREFIXES = {
    "T": 12, "G": 9, "M": 6, "k": 3, "h": 2, "da": 1, "d": -1, "c": -2, "m": -3, "u": -6, "n": -9, "p": -12,
}  # fmt: skip
"""Powers of ten before units of SI, g and l."""
_POUND, _GRAVITY, _INCH = Fraction("0.45359237"), Fraction("9.80665"), Fraction("0.0254")
_OTHERS: dict[str, tuple[Fraction, int, str]] = {
    "g": (Fraction(1, 1000), 0, "kg"),
    "t": (Fraction(1000), 0, "kg"),
    "l": (Fraction(1, 1000), 0, "m3"),
    "Nm": (Fraction(1), 0, "N m"),
    "min": (Fraction(60), 0, "s"),
    "h": (Fraction(3600), 0, "s"),
    "rpm": (Fraction(2, 60), 1, "rad/s"),
    "rev": (Fraction(2), 1, "rad"),
    "deg": (Fraction(1, 180), 1, "rad"),
    "arcmin": (Fraction(1, 10800), 1, "rad"),
    "arcsec": (Fraction(1, 648000), 1, "rad"),
    "%": (Fraction(1, 100), 0, "1"),
    "bar": (Fraction(100000), 0, "Pa"),
    "PS": (75 * _GRAVITY, 0, "W"),
    "hp": (550 * 12 * _INCH * _POUND * _GRAVITY, 0, "W"),
    "in": (_INCH, 0, "m"),
    "ft": (12 * _INCH, 0, "m"),
    "mi": (63360 * _INCH, 0, "m"),
    "mph": (63360 * _INCH / 3600, 0, "m/s"),
    "kph": (Fraction(1000, 3600), 0, "m/s"),
    "lb": (_POUND, 0, "kg"),
    "lbf": (_POUND * _GRAVITY, 0, "N"),
    "psi": (_POUND * _GRAVITY / _INCH**2, 0, "Pa"),
}
"""Other units: how many of the SI unit behind them, as a fraction and a power of pi."""
_PREFIXED = {*_SI, "g", "l", "Nm"} - {"kg", "Ohm"}
_FACTOR = re.compile(r"([A-Za-z%]+)(?:\^?([+-]?\d+))?")
_NESTED = re.compile(r"\([^)]*/")
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*")
_COMMA = re.compile(r"\s*,(\d+)")
_POWERS = re.compile(r"(.*)\((\w+)/(\w+)\)\^-i")
_CLOCK = ("min", "h")
_CLOCK_WORDS = re.compile(r"\b(min|h)\b")
_SIGNS = str.maketrans({
    "\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u", "\N{DEGREE SIGN}": "deg", "\N{OHM SIGN}": "ohm",
    "\N{GREEK CAPITAL LETTER OMEGA}": "ohm", "·": " ", "⋅": " ", "*": " ", "²": "2", "³": "3", "−": "-",
    "⁻": "-", "¹": "1", "(": " ", ")": " ", "\N{NO-BREAK SPACE}": " ",
})  # fmt: skip


def _plain(text: str) -> str:
    """A text in the letters that are read: powers may be written with ** too."""
    return text.replace("**", "^").translate(_SIGNS)


class Unit(NamedTuple):
    """A unit as it was written: one of it is ratio * pi^turns of `si`, which reads alike and is coherent.

    exponents: of the base units, zeros left out. cycles: how often it counts whole cycles, as Hz does. clock: whether minutes
    or hours stand in it.
    """

    text: str
    ratio: Fraction
    turns: int
    si: str
    exponents: MappingProxyType[str, int]
    cycles: int
    clock: bool = False

    @property
    def factor(self) -> float:
        """SI units in one of it."""
        return float(self.ratio) * math.pi**self.turns

    @property
    def is_coherent(self) -> bool:
        """Whether a value in it is one in SI."""
        return self.ratio == 1 and self.turns == 0

    def in_si(self, value: float) -> float:
        """A value in SI; the digits of the value are taken as decimals, so that 0.1 mm is 1e-4 m."""
        if self.is_coherent or not math.isfinite(value):
            return value
        return float(Fraction(repr(float(value))) * self.ratio) * math.pi**self.turns

    def of_si(self, value: float) -> float:
        """A value of SI in this unit, without the digits that rounding leaves: 500 rpm and back are 500."""
        if self.is_coherent or not math.isfinite(value):
            return value
        found = float(Fraction(repr(float(value) / math.pi**self.turns)) / self.ratio)
        short = float(f"{found:.15g}")
        return short if self.in_si(short) == value else found

    def measures(self, other: Unit) -> bool:
        """Whether both measure the same. A radian counts as 1; a cycle is none of both, and what is counted per minute or
        hour may be turns."""
        return self._alike(other) and (
            self.exponents.get("rad", 0) == other.exponents.get("rad", 0)
            or (self.cycles == other.cycles and not (self.clock or other.clock))
        )

    def _alike(self, other: Unit) -> bool:
        """The same exponents, but for those of the radian."""
        mine, others = ({b: n for b, n in unit.exponents.items() if b != "rad"} for unit in (self, other))
        return mine == others

    def doubt(self, other: Unit) -> str:
        """What is left open where the two differ in nothing but turns and radians, and the way out; else ""."""
        if not self._alike(other) or self.measures(other):
            return ""
        if self.cycles != other.cycles:
            return "; a frequency in Hz counts cycles: give rad/s or rpm"
        text = next(unit.text for unit in (self, other) if unit.clock)
        return f"; '{text}' does not say whether it counts turns or radians: write rpm (or rev, rad) for the one that is meant"


@cache
def parse_unit(text: str) -> Unit:
    """The unit that a text stands for. Factors are separated by blanks; everything after a slash divides ("W/m2 K" is
    W m-2 K-1); "m2", "m^2" and "s-2" are powers; "" and "1" are the number one. Raises ParameterError for any other text.
    """
    if _NESTED.search(text):
        raise ParameterError(f"unit '{text}': write it with one slash and without brackets, such as 'N m s/rad'")
    plain = _plain(text)
    factors = [
        (*_factor(word, text), 1 if position == 0 else -1)
        for position, part in enumerate(plain.split("/")) for word in part.split() if word != "1"
    ]  # fmt: skip
    ratio, turns, cycles, exponents = Fraction(1), 0, 0, dict.fromkeys(BASE, 0)
    for one, power, sign in factors:
        ratio, turns, cycles = (
            ratio * one.ratio ** (sign * power), turns + sign * power * one.turns, cycles + sign * power * one.cycles
        )  # fmt: skip
        for base, exponent in one.exponents.items():
            exponents[base] += sign * power * exponent
    si = text if plain == text and all(one.text in _SI for one, _, _ in factors) else _si_text(factors)
    clock = any(one.text in _CLOCK for one, _, _ in factors)
    return Unit(text, ratio, turns, si, MappingProxyType({b: n for b, n in exponents.items() if n}), cycles, clock)


def _factor(word: str, text: str) -> tuple[Unit, int]:
    """One factor such as "kN" or "s-2": the unit, and its power."""
    match = _FACTOR.fullmatch(word)
    one = None if match is None else _named(match[1])
    if match is None or one is None:
        way = of_no_factor(_plain(text), "") or near_unit(_plain(text), _names()) or f"; known are {known_units()}"
        raise ParameterError(f"unit '{text}': '{word}' is no unit known here{way}")
    return one, int(match[2] or 1)


@cache
def _named(name: str) -> Unit | None:
    if name in _SI:
        return Unit(name, Fraction(1), 0, name, MappingProxyType(_SI[name]), int(name == "Hz"))
    if name in _OTHERS:
        ratio, turns, si = _OTHERS[name]
        return Unit(name, ratio, turns, si, parse_unit(si).exponents, 0)
    for prefix, power in _PREFIXES.items():
        one = _named(name.removeprefix(prefix)) if name.removeprefix(prefix) in _PREFIXED else None
        if one is not None and name.startswith(prefix):
            return one._replace(text=name, ratio=one.ratio * Fraction(10) ** power)
    return None


@cache
def _names() -> dict[str, bool]:
    """Whether a name of a unit has a prefix, of all."""
    return {prefix + name: True for prefix in _PREFIXES for name in _PREFIXED} | dict.fromkeys((*_SI, *_OTHERS), False)


def _si_text(factors: list[tuple[Unit, int, int]]) -> str:
    """The coherent unit behind factors with their powers: numerator (1) or denominator (-1), as they were written."""
    lines: dict[int, list[str]] = {1: [], -1: []}
    for one, power, sign in factors:
        for below, words in enumerate(one.si.split("/")):
            for name, exponent in _FACTOR.findall(words):
                total = power * int(exponent or 1)
                lines[-sign if below else sign].append(name if total == 1 else f"{name}{total}")
    above = " ".join(lines[1]) or "1"
    return f"{above}/{' '.join(lines[-1])}" if lines[-1] else above


def known_units() -> str:
    """The units that are read, for messages."""
    return f"{', '.join(_SI)} (with prefixes: kN, mm, um, MPa), {', '.join(_OTHERS)}, joined as in 'N m/rad' or 'kg m2'"


def base_exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units (and rad), zeros left out: "N m/rad" gives kg 1, m 2, s -2, rad -1.

    Raises ParameterError for text that is no unit known here.
    """
    return dict(parse_unit(unit).exponents)


def check_unit(what: str, unit: Any) -> Unit:
    """The unit of a value. Raises ParameterError where it is not text, or none that is known here."""
    if not isinstance(unit, str):
        raise ParameterError(f"{what}: unit = {unit!r} must be text such as 'N m'")
    try:
        return parse_unit(unit)
    except ParameterError as error:
        raise ParameterError(f"{what}: {error}") from None


def in_unit(what: str, value: Any, unit: Unit) -> float:
    """A finite number in a unit: a plain one is in it, one that brings a unit is converted."""
    return unit.of_si(number_in_si(what, value, unit.text)) if has_unit(value) else finite_number(what, value)


def declared(what: str, unit: Any) -> Unit:
    """The unit that a block declares. Raises ParameterError where values in it are none in SI, as a bare number is."""
    found = check_unit(what, unit)
    if not found.is_coherent:
        raise ParameterError(
            f"{what}: unit '{unit}': declare it in SI, '{found.si}'; values may be given in {unit} then"
        )
    return found


def unit_of_entry(unit: str, i: int) -> str:
    """The unit of number i of a row of coefficients: "N m (rad/s)^-i" stands for N m, N m s/rad, N m s2/rad2."""
    match = _POWERS.fullmatch(unit)
    if match is None or i == 0:
        return unit if match is None else match[1].strip()
    power = "" if i == 1 else str(i)
    return f"{match[1]}{match[3]}{power}/{match[2]}{power}"


def unit_along(unit: str, slides: bool) -> str:
    """The unit on a slider of what a flange that takes both declares for a turning one: N m/rad becomes N/m."""
    return unit.replace("N m", "N").replace("rad", "m") if slides else unit


class Given(float):
    """A number in SI that was given in a unit: of a shaft or of a slider, whichever its block turns out to be."""

    __slots__ = ("unit",)
    unit: str

    def __new__(cls, number: float, unit: str) -> Given:
        made = super().__new__(cls, number)
        made.unit = unit
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return Given, (float(self), self.unit)


def given(value: Any, unit: str, other: str) -> Given:
    """A value that brings its unit, for a field in `unit`, or in `other`: on a slider, or of a deflection that is an angle."""
    wanted = parse_unit(unit)
    number, found = _read(_shown(value), value, wanted)
    if not found.measures(parse_unit(other)):
        same_measure(_shown(value), found, wanted)
    return Given(found.in_si(number), found.text)


def same_measure(what: str, given: Unit, wanted: Unit) -> None:
    """ParameterError where a unit measures something else than what is wanted."""
    way = of_no_factor(_plain(given.text), wanted.text)
    if way or not given.measures(wanted):
        raise ParameterError(
            f"{what} is in {given.text or '1'} ({given.si or '1'}), but what belongs here is in {wanted.text or '1'}"
            f"{given.doubt(wanted)}{same_letters(given.text, wanted.text)}{way}"
        )


def has_unit(value: Any) -> bool:
    """Whether a value brings its unit: text, or a quantity of a package for units (pint: with `magnitude` and `units`)."""
    return isinstance(value, str) or (hasattr(value, "magnitude") and hasattr(value, "to_base_units"))


def unit_written(value: Any) -> str | None:
    """The unit that a value brings, as it is written; None where it is a bare number."""
    if not has_unit(value):
        return None
    return number_and_unit(value)[1] or "1" if isinstance(value, str) else _text(value.units)


def is_quantity(text: str) -> bool:
    """Whether a text is a number and something behind it, which may be its unit."""
    return all(number_and_unit(text))


def number_and_unit(text: str) -> tuple[str, str]:
    """The number that a text begins with, and what is behind it."""
    plain = _plain(text)
    match = _NUMBER.match(plain)
    return ("", plain) if match is None else (match[1], plain[match.end() :].strip())


def number_in_si(what: str, value: Any, unit: str) -> float:
    """The number in SI of a value that brings its unit, such as "200 MN/m". unit: what belongs there.

    Raises ParameterError, which names both, where the value measures something else.
    """
    wanted = parse_unit(unit)
    what = f"{what} = {_shown(value)}"
    number, found = _read(what, value, wanted)
    same_measure(what, found, wanted)
    return found.in_si(number)


def seconds(name: str, value: float | str) -> float:
    """A time [s], or text with its unit such as "20 ms"."""
    return number_in_si(name, value, "s") if has_unit(value) else finite_number(name, value)


def row_in_si(what: str, values: Any, unit: str) -> NDArray[np.float64]:
    """A row of values in SI, or one value as a row of it: each brings its unit, or is a bare number. Raises ParameterError for
    what is no finite number, or measures something else."""
    cells = [values] if has_unit(values) else values
    if isinstance(cells, (list, tuple)):
        cells = [number_in_si(what, x, unit) if has_unit(x) else x for x in cells]
    try:
        row = np.atleast_1d(np.asarray(cells, dtype=np.float64))
    except (TypeError, ValueError):
        raise ParameterError(f"{what} = {values!r:.80} must be numbers in {unit}, or texts with their unit") from None
    if not np.isfinite(row).all():
        i = int(np.flatnonzero(~np.isfinite(row))[0])
        raise ParameterError(f"{what}: value [{i}] = {row.flat[i]} must be a finite number; leave it out or repair it")
    return row


def frequencies_in_si(what: str, values: Any) -> NDArray[np.float64]:
    """Frequencies of an oscillation [rad/s], as of `row_in_si`; among them some in Hz, whose cycle is 2 pi."""
    cells = [values] if has_unit(values) else values
    listed = [_angular(what, x) if has_unit(x) else x for x in cells] if isinstance(cells, (list, tuple)) else cells
    return row_in_si(what, listed, "rad/s")


def _angular(what: str, value: Any) -> float:
    number, unit = _read(f"{what} = {_shown(value)}", value, parse_unit("rad/s"))
    cycles = unit.cycles == 1 and unit.measures(parse_unit("Hz"))
    return 2 * math.pi * unit.in_si(number) if cycles else number_in_si(what, value, "rad/s")


def _shown(value: Any) -> str:
    return f"{value!r:.80}" if isinstance(value, str) else str(value)


def _text(units: Any) -> str:  # of pint, in our words
    return format(units, "~C").replace("**", "^")


def _read(what: str, value: Any, wanted: Unit) -> tuple[float, Unit]:
    if not isinstance(value, str):
        base = value.to_base_units()  # SI, angles in radians; Hz becomes 1/s
        unit = check_unit(what, _text(base.units))
        words = _text(value.units)
        clock = bool(_CLOCK_WORDS.search(words))
        return float(base.magnitude), unit._replace(cycles=unit.cycles + ("Hz" in words), clock=clock)
    number, behind = number_and_unit(value)
    if comma := _COMMA.match(behind):
        point = "" if "." in number + behind else "."
        way = f"'{number}{point}{comma[1]}{behind[comma.end() :]}'"
        raise ParameterError(f"{what}: a number is written with a point and without commas: {way}")
    if number and (way := in_one_piece(number, behind)):
        raise ParameterError(f"{what}: a number is written without blanks or signs between its digits: '{way}'")
    if not (number and behind):
        example = f"'3 {wanted.text}'" if wanted.text not in ("", "1") else "3"
        raise ParameterError(f"{what} must be a number, or text of a number with its unit such as {example}")
    return float(number), check_unit(what, behind)
