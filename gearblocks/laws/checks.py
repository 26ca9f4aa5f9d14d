"""Checks of contributions that a user's block yields, before a law is derived: one for each kind, and one of all together.

Every problem is one sentence with its way out. Knows nothing of derivation, nor of the values of the block.
"""

from __future__ import annotations

import re
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from gearblocks.errors import GearblocksError, ModelError, ParameterError, did_you_mean
from gearblocks.language.block import Block
from gearblocks.language.contributions import (
    Acts,
    Body,
    Energy,
    Force,
    Hold,
    LossyTie,
    Motion,
    Potential,
    Rate,
    Shows,
    Start,
    Stick,
    Stop,
    Switch,
    Tie,
)
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Flange
from gearblocks.language.units import declared
from gearblocks.laws.symbols import CONSTANT, FlangeSymbols, Pool, Symbols

_WORD = re.compile(r"[A-Za-z_]\w*")


def physics_problems(path: str, block: Block, grounded: frozenset[str]) -> list[str]:
    """Everything that is wrong with what the physics of a block yields, each as one sentence."""
    name = f"{type(block).__name__} '{path}'"
    pool = Pool()
    s = Symbols(block, pool, grounded)
    try:
        found = type(block).physics(_guarded(block), s)
        items = list(found) if isinstance(found, Iterable) else None
    except GearblocksError as error:
        return [f"{name}: {error}"]
    except Exception as error:  # noqa: BLE001  a user's code may raise anything; the message names it
        return [f"{name}: physics {_raised(error, block, s)}"]
    if items is None:
        return [f"{name}: physics gives {found!r:.80}; let it yield contributions, such as gb.Acts(s.flange, torque)"]
    check = _Check(block, s, pool)
    return [f"{name}: {problem}" for problem in (*(p for x in items for p in check.item(x)), *check.whole(items))]


class _Number:
    """Stands for a number of `self` while physics is checked: present, but good for nothing else.

    A number of `self` would be baked into the law, which all blocks of a kind share.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def refuse(self, *_: Any) -> Any:
        """Any use but the question whether it is None."""
        raise ModelError(f"physics uses the number self.{self.name}: write s.{self.name} (ask self only 'is None')")

    __hash__ = None  # type: ignore[assignment]
    for _operation in [
        "add",
        "radd",
        "sub",
        "rsub",
        "mul",
        "rmul",
        "truediv",
        "rtruediv",
        "pow",
        "rpow",
        "neg",
        "abs",
        "lt",
        "le",
        "gt",
        "ge",
        "eq",
        "ne",
        "bool",
        "float",
        "int",
        "mod",
        "rmod",
    ]:
        locals()[f"__{_operation}__"] = refuse
    _sympy_ = refuse


def _guarded(block: Block) -> Any:
    """The block with its numbers out of reach."""
    copy = object.__new__(type(block))
    for name, field in type(block).fields.items():
        value = block.__dict__[name]
        if field.role in ("param", "exact", "signal"):
            if isinstance(value, tuple):
                value = tuple(_Number(f"{name}[{i}]") for i in range(len(value)))
            elif value is not None and not isinstance(value, str):
                value = _Number(name)
        copy.__dict__[name] = value
    return copy


_DECIDED = "gb.piecewise, gb.minimum and gb.maximum"
_FUNCTIONS = "gb.sin, gb.exp and their like; a table is a field, read as s.local('field', x=quantity)"
"""What stands in physics in place of decisions and of functions of numbers."""


def _raised(error: Exception, block: Block, s: Symbols) -> str:
    """Words for an exception of a user's code."""
    frames = traceback.extract_tb(error.__traceback__)
    file = getattr(getattr(type(block).physics, "__code__", None), "co_filename", "")
    line = next((f.lineno for f in reversed(frames) if f.filename == file), frames[-1].lineno)
    if isinstance(error, TypeError) and getattr(getattr(type(block).physics, "__code__", None), "co_argcount", 2) != 2:
        return "must take self and s, the symbols: write `def physics(self, s)`"
    if isinstance(error, AttributeError) and isinstance(error.obj, (Symbols, FlangeSymbols)):
        of_flange = isinstance(error.obj, FlangeSymbols)
        known = (
            ["phi", "w", "alpha", "tau", "mobility", "s", "v", "f"]
            if of_flange
            else [n for n in vars(s) if not n.startswith("_")]
        )
        near = did_you_mean(str(error.name), known)
        return f"asks {'a flange' if of_flange else 's'} for '{error.name}'; it has {', '.join(known)}{near}"
    if isinstance(error, TypeError) and "truth value" in str(error):
        found = str(error).rpartition(": ")[2]
        return f"decides by '{found}' (line {line}), which changes along a run: in place of if, min and max take {_DECIDED}"
    if isinstance(error, TypeError) and ("ufunc" in str(error) or "expression to float" in str(error)):
        return f"gives a symbol to a function of numbers (line {line}: {error}); take {_FUNCTIONS}"
    return f"raises {type(error).__name__}: {error} (line {line}; an optional field that is not given is None)"


class _Check:
    """The contributions of one block against what it declares."""

    def __init__(self, block: Block, s: Symbols, pool: Pool) -> None:
        self.block, self.pool = block, pool
        self.flanges = {name: getattr(s, name) for name in type(block).flanges}
        self.states = {name: getattr(s, name) for name in type(block).states}

    def item(self, item: Any) -> Iterator[str]:
        """Problems of one contribution by itself."""
        kind = type(item)
        if kind not in KINDS:
            yield f"physics yields {item!r:.80}, which is no contribution such as gb.Acts(...)"
            return
        known = KINDS[kind]
        showing, optional = kind is Shows, kind is Energy
        problems = [p for f in known.expressions if (p := self.expression(getattr(item, f), showing, optional))]
        if known.check is not None:
            problems += [p for p in known.check(self, item, not problems) if p]
        yield from (f"{kind.__name__}: {problem}" for problem in problems)

    def whole(self, items: list[Any]) -> Iterator[str]:
        """Problems of all contributions together."""
        for name, state in self.states.items():
            rates = sum(any(getattr(x, a) is state for a in KINDS[type(x)].rates) for x in items if type(x) in KINDS)
            if rates != 1:
                yield f"the state '{name}' has {rates} rates; yield one gb.Rate(s.{name}, ...)"
        if any(isinstance(x, Body) and not self.flange(x.flange) and x.flange.phi.is_Symbol for x in items):
            yield from self.start_values(items)
        shown = [x.name for x in items if isinstance(x, Shows)]
        yield from (f"the output '{name}' is shown twice" for name in dict.fromkeys(shown) if shown.count(name) > 1)

    def start_values(self, items: list[Any]) -> Iterator[str]:
        """Start values of a body that the law reads: they are no numbers of a run."""
        for symbol in sorted(self.read(items), key=str):
            meaning = self.pool.roles.get(symbol)
            if meaning is not None and meaning.role == "own" and meaning.of in self.pool.starts:
                yield f"the physics reads the start value '{meaning.of}': declare a parameter of its own for what the law needs"

    def read(self, items: list[Any]) -> set[Any]:
        """Symbols in the expressions of contributions."""
        exprs = [getattr(x, name) for x in items for name in KINDS.get(type(x), _Kind(())).expressions]
        return {x for e in exprs if isinstance(e, sp.Expr) for x in e.free_symbols}

    # -- one check for each kind of contribution; `sound`: its expressions are in order --------------------------------

    def body(self, item: Body, sound: bool) -> Iterator[str]:
        """An inertia at a flange: constant and not negative."""
        yield self.flange(item.flange)
        if sound:
            inertia = sp.sympify(item.J)
            if self.pool.level(inertia) != CONSTANT:
                yield f"J = '{inertia}' changes during a run; give an expression of parameters"
            elif inertia.is_negative:
                yield f"J = {inertia} kg m2 must be >= 0"

    def acts(self, item: Acts, _sound: bool) -> Iterator[str]:
        """A torque on a flange."""
        yield self.flange(item.flange)

    def force(self, item: Force, sound: bool) -> Iterator[str]:
        """A force along a deflection of angles."""
        if sound:
            yield self.angles(item.deflection)

    def potential(self, item: Potential, sound: bool) -> Iterator[str]:
        """An energy of angles."""
        if sound:
            yield self.angles(item.energy)

    def relation(self, item: Tie | Motion, sound: bool) -> Iterator[str]:
        """A relation of flange angles, or of flange speeds alone."""
        if sound:
            yield self.tie(item)
        for rate in getattr(item, "rates", None) or ():
            yield self.expression(rate, False, False)

    def of_state(self, item: Rate | Start | Hold, _sound: bool) -> Iterator[str]:
        """Something about a state of the block or of its effects."""
        if not any(item.state is x for x in (*self.states.values(), *self.inner())):
            has = ", ".join(f"s.{name}" for name in self.states) or "none: declare one with gb.State('words', 'unit')"
            yield f"'{item.state}' is no state of the block; it has {has}"

    def switched(self, item: Stick | Stop, sound: bool) -> Iterator[str]:
        """A switched constraint along a slip or gap."""
        yield from self.stick(item, sound)
        yield from self.named(item, sound)

    def lossy(self, item: LossyTie, sound: bool) -> Iterator[str]:
        """A rigid constraint with losses: parts of its force and constant losses, and two slips."""
        yield from (p for x in (*item.driving, *item.coasting) if (p := self.expression(x, False, False)))
        for slip in (item.tie, item.slip) if sound else ():
            yield from self.stick(Stick("", slip, 0), True)

    def named(self, item: Stick | Stop | Switch | Shows, _sound: bool) -> Iterator[str]:
        """The name of something that events or outputs show."""
        if not isinstance(item.name, str):
            yield f"its name {item.name!r} must be text"

    def shows(self, item: Shows, sound: bool) -> Iterator[str]:
        """The name and unit of an output."""
        yield from self.named(item, sound)
        if isinstance(item.name, str) and not _WORD.fullmatch(item.name):
            yield f"the name '{item.name}' must be a word of letters, digits and '_'"
        try:
            declared(f"output '{item.name}'", item.unit)
        except ParameterError as error:
            yield str(error)

    # -- what they share ------------------------------------------------------------------------------------------------

    def inner(self) -> Iterator[Any]:
        """States of the effects."""
        return (x for x, meaning in self.pool.roles.items() if meaning.role == "state")

    def stick(self, item: Stick | Stop, sound: bool) -> Iterator[str]:
        """Whether a slip or gap is linear in flange speeds or angles, and what else belongs to it."""
        if isinstance(item, Stick):
            sizes = [x for x in (*in_pair(item.limit), *in_pair(item.sliding)) if x not in (None, sp.oo, -sp.oo)]
            problems = [p for x in sizes if (p := self.expression(x, False, False))]
            yield from problems
        for name in ("impulse", "impacts"):
            state = getattr(item, name, None)
            if state is not None and not any(state is x for x in self.states.values()):
                yield f"{name} = '{state}' is no state of the block; declare one with gb.State('words', 'unit')"
        if not sound:
            return
        expr, role = (item.slip, "w") if isinstance(item, Stick) else (item.gap, "phi")
        moving = {x for x in sp.sympify(expr).free_symbols if self.pool.roles[x].role == role}
        slopes = [sp.diff(expr, x) for x in moving]
        rest = sp.sympify(expr).xreplace(dict.fromkeys(moving, sp.Integer(0)))
        grounded = any(not f.phi.is_Symbol for f in self.flanges.values())
        if any(self.pool.level(x) != CONSTANT for x in slopes) or (not moving and not grounded):
            yield f"'{expr}' must be linear in the flange {'speeds' if role == 'w' else 'angles'} with constant factors"
        elif (rest != 0) if role == "w" else self.pool.level(rest) != CONSTANT:
            yield f"'{expr}' contains '{rest}', which is not {'a speed of a flange' if role == 'w' else 'constant'}"

    def flange(self, flange: Any) -> str:
        """Whether something is a flange of s."""
        if any(flange is own for own in self.flanges.values()):
            return ""
        names = ", ".join(f"s.{name}" for name in self.flanges) or "none"
        return f"{_shown(flange)} is no flange of s; there are {names}"

    def angles(self, expr: Any) -> str:
        """Whether an expression moves with the flange angles alone."""
        roles = {self.pool.roles[x].role for x in sp.sympify(expr).free_symbols}
        if roles & {"w", "state"}:
            return f"'{expr}' must be of angles (s.flange.phi), not of speeds or states"
        grounded = any(not f.phi.is_Symbol for f in self.flanges.values())
        return "" if "phi" in roles or grounded else f"'{expr}' contains no angle of a flange (s.flange.phi)"

    def tie(self, item: Tie | Motion) -> str:
        """Whether a tie speaks of the flanges: of their angles, or of their speeds alone."""
        wanted, other = ("phi", "w") if isinstance(item, Tie) else ("w", "phi")
        roles = {self.pool.roles[x].role for x in sp.sympify(item.zero).free_symbols}
        grounded = any(not f.phi.is_Symbol for f in self.flanges.values())
        if other in roles:
            return f"'{item.zero}' must be of s.flange.{wanted}, not of s.flange.{other}"
        return "" if wanted in roles or grounded else f"'{item.zero}' contains no s.flange.{wanted}"

    def expression(self, x: Any, showing: bool, optional: bool) -> str:
        """Whether x can stand in a law."""
        if optional and x is None:
            return ""
        if isinstance(x, _Number):
            return f"the number self.{x.name} stands in it: write s.{x.name}"
        if isinstance(x, Expr) or hasattr(x, "_expr_"):
            return f"{x!r} is a signal from outside: use s.time, or declare a field with gb.signal(...)"
        if isinstance(x, (bool, str)) or x is None or not isinstance(x, (int, float, sp.Basic)):
            return f"{_shown(x)} is no expression of the symbols in s"
        expr = sp.sympify(x)
        if not isinstance(expr, sp.Expr):
            return (
                f"'{expr}' is a condition, not a value: put it into sympy.Piecewise((value, condition), (other, True))"
            )
        if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I):
            return f"'{expr}' is not finite and real"
        if unknown := expr.atoms(AppliedUndef, sp.Derivative, sp.Integral):
            return f"'{expr}' contains '{next(iter(unknown))}', which has no value here"
        for symbol in sorted(expr.free_symbols, key=str):
            meaning = self.pool.roles.get(symbol)
            if meaning is None:
                return (
                    f"the symbol '{symbol}' in '{expr}' is not from s; declare it with gb.param, gb.signal or gb.State"
                )
            if meaning.role in ("alpha", "tau", "constraint_force") and not showing:
                return f"'{symbol}' in '{expr}' is a result of the motion, which only Shows can read"
        return ""


@dataclass(frozen=True, slots=True)
class _Kind:
    """Check of one kind of contribution: its expressions, a check of the rest, and the states that it gives rates to."""

    expressions: tuple[str, ...]
    check: Callable[[_Check, Any, bool], Iterator[str]] | None = None
    rates: tuple[str, ...] = ()


KINDS: dict[type, _Kind] = {
    Body: _Kind(("J",), _Check.body),
    Force: _Kind(("deflection", "force"), _Check.force),
    Potential: _Kind(("energy",), _Check.potential),
    Acts: _Kind(("tau",), _Check.acts),
    Tie: _Kind(("zero",), _Check.relation),
    Motion: _Kind(("zero",), _Check.relation),
    Rate: _Kind(("expr",), _Check.of_state, ("state",)),
    Start: _Kind(("value",), _Check.of_state),
    Hold: _Kind(("value", "when"), _Check.of_state, ("state",)),
    Switch: _Kind(("surface", "when"), _Check.named),
    Stick: _Kind(("slip", "engaged"), _Check.switched, ("impulse",)),
    Stop: _Kind(("gap", "restitution"), _Check.switched, ("impulse", "impacts")),
    LossyTie: _Kind(("tie", "slip"), _Check.lossy),
    Shows: _Kind(("expr",), _Check.shows),
    Energy: _Kind(("stored", "loss")),
}


def in_pair(x: Any) -> tuple[Any, Any]:
    """A pair, or the same thing twice."""
    return x if isinstance(x, tuple) else (x, x)


def _shown(x: Any) -> str:
    if isinstance(x, Flange):
        return "a flange of self (write s.<flange>)"
    return "a flange of s" if isinstance(x, FlangeSymbols) else f"{x!r:.80}"
