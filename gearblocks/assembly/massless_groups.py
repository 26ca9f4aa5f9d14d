"""Shafts without inertia that are damped only against each other.

Their balances of torque give the differences of their speeds; how they turn together follows from springs alone. One of
them stands for that, and the others follow it and a part of their own: w[i] = z[i] w[one] + part[i].
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import sympy as sp

from gearblocks.assembly.elimination import Combination, Elimination, Row, row_sum
from gearblocks.assembly.kinematics import Follower
from gearblocks.assembly.rigid_constraints import Groups
from gearblocks.laws.energy_balance import vanishes
from gearblocks.laws.law import Law
from gearblocks.laws.rational import Exact, exact_value
from gearblocks.train.graph import GROUND, Component

_ROUNDING = 1e-12  # of the sizes of what cancels: factors that are floats


class Known(Protocol):
    """Exact values of the symbols that enter ratios of one component."""

    @property
    def values(self) -> dict[Any, Exact]:
        """By symbol."""


@dataclass(slots=True)
class Shafts:
    """The groups of a train for which dampers are looked up: hidden ones, and how others follow."""

    groups: Groups
    hidden: Sequence[int]
    followers: Sequence[Follower]

    def rows(self) -> dict[int, Row]:
        """The hidden groups that the speed of each group depends on."""
        found: dict[int, Row] = {group: {group: 1} for group in self.hidden}
        for f in self.followers:
            if f.row is not None:
                found[f.group] = row_sum(((c, found.get(g, {})) for g, c in f.row.groups.items()), _ROUNDING)
        return found


def floating(
    shafts: Shafts, components: Iterable[Component], laws: Iterable[Law], known: Iterable[Known]
) -> dict[int, Row]:
    """The groups that turn along with others at no damper's cost: by group, its speed over those that stand for them."""
    if len(shafts.hidden) < 2:
        return {}
    elimination = Elimination(_ROUNDING)  # of the forms that dampers keep at zero
    rows = shafts.rows()
    forms: dict[int, list[Mapping[str, Any]]] = {}
    for c, law, values in zip(components, laws, known, strict=True):
        nodes = {n: node for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node != GROUND}
        at = {n: shafts.groups.find(node) for n, node in nodes.items()}
        if not any(root in rows for root, _ in at.values()):
            continue
        if id(law) not in forms:
            forms[id(law)] = list(damped_forms(law))
        for form in forms[id(law)]:
            terms = ((exact_value(c, values.values) * at[n][1], rows.get(at[n][0], {})) for n, c in form.items())
            left = elimination.left(row_sum(terms, _ROUNDING))
            if left:
                elimination.solve(Combination(left), max(left))
    return {group: row for group in elimination.definitions if (row := elimination.gains(group))}


# -- what a law damps -------------------------------------------------------------------------------------------------


def damped_forms(law: Law) -> Iterator[Mapping[str, Any]]:
    """Linear forms of the flange speeds that the torques of a law depend on: its deflections where they suffice, else the
    speed of every flange."""
    speeds = {slot.of: x for x, slot in law.pool.slots.items() if slot.role == "w"}
    torques = [tau.xreplace(law.forces) for tau in law.torques.values()]
    gradients = [{n: sp.diff(tau, w) for n, w in speeds.items() if tau.has(w)} for tau in torques]
    gradients = [g for g in gradients if g]
    needed: set[int] = set()
    for gradient in gradients:
        shares = _shares(law, gradient)
        if shares is None:
            yield from ({n: 1} for n in dict.fromkeys(n for g in gradients for n in g))
            return
        needed |= shares
    yield from (law.forms[j].coefficients for j in sorted(needed))


def _shares(law: Law, gradient: dict[str, Any]) -> set[int] | None:
    """Numbers of the deflections whose rates a gradient over flange speeds is a combination of; None where it is none."""
    left, found, done = dict(gradient), set(), set[str]()
    for j, form in enumerate(law.forms):
        pivot = next((n for n in form.coefficients if _alone(law, n, j) and n not in done), None)
        if pivot is None or pivot not in left:
            continue
        share = left[pivot] / form.coefficients[pivot]
        found.add(j)
        done.add(pivot)
        for n, c in form.coefficients.items():
            left[n] = left.get(n, 0) - share * c
    return found if all(vanishes(sp.sympify(x), law.pool) for x in left.values()) else None


def _alone(law: Law, flange: str, number: int) -> bool:
    """Whether a flange stands in one deflection only."""
    return [j for j, form in enumerate(law.forms) if flange in form.coefficients] == [number]
