"""Derivation of a law: one symbolic pass per kind of block, from contributions to torques, rates, event functions, energies.

Virtual work: a force F along a deflection x(phi) gives the torque -F dx/dphi on each flange, a potential V(phi) the torque
-dV/dphi. A kind is a class with a structure (which fields are present) and a set of grounded flanges; all its instances
share the law. Knows nothing of numbers, which come from tables, nor of trains.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import sympy as sp

from gearblocks.errors import ModelError
from gearblocks.language.block import Block
from gearblocks.language.contributions import (
    Acts,
    Body,
    Contribution,
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
from gearblocks.laws.energy_balance import add_energy_balance
from gearblocks.laws.functions import Table2At, TableAt
from gearblocks.laws.heat import add_heat
from gearblocks.laws.law import COORDINATES, LOCATED, READ, Form, Law
from gearblocks.laws.prescribed_motion import (
    can_be_solved,
    is_constant_tie,
    linear_tie,
    prescribed_angle,
    prescribed_speed,
    written_out,
)
from gearblocks.laws.relative_angles import in_coordinates
from gearblocks.laws.switched_constraints import along, constraint_laws, constraint_loss, sizes_of_slips, sliding_force
from gearblocks.laws.switching import Freezer
from gearblocks.laws.symbols import CONSTANT, MOVING, Pool, Symbols


def _contributions(block: Block, s: Symbols) -> defaultdict[type, list[Any]]:
    """Contributions of one call of physics, by kind."""
    found: defaultdict[type, list[Any]] = defaultdict(list)
    for item in block.physics(s):
        if type(item) not in get_args(Contribution):
            raise ModelError(f"{type(block).__name__}.physics yields {item!r}, which is no contribution")
        found[type(item)].append(item)
    return found


def derive(
    block: Block,
    grounded: frozenset[str],
    *,
    reading: bool = False,
    inverted: bool = False,
    sensed: frozenset[str] = frozenset(),
) -> Law:
    """The law of the kind that `block` is an instance of.

    inverted=True solves its nonlinear relation for its other flange (see `Tie.inverse`). reading=True keeps angles,
    conditions and named parts (a mesh force, say) as they are, for people to read. sensed: names of outputs that other laws
    read, whose conditions are located as those of the law itself.
    """
    law = Law(Pool(reading=reading))
    pool, kind = law.pool, type(block).__name__
    s = Symbols(block, pool, grounded)
    found = _contributions(block, s)
    flanges = {name: getattr(s, name) for name in type(block).flanges if name not in grounded}
    law.bodies = [(_flange_name(flanges, b.flange), sp.sympify(b.J)) for b in found[Body] if b.flange.phi.is_Symbol]
    law.rates = {pool.roles[r.state].of: sp.sympify(r.expr) for r in found[Rate]}
    law.starts = {pool.roles[x.state].of: sp.sympify(x.value) for x in found[Start]}
    law.holds = [(pool.roles[h.state].of, sp.sympify(h.value), sp.sympify(h.when)) for h in found[Hold]]
    law.inverse_speeds = {pool.roles[h.state].of for h in found[Hold] if h.inverse_speed}
    law.rates |= {state: sp.Integer(0) for state, _, _ in law.holds}
    for tie in found[Tie]:
        zero = _relation(law, tie, flanges, inverted)
        if is_constant_tie(law, flanges, zero):
            linear = linear_tie(flanges, zero)
            law.ties += [linear] if linear[0] else []
        else:
            law.prescribed.append(prescribed_angle(law, kind, flanges, zero, tie.rates))
    speeds = {f.w for f in flanges.values()}
    zeros = [written_out(pool.spelled(m.zero, speeds), speeds) for m in found[Motion]]
    law.prescribed += [prescribed_speed(law, kind, flanges, zero) for zero in zeros]
    law.constraints = constraint_laws(pool, flanges, [*found[Stick], *found[Stop], *found[LossyTie]])
    law.rates |= {x: sp.Integer(0) for k in law.constraints.values() for x in (k.impulse, k.impacts) if x is not None}
    law.torques = _torques(law, flanges, found, reading)
    _energies(law, found[Energy])
    law.shows = [Shows(x.name, sp.sympify(x.expr), x.unit, x.words) for x in found[Shows]]
    add_heat(law, block, s)
    for constraint in law.constraints.values():
        law = law.map(partial(along, pool, constraint), "shows")
    if not reading:
        law = _in_coordinates(law, flanges, [*found[Force], *(Force(x.gap, 0) for x in found[Stop])])
        law = _frozen(law, found[Switch], sensed)
        if law.stored is not None and _jumps_in_time(law):
            law.stored = None
        add_energy_balance(law, flanges)
    return law


def _energies(law: Law, entries: Iterable[Energy]) -> None:
    """Stored energy and lost power, that of sliding friction included."""
    stored = [sp.sympify(e.stored) for e in entries if e.stored is not None]
    losses = [sp.sympify(e.loss) for e in entries if e.loss is not None]
    losses += [-sliding_force(law.pool, k) * k.slip for k in law.constraints.values()]
    law.stored = sp.Add(*stored) if stored and not _is_driven(law.pool, stored) else None
    law.loss = sp.Add(*losses) if losses else None


def _flange_name(flanges: Mapping[str, Any], wanted: Any) -> str:
    return next(name for name, f in flanges.items() if f is wanted)


def _relation(law: Law, tie: Tie, flanges: Mapping[str, Any], inverted: bool) -> Any:
    """What stays 0, solved for its other flange where that is wanted, or where the first one is grounded; notes which flange
    that is."""
    angles = {f.phi for f in flanges.values()}
    zero = written_out(law.pool.spelled(tie.zero, angles), angles)
    if tie.inverse is None or not tie.inverse[0].phi.is_Symbol:
        return zero
    law.invertible = _flange_name(flanges, tie.inverse[0])
    if inverted or not can_be_solved(zero, flanges):
        return written_out(law.pool.spelled(tie.inverse[1](), angles), angles)
    return zero


def _is_driven(pool: Pool, exprs: Iterable[Any]) -> bool:
    """Whether an input or a feedback signal stands in a stored energy: its jumps would be lost, so the work counts as
    exchange."""
    return any(pool.roles[x].role in ("input", "sense") for e in exprs for x in e.free_symbols)


def _jumps_in_time(law: Law) -> bool:
    """Whether a switch of time or a step table stands in a stored energy: its jumps would be lost, so the work counts as
    exchange."""
    roles = law.pool.roles
    modes = {x for x in law.stored.free_symbols if roles[x].role == "mode" and roles[x].of.level != MOVING}
    smooth = {mode for e in law.stored.atoms(Table2At) for mode in e.args[5:]}
    smooth |= {e.args[3] for e in law.stored.atoms(TableAt) if len(e.args) == 4 and roles[e.args[0]].of.kind != "step"}
    return bool(modes - smooth)


def _torques(
    law: Law, flanges: Mapping[str, Any], found: Mapping[type, list[Any]], reading: bool
) -> dict[str, Any]:  # fmt: skip
    """Torque that the block exerts on each flange: virtual work of its forces and potentials, and what acts."""
    total: dict[str, Any] = {}

    def add(name: str, tau: Any) -> None:
        if tau != 0:
            total[name] = total.get(name, 0) + tau

    for force in found[Force]:
        form = None if reading else _linear_form(law.pool, flanges, sp.sympify(force.deflection))
        if form is not None and form.whole:
            symbol = law.pool.symbol("force", len(law.forces), f"force{len(law.forces)}")
            law.forces[symbol] = form.scale * sp.sympify(force.force)
            for name, c in form.coefficients.items():
                add(name, -c * symbol)
            continue
        for name, flange in flanges.items():
            along = law.pool.by_name(sp.diff(law.pool.spelled(force.deflection, {flange.phi}), flange.phi))
            add(name, -sp.sympify(force.force) * along)
    for potential in found[Potential]:
        for name, flange in flanges.items():
            add(name, -sp.diff(law.pool.spelled(potential.energy, {flange.phi}), flange.phi))
    for act in found[Acts]:
        if act.flange.phi.is_Symbol:
            add(_flange_name(flanges, act.flange), sp.sympify(act.tau))
    for constraint in law.constraints.values():
        whole = law.pool.symbol("friction", constraint.name, f"T_{constraint.name}".rstrip("_"))
        for name, c in constraint.row.items():
            add(name, c * (whole if reading else sliding_force(law.pool, constraint)))
    return total


def _in_coordinates(law: Law, flanges: Mapping[str, Any], forces: Iterable[Force]) -> Law:
    """The law in relative coordinates: one per independent deflection, and absolute angles only where left."""
    replace: dict[Any, Any] = {}
    for force in forces:
        form = _linear_form(law.pool, flanges, sp.sympify(force.deflection))
        if form is None:
            continue
        u = law.pool.symbol("coordinate", len(law.forms), f"u{len(law.forms)}")
        solved = _solve(law.pool, form, u, flanges, replace)
        if solved is not None:
            replace = solved
            law.forms.append(form)
            law.coordinates.append(u)
    law.replaced = replace
    return law.map(lambda e: in_coordinates(law.pool, e, replace), COORDINATES) if replace else law


def _solve(
    pool: Pool, form: Form, u: Any, flanges: Mapping[str, Any], replace: dict[Any, Any]
) -> dict[Any, Any] | None:  # fmt: skip
    """The replacements with one more angle expressed by the coordinate u, or None when the form adds nothing new."""
    expr = sum(c * flanges[n].phi for n, c in form.coefficients.items())
    expr = sp.expand(expr.xreplace(replace)) if replace else expr
    pivots = [f.phi for n in reversed(form.coefficients) if expr.has((f := flanges[n]).phi) and f.phi not in replace]
    if not pivots:
        return None
    slopes = {x: sp.diff(expr, x) for x in pivots}
    pivot = next((x for x in pivots if not _may_vanish(pool, slopes[x])), pivots[0])
    slope = slopes[pivot]
    solved = (u - expr.xreplace({pivot: sp.Integer(0)})) / slope
    return {**{k: v.xreplace({pivot: solved}) for k, v in replace.items()}, pivot: solved}


def _linear_form(pool: Pool, flanges: Mapping[str, Any], deflection: Any) -> Form | None:
    """The part of a deflection linear in the angles, scaled so that one of its coefficients is 1 or -1: the first that is no
    number of the block, which might be 0, else the first."""
    slopes = {n: sp.diff(deflection, f.phi) for n, f in flanges.items()}
    angles = {f.phi: 0 for f in flanges.values()}
    linear = {n: sp.expand(c) for n, c in slopes.items() if c != 0}
    linear = {n: c if not c.free_symbols & set(angles) else _constant_part(c, set(angles)) for n, c in linear.items()}
    linear = {n: c for n, c in linear.items() if c != 0}
    if not linear or any(pool.level(c) != CONSTANT for c in linear.values()):
        return None
    first = next(iter(linear.values()))
    if _may_vanish(pool, first):
        first = next((c for c in linear.values() if c.is_number), first)
    scale = -first if first.could_extract_minus_sign() else first
    whole = not any(c.free_symbols & set(angles) for c in slopes.values())
    return Form({n: sp.cancel(c / scale) for n, c in linear.items()}, scale, whole)


def _may_vanish(pool: Pool, coefficient: Any) -> bool:
    """Whether a number of the block in a coefficient may be 0."""
    return any(pool.roles[x].of not in pool.nonzero for x in coefficient.free_symbols)


def _constant_part(slope: Any, angles: set[Any]) -> Any:
    """Terms of a slope free of the angles (the rest belongs to a term over the angle, such as an error)."""
    return sp.Add(*(term for term in sp.Add.make_args(slope) if not term.free_symbols & angles))


def unlocated(law: Law) -> frozenset[str]:
    """Names of the outputs with conditions of their own, which nothing locates."""
    whole = {TableAt: 4, Table2At: 7}  # arguments where the segments are modes
    return frozenset(
        show.name
        for show in law.shows
        if show.expr.has(sp.Heaviside, sp.floor)
        or any(len(x.args) < n for kind, n in whole.items() for x in show.expr.atoms(kind))
    )


def _frozen(law: Law, declared: Iterable[Switch], sensed: frozenset[str]) -> Law:
    """The law with the conditions of its dynamics as modes, those by which states are set among them; outputs read these modes
    and locate nothing of their own, but for those that are `sensed`."""
    pool, freezer = law.pool, Freezer(law.pool, sizes_of_slips(law.pool, law.constraints))

    def new(expr: Any) -> Any:
        return in_coordinates(pool, expr, law.replaced)

    freezer.declare(Switch(x.name, new(x.surface), new(x.when), x.low, x.high) for x in declared)
    frozen = law.map(freezer.freeze, LOCATED)
    # the switches of each constraint follow those of its own expressions
    frozen.constraints = {
        name: freezer.add_constraint(constraint.map(freezer.freeze)) for name, constraint in law.constraints.items()
    }
    frozen.constraint_loss = constraint_loss(pool, frozen.constraints)
    frozen.shows = [replace(x, expr=freezer.freeze(x.expr)) if x.name in sensed else x for x in frozen.shows]
    frozen.holds = [(state, value, freezer.freeze(when)) for state, value, when in frozen.holds]
    freezer.locating = False
    frozen = frozen.map(freezer.freeze, READ)
    frozen.switches = freezer.switches
    return frozen


def check_feedback(law: Law, path: str) -> None:
    """ModelError where the component at `path` needs a feedback signal before there is one: at the start, or for a prescribed
    motion."""

    def sensed(exprs: Iterable[Any]) -> str:
        roles = (law.pool.roles[x] for e in exprs for x in e.free_symbols)
        return next((meaning.of for meaning in roles if meaning.role == "sense"), "")

    if found := sensed(law.expressions("prescribed", "prescribed angles")):
        raise ModelError(
            f"'{path}': the sensed output '{found}' cannot prescribe a rigid motion, not through a filter either: it may "
            f"follow from the torques of that motion; prescribe an Input, or drive with a torque that depends on it"
        )
    for state, value in law.starts.items():
        if found := sensed([value]):
            raise ModelError(
                f"'{path}': the state '{state}' starts from the sensed output '{found}', which is not known before the "
                f"start; give Start a number, a Parameter or an Input"
            )
