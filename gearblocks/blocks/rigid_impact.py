"""Rigid impacts: contacts without compliance that have a gap and a restitution, two unilateral constraints at its ends."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

from gearblocks.blocks.effects import HuntCrossley
from gearblocks.blocks.stops import Limits, pressing, stops
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows


def _gap_field(block: Any) -> str:
    return "half_gap" if "half_gap" in type(block).fields else "backlash"


def _ends(block: Any) -> list[str]:
    """Fields that give the gap."""
    found = [_gap_field(block), *(name for name in ("lower", "upper") if name in type(block).fields)]
    return [name for name in found if getattr(block, name) is not None]


def _has_restitution(block: Any) -> bool:
    return bool(_ends(block)) and isinstance(block.contact_damping, HuntCrossley)


def hits(block: Any) -> bool:
    """Whether the two sides are rigid and hit each other."""
    return block.k is None and getattr(block, "stiffness", None) is None and _has_restitution(block)


def without(block: Any, name: str, changed: Block) -> Block:
    """The block without the effect, given `changed`, which lacks all that the effect would take along elsewhere.

    Gap and restitution outlive the compliance; of a rigid impact, they go together.
    """
    if name == "compliance" and _has_restitution(block):
        kept = [*_ends(block), "contact_damping", *(["rest"] if "rest" in type(block).fields else [])]
        changed = changed.changed(**{field: getattr(block, field) for field in kept})
    elif name in ("backlash", "damping") and hits(block):
        gone = [*_ends(block), *(["rest"] if "rest" in type(block).fields else [])]
        changed = changed.changed(**{**dict.fromkeys(gone), "contact_damping": "clipped"})
    return changed


def impact(block: Any, s: Any, angle: Any, radius: Any) -> Generator[Contribution, None, Any]:
    """The stops at both ends of the gap about zero deflection radius * angle, and the force against it: > 0 on the drive
    side. The angle has exact factors, which the stops need."""
    if "half_gap" not in type(block).fields:
        lower, upper = block.backlash.ends(s.backlash)
    elif block.half_gap is not None:
        lower, upper = -s.half_gap, s.half_gap
    else:
        lower, upper = s.lower, s.upper
    least, most = (None if end is None else end / radius for end in (lower, upper))
    limits = Limits(angle, least, most, s.contact_damping.restitution)
    yield from stops(limits)
    force, contact = pressing(s, limits)
    yield Shows("contact", contact, "1", "-1 coast side, 0 none, +1 drive side")
    return -force / radius
