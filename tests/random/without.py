"""`without` against the train built without: a compliant part taken away, and the same train with a rigid one in its place."""

from __future__ import annotations

from dataclasses import replace
from random import Random

from tests.random.description import FIXED, HITS, Part, Train


def tied_pair(train: Train, random: Random) -> tuple[str, Train, Train] | None:
    """A compliant part's name, the train at rest, and the same with a rigid part in its place; None where there is none.

    Only a part whose two ends nothing else ties: a loop of rigid parts could not move. Nor one with HuntCrossley: its rigid
    sides keep their play and hit each other.
    """
    parts = {p.name: p for p in train.parts}
    free = [n for n in train.drops if n in parts and not _keeps_play(parts[n]) and _opens(train, parts[n])]
    if not free or train.initial is not None:
        return None
    name = random.choice(free)
    rested = train.with_parts(p.changed(w0=None, v0=None, phi0=None, s0=None) for p in train.parts)
    parts = {p.name: p for p in rested.parts}
    rigid = [_rigid(p) if p.name == name else p for p in rested.parts]
    return name, rested, rested.with_parts(rigid)


def _keeps_play(part: Part) -> bool:
    return bool(part.field(HITS)) or "HuntCrossley" in str(part.field("contact_damping"))


def _opens(train: Train, part: Part) -> bool:
    """Whether without this part its two ends hang together through nothing."""
    ends = [n for _, n in part.at]
    if len(ends) != 2 or any(n in FIXED for n in ends):
        return False
    reached, todo = {ends[0]}, [ends[0]]
    while todo:
        node = todo.pop()
        for other in train.parts:
            nodes = [n for _, n in other.at if n not in FIXED]
            if other.name != part.name and node in nodes:
                todo += [n for n in nodes if n not in reached]
                reached |= set(nodes)
    return ends[1] not in reached


def _rigid(part: Part) -> Part:
    if part.block == "GearMesh":
        at = (("a", part.node("pinion")), ("b", part.node("wheel")))
        return Part(part.name, "IdealGear", (("teeth", part.field("teeth")), ("external", part.field("external"))), at)
    return replace(part, block="Shaft", fields=(("rigid", True),))
