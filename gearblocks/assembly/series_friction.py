"""Friction in a row without anything between: at a shaft without inertia that two friction elements alone touch.

All elements of such a row bear one torque, that of the weakest: it slips, and the others stick for ever, as rigid constraints.
Knows nothing of time: which one is the weakest has to follow from the numbers of the train, which are structure then.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from gearblocks.assembly.tables import GROUND_GROUP, Assembly
from gearblocks.errors import ModelError
from gearblocks.language.signals import Parameter
from gearblocks.laws.algebraic_friction import held_fast
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.graph import Train


@dataclass(frozen=True, slots=True)
class _Strength:
    """Sliding and static torque of an element, and the numbers by path that they follow from."""

    slides: float
    holds: float
    numbers: tuple[tuple[str, float], ...]


def with_series_locked(assembly: Assembly) -> tuple[Train, tuple[tuple[str, float], ...]]:
    """The train where all but the weakest element of every row are rigid, and the numbers that this rests on.

    Raises ModelError where the numbers do not tell the weakest.
    """
    components, numbers = list(assembly.train.components), list[tuple[str, float]]()
    for row in _rows(assembly):
        found = {index: _strength(assembly, index) for index in row}
        weakest = _weakest(assembly, found)
        for index, strength in found.items():
            numbers += strength.numbers
            if index != weakest:
                components[index] = components[index]._replace(block=held_fast(components[index].block))
    return replace(assembly.train, components=tuple(components)), tuple(numbers)


def _rows(assembly: Assembly) -> Iterator[list[int]]:
    """Components in a row, in their order."""
    touching: dict[int, list[int]] = {g: [] for g in range(assembly.n_speeds, assembly.n_speeds + assembly.n_massless)}
    rubbing: set[int] = set()
    for f in assembly.dependent_groups:
        for source in f.sources:
            touching.pop(source, None)
    for batch in assembly.batches:
        law = batch.law
        alone = {k.kind for k in law.constraints.values()} == {"friction"} and len(law.constraints) == 1
        rubs = alone and not law.forces and not law.ties and not law.prescribed
        for e, index in enumerate(batch.components):
            rubbing |= {index} if rubs else set()
            for flange in batch.flanges:
                group = batch.groups[flange][e]
                if group != GROUND_GROUP and group in touching and not (law.bodies and not law.torques):
                    touching[group].append(index)
    joined, members = DisjointSets[int](), set[int]()
    for pair in touching.values():
        if len(pair) == 2 and pair[0] != pair[1] and rubbing.issuperset(pair):
            joined.join(*pair)
            members.update(pair)
    rows: dict[int, list[int]] = {}
    for index in sorted(members):
        rows.setdefault(joined.root(index), []).append(index)
    yield from rows.values()


def _strength(assembly: Assembly, index: int) -> _Strength:
    """Raises ModelError for a friction torque that is no number."""
    c = assembly.train.components[index]
    values, numbers = dict[str, float](), list[tuple[str, float]]()
    for field in ("capacity", "mu", "force_max", "engagement", "geometry", "peak"):
        value = getattr(c.block, field, None)
        if isinstance(value, Parameter):
            values[field] = value.si
            numbers.append((value.name, value.si))
        elif isinstance(value, (int, float)):
            values[field] = float(value)
            numbers.append((f"{c.path}.{field}", float(value)))
        elif value is not None:
            break
    else:
        if "capacity" in values or "mu" in values:
            normal = values.get("force_max", 1.0) * values.get("engagement", 1.0) * values.get("geometry", 1.0)
            slides = max(values["capacity"] if "capacity" in values else values["mu"] * normal, 0.0)
            return _Strength(slides, slides * values.get("peak", 1.0), tuple(numbers))
    raise ModelError(
        f"'{c.path}': friction stands in a row with another one on a shaft without inertia, and which one slips follows only "
        f"where both are a Clutch or Brake with numbers for capacity, or for mu, force_max and engagement; put an Inertia there"
    )


def _weakest(assembly: Assembly, found: dict[int, _Strength]) -> int:
    """Raises ModelError where two are as weak, or one slips first and another would go on."""
    order = sorted(found, key=lambda i: found[i].slides)
    first, second = found[order[0]], found[order[1]]
    names = " and ".join(f"'{assembly.train.components[i].path}'" for i in order[:2])
    if first.slides == second.slides:
        raise ModelError(
            f"{names} are in a row on a shaft without inertia and slip at the same torque, {first.slides:g} N m: how fast that "
            f"shaft turns nothing tells; put an Inertia there, or give one of them more"
        )
    if first.holds >= min(found[i].holds for i in order[1:]):
        raise ModelError(
            f"{names} are in a row on a shaft without inertia; one slips at less ({first.slides:g} N m), the other breaks away "
            f"at no more ({second.holds:g} N m): which one slips depends on how they got there; put an Inertia there"
        )
    return order[0]
