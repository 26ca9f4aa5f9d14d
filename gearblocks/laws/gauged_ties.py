"""Lossy gears with an inertia on what their tie holds at rest: the speed tie itself, which is 0.

    M a = f + h F,  g a = 0     is     (M + J g' g) a = f + h F,  g a = 0

g: row of the tie, h: torques of its force F, losses included. No motion and no force depends on J, and a side without inertia
of its own has a regular mass matrix. Knows nothing of trains: where it is wanted the assembly says.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import sympy as sp

from gearblocks.language.block import Block
from gearblocks.language.contributions import Body, Contribution, LossyTie, Tie
from gearblocks.language.fields import Unseen

GAUGE = "tied"
"""The flange that such a gear has besides: its speed is that of the tie."""


def with_gauge(block: Block, J: float) -> Block:
    """The block with an inertia J on the speed of its tie."""
    made = object.__new__(_kind(type(block), J))
    made.__dict__.update(block.__dict__)
    return made


@lru_cache(maxsize=256)
def _kind(kind: type[Block], J: float) -> type[Block]:
    """The class of such blocks."""
    members: dict[str, Any] = {
        "__module__": kind.__module__,
        "__qualname__": f"{kind.__qualname__} with {J!r} on its tie",
        "__doc__": kind.__doc__,
        "physics": lambda self, s: _physics(kind.physics(self, s), s, J),
        GAUGE: Unseen("the speed of the tie"),
    }
    return type(kind.__name__, (kind,), members)


def _physics(items: Iterator[Contribution], s: Any, J: float) -> Iterator[Contribution]:
    """The contributions of the block, and that inertia."""
    gauge = getattr(s, GAUGE)
    for item in items:
        yield item
        if isinstance(item, LossyTie):
            speeds = {f.w: f.phi for n in type(s._owner).flanges if (f := getattr(s, n)).phi.is_Symbol}
            yield Tie(sp.expand(sp.sympify(item.tie)).xreplace(speeds) - gauge.phi)
            yield Body(gauge, sp.Float(J))
