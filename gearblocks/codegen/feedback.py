"""Feedback signals: the outputs that signals read, where they come from and in which order they are computed.

Each may read others; an algebraic loop of them is refused. Knows nothing of what a signal does in a law.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from gearblocks.assembly.angle_wrapping import located
from gearblocks.assembly.tables import Assembly
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.codegen.parts import Call, FeedbackSignal
from gearblocks.errors import ModelError, did_you_mean


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
    raise ModelError(f"sense('{path}'): no block shows that output{did_you_mean(path, known)}")


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
        roles = [code.law.pool.roles[x] for x in expr.free_symbols]
        if path in in_law and any(s.role in ("alpha", "tau", "constraint_force") for s in roles):
            raise ModelError(
                f"sense('{path}'): an acceleration or reaction cannot be fed back; sense a speed or a torque law"
            )
        for role in roles:
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
