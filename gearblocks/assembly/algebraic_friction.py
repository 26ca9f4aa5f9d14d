"""Which friction, locks and lossy gears act on shafts without inertia, and the train with their forces as unknowns.

The law of such a force is algebraic (laws/algebraic_friction.py); its unknown is a massless group of its own, at a node
that nothing else touches. Knows nothing of how the law reads.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from gearblocks.assembly.elimination import Combination, Elimination
from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.errors import ModelError
from gearblocks.language.block import places_of
from gearblocks.language.signals import Parameter
from gearblocks.laws.algebraic_friction import ForceUnknown, with_algebraic_forces
from gearblocks.laws.rational import Exact, exact_value
from gearblocks.train.graph import Train


def algebraic_forces(assembly: Assembly) -> Train:
    """The train where the forces of switched constraints on massless groups are unknowns; the train itself without any.

    Raises ModelError where these forces are not told by the balance of torques.
    """
    train = assembly.train
    found = list(_massless_constraints(assembly))
    if not found:
        return train
    components, n = list(train.components), train.n_nodes
    for index, names, lost_behind in found:
        c = components[index]
        nodes = (*c.nodes, *range(n, n + len(names)))
        components[index] = c._replace(
            block=with_algebraic_forces(c.block, names, lost_behind=lost_behind), nodes=nodes
        )
        n += len(names)
    return replace(train, components=tuple(components), n_nodes=n)


def force_unknowns(assembly: Assembly) -> frozenset[int]:
    """The groups that stand for forces."""
    return frozenset(
        assembly.group_of_node[c.nodes[place]][0]
        for c in assembly.train.components
        for place in places_of(type(c.block), ForceUnknown)
    )


def _massless_constraints(assembly: Assembly) -> Iterator[tuple[int, tuple[str, ...], bool]]:
    """Components with names of their constraints that act on massless groups; and whether what is lost in a lossy tie acts on
    its other side, since the tie says how fast this one is."""
    rows = massless_rows(assembly)
    if not rows:
        return
    independent, geared = Elimination(), set[int]()
    for batch in assembly.batches:
        for e, index in enumerate(batch.components):
            names, behind = [], False
            path = assembly.train.components[index].path
            for name, constraint in batch.law.constraints.items():
                row: dict[int, Exact] = {}
                for flange, expr in constraint.row.items():
                    group = batch.groups[flange][e] if flange in batch.groups else GROUND_GROUP
                    value = exact_value(expr, {s: v[e] for s, v in batch.exact.items()})
                    for source, c in rows.get(group, {}).items():
                        row[source] = row.get(source, 0) + value * batch.gains[flange][e] * c
                row = {g: c for g, c in row.items() if c}
                if constraint.is_stop:
                    _refuse_stop(path, row)
                elif row and name == "loss" and constraint.losses and not independent.left(row):
                    behind = True
                    _refuse_lost_behind(path, rows.get(batch.groups["b"][e] if "b" in batch.groups else GROUND_GROUP))
                elif row:
                    names.append(name)
                    geared |= row.keys() if name == "tie" else set()
                    _note(independent, row, path, not geared.isdisjoint(row))
            if "tie" in names:
                _refuse_losses(path, assembly.train.components[index].block, behind or "loss" in names)
            if names or behind:
                yield index, tuple(names), behind


def _note(independent: Elimination, row: dict[int, Exact], path: str, geared: bool) -> None:
    """ModelError where a slip is given by others of massless groups, so that two forces would hold the same.

    geared: one of them is a lossy gear, which ties the shaft rigidly, so that an inertia there makes nothing stiff.
    """
    left = independent.left(row)
    if not left:
        raise ModelError(_several(path, geared))
    independent.solve(Combination(dict(left)), next(iter(left)))


def _several(path: str, geared: bool) -> str:
    small = "; 1e-6 of that on the other side of the gear does, and is not stiff, as the gear ties it" if geared else ""
    return (
        f"'{path}': several elements that can stick act on one shaft without inertia, whose balance does not tell their "
        f"forces apart; put an Inertia there{small}"
    )


def _refuse_lost_behind(path: str, massless: dict[int, Exact] | None) -> None:
    """ModelError where what a gear loses would act on its side b, which has no inertia either."""
    if massless:
        raise ModelError(_several(path, geared=True))


def _refuse_stop(path: str, row: dict[int, Exact]) -> None:
    """ModelError for a stop at a massless group."""
    if row:
        raise ModelError(
            f"'{path}': a stop acts on a shaft without inertia, which it could not hold by itself; put an Inertia there"
        )


def _refuse_losses(path: str, block: Any, at_a: bool) -> None:
    """ModelError for losses of a gear that the torques at its side without inertia do not tell."""
    for eta2, tau1, tau2 in loss_rows(block):
        wrong = ("eta2 > 0" if eta2 < 0 else "tau1 = tau2" if tau1 != tau2 else "") if at_a else ""
        if wrong or (not at_a and tau1 > tau2):
            raise ModelError(
                f"'{path}': the shaft at its side {'a' if at_a else 'b'} has no inertia, so that its losses need "
                f"{wrong or 'tau1 <= tau2'} (eta2 = {eta2:g}, tau1 = {tau1:g} N m, tau2 = {tau2:g} N m); put an Inertia there"
            )


def loss_rows(block: Any) -> Iterator[tuple[float, float, float]]:
    """eta2, tau1, tau2 of every row of the losses of a gear, by the numbers that it has now."""
    rows = block.loss_table or ((0.0, *block.efficiency, *(block.bearing or (0.0, 0.0))),)
    for _, _, *of in rows:
        eta2, tau1, tau2 = map(_number, of)
        yield eta2, tau1, tau2


def _number(x: Any) -> float:
    return float(x.si if isinstance(x, Parameter) else x)


def massless_rows(assembly: Assembly) -> dict[int, dict[int, Exact]]:
    """Speeds of groups over the massless ones they move with."""
    first = assembly.n_speeds
    rows: dict[int, dict[int, Exact]] = {g: {g: 1} for g in range(first, first + assembly.n_massless)}
    for f in assembly.dependent_groups if rows else ():
        row: dict[int, Exact] = {}
        for source, c in f.row.groups.items() if f.row is not None else ():
            for g, x in rows.get(source, {}).items():
                row[g] = row.get(g, 0) + c * x
        if row:
            rows[f.group] = row
    return rows
