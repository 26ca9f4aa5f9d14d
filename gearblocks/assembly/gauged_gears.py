"""Lossy gears of which one side has no inertia, where something sticks or stops at that side.

They get an inertia on the speed of their tie, which is 0 (laws/gauged_ties.py): the side is then a shaft like any other. Which
one it is, is free; a power of two about as large as the inertia on the other side, as seen by the tie, loses no digits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gearblocks.assembly.algebraic_friction import loss_rows, massless_rows
from gearblocks.assembly.block_numbers import number
from gearblocks.assembly.tables import GROUND_GROUP, Assembly, Batch
from gearblocks.laws.gauged_ties import with_gauge
from gearblocks.laws.rational import Exact, exact_value
from gearblocks.train.graph import Train


def with_gauged_gears(assembly: Assembly) -> Train:
    """The train with such inertias on all lossy gears that join one massless group with others; the train itself where there
    are none."""
    massless, present = massless_rows(assembly), _inertias(assembly)
    components, n = list(assembly.train.components), assembly.train.n_nodes
    for batch in assembly.batches:
        tie = batch.law.constraints.get("tie")
        for e, index in enumerate(batch.components) if tie is not None and tie.share is not None else ():
            row, c = _row(batch, e), components[index]
            driven = batch.groups["b"][e] in massless if "b" in batch.groups else False
            if len(_over(row, massless)) == 1 and (driven or _answers(c.block)):
                components[index] = c._replace(block=with_gauge(c.block, _size(row, present)), nodes=(*c.nodes, n))
                n += 1
    return assembly.train if n == assembly.train.n_nodes else replace(
        assembly.train, components=tuple(components), n_nodes=n
    )  # fmt: skip


def _answers(block: Any) -> bool:
    """Whether what enters at a tells what leaves at b, and something enters whatever leaves."""
    return all(eta2 > 0 and tau1 == tau2 for eta2, tau1, tau2 in loss_rows(block))


def _row(batch: Batch, e: int) -> dict[int, Exact]:
    """The row of a tie over groups."""
    row: dict[int, Exact] = {}
    known = {symbol: values[e] for symbol, values in batch.exact.items()}
    for flange, expr in batch.law.constraints["tie"].row.items():
        group = batch.groups[flange][e] if flange in batch.groups else GROUND_GROUP
        if group != GROUND_GROUP:
            row[group] = row.get(group, 0) + exact_value(expr, known) * batch.gains[flange][e]
    return row


def _over(row: Mapping[int, Exact], massless: Mapping[int, Mapping[int, Exact]]) -> dict[int, Exact]:
    """A row over massless groups."""
    found: dict[int, Exact] = {}
    for group, value in row.items():
        for source, c in massless.get(group, {}).items():
            found[source] = found.get(source, 0) + value * c
    return {group: c for group, c in found.items() if c}


def _size(row: Mapping[int, Exact], present: Mapping[int, float]) -> float:
    """The inertia of the groups of a row about its speed, to a power of two."""
    seen = [present[g] / float(c) ** 2 for g, c in row.items() if c and present.get(g, 0.0) > 0]
    size = min(seen or [x for x in present.values() if x > 0] or [1.0])
    return 2.0 ** round(math.log2(size))


def _inertias(assembly: Assembly) -> dict[int, float]:
    """Inertia of the bodies of every group by the numbers that they have now."""
    found: dict[int, float] = {}
    for batch in assembly.batches:
        for flange, expr in batch.law.bodies:
            for e, index in enumerate(batch.components):
                if (group := batch.groups[flange][e]) != GROUND_GROUP:
                    own = number(batch, assembly.train.components[index], expr) * float(batch.gains[flange][e]) ** 2
                    found[group] = found.get(group, 0.0) + (own if math.isfinite(own) else 0.0)
    return found
