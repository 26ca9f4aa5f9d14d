"""Floating massless groups: without inertia, and damped only against each other.

    w_i = sum of z_ij w_j + part_i      z: null space of the speeds of dampers, D w = 0

Their balances of torque D' c D w = ... are singular: they give differences of speeds (the parts), and their common motion
follows from springs alone. Some groups j stand for that, and the others depend on them. Knows nothing of the
numbers of dampers, only of the linear forms that they damp.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.assembly.elimination import Combination, Elimination, Row, row_sum
from gearblocks.assembly.kinematics import DependentGroup
from gearblocks.assembly.rigid_constraints import Groups
from gearblocks.assembly.tables import ExactValues
from gearblocks.laws.law import Law
from gearblocks.laws.rational import exact_value
from gearblocks.laws.vanishing import vanishes
from gearblocks.train.graph import GROUND, Component

_ROUNDING = 1e-12  # of the sizes of what cancels: factors that are floats


@dataclass(slots=True)
class MasslessGroups:
    """The groups of a train for which dampers are looked up: massless ones, and the dependent ones."""

    groups: Groups
    massless: Sequence[int]
    dependent_groups: Sequence[DependentGroup]

    def rows(self) -> dict[int, Row]:
        """Speeds of groups over the massless ones; what else they depend on is left aside."""
        found: dict[int, Row] = {group: {group: 1} for group in self.massless}
        for f in self.dependent_groups:
            if f.row is not None:
                found[f.group] = row_sum(((c, found.get(g, {})) for g, c in f.row.groups.items()), _ROUNDING)
        return found


def floating(
    among: MasslessGroups, components: Iterable[Component], laws: Iterable[Law], known: Iterable[ExactValues]
) -> dict[int, Row]:
    """Floating groups: each with its speed over those that stand for them while no damper sees a speed."""
    if len(among.massless) < 2:
        return {}
    elimination = Elimination(_ROUNDING)  # of the forms that dampers keep at zero
    rows = among.rows()
    forms: dict[int, list[Mapping[str, Any]]] = {}
    for c, law, values in zip(components, laws, known, strict=True):
        nodes = {n: node for n, node in zip(type(c.block).flanges, c.nodes, strict=True) if node != GROUND}
        at = {n: among.groups.find(node) for n, node in nodes.items()}
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
    speeds = {meaning.of: x for x, meaning in law.pool.roles.items() if meaning.role == "w"}
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
    return found if all(vanishes(sp.sympify(x), law) for x in left.values()) else None


def _alone(law: Law, flange: str, number: int) -> bool:
    """Whether a flange stands in one deflection only."""
    return [j for j, form in enumerate(law.forms) if flange in form.coefficients] == [number]
