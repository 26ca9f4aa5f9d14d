"""Start values that follow from others: which given ones the rigid constraints and prescribed motions leave no choice for.

    phi_g = sum of c_k phi_k over free groups    each given phi_g solved for one of them; one that is over none depends
    w_g   = sum of c_k w_k                       in the same way; a prescribed speed is free in its angle alone

Of a nonlinear relation only its sources count, with generic factors; one that nobody gives starts at 0 and is not solved
for. Knows nothing of values.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from fractions import Fraction

from gearblocks.assembly.assemble import assemble
from gearblocks.assembly.elimination import Combination, Elimination
from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.errors import ModelError
from gearblocks.language.block import given_start, start_fields
from gearblocks.language.fields import ANGLE, SPEED
from gearblocks.train.graph import Train


def dependent_starts(train: Train) -> dict[str, list[str]]:
    """By "angle" and "speed": paths of the bodies whose given start value follows from motions and from those given before
    it. Nothing for a train that cannot be assembled."""
    bodies = [
        c._replace(block=c.block.changed(**dict.fromkeys(start_fields(type(c.block)).values())))
        if len(c.nodes) == 2 else c for c in train.components
    ]  # fmt: skip
    try:
        assembly = assemble(replace(train, components=tuple(bodies)))  # which a Fixed may contradict
    except ModelError:
        return {ANGLE: [], SPEED: []}
    return {of: _dependent(train, assembly, of) for of in (ANGLE, SPEED)}


def _dependent(train: Train, assembly: Assembly, of: str) -> list[str]:
    bodies = [c for c in train.components if len(c.nodes) == 2 and given_start(c.block, of) is not None]
    places = [assembly.group_of_node[c.nodes[0]] for c in bodies]
    groups, given = _definitions(assembly, {group for group, _ in places}, of), Elimination()
    found: list[str] = []
    for c, (group, gain) in zip(bodies, places, strict=True):
        if group == GROUND_GROUP:
            if of == SPEED:
                found.append(c.path)
            continue
        left = given.left({g: x * gain for g, x in groups.gains(group).items()})
        if left:
            given.solve(Combination(dict(left)), next(iter(left)))
        else:
            found.append(c.path)
    return found


def _definitions(assembly: Assembly, known: Container[int], of: str) -> Elimination:
    """Dependent groups over those that are free. known: groups with a given start value."""
    found = Elimination()
    for f in assembly.dependent_groups:
        if f.row is not None:
            sources = dict(f.row.groups)
        elif f.prescribed is not None and (of == SPEED or not f.prescribed.by_speed):
            sources = {
                g: Fraction(2 * f.group + 3, 2 * g + 5) for g in f.sources if g in known or g in found.definitions
            }
        else:
            continue
        found.solve(Combination({f.group: -1, **sources}), f.group)
    return found
