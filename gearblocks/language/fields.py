"""Declarations of fields (parameters, exact numbers, options, signals, effects) with words, unit, default, bounds and role;
of flanges and states.

What a field means is declared here, never read off its name. Knows nothing of blocks, nor of values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearblocks.errors import ModelError, arguments_told, by_name_only
from gearblocks.language.expression import finite_number
from gearblocks.language.tidy import Tidy
from gearblocks.language.units import declared, unit_of_entry


def same_value(one: Any, other: Any) -> bool:
    """Whether two values of a field, or fields by name, are equal: arrays by their numbers."""
    try:
        return one is other or bool(one == other)
    except ValueError:  # of arrays, which are compared number by number
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            return one.keys() == other.keys() and all(same_value(one[name], other[name]) for name in one)
        return bool(np.array_equal(one, other))


class _Required:
    """Stands for the default that a required field has not; printed alike in every process."""

    def __repr__(self) -> str:
        return "required"


_REQUIRED: Any = _Required()

ANGLE, SPEED = "angle", "speed"
"""Roles of start values: the angle or the speed of a shaft; of a slider, position or speed."""
RELATIVE_ANGLE, RELATIVE_SPEED, ACCELERATION = "relative angle", "relative speed", "acceleration"
"""Further roles of start values: of a compliant element, from its first flange to its second; of a body."""
COMPLIANCE = "compliance"
"""The effect that all others of a compliant block rest on."""
SLIP, INERTIA = "slip", "inertia"
GIVING_WAY = (COMPLIANCE, "backlash", SLIP)
"""Effects that let the flanges of a block turn apart: without them it may be a rigid tie."""


@dataclass(frozen=True, slots=True)
class Field:
    """The declaration of one field: words, unit, default and bounds.

    role: "param" (a number, runs as a tunable value), "exact" (integers that enter ratios exactly), "option" (part of
    the structure), "signal", "effect". belongs_to: the effect that goes when this field is None ("compliance").
    convert: turns a short form (a Table, say) into the effect that it stands for. over: the quantity of the block
    ("twist") that an expression in the field may contain, and a Table in it is read at. start: the start value that the
    field is, of the shaft that its block has a body at: "angle" or "speed". absence_of: the effect that True in this
    option says is absent. leading: of a row, how many of its first numbers the law takes; the others follow from them.
    usual: the largest size that one expects, above which rig.describe() asks whether it is meant. each: of a row, words
    of its numbers one by one, or one text for all with {n} (1, 2, ...) or {odd} (1, 3, ...). of_deflection: in the unit of
    the deflection that an effect is of: a length, or an angle where the field for the effect says so (turns). or_one_of:
    fields one of which must be given where this one is not. part: the output of another part ("T") that a text in the field,
    the name of that part, stands for. symbol: that of printed equations, spelled as "T_C" or "omega_0". unless: the option
    that, where it is True, lifts the bounds. why: what is said behind a bound that is broken: its reason, or another way out.
    positive: of a row, the numbers that are > 0.
    """

    words: str
    unit: str
    role: str
    default: Any = _REQUIRED
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    many: bool = False
    belongs_to: str | None = None
    convert: Callable[[Any], Any] | None = None
    over: str | None = None
    start: str | None = None
    absence_of: str | None = None
    leading: int | None = None
    usual: float | None = None
    or_one_of: tuple[str, ...] = ()
    each: tuple[str, ...] = ()
    of_deflection: bool = False
    turns: bool = False
    part: str = ""
    symbol: str = ""
    unless: str = ""
    why: str = ""
    positive: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.unit != "1":
            declared(f"'{self.words}'", unit_of_entry(self.unit, 1) if isinstance(self.unit, str) else self.unit)

    def entry(self, i: int) -> Field:
        """The declaration of number i of a row."""
        words = self.each[i] if i < len(self.each) else (self.each or (self.words,))[0]
        unit = self.unit if "^-i" not in self.unit else unit_of_entry(self.unit, i)
        if (words, unit) == (self.words, self.unit) and i not in self.positive:
            return self
        least = 0.0 if i in self.positive else self.gt
        return replace(
            self, unit=unit, gt=least, words=words.replace("{n}", str(i + 1)).replace("{odd}", str(2 * i + 1))
        )

    def along(self, other: Field) -> Field:
        """The declaration of a field of the effect that stands in this one."""
        return replace(other, unit="rad") if self.turns and other.of_deflection else other

    def binding(self, values: Mapping[str, Any]) -> Field:
        """The declaration as it binds an owner with these values: without bounds where its option lifts them."""
        return (
            replace(self, gt=None, ge=None, lt=None, le=None) if self.unless and values[self.unless] is True else self
        )

    @property
    def required(self) -> bool:
        """Whether a block cannot be made without it."""
        return self.default is _REQUIRED


@by_name_only
def param(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, gt: float | None = None, ge: float | None = None,
    lt: float | None = None, le: float | None = None, many: bool = False, belongs_to: str | None = None,
    start: str | None = None, leading: int | None = None, usual: float | None = None, each: tuple[str, ...] = (),
    of_deflection: bool = False, or_one_of: tuple[str, ...] = (), symbol: str = "", positive: tuple[int, ...] = (),
) -> Any:  # fmt: skip
    """A number in SI units; a `Parameter` may stand for it. Bounds: gt (>), ge (>=), lt (<), le (<=).

    default=None makes it optional: None means absent. many=True: a tuple of numbers. start="angle" or "speed": the start
    angle [rad, m] or start speed [rad/s, m/s] of the shaft that the block has a Body at, fixed once a run has begun; the
    physics of the block cannot read it. leading: only so many first numbers of a row run as values, the others follow.
    usual: the largest size that one expects; above it rig.describe() asks whether it is meant. each: words of the numbers of
    a row one by one, or one text with {n} (1, 2, ...) or {odd} (1, 3, ...). of_deflection: of an effect, a length that is an
    angle where the deflection is one (see `effect`). or_one_of: fields one of which must be given where this one is not.
    symbol: that of printed equations, as "T_C" or "omega_0"; else its name. positive: which numbers of a row are > 0.
    """
    known = (None, ANGLE, SPEED, RELATIVE_ANGLE, RELATIVE_SPEED, ACCELERATION)
    if start not in known or (start is not None and many):
        raise ModelError(f"param '{words}': start = {start!r} must be 'angle' or 'speed', of one number")
    return Field(
        words,
        unit,
        "param",
        default,
        gt,
        ge,
        lt,
        le,
        many,
        belongs_to,
        start=start,
        leading=leading,
        usual=usual,
        each=each,
        of_deflection=of_deflection,
        or_one_of=or_one_of,
        symbol=symbol,
        positive=positive,
    )


@by_name_only
def exact(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, many: bool = False, each: tuple[str, ...] = (),
    symbol: str = "",
) -> Any:  # fmt: skip
    """A number that enters ratios exactly (tooth counts; a float stands for its exact binary fraction). Structural. symbol:
    that of printed equations."""
    return Field(words, unit, "exact", default, many=many, each=each, symbol=symbol)


@by_name_only
def option(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, many: bool = False, belongs_to: str | None = None,
    absence_of: str | None = None, turns: bool = False,
) -> Any:  # fmt: skip
    """A choice (text, truth, number) that decides the form of the law. Structural. many=True: a tuple of them. A function, an
    array or another object counts by its content.

    absence_of: the effect ("compliance") that True stands for the absence of. turns: see `effect`, where it takes one.
    """
    return Field(words, unit, "option", default, many=many, belongs_to=belongs_to, absence_of=absence_of, turns=turns)


@by_name_only
def signal(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, gt: float | None = None, ge: float | None = None,
    lt: float | None = None, belongs_to: str | None = None, over: str | None = None, part: str = "", symbol: str = "",
    unless: str = "", why: str = "",
) -> Any:  # fmt: skip
    """A number, Parameter, Input, Table over time or expression (see gb.time, gb.sense), by sympy too.

    gt (>), ge (>=), lt (<): bounds of a number or Parameter; what varies is not judged. unless: the option that, where it is
    True, lifts them. why: said behind a bound that is broken. over: a quantity of the block that may stand
    in it too, see Symbols.local; a Table then goes over that quantity. part: an output, such as "T": a text is the name of the
    part of the train that shows it. symbol: that of printed equations.
    """
    return Field(
        words, unit, "signal", default, gt, ge, lt, belongs_to=belongs_to, over=over, part=part, symbol=symbol,
        unless=unless, why=why,
    )  # fmt: skip


@by_name_only
def effect(words: str, *, default: Any = None, convert: Callable[[Any], Any] | None = None, turns: bool = False) -> Any:
    """An effect object, or None: absent. convert: turns a short form into the effect it stands for. turns: the deflection that
    it is of is an angle, and what the effect has of that is in rad."""
    return Field(words, "1", "effect", default, convert=convert, turns=turns)


@arguments_told
@dataclass(frozen=True, slots=True)
class Flange(metaclass=Tidy):
    """A rotating connection point, or a sliding one.

    ground: means the ground when nothing is connected; spare: may stay open; both: is the ground then, but a chain passes
    through it. slider: True for positions [m], speeds [m/s] and forces [N] in place of angles and torques; None for a
    flange that is what it is connected to.
    """

    words: str
    ground: bool = False
    spare: bool = False
    slider: bool | None = False

    def __post_init__(self) -> None:
        if self.slider not in (True, False, None):
            raise ModelError(f"Flange '{self.words}': slider = {self.slider!r} must be True, False or None (both)")


class Unseen(Flange):
    """A flange that the assembly adds to a block: no shaft of the train, and in no list of outputs or start values."""

    __slots__ = ()


@arguments_told
@dataclass(frozen=True, slots=True)
class State(metaclass=Tidy):
    """A state of a block's own. The block yields Rate(s.name, expression), or Hold(s.name, value, when).

    accumulates: it adds up what passes, such as heat; a static equilibrium does not ask it to rest. symbol: that of printed
    equations, as "gamma_1"; else its name.
    """

    words: str
    unit: str = "1"
    start: float = 0.0
    accumulates: bool = False
    symbol: str = ""

    def __post_init__(self) -> None:
        declared(f"State '{self.words}'", self.unit)
        object.__setattr__(self, "start", finite_number(f"State '{self.words}': start", self.start))
