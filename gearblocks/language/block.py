"""Blocks and effects: classes whose attributes declare flanges, fields and states, and whose `physics` yields contributions.

Instances are frozen and keyword-only. `self` holds numbers, `s` holds symbols. Knows nothing of laws, nor of trains.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from types import CodeType, FunctionType, MappingProxyType
from typing import Any, ClassVar, Self, dataclass_transform

from gearblocks.errors import GearblocksError, ModelError, did_you_mean
from gearblocks.language.contributions import Contribution, Parts
from gearblocks.language.expression import Expr, from_sympy, is_sympy
from gearblocks.language.fields import (
    ANGLE,
    COMPLIANCE,
    SPEED,
    Field,
    Flange,
    State,
    effect,
    exact,
    option,
    param,
    same_value,
    signal,
)
from gearblocks.language.reference import Documented
from gearblocks.language.units import given, has_unit, is_quantity, unit_along
from gearblocks.language.watches import Excitation, Watch, beyond, excitations_by_time

_TAKEN = {
    "brings", "changed", "effects", "energy_of", "excitations", "fields", "flanges", "gives_way", "is_constant",
    "local", "named", "needed_by", "number_problems", "parts", "physics", "problems", "rate_of", "ratio_varies",
    "reading", "slope", "states", "stick", "tabled", "time", "turned", "undeformed", "without_effect", "would_show",
    "beyond_tables",
}  # fmt: skip
"""Names that blocks, effects and their symbols use themselves."""


class Declared(metaclass=Documented):
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
        starts = [f"{name} ({spec.start})" for name, spec in cls.fields.items() if spec.start is not None]
        if len(starts) > len(start_fields(cls)):
            raise ModelError(f"{cls.__name__}: {', '.join(starts)}: declare one start value of each kind")

    def __new__(cls, *_: Any, **__: Any) -> Self:
        if cls.__abstractmethods__:
            raise ModelError(
                f"{cls.__name__} has no {', '.join(cls.__abstractmethods__)}: write in it `def physics(self, s)`, which "
                "yields what it does to its flanges, such as gb.Acts(s.shaft, ...); help(gb.Block) shows one"
            )
        return object.__new__(cls)

    def __init__(self, *unnamed: Any, **values: Any) -> None:
        fields, kind, store = type(self).fields, type(self).__name__, self.__dict__
        if unnamed:
            example = f"such as {kind}({next(iter(fields))}=...)" if fields else "and there are none"
            raise ModelError(f"{kind}: {unnamed[0]!r} is given without a name; fields are given by name, {example}")
        problems = [
            f"{kind} has no field '{name}'; it has {', '.join(fields) or 'none'}{did_you_mean(name, fields)}"
            for name in values if name not in fields
        ]  # fmt: skip
        store.update(_defaults(type(self)))
        for name, spec in _needed(type(self)):
            if name not in values and (spec.required or not any(n in values for n in spec.or_one_of)):
                unit = "" if spec.unit == "1" else f", {spec.unit}"
                beside = f", or {' or '.join(spec.or_one_of)}" if spec.or_one_of else ""
                problems.append(f"{kind} needs {name} ({spec.words}{unit}){beside}; it was not given")
        for name, value in values.items():
            try:
                if name in fields:
                    store[name] = _kept(value, fields[name])
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
        return type(self) is type(other) and same_value(field_values(self), field_values(other))

    def __hash__(self) -> int:
        try:
            return hash((type(self), *field_values(self).values()))
        except TypeError:  # an array, say
            return hash(type(self))

    def changed(self, **values: Any) -> Any:
        """A copy with other values."""
        return type(self)(**field_values(self) | values)

    def problems(self) -> Iterator[str]:
        """Problems of the combination of values, each as one sentence without the block's name; asked when the block joins a
        train."""
        return iter(())

    def number_problems(self) -> Iterator[str]:
        """Those that other numbers may make: asked with the numbers that its Parameters stand for, and with those that a run
        or a study gives. All of `problems()`, where a block does not say what of it goes without numbers."""
        return self.problems()


def field_values(owner: Any) -> dict[str, Any]:
    """The values of the fields of an object by name. What it keeps for itself (functools.cached_property) is none of them."""
    return {name: owner.__dict__[name] for name in type(owner).fields}


_BARE = frozenset((float, int, bool, type(None)))


@cache
def _defaults(kind: type[Declared]) -> Mapping[str, Any]:
    """Defaults of all fields, in their order."""
    return MappingProxyType({name: spec.default for name, spec in kind.fields.items()})


@cache
def _needed(kind: type[Declared]) -> tuple[tuple[str, Field], ...]:
    """The fields that must be given, by themselves or as one of several."""
    return tuple((name, spec) for name, spec in kind.fields.items() if spec.required or spec.or_one_of)


def _kept(value: Any, spec: Field) -> Any:
    """A given value as the block keeps it."""
    if type(value) not in _BARE:
        value = _plain(value, spec.many)
        if spec.part and isinstance(value, str) and not is_quantity(value):
            value = Expr("sense", f"{value}.{spec.part}")
        if spec.role == "exact":
            value = _exact(value)
        if type(value) not in _BARE and (spec.role in ("param", "signal") or spec.unit != "1"):
            value = _in_si(value, spec)
    return value if spec.convert is None else spec.convert(value)


def _in_si(value: Any, spec: Field) -> Any:
    """A value of a field that brings its unit, as a number in SI; any other as it is."""
    if isinstance(value, tuple):
        return tuple(_in_si(v, spec.entry(i)) for i, v in enumerate(value))
    if not has_unit(value) or (isinstance(value, str) and not is_quantity(value)):
        return value
    return given(value, spec.unit, "rad" if spec.of_deflection else unit_along(spec.unit, True))


def _exact(value: Any) -> Any:
    """A ratio or tooth count that is written as text, as the number that it is: "3.5", "41/23", "23"; any other as it is."""
    if isinstance(value, tuple):
        return tuple(map(_exact, value))
    try:
        number = Fraction(value) if isinstance(value, str) else None
    except (ValueError, ZeroDivisionError):
        number = None
    if number is None:
        return value
    return number.numerator if number.denominator == 1 else number if "/" in value else float(value)


_CALLED_STARTS = {"phi0": ANGLE, "s0": ANGLE, "w0": SPEED, "v0": SPEED}
"""What the catalogue calls start values."""


def _declare_called_starts(cls: type[Block]) -> None:
    """A parameter that is called as the catalogue calls start values, and that no code of its block mentions, is one.

    Blocks were written so before start values had a role; what the block reads is a parameter like any other.
    """
    own = {
        n: v for n in _CALLED_STARTS if isinstance(v := vars(cls).get(n), Field) and v.role == "param" and not v.many
    }
    taken = {v.start for v in (*vars(cls).values(), *cls.fields.values()) if isinstance(v, Field)}
    functions = [getattr(f, "__func__", getattr(f, "fget", f)) for f in vars(cls).values()]
    mentioned = {name for f in functions if isinstance(f, FunctionType) for name in _mentioned_by(f, set())}
    for name in own.keys() - mentioned:
        if _CALLED_STARTS[name] not in taken:
            setattr(cls, name, replace(own[name], start=_CALLED_STARTS[name]))


def _mentioned_by(function: FunctionType, seen: set[int]) -> Iterator[str]:
    """Names and texts in the code of a function and of the functions beside it that it names."""
    seen.add(id(function))
    names = set(_mentioned(function.__code__))
    yield from names
    for name in names:
        other = function.__globals__.get(name)
        if isinstance(other, FunctionType) and id(other) not in seen:
            yield from _mentioned_by(other, seen)


def _mentioned(code: CodeType) -> Iterator[str]:
    """Names and texts in the code of a function and of those inside it."""
    yield from code.co_names
    for x in code.co_consts:
        if isinstance(x, CodeType):
            yield from _mentioned(x)
        elif isinstance(x, str):
            yield x


@cache
def _over_slip(kind: type[Declared]) -> tuple[str, ...]:
    """Names of the fields that may go over the slip."""
    return tuple(name for name, spec in kind.fields.items() if spec.over == "slip")


@cache
def start_fields(kind: type[Declared]) -> Mapping[str, str]:
    """Names of the fields that are start values, by what they are of: "angle" and "speed", where they are declared."""
    return MappingProxyType({spec.start: name for name, spec in kind.fields.items() if spec.start is not None})


@cache
def places_of(kind: type[Declared], sort: type[Flange]) -> tuple[int, ...]:
    """Numbers of the flanges of a kind that are of a sort."""
    return tuple(i for i, flange in enumerate(kind.flanges.values()) if isinstance(flange, sort))


def given_start(block: Declared, of: str) -> Any:
    """The start angle or speed that a block gives (a number, Parameter or expression), or None."""
    name = start_fields(type(block)).get(of)
    return None if name is None else block.__dict__[name]


def declared_state(owner: Declared, path: str) -> State:
    """The declaration of a state of a block or of its effects, by its path inside the block."""
    *inner, name = path.split(".")
    for part in inner:
        owner = owner.__dict__[part]
    return type(owner).states[name]


def _plain(value: Any, many: bool) -> Any:
    """A given value as it is kept: tuples for lists and arrays, Python numbers, light expressions for sympy ones."""
    if many and not isinstance(value, (str, bytes)) and hasattr(value, "__iter__") and not is_sympy(value):
        return tuple(_plain(v, True) for v in value)  # rows of rows too
    if is_sympy(value):
        expression = from_sympy(value)
        return expression.args[0] if expression.op in ("number", "parameter", "input") else expression
    if type(value).__module__ == "numpy" and getattr(value, "shape", None) == ():
        return value.item()
    return value


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(param, exact, option, signal, effect))
class Effect(Declared, ABC):
    """A modelled phenomenon that a block has or has not. Subclasses declare fields like blocks do."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if starts := start_fields(cls):
            raise ModelError(
                f"{cls.__name__}.{next(iter(starts.values()))}: an effect has no start values; its block has"
            )

    def needed_by(self, block: Block) -> bool:  # noqa: ARG002  few are
        """Whether a law of the block reads it, so that it cannot be left out."""
        return False


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(param, exact, option, signal, effect))
class Block(Declared, ABC):
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
    A parameter declared with start="angle" or "speed" is a start value of the shaft that the block has a Body at; so is one
    called phi0, w0, s0 or v0, as in the catalogue, that nothing in the block reads.
    Functions and decisions are gb.sin, gb.exp, gb.piecewise, gb.maximum and their like, or sympy's; a Table over quantities
    of the block is a field, map = gb.option("torque over speed"), read as s.local("map", speed=s.shaft.w).
    s.<flange>.mobility is 1/J of all inertia tied rigidly to the flange (0 at the ground).
    """

    def __init_subclass__(cls) -> None:
        _declare_called_starts(cls)
        super().__init_subclass__()

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
            value = self.__dict__[name]
            needed = isinstance(value, Effect) and value.needed_by(self)
            absent = value is None or (spec.role != "effect" and same_value(value, spec.default))
            if key and not absent and not needed:
                present.setdefault(key, value)
        return present

    def without_effect(self, name: str) -> Block:
        """The block without one effect; without compliance, without all effects that rest on it."""
        fields = type(self).fields
        gone = set(self.effects()) if name == COMPLIANCE else {name}
        owners = {n: n if spec.role == "effect" else spec.belongs_to for n, spec in fields.items()}
        dropped: dict[str, Any] = {
            n: None if fields[n].role != "option" or fields[n].required else fields[n].default
            for n, owner in owners.items()
            if owner in gone
        }
        dropped |= {n: True for n, spec in fields.items() if spec.absence_of == name}
        changed = self.changed(**dropped)
        assert isinstance(changed, Block)
        return changed

    def gives_way(self, flange: str) -> tuple[str, float] | None:
        """The effect that lets a flange turn against the others, and its stiffness about that flange [N m/rad] as far as it
        is a number, else 0. None where it gives no way."""
        return (COMPLIANCE, 0.0) if COMPLIANCE in self.effects() and not type(self).flanges[flange].ground else None

    def undeformed(self) -> Mapping[str, str]:
        """Of a compliant element the fields that say at which deflection it carries nothing: "rest" names where that is (else
        0), "lower" and "upper" the ends of the range about it, as far as it has one."""
        return {}

    def ratio_varies(self) -> bool:
        """Whether, of a compliant element, the ratio at which nothing deforms follows from the angles."""
        return False

    def would_show(self, effect: str) -> Iterator[Watch]:  # noqa: ARG002  most effects act always
        """What shows, on the block without this effect, that it would act; nothing for one that always acts."""
        return iter(())

    def beyond_tables(self) -> Iterator[tuple[str, Watch]]:
        """Fields with tables that are held beyond their last point, and what shows that a run went there: here those over its
        slip, whose output is w_rel, and those of its parts."""
        kind = type(self)
        if kind.parts is Block.parts and not _over_slip(kind):
            return
        for name in _over_slip(kind):
            value = self.__dict__[name]
            leaves = value.leaves() if isinstance(value, Expr) else ()
            held = [leaf.args[0] for leaf in leaves if leaf.op == "table" and leaf.args[1].op == "local"]
            bare = () if name == "capacity" else (value,)  # a capacity that is a bare Table goes over time
            for table in (*bare, *held):
                yield from ((name, watch) for watch in beyond(table, "w_rel"))
        parts = self.parts()
        for part, block in parts.blocks.items() if parts is not None else ():
            for name, watch in block.beyond_tables():
                yield f"{part}.{name}", watch.of_part(part)

    def excitations(self) -> Iterator[Excitation]:
        """What excites the train: here the waves over time in its signals."""
        return excitations_by_time(self.__dict__[n] for n, spec in type(self).fields.items() if spec.role == "signal")
