"""How a block says what it is, what it has and what it does.

A block is a class with flanges, parameters, signals, states and effects as class attributes, and a method `physics`
that yields contributions. Instances are frozen and keyword-only. `self` holds numbers, `s` holds symbols.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, TypeAlias, dataclass_transform

from gearblocks.errors import GearblocksError, ModelError, did_you_mean
from gearblocks.language.expression import finite_number, from_sympy, is_sympy


class _Required:
    """Stands for the default that a required field has not; printed alike in every process."""

    def __repr__(self) -> str:
        return "required"


_REQUIRED: Any = _Required()


@dataclass(frozen=True, slots=True)
class Field:
    """The declaration of one field: words, unit, default and bounds.

    role: "param" (a number, runs as a tunable value), "exact" (integers that enter ratios exactly), "option" (part of
    the structure), "signal", "effect". belongs_to: the effect that goes when this field is None ("compliance").
    convert: turns a short form (a Table, say) into the effect that it stands for. over: the quantity of the block
    ("twist") that an expression in the field may contain, and a Table in it is read at.
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

    @property
    def required(self) -> bool:
        """Whether a block cannot be made without it."""
        return self.default is _REQUIRED


def param(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, gt: float | None = None, ge: float | None = None,
    lt: float | None = None, le: float | None = None, many: bool = False, belongs_to: str | None = None,
) -> Any:  # fmt: skip
    """A number in SI units; a `Parameter` may stand for it. Bounds: gt (>), ge (>=), lt (<), le (<=).

    default=None makes it optional: None means absent. many=True: a tuple of numbers.
    """
    return Field(words, unit, "param", default, gt, ge, lt, le, many, belongs_to)


def exact(words: str, unit: str = "1", *, default: Any = _REQUIRED, many: bool = False) -> Any:
    """A number that enters ratios exactly (tooth counts; a float stands for its exact binary fraction). Structural."""
    return Field(words, unit, "exact", default, many=many)


def option(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, many: bool = False, belongs_to: str | None = None
) -> Any:
    """A choice (text, truth, number) that decides the form of the law. Structural. many=True: a tuple of them."""
    return Field(words, unit, "option", default, many=many, belongs_to=belongs_to)


def signal(
    words: str, unit: str = "1", *, default: Any = _REQUIRED, ge: float | None = None, belongs_to: str | None = None,
    over: str | None = None,
) -> Any:  # fmt: skip
    """A number, Parameter, Input, Table over time or expression (see gb.time, gb.sense).

    ge: the least value of a number or Parameter; what varies is not judged. over: a quantity of the block that may stand
    in it too, see Symbols.local; a Table then goes over that quantity.
    """
    return Field(words, unit, "signal", default, ge=ge, belongs_to=belongs_to, over=over)


def effect(words: str, *, default: Any = None, convert: Callable[[Any], Any] | None = None) -> Any:
    """An effect object, or None: absent. convert: turns a short form into the effect it stands for."""
    return Field(words, "1", "effect", default, convert=convert)


@dataclass(frozen=True, slots=True)
class Flange:
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


@dataclass(frozen=True, slots=True)
class State:
    """A state of a block's own. The block yields Rate(s.name, expression), or Hold(s.name, value, when)."""

    words: str
    unit: str = "1"
    start: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", finite_number(f"State '{self.words}': start", self.start))


# -- contributions ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Body:
    """A rotating inertia J [kg m2] at a flange."""

    flange: Any
    J: Any


@dataclass(frozen=True, slots=True)
class Force:
    """A force along a deflection: every flange gets the torque -force * d deflection / d phi.

    Factors of angles in a deflection are taken as they are, floats too; what is left where floats cancel (1e-14 of their
    sizes, as of three cosines 120 degrees apart) counts as 0. Two deflections that differ by less are the same.
    """

    deflection: Any
    force: Any


@dataclass(frozen=True, slots=True)
class Potential:
    """An energy [J] of the flange angles: every flange gets the torque -d energy / d phi."""

    energy: Any


@dataclass(frozen=True, slots=True)
class Acts:
    """The torque tau [N m] that the block exerts ON the flange."""

    flange: Any
    tau: Any


@dataclass(frozen=True, slots=True)
class Tie:
    """A rigid relation that stays zero.

    Linear in the flange angles with exact ratios; or, where it moves with time, with states or not linearly with angles,
    solved for a flange that it contains linearly by itself (phi_b - F(phi_a)). Then it must be smooth twice over.
    """

    zero: Any


@dataclass(frozen=True, slots=True)
class Motion:
    """A prescribed speed: `zero`, linear in the flange speeds with the factors 1 and -1, stays zero. The rest must be
    continuous."""

    zero: Any


@dataclass(frozen=True, slots=True)
class Start:
    """The value of a state of the block at the start, computed from angles, time and parameters there."""

    state: Any
    value: Any


@dataclass(frozen=True, slots=True)
class Rate:
    """The time derivative of a state of the block."""

    state: Any
    expr: Any


@dataclass(frozen=True, slots=True)
class Hold:
    """A state that stays as it is until `when` turns from 0 to 1 at an event; it then takes `value` of that instant.

    when: an expression of conditions that the law has anyway (a contact, say), 0 or 1.
    """

    state: Any
    value: Any
    when: Any


@dataclass(frozen=True, slots=True)
class Switch:
    """A named located switch: mode `high` where surface >= 0, else `low`; watched only while `when` is not zero.

    Conditions written with Piecewise, Abs, sign, Min, Max or Heaviside are located without one; a Switch gives them a
    name and the values shown in the events. The events name the block and the switch, or the block alone when the name
    is empty (a mode of the block as a whole, such as its contact).
    """

    name: str
    surface: Any
    when: Any = 1
    low: float = 0.0
    high: float = 1.0


@dataclass(frozen=True, slots=True)
class Stick:
    """Friction that can stick, or a lock, along a slip: linear in the flange speeds with constant factors.

    A force > 0 drives the slip up: every flange gets the torque force * d slip / d w. While stuck the slip is exactly 0
    and the held force stays in [-limit, limit], or in limit = (lower, upper) (sympy.oo: without limit); while it slides,
    the force against the slip is `sliding` (default: limit; a pair: while slip > 0, while slip < 0), which may contain
    sympy.Abs(slip). engaged <= 0: free. An unlimited lock closes on a speed difference by a plastic impact; `impulse`: a
    state of the block that keeps it [N m s]. Loss, events and modes come by themselves, see Symbols.stick.
    """

    name: str
    slip: Any
    limit: Any
    sliding: Any = None
    engaged: Any = 1
    impulse: Any = None


@dataclass(frozen=True, slots=True)
class Stop:
    """A rigid unilateral contact: the gap, linear in the flange angles with constant factors, stays >= 0.

    It closes by an impact with Newton's restitution (rate after = -restitution * rate before) and stays closed while it
    is pressed. impulse: a state of the block that keeps the last impulse [N m s]; impacts: one that counts them.
    """

    name: str
    gap: Any
    restitution: Any
    impulse: Any = None
    impacts: Any = None


@dataclass(frozen=True, slots=True)
class LossyTie:
    """A rigid tie whose losses depend on the force that it carries, and that sticks at rest.

    tie: the speed that stays 0, linear in the flange speeds; its force is Symbols.stick("tie"). slip: the speed at which
    loss is taken from the shafts; force lost = share * force of the tie + rest, against the slip: (share, rest) =
    `driving` where slip * force >= 0, else `coasting` (both may contain sympy.Abs(slip)). At rest it holds what lies
    between the losses of either direction; Symbols.stick("loss") tells.
    """

    tie: Any
    slip: Any
    driving: Any
    coasting: Any


@dataclass(frozen=True, slots=True)
class Shows:
    """An output of the block."""

    name: str
    expr: Any
    unit: str = "1"
    words: str = ""


@dataclass(frozen=True, slots=True)
class Energy:
    """Entry of the ledger: stored energy [J] and lost power [W]. What neither explains counts as supplied."""

    stored: Any = None
    loss: Any = None


Contribution: TypeAlias = (
    Body
    | Force
    | Potential
    | Acts
    | Tie
    | Motion
    | Rate
    | Start
    | Hold
    | Switch
    | Stick
    | Stop
    | LossyTie
    | Shows
    | Energy
)


@dataclass(frozen=True)
class Parts:
    """What a composite block stands for: blocks by name, links between (name, flange) pairs, and its own flanges."""

    blocks: Mapping[str, Any]
    links: tuple[tuple[tuple[str, str], tuple[str, str]], ...]
    flanges: Mapping[str, tuple[str, str]]


# -- fields of blocks and effects -------------------------------------------------------------------------------------


_TAKEN = {
    "changed", "effects", "energy_of", "fields", "flanges", "is_constant", "local", "named", "parts", "physics",
    "problems", "rate_of", "reading", "slope", "states", "stick", "tabled", "time", "turned", "without_effect",
}  # fmt: skip
"""Names that blocks, effects and their symbols use themselves."""


class _Declared:
    """Frozen keyword-only object whose class attributes declare its fields."""

    fields: ClassVar[Mapping[str, Field]] = MappingProxyType({})
    flanges: ClassVar[Mapping[str, Flange]] = MappingProxyType({})
    states: ClassVar[Mapping[str, State]] = MappingProxyType({})

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        members = {name: value for name, value in vars(cls).items() if not name.startswith("__")}
        for name, value in members.items():
            if value in (Flange, State, param, signal, effect, exact, option):
                raise ModelError(
                    f"{cls.__name__}.{name}: write gb.{value.__name__}(...) with its words, not the bare name"
                )
            if isinstance(value, (Field, Flange, State)) and name in _TAKEN:
                raise ModelError(
                    f"{cls.__name__}: a field, flange or state cannot be named '{name}'; take another name"
                )
        for name, kind in (("fields", Field), ("flanges", Flange), ("states", State)):
            own = {n: v for n, v in members.items() if isinstance(v, kind)}
            setattr(cls, name, MappingProxyType({**getattr(cls, name), **own}))

    def __init__(self, *unnamed: Any, **values: Any) -> None:
        fields, kind, store = type(self).fields, type(self).__name__, self.__dict__
        if unnamed:
            example = f"such as {kind}({next(iter(fields))}=...)" if fields else "and there are none"
            raise ModelError(f"{kind}: {unnamed[0]!r} is given without a name; fields are given by name, {example}")
        problems = [
            f"{kind} has no field '{name}'; it has {', '.join(fields) or 'none'}{did_you_mean(name, fields)}"
            for name in values if name not in fields
        ]  # fmt: skip
        for name, spec in fields.items():
            try:
                if name in values:
                    value = _plain(values[name], spec.many)
                    store[name] = value if spec.convert is None else spec.convert(value)
                elif spec.required:
                    unit = "" if spec.unit == "1" else f", {spec.unit}"
                    problems.append(f"{kind} needs {name} ({spec.words}{unit}); it was not given")
                else:
                    store[name] = spec.default
            except GearblocksError as error:
                problems.append(f"{kind}: {name}: {error}")
        if problems:
            raise ModelError(problems)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(
            f"{type(self).__name__} is frozen: make a changed train with rig.set({{'path.{name}': value}})"
        )

    def __repr__(self) -> str:
        given = (f"{n}={self.__dict__[n]!r}" for n in type(self).fields if self.__dict__[n] is not None)
        return f"{type(self).__name__}({', '.join(given)})"

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash((type(self), tuple(self.__dict__.items())))

    def changed(self, **values: Any) -> Any:
        """A copy with other values."""
        return type(self)(**{**self.__dict__, **values})

    def problems(self) -> Iterator[str]:
        """What is wrong with the combination of values, each as one sentence without the block's name."""
        return iter(())


def _plain(value: Any, many: bool) -> Any:
    """A given value as it is kept: tuples for lists and arrays, Python numbers, light expressions for sympy ones."""
    if many and not isinstance(value, (str, bytes)) and hasattr(value, "__iter__") and not is_sympy(value):
        return tuple(_plain(v, False) for v in value)
    if is_sympy(value):
        expression = from_sympy(value)
        return expression.args[0] if expression.op in ("number", "parameter", "input") else expression
    if type(value).__module__ == "numpy" and getattr(value, "shape", None) == ():
        return value.item()
    return value


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(param, exact, option, signal, effect))
class Effect(_Declared, ABC):
    """A modelled phenomenon that a block has or has not. Subclasses declare fields like blocks do."""


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(param, exact, option, signal, effect))
class Block(_Declared, ABC):
    """A part of a drivetrain. Subclasses declare flanges, fields and states, and yield their physics.

        class DCMotor(gb.Block):
            shaft = gb.Flange("output shaft")
            R: float = gb.param("resistance", "ohm", gt=0)
            L: float = gb.param("inductance", "H", gt=0)
            k: float = gb.param("torque constant", "N m/A")
            u = gb.signal("terminal voltage", "V")
            i = gb.State("current", "A")

            def physics(self, s):
                yield gb.Acts(s.shaft, s.k * s.i)
                yield gb.Rate(s.i, (s.u - s.R * s.i - s.k * s.shaft.w) / s.L)
                yield gb.Shows("torque", s.k * s.i, "N m")
                yield gb.Energy(stored=s.L * s.i**2 / 2, loss=s.R * s.i**2)

    In `physics`, s.<flange>.phi and .w are angle [rad] and speed [rad/s], s.<field> the symbol of a number or signal
    (None when absent), s.<effect> the symbols of an effect, s.<state> a state, s.time the time. In Shows also
    s.<flange>.alpha [rad/s2] and s.<flange>.tau [N m], the torque that the block exerts on the flange. On a slider
    s.<flange>.s, .v and .f are other names of phi, w and tau (in m, m/s and N).
    s.<flange>.mobility is 1/J of all inertia tied rigidly to the flange (0 at the ground).
    """

    @abstractmethod
    def physics(self, s: Any) -> Iterator[Contribution]:
        """Yields contributions: what it does to its flanges and shows, see Contribution."""

    def parts(self) -> Parts | None:
        """The blocks that this one stands for, or None: it has physics of its own."""
        return None

    def effects(self) -> dict[str, Any]:
        """The effects that are present, by name."""
        present: dict[str, Any] = {}
        for name, spec in type(self).fields.items():
            key = name if spec.role == "effect" else spec.belongs_to
            if key and self.__dict__[name] is not None and self.__dict__[name] != spec.default:
                present.setdefault(key, self.__dict__[name])
        return present

    def without_effect(self, name: str) -> Block:
        """The same block with one effect taken away; without compliance nothing that lives on it stays."""
        fields = type(self).fields
        gone = set(self.effects()) if name == "compliance" else {name}
        owners = {n: n if spec.role == "effect" else spec.belongs_to for n, spec in fields.items()}
        dropped: dict[str, Any] = {
            n: fields[n].default if fields[n].role == "option" else None for n, owner in owners.items() if owner in gone
        }
        if name == "compliance" and "rigid" in fields:
            dropped["rigid"] = True
        changed = self.changed(**dropped)
        assert isinstance(changed, Block)
        return changed
