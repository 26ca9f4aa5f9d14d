"""Start speeds that nothing gives, and the blows that they make: a compliant element between a body that starts turning and
one that nothing gave a speed.

    T = k v_rel / sqrt(k g' M^-1 g)        the peak of the vibration that a speed of its deflection starts

g: the deflection per speed, M: inertias of the rigid groups that it joins. Knows nothing of runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from gearblocks.assembly.tables import GROUND_GROUP, Assembly, Batch
from gearblocks.errors import GearblocksError
from gearblocks.language.block import given_start
from gearblocks.language.fields import COMPLIANCE, SPEED
from gearblocks.language.units import unit_along
from gearblocks.laws.rational import Exact
from gearblocks.model.build import check_user_blocks
from gearblocks.model.single_springs import inertias, levers, mobility, stiffnesses
from gearblocks.model.start_values import start_of
from gearblocks.train.graph import Component, Tree, flatten

SHOWN = 12
"""Names that are listed."""


def open_starts(tree: Tree) -> Iterator[str]:
    """What there is to say of a train; nothing where no body gives a start speed, or it cannot be assembled."""
    from gearblocks.assembly.assemble import assemble

    try:
        train = flatten(tree)
        if not any(given_start(c.block, SPEED) is not None for c in train.components):
            return
        check_user_blocks(train)
        assembly = assemble(train)
    except GearblocksError:
        return
    yield from _told(assembly)


def _told(assembly: Assembly) -> Iterator[str]:
    given, bodies = _given(assembly), _bodies(assembly)
    if not any(given.values()):
        return
    open_ones = [path for path, (group, _) in bodies.items() if group < assembly.n_speeds and group not in given]
    if not open_ones:
        return
    more = f" and {len(open_ones) - SHOWN} more" if len(open_ones) > SHOWN else ""
    yield f"start speeds that nothing gives, 0 unless ties say otherwise: {', '.join(open_ones[:SHOWN])}{more}"
    inertia = inertias(assembly)
    for batch in assembly.batches:
        for e, index in enumerate(batch.components):
            c = assembly.train.components[index]
            if COMPLIANCE in c.block.effects():
                yield from _blow(assembly, batch, e, c, given, inertia)


def _bodies(assembly: Assembly) -> dict[str, tuple[int, Exact]]:
    """Group and gain of every body that moves."""
    found: dict[str, tuple[int, Exact]] = {}
    for batch in assembly.batches:
        for flange, _ in batch.law.bodies:
            for e, index in enumerate(batch.components):
                group = batch.groups[flange][e]
                if group != GROUND_GROUP:
                    found[assembly.train.components[index].path] = group, batch.gains[flange][e]
    return found


def _given(assembly: Assembly) -> dict[int, float]:
    """Speeds of the groups of which a body gives one, or which follow from one."""
    blocks = {c.path: c.block for c in assembly.train.components}
    found: dict[int, float] = {}
    for path, (group, gain) in _bodies(assembly).items():
        value = start_of(blocks[path], SPEED) if given_start(blocks[path], SPEED) is not None else None
        if value is not None:
            found.setdefault(group, value / float(gain))
    for f in assembly.dependent_groups:
        if f.group in found:
            found |= {g: found.get(g, 0.0) for g in f.sources}
    for group, start in enumerate(assembly.starts[: assembly.n_speeds]):  # through lossy ties
        if group not in found and start.w0 in blocks and given_start(blocks[start.w0], SPEED) is not None:
            found[group] = (start_of(blocks[start.w0], SPEED) or 0.0) / float(start.w0_gain)
    return found


def _blow(
    assembly: Assembly, batch: Batch, e: int, c: Component, given: dict[int, float], inertia: dict[int, float]
) -> Iterator[str]:  # fmt: skip
    """What an element between a given speed and an open one would feel."""
    stiff = next(iter(stiffnesses(c)), None)
    per_torque = mobility(assembly, batch, e, c, inertia) if stiff is not None else 0.0
    if stiff is None or per_torque <= 0:
        return
    row = levers(batch, e, c)
    rate = sum(lever * given.get(g, 0.0) for g, lever in row.items())
    if rate != 0 and any(g not in given for g in row):
        force = abs(rate) * math.sqrt(stiff[1] / per_torque)
        along = unit_along(type(c.block).fields[stiff[0]].unit, c.slides) == "N/m"
        unit = "N" if along else "N m"
        yield (
            f"a blow of {force:.3g} {unit} on '{c.path}' at the start: one side turns, and nothing gives the other a start "
            "speed; initial='rolling' lets it turn along"
        )
