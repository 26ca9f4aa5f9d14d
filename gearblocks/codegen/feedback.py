"""Feedback signals: the outputs that signals read, where they come from and in which order they are computed.

Each may read others; an algebraic loop of them is refused. Accelerations, constraint forces and reactions are signals behind
the motion: they follow from all torques, so only rates of states and the ledger may read them. Knows nothing of what a signal
does in a law.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import sympy as sp

from gearblocks.assembly.angle_wrapping import located
from gearblocks.assembly.tables import Assembly
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.codegen.parts import Call, FeedbackSignal
from gearblocks.codegen.switched_constraints import constraint_torques
from gearblocks.codegen.symbol_names import by_name
from gearblocks.errors import ModelError, did_you_mean
from gearblocks.train.graph import Component
from gearblocks.train.translational import flange_names

if TYPE_CHECKING:
    from gearblocks.codegen.generator import Generator


def _shown(codes: Iterable[BatchCode], assembly: Assembly, path: str) -> tuple[BatchCode, int, Any, int]:
    """(batch, instance, expression, number) of an output that a signal may read."""
    known = []
    for code in codes:
        for e, index in enumerate(code.batch.components):
            prefix = assembly.train.components[index].path + "."
            for i, (show, expr) in enumerate(code.shows):
                known.append(prefix + show.name)
                if path == known[-1]:
                    return code, e, expr, i
    for code in codes:
        for e, index in enumerate(code.batch.components):
            component = assembly.train.components[index]
            if path.startswith(f"{component.path}.") and (found := _at_flange(code, component, path)) is not None:
                return code, e, found, -1
    raise ModelError(f"sense('{path}'): no block shows that output{did_you_mean(path, known)}")


def _at_flange(code: BatchCode, component: Component, path: str) -> Any:
    """Speed, torque or power of a flange, as far as the law gives it; the reaction of a rigid constraint by its role."""
    flange, _, quantity = path.removeprefix(f"{component.path}.").partition(".")
    if flange not in code.batch.groups:
        return None
    _, speed, torque, power = flange_names(flange in component.sliders)
    pool, law = code.law.pool, code.law
    w = pool.symbol("w", flange, f"w_{flange}")
    if quantity == speed:
        return w
    if quantity not in (torque, power):
        return None
    held = [f for coefficients, _ in law.ties for f in coefficients] + [
        f for x in law.prescribed for f in (x.flange, *x.gains)
    ]
    if flange in held:
        tau = pool.symbol("tau", flange, f"tau_{flange}")
    else:
        tau = code.torques.get(flange, sp.Integer(0))
        tau += sum(-J * pool.symbol("alpha", f, f"alpha_{f}") for f, J in law.bodies if f == flange)
        tau += sum(torque for f, torque in constraint_torques(code) if f == flange)
    return tau * w if quantity == power else tau


def signals_behind_motion(g: Generator, in_law: Iterable[str]) -> frozenset[str]:
    """Signals that read accelerations or constraint forces. ModelError where a torque or anything else that the motion follows
    from reads one, with the loop."""
    roles: dict[str, set[str]] = {}

    def roles_of(path: str, chain: tuple[str, ...] = ()) -> set[str]:
        if path in chain:  # order_signals refuses it
            return set()
        if path not in roles:
            code, _, expr, _ = _shown(g.codes, g.assembly, path)
            meanings = [code.law.pool.roles[x] for x in expr.free_symbols]
            roles[path] = {m.role for m in meanings}.union(
                *(roles_of(m.of, (*chain, path)) for m in meanings if m.role == "sense")
            )
        return roles[path]

    behind = frozenset(path for path in in_law if roles_of(path) & {"alpha", "constraint_force", "tau"})
    for path in sorted(behind):
        for code in g.codes:
            _check_reader(g, code, path)
    return behind


_BEFORE_MOTION = (
    "forces", "torques", "surfaces", "bands", "whens", "prescribed", "prescribed angles", "starts", "constraints", "stored",
    "constraint_loss", "holds",
)  # fmt: skip


def _check_reader(g: Generator, code: BatchCode, path: str) -> None:
    """ModelError where a batch reads a signal behind the motion in what the motion follows from."""
    symbol = next((x for x, m in code.law.pool.roles.items() if m.role == "sense" and m.of == path), None)
    if symbol is None:
        return
    reader = code.paths[0]
    if any(symbol in e.free_symbols for e in code.law.expressions(*_BEFORE_MOTION)):
        raise ModelError(
            f"sense('{path}'): an acceleration or reaction cannot be fed back into the torque or a condition of '{reader}': it "
            f"follows from the torques of all parts, an algebraic loop {reader} -> {path} -> {reader}; let a state stand "
            f"between, in a block whose gb.Rate reads it, or sense a speed or a torque law"
        )
    in_rates = any(symbol in e.free_symbols for e in code.law.expressions("rates", "loss", "supplied"))
    if in_rates and g.assembly.n_massless:
        raise ModelError(
            f"sense('{path}'): an acceleration or reaction cannot be fed back, which '{reader}' asks for, in a train with a "
            f"shaft without inertia, which has no acceleration of its own; put an Inertia on that shaft"
        )


def reads_motion(g: Generator, code: BatchCode, expr: Any) -> bool:
    """Whether an expression reads a signal behind the motion."""
    roles = code.law.pool.roles
    return any(roles[x].role == "sense" and roles[x].of in g.behind_motion for x in sp.sympify(expr).free_symbols)


def reads_angles(assembly: Assembly, path: str) -> bool:
    """Whether an output that a signal reads needs absolute angles."""
    for batch in assembly.batches:
        for index in batch.components:
            prefix = assembly.train.components[index].path + "."
            for show in batch.law.shows:
                if prefix + show.name == path:
                    roles = [batch.law.pool.roles[x] for x in show.expr.free_symbols]
                    return any(s.role == "phi" or (s.role == "coordinate" and not batch.used[s.of]) for s in roles)
    return False


def order_signals(
    signals: dict[str, FeedbackSignal], codes: list[BatchCode], assembly: Assembly, in_law: set[str],
    whole: set[tuple[int, int]],
) -> dict[str, FeedbackSignal]:  # fmt: skip
    """Calls of feedback signals in an order in which each reads only earlier ones.

    whole: (batch, output) that read unwrapped angles.
    """
    done: dict[str, None] = {}

    def visit(path: str, chain: tuple[str, ...]) -> None:
        if path in chain:
            loop = " -> ".join((*chain[chain.index(path) :], path))
            raise ModelError(f"the signals form an algebraic loop: {loop}; put a state between them")
        if path in done:
            return
        code, e, expr, show = _shown(codes, assembly, path)
        for role in (code.law.pool.roles[x] for x in by_name(expr)):
            if role.role == "sense":
                visit(role.of, (*chain, path))
        signal = signals[path]
        signal.batch, signal.instance, signal.expr = code.number, e, expr
        unwrapped = (code.number, show) in whole and path not in in_law
        assignment = Assignment(Operand(Role.FEEDBACK_SIGNALS, signal.index), "=", located(expr) if unwrapped else expr)
        vector = Role.UNWRAPPED_ANGLES if unwrapped else Role.STATES
        signal.call = Call(code.function(f"feedback_{signal.index}", [assignment], vector=vector), e)
        done[path] = None

    for path in signals:
        visit(path, ())
    return {path: signals[path] for path in done}
