"""Springs by themselves: constant stiffnesses of blocks and the inertias that each swings against.

    w^2 = k g' M^-1 g        g: the deflection per speed, M: inertias of the rigid groups that it joins

Knows nothing of modes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from gearblocks.assembly.block_numbers import number
from gearblocks.assembly.tables import GROUND_GROUP, Assembly, Batch
from gearblocks.language.fields import COMPLIANCE, Field
from gearblocks.language.signals import constant_value
from gearblocks.language.units import parse_unit
from gearblocks.train.graph import Component

_STIFFNESS = tuple(parse_unit(unit) for unit in ("N/m", "N m/rad"))


def is_stiffness(spec: Field) -> bool:
    return spec.belongs_to == COMPLIANCE and any(parse_unit(spec.unit) == unit for unit in _STIFFNESS)


def stiffnesses(c: Component) -> Iterator[tuple[str, float]]:
    """Constant stiffnesses of a block."""
    for name, spec in type(c.block).fields.items():
        k = constant_value(v) if is_stiffness(spec) and (v := c.block.__dict__[name]) is not None else math.nan
        if k > 0 and math.isfinite(k):
            yield name, k


def inertias(assembly: Assembly) -> dict[int, float]:
    """Inertia of every independent group that nothing dependent rests on; NaN for the others."""
    found = {g: math.nan for f in assembly.dependent_groups for g in (f.group, *f.sources)}
    for batch in assembly.batches:
        for flange, expression in batch.law.bodies:
            for e, index in enumerate(batch.components):
                group, gain = batch.groups[flange][e], float(batch.gains[flange][e])
                own = number(batch, assembly.train.components[index], expression)
                found[group] = found.get(group, 0.0) + gain**2 * own
    return found


def mobility(assembly: Assembly, batch: Batch, e: int, c: Component, inertia: dict[int, float]) -> float:
    """g' M^-1 g of the first deflection of a block; 0 where it cannot be told."""
    if not batch.law.forms:
        return 0.0
    row = levers(batch, e, c)
    if not all(group < assembly.n_speeds and inertia.get(group, 0.0) > 0 for group in row):
        return 0.0
    found = sum(lever**2 / inertia[group] for group, lever in row.items())
    return found if math.isfinite(found) else 0.0


def levers(batch: Batch, e: int, c: Component) -> dict[int, float]:
    """The first deflection of a block per angle of each group; NaN where that is no number."""
    form = batch.law.forms[0]
    row: dict[int, float] = {}
    for flange, coefficient in form.coefficients.items():
        if flange in batch.groups and (group := batch.groups[flange][e]) != GROUND_GROUP:
            lever = number(batch, c, form.scale * coefficient) * float(batch.gains[flange][e])
            row[group] = row.get(group, 0.0) + lever
    return row
