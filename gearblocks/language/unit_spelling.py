"""Units that are written otherwise than they are read: the spelling that was meant, for messages alone."""

from __future__ import annotations

import re
from collections.abc import Mapping

_FACTOR = re.compile(r"([A-Za-z%]+)(\^?[+-]?\d*)")
_GROUPS = re.compile(r"((?:['\N{RIGHT SINGLE QUOTATION MARK}_ ]?\d{3})+)(\.\d+)?(?![\d/])")
_WORDS = {
    "micron": "um", "microns": "um", "u": "rev", "turn": "rev", "turns": "rev", "upm": "rpm", "degree": "deg",
    "degrees": "deg", "radian": "rad", "radians": "rad", "sec": "s", "second": "s", "seconds": "s", "minute": "min",
    "minutes": "min", "hour": "h", "hours": "h", "newton": "N", "newtons": "N", "meter": "m", "metre": "m", "meters": "m",
    "metres": "m", "inch": "in", "lbs": "lb", "kgs": "kg", "gram": "g", "grams": "g", "kmh": "km/h", "percent": "%",
}  # fmt: skip
"""Names of units in other tongues and at full length."""


def near_unit(text: str, known: Mapping[str, bool]) -> str:
    """ " - did you mean 'kg m2'?" where every factor of a unit is a known one in other letters, or several in one word.

    known: whether a name has a prefix."""
    if not all(_FACTOR.fullmatch(word) for word in re.split(r"[\s/]+", text)):
        return ""
    factors = [_nearest(match, known) for match in _FACTOR.finditer(text)]
    told = iter(factors)
    return f" - did you mean '{_FACTOR.sub(lambda _: next(told), text)}'?" if all(factors) else ""


def same_letters(given: str, wanted: str) -> str:
    """The question whether "N m" was meant where "nm" is given, which is another unit in the same letters."""
    alike = given != wanted and given.replace(" ", "").casefold() == wanted.replace(" ", "").casefold()
    return f" - did you mean '{wanted}'?" if alike else ""


def of_no_factor(given: str, wanted: str) -> str:
    """The way out from degrees Celsius, whose 0 is not that of K, and from a slope in % for an angle; else ""."""
    if re.sub(r"\s", "", given).casefold() in ("degc", "celsius", "degcelsius", "degreecelsius", "degreescelsius"):
        return "; temperatures are in K: 20 degrees Celsius are 293.15 K"
    return "; a slope of 5 % is the angle sympy.atan(0.05), '2.86 deg'" if given == "%" and wanted == "rad" else ""


def in_one_piece(number: str, behind: str) -> str:
    """A number whose thousands stand apart ("20 000 N m", "20'000") and the unit behind it as they are read, else ""."""
    match = _GROUPS.match(behind)
    if match is None or "." in number:
        return ""
    digits = re.sub(r"\D", "", match[1])
    return f"{number}{digits}{match[2] or ''} {behind[match.end() :].strip()}".strip()


def _nearest(match: re.Match[str], known: Mapping[str, bool]) -> str:
    letters, power = match[1], match[2]
    if letters in known:
        return letters + power
    if letters.casefold() in _WORDS:
        return _WORDS[letters.casefold()] + power
    alike = [name for name in known if name.casefold() == letters.casefold()]
    if alike:  # NM is Nm sooner than nm, MM is mm sooner than Mm, MPA is MPa sooner than mPa
        return max(alike, key=lambda name: (not known[name], name == letters.lower(), _same(name, letters))) + power
    apart = _apart(letters, known)
    return apart + power if apart else ""


def _apart(letters: str, known: Mapping[str, bool]) -> str:
    """Units that stand in one word without blanks, the longest first, else ""."""
    for cut in range(len(letters), 0, -1):
        if letters[cut:] == letters[cut - 1]:  # Nmm is N mm, not Nm m
            continue
        if letters[:cut] in known and (cut == len(letters) or _apart(letters[cut:], known)):
            return f"{letters[:cut]} {_apart(letters[cut:], known)}".rstrip()
    return ""


def _same(name: str, other: str) -> int:
    """How many letters stand alike in two words of one length."""
    return sum(a == b for a, b in zip(name, other, strict=True))
