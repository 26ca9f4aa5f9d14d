"""Start angles that follow from others: which given ones the rigid constraints and prescribed motions leave no choice for.

    phi_g = sum of c_k phi_k over free groups    each given phi_g solved for one of them; one that is over none depends

Of a nonlinear relation only its sources count, with generic factors; one that nobody gives starts at 0 and is not solved
for. Knows nothing of values.
"""

from __future__ import annotations

from collections.abc import Container
from fractions import Fraction

from gearblocks.assembly.assemble import assemble
from gearblocks.assembly.elimination import Combination, Elimination
from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.errors import ModelError
from gearblocks.language.block import given_start
from gearblocks.language.fields import ANGLE
from gearblocks.train.graph import Train


def dependent_angles(train: Train) -> list[str]:
    """Paths of the bodies whose given start angle follows from motions and from the angles given before it. Empty for a train
    that cannot be assembled."""
    try:
        assembly = assemble(train)
    except ModelError:
        return []
    bodies = [c for c in train.components if len(c.nodes) == 2 and given_start(c.block, ANGLE) is not None]
    places = [assembly.group_of_node[c.nodes[0]] for c in bodies]
    groups, given, found = _definitions(assembly, {group for group, _ in places}), Elimination(), []
    for c, (group, gain) in zip(bodies, places, strict=True):
        if group == GROUND_GROUP:
            continue
        left = given.left({g: x * gain for g, x in groups.gains(group).items()})
        if left:
            given.solve(Combination(dict(left)), next(iter(left)))
        else:
            found.append(c.path)
    return found


def _definitions(assembly: Assembly, known: Container[int]) -> Elimination:
    """Dependent groups over those that are free. known: groups with a given angle."""
    found = Elimination()
    for f in assembly.dependent_groups:
        if f.row is not None:
            sources = dict(f.row.groups)
        elif f.prescribed is not None and not f.prescribed.by_speed:
            sources = {
                g: Fraction(2 * f.group + 3, 2 * g + 5) for g in f.sources if g in known or g in found.definitions
            }
        else:
            continue
        found.solve(Combination({f.group: -1, **sources}), f.group)
    return found
