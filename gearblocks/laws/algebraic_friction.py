"""Friction, locks and lossy gears at shafts without inertia, as laws of algebraic forces.

A slip of such a shaft has no inertia to be decelerated: the force q against the slip is found with the speeds, from the
balance of torques, and the law is the normal map of Coulomb's inclusion q in [-B, F] sign(slip):

    q = min(max(q + r slip, -B), F)        F, B: force bounds against forward and backward slip;  r = 1 N m s/rad

so that stuck means slip = 0 and sliding q = F (or -B), with one event function (q + r slip - F) on both sides of a change.
q is the speed of a flange that is no shaft (`ForceUnknown`), whose balance this equation is; r is no damping, as r slip is 0
wherever it acts. Knows nothing of trains: which slips have no inertia the assembly says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import sympy as sp

from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Contribution, Energy, LossyTie, Rate, Stick, Switch, Tie
from gearblocks.language.fields import Unseen
from gearblocks.language.signals import Table
from gearblocks.laws.checks import in_pair
from gearblocks.laws.functions import TableAt
from gearblocks.laws.law import Law
from gearblocks.laws.switched_constraints import along_slip, row_of
from gearblocks.laws.symbols import SymbolRole

_LEAST = sp.Float(1e-300)
"""Above this it is engaged: what falls to 0 exactly has crossed it."""

_TRACE = sp.Float(1e-200)
"""Damping of what is free [N m s/rad]: a shaft that nothing else holds, as in its gap, moves along."""


_BEYOND = sp.Float(1 + 2.0**-20, 17)
"""How far what leaves has to be below -tau1, in parts of it, until b drives. Where nothing enters, as from a gap, it is
-tau1 but for rounding for as long as that is so, which tells no side."""

_ROUNDING = sp.Float(2.0**-30, 17)
"""And per speed [N m s/rad]: rounding of the force of a tie, r times its slip, where there are no bearing torques."""


@dataclass(frozen=True, slots=True)
class ForceUnknown(Unseen):
    """A flange that is no shaft: its speed is a constraint force, and its balance the law of that force."""


def unknown_name(constraint: str) -> str:
    """The flange that stands for the force of a constraint."""
    return f"held_{constraint}".rstrip("_")


TIE = unknown_name("tie")
"""The unknown of a lossy tie."""


def tie_row(law: Law) -> dict[str, Any]:
    """The row over the flange speeds of a lossy tie whose force is an unknown."""
    speeds = {meaning.of: x for x, meaning in law.pool.roles.items() if meaning.role == "w"}
    balance = law.torques[TIE].xreplace(law.forces)
    return {f: -c for f, x in speeds.items() if (c := sp.diff(balance, x)) != 0 and f != TIE}


class SlipLaw(NamedTuple):
    """A constraint of a law whose force is an unknown: its row over the flange speeds, and the numbers of its event functions
    (see Program.algebraic_slips), None where it has none; pressed: numbers whose product is its engagement, where these are
    constant."""

    row: Mapping[str, Any]
    tie: bool
    forward: int | None = None
    backward: int | None = None
    engaged: int | None = None
    pressed: tuple[SymbolRole, ...] = ()


def slip_laws(law: Law, flanges: Mapping[str, Any]) -> Iterator[SlipLaw]:
    """Ties, friction and locks whose forces are unknowns; losses of gears aside."""
    for unknown, flange in flanges.items():
        if not isinstance(flange, ForceUnknown) or unknown == unknown_name("loss"):
            continue
        if unknown == TIE:
            yield SlipLaw(tie_row(law), True)
            continue
        mine = [i for i, x in enumerate(law.switches) if unknown_name(x.name) == unknown and x.constraint is None]
        found = {(law.switches[i].low, law.switches[i].high): i for i in mine}
        sides = found.get((0.0, 1.0)), found.get((0.0, -1.0)), found.get((2.0, 0.0))
        stuck = {law.switches[i].symbol: sp.Integer(i == sides[2]) for i in mine}
        balance = law.torques[unknown].xreplace(law.forces).xreplace(stuck)
        constant = balance.atoms(sp.Heaviside)
        balance = sp.expand(balance.xreplace(dict.fromkeys(constant, sp.Integer(1))))
        speeds = {meaning.of: x for x, meaning in law.pool.roles.items() if meaning.role == "w"}
        row = {f: c for f, x in speeds.items() if (c := sp.diff(balance, x)) != 0 and f != unknown}
        factors = [x for e in constant for x in sp.Mul.make_args(e.args[0] + _LEAST)]
        yield SlipLaw(row, False, *sides, tuple(law.pool.roles[x] for x in factors if x.is_Symbol))


def with_algebraic_forces(block: Block, constraints: tuple[str, ...], *, lost_behind: bool = False) -> Block:
    """The block with the forces of these of its constraints as unknowns of the balance of torques.

    lost_behind: the loss of a lossy tie acts on the other side of it, where there is inertia.
    """
    made = object.__new__(_kind(type(block), constraints, lost_behind))
    made.__dict__.update(block.__dict__)
    return made


@lru_cache(maxsize=256)
def _kind(kind: type[Block], constraints: tuple[str, ...], lost_behind: bool) -> type[Block]:
    """The class of such blocks: a further flange per force."""
    of = ", ".join(map(unknown_name, constraints)) + (", lost behind" if lost_behind else "")
    members: dict[str, Any] = {
        "__module__": kind.__module__,
        "__qualname__": f"{kind.__qualname__} with algebraic {of}",
        "__doc__": kind.__doc__,
        "physics": lambda self, s: _physics(kind.physics(self, s), s, constraints, lost_behind),
    }
    for name in constraints:
        members[unknown_name(name)] = ForceUnknown(f"force of the constraint '{name}'")
    return type(kind.__name__, (kind,), members)


def _physics(
    items: Iterator[Contribution], s: Any, constraints: tuple[str, ...], lost_behind: bool
) -> Iterator[Contribution]:  # fmt: skip
    """The contributions of the block with those constraints as algebraic laws."""
    kept: list[Contribution] = []
    made: list[Contribution] = []
    known: dict[Any, Any] = {}
    for item in items:
        if isinstance(item, LossyTie):
            law = _lossy(s, item, "loss" in constraints, lost_behind)
        elif isinstance(item, Stick) and item.name in constraints:
            law = _stick(s, item)
        else:
            kept.append(item)
            continue
        made += law.items
        known |= law.known
    for item in (*kept, *made):
        yield _in_terms_of(item, known)


def _in_terms_of(item: Contribution, known: Mapping[Any, Any]) -> Contribution:
    """A contribution with what its block reads of a constraint replaced."""
    values = {f.name: getattr(item, f.name) for f in fields(item)}
    new = {n: x.xreplace(known) for n, x in values.items() if isinstance(x, sp.Basic) and x.free_symbols & known.keys()}
    return replace(item, **new) if new else item


def held_fast(block: Block) -> Block:
    """The block with its friction as a rigid constraint: it never slips."""
    made = object.__new__(_held_kind(type(block)))
    made.__dict__.update(block.__dict__)
    return made


@lru_cache(maxsize=64)
def _held_kind(kind: type[Block]) -> type[Block]:
    """The class of such blocks."""
    members: dict[str, Any] = {
        "__module__": kind.__module__,
        "__qualname__": f"{kind.__qualname__} held fast",
        "__doc__": kind.__doc__,
        "physics": lambda self, s: _held(kind.physics(self, s), s),
    }
    return type(kind.__name__, (kind,), members)


def _held(items: Iterator[Contribution], s: Any) -> Iterator[Contribution]:
    """The contributions with a Tie in place of the Stick; its force is what the flanges get."""
    kept, known = list[Contribution](), dict[Any, Any]()
    for item in items:
        if not isinstance(item, Stick):
            kept.append(item)
            continue
        slip, flanges = sp.expand(sp.sympify(item.slip)), _flanges(s)
        kept.append(Tie(slip.xreplace({f.w: f.phi for f in flanges.values()})))
        flange, c = next(iter(row_of(s._pool, flanges, slip, "w").items()))
        direction, stuck, force = s.stick(item.name)
        known |= {direction: sp.Integer(0), stuck: sp.Integer(1), force: getattr(s, flange).tau / c}
    for item in kept:
        yield _in_terms_of(item, known)


@dataclass(slots=True)
class _Algebraic:
    """Contributions of a constraint; known: what its direction, state and force are."""

    items: list[Contribution]
    known: dict[Any, Any]


@dataclass(frozen=True, slots=True)
class _Bounds:
    """Force bounds against the slip: where it slides forward and backward, and stuck. None: without limit."""

    forward: Any
    backward: Any
    stuck_forward: Any
    stuck_backward: Any


def _stick(s: Any, item: Stick) -> _Algebraic:
    """Dry friction or a lock along a slip."""
    slip = sp.expand(sp.sympify(item.slip))
    lower, upper = item.limit if isinstance(item.limit, tuple) else (-item.limit, item.limit)
    lower, upper = (None if sp.sympify(x).is_infinite else sp.sympify(x) for x in (lower, upper))
    held = (None if lower is None else -lower), upper
    pair = held if item.sliding is None else in_pair(item.sliding)
    forward, backward = (
        None if bound is None else _beyond_rest(s, along_slip(sp.sympify(x), slip, sp.Integer(sign)), sign * slip)
        for bound, x, sign in zip(held, pair, (1, -1), strict=True)
    )
    stuck = (None if x is None else along_slip(x, slip, sp.Integer(0)) for x in held)
    return _friction(s, item.name, slip, _Bounds(forward, backward, *stuck), item.engaged, item.impulse)


def _friction(s: Any, name: str, slip: Any, bounds: _Bounds, engaged: Any = 1, impulse: Any = None) -> _Algebraic:
    """The law of the module's head, free where engaged <= 0."""
    made = _Algebraic([], {})
    unknown, slides = getattr(s, unknown_name(name)), s._pool.own_mode
    force, on = unknown.w, sp.Integer(1)
    pressed = force + slip
    if not sp.sympify(engaged).is_number:
        on = sp.Heaviside(engaged - _LEAST, 1)
        made.items.append(Switch(name, engaged - _LEAST, low=2.0, high=0.0))
    sides, sliding, one_sided = [], sp.Integer(0), bounds.forward is None or bounds.backward is None
    for sign, bound, at_rest in (
        (1, bounds.forward, bounds.stuck_forward),
        (-1, bounds.backward, bounds.stuck_backward),
    ):
        if bound is None:
            sides.append(sp.Integer(0))
            continue
        surface = sign * pressed - (slides * bound + (1 - slides) * (at_rest + _LEAST))
        if one_sided:  # q alone while it is stuck, as its bound may be 0 and the slip is rounding
            held = slides * sign * slip + (1 - slides) * (sign * force - at_rest - _LEAST)
            surface = on * held + (1 - on) * surface
        made.items.append(Switch(name, surface, low=0.0, high=float(sign)))
        sides.append(sp.Heaviside(surface, 1))
        sliding += sign * sides[-1] * bound
    forward, backward = sides
    stuck = on * (1 - forward) * (1 - backward)
    against = stuck * pressed + on * sliding + (1 - on) * _TRACE * slip
    made.items += [
        Acts(getattr(s, flange), -c * against) for flange, c in row_of(s._pool, _flanges(s), slip, "w").items()
    ]
    made.items.append(Acts(unknown, against - force))
    made.items.append(Energy(loss=on * sliding * slip))
    if impulse is not None:
        made.items.append(Rate(impulse, sp.Integer(0)))
    direction, is_stuck, constraint_force = s.stick(name)
    made.known = {direction: on * (forward - backward), is_stuck: stuck, constraint_force: -stuck * force}
    return made


# -- lossy gears ------------------------------------------------------------------------------------------------------


def _lossy(s: Any, item: LossyTie, everywhere: bool, behind: bool) -> _Algebraic:
    """A rigid constraint whose force is an unknown, and its loss: Coulomb friction with bounds that follow from that force.

    Where the side that the loss acts on has inertia it is a Stick on its slip; everywhere: no side has. behind: the loss acts
    on the other side of the tie, and is then one of what enters.
    """
    tie, slip = sp.expand(sp.sympify(item.tie)), sp.expand(sp.sympify(item.slip))
    rows = row_of(s._pool, _flanges(s), tie, "w"), row_of(s._pool, _flanges(s), slip, "w")
    unknown = getattr(s, unknown_name("tie"))
    force = unknown.w - tie
    made = _Algebraic([Acts(getattr(s, f), c * force) for f, c in rows[0].items()], {})
    made.items.append(Acts(unknown, -tie))
    direction, _, held = s.stick("loss")
    if behind:
        shared = next(f for f in rows[1] if f in rows[0])
        moved = sp.expand(slip - rows[1][shared] / rows[0][shared] * tie)
        item = replace(item, driving=_moved(item.driving, slip, moved), coasting=_moved(item.coasting, slip, moved))
        slip = moved
    lost = [_lost_of_entering if behind else _lost_of_leaving] * 2
    if everywhere:
        lost = [partial(_lost_of_leaving_alike, speed=d * slip) for d in (1, -1)]
    forward, backward = lost[0](force, item), lost[1](-force, item)
    leaving = force
    if everywhere:
        forward, backward = (along_slip(x, slip, sp.Integer(d)) for x, d in ((forward, 1), (backward, -1)))
        rest = (
            along_slip(lost[0](force, item), slip, sp.Integer(0)),
            along_slip(lost[1](-force, item), slip, sp.Integer(0)),
        )
        bounds = _Bounds(_beyond_rest(s, forward, slip), _beyond_rest(s, backward, -slip), *rest)
        law = _friction(s, "loss", slip, bounds)
        made.items += law.items
        made.known |= law.known
        direction, held = law.known[direction], law.known[held]
    else:
        made.items.append(Stick("loss", slip, (-forward, backward), (forward, backward)))
        if behind:
            leaving = (
                force + held - (1 + direction) / 2 * direction * forward - (1 - direction) / 2 * direction * backward
            )
    sign, _, tie_force = s.stick("tie")
    sides = sp.Heaviside(direction * leaving + item.driving[1], 1) - sp.Heaviside(
        -direction * leaving - item.coasting[1], 1
    )
    made.known |= {tie_force: leaving, sign: direction * sides}
    return made


def _moved(law: tuple[Any, Any], slip: Any, moved: Any) -> tuple[Any, Any]:
    """Share and rest over the size of a slip that is written in other speeds."""
    share, rest = (sp.sympify(x).xreplace({sp.Abs(slip): sp.Abs(moved)}) for x in law)
    return share, rest


def _lost_of_leaving(force: Any, item: LossyTie) -> Any:
    """The force lost on the way to what leaves, for slip forward: what enters less what leaves."""
    (s1, r1), (s2, r2) = (tuple(map(sp.sympify, x)) for x in (item.driving, item.coasting))
    if sp.simplify(r1 - r2) == 0:
        drives = sp.Heaviside(force + r1, 1)
        return (drives * s1 + (1 - drives) * s2) * (force + r1) + r1
    return sp.Max((1 + s1) * (force + r1), 0) + sp.Min((1 + s2) * (force + r2), 0) - force


def _lost_of_leaving_alike(force: Any, item: LossyTie, speed: Any) -> Any:
    """The same where the bearing torques of both sides are one number: one side or the other, with nothing between. speed: the
    slip, in the direction of the loss."""
    (s1, r1), (s2, r2) = (tuple(map(sp.sympify, x)) for x in (item.driving, item.coasting))
    drives = sp.Heaviside(force + _BEYOND * r1 + _ROUNDING * speed, 1)
    return drives * (s1 * (force + r1) + r1) + (1 - drives) * (s2 * (force + r2) + r2)


def _lost_of_entering(force: Any, item: LossyTie) -> Any:
    """The force lost of what enters, for slip forward."""
    (s1, r1), (s2, r2) = (tuple(map(sp.sympify, x)) for x in (item.driving, item.coasting))
    drives = sp.Heaviside(force, 1)
    return drives * (force * s1 / (1 + s1) + r1) + (1 - drives) * (force * s2 / (1 + s2) + r2)


def _flanges(s: Any) -> dict[str, Any]:
    """The flanges of the block that are not grounded."""
    return {n: f for n in type(s._owner).flanges if (f := getattr(s, n)).phi.is_Symbol}


def _beyond_rest(s: Any, bound: Any, size: Any) -> Any:
    """A bound with its tables over the size of the slip drawn on below 0, where noise would read another segment."""

    def drawn_on(call: Any) -> Any:
        table = s._pool.roles[call.args[0]].of
        if (
            not isinstance(table, Table)
            or table.kind == "cubic"
            or table.x[0] != 0
            or sp.expand(call.args[1] - size) != 0
        ):
            return call
        x = [-float(table.x[1]), *map(float, table.x[1:])]
        before = 2 * float(table.y[0]) - float(table.y[1]) if table.kind == "linear" else float(table.y[0])
        y = [before, *map(float, table.y[1:])]
        return s.tabled(Table(x, y, table.kind), call.args[1])

    return bound.replace(lambda e: isinstance(e, TableAt), drawn_on)
