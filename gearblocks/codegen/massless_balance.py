"""Balance of torques at a massless group: torque rate, damping and stiffness entries of one law.

Knows nothing of groups as a whole: what several laws give one group is added up elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy as sp

from gearblocks.assembly.tables import GROUND_GROUP, Batch
from gearblocks.codegen.parts import Balance, MasslessRows
from gearblocks.laws.law import Law
from gearblocks.laws.symbols import time_symbol


def balance_of(
    batch: Batch, hoist: Callable[[Any], Any], rows: MasslessRows, floating_bases: frozenset[int], by_mode: bool
) -> Balance:
    """The balance of a batch, hoisted; empty where none of its flanges is at such a shaft. by_mode: dampers may be without
    effect in some modes."""
    law = batch.law
    at = [f for f in batch.flanges if any(group in rows for group in batch.groups[f])]
    speeds = {f: law.pool.symbol("w", f, f"w_{f}") for f in at}
    result = Balance()
    for f in at:
        if f not in law.torques or batch.groups[f][0] == GROUND_GROUP:
            continue
        torque = law.torques[f].xreplace(law.forces)
        alone = not by_mode and all(floating_bases.isdisjoint(rows.get(group, ())) for group in batch.groups[f])
        torque_rate = _rate(law, torque, damped=alone)
        result.torques[f], result.torque_rates[f] = hoist(torque), hoist(torque_rate)
        for other, w in speeds.items():
            damping, stiffness = sp.diff(torque, w), _stiffness(law, torque, other)
            if damping != 0:
                result.damping_entries[f, other] = hoist(damping)
            if stiffness != 0:
                result.stiffness_entries[f, other] = hoist(stiffness)
    return result


def _stiffness(law: Law, torque: Any, flange: str) -> Any:
    """Derivative of a torque by the angle of a flange."""
    total = sp.diff(torque, law.pool.symbol("phi", flange, f"phi_{flange}"))
    for form, u in zip(law.forms, law.coordinates, strict=True):
        total += sp.diff(torque, u) * form.coefficients.get(flange, 0)
    return total


def _rate(law: Law, torque: Any, *, damped: bool) -> Any:
    """Torque rate. What dampers add to it is left aside: it cancels at a floating group, and a `damped` group needs no rate
    (0)."""
    speeds = [x for x in torque.free_symbols if law.pool.roles[x].role == "w"]
    if speeds and damped:
        return sp.Integer(0)
    torque = torque.xreplace(dict.fromkeys(speeds, sp.Integer(0)))
    total = sp.diff(torque, time_symbol())
    for form, u in zip(law.forms, law.coordinates, strict=True):
        slope = sp.diff(torque, u)
        if slope != 0:
            total += slope * sum(c * law.pool.symbol("w", n, f"w_{n}") for n, c in form.coefficients.items())
    for x in list(torque.free_symbols):
        meaning = law.pool.roles[x]
        if meaning.role == "phi":
            total += sp.diff(torque, x) * law.pool.symbol("w", meaning.of, f"w_{meaning.of}")
        elif meaning.role == "state":
            total += sp.diff(torque, x) * law.rates[meaning.of]
    return total
