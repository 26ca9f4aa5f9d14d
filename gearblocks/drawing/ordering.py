"""Order of the elements from left to right: from a source along the power flow, a shaft's own elements before what leads on.

The level of a shaft is its distance from the source, counted in elements. An element leads from its shafts of the lowest level
to the others; it comes after all that leads to those, and after what sits on them alone. Knows nothing of lanes.
"""

from __future__ import annotations

from collections import defaultdict, deque
from typing import final

from gearblocks.blocks import (
    Acceleration,
    Angle,
    DCMotor,
    Engine,
    Fixed,
    Force,
    Inertia,
    Mass,
    Speed,
    Torque,
)
from gearblocks.drawing.scheme import Element, Scheme
from gearblocks.language.block import Block
from gearblocks.language.signals import constant_value

_FIRST = {Engine: 0, DCMotor: 0, Speed: 1, Angle: 1, Acceleration: 1, Torque: 2, Force: 2}
"""What a train starts from, the lowest number first."""


def orders(scheme: Scheme) -> list[list[int]]:
    """Orders worth drawing: branch after branch, and all branches at once; each a list of numbers of elements."""
    flow = _Flow(scheme)
    found = [flow.order(deep) for deep in (True, False)]
    return found if found[0] != found[1] else found[:1]


def _start_rank(block: Block) -> int:
    """How likely a train starts from a block, the lowest number first; a constant torque below 0 is a load."""
    given = block.__dict__.get("tau", block.__dict__.get("f"))
    return 3 if given is not None and constant_value(given) < 0 else _FIRST.get(type(block), 9)


@final
class _Flow:
    """Levels of the shafts, and what must come before each element."""

    def __init__(self, scheme: Scheme) -> None:
        self.elements = scheme.elements
        self.on_shaft = defaultdict[int, list[int]](list)
        for i, e in enumerate(self.elements):
            for shaft in e.shafts:
                self.on_shaft[shaft].append(i)
        self.sources: dict[int, int] = {}  # the element that a train or a part by itself starts from, and its place
        self.level = self._levels(len(scheme.shafts))
        self.needs = [set[int]() for _ in self.elements]
        for shaft, here in self.on_shaft.items():
            riders = sorted((i for i in here if self.elements[i].is_rider), key=self._rank)
            leading_to = [i for i in here if shaft not in self._inputs(i)]
            leading_on = [i for i in here if not self.elements[i].is_rider and shaft in self._inputs(i)]
            before = [i for i in leading_to if not self.elements[i].is_rider]
            for i in riders:
                self.needs[i].update(before)
                before = [i]
            for i in leading_on:
                self.needs[i].update(before)

    def _levels(self, n: int) -> list[int]:
        level = [-1] * n
        starts = sorted(range(len(self.elements)), key=lambda i: (_start_rank(self.elements[i].block), i))
        for start in starts:
            shaft = self.elements[start].shafts[0]
            if level[shaft] >= 0:
                continue
            self.sources[start] = len(self.sources)
            level[shaft], waiting = 0, deque([shaft])
            while waiting:
                here = waiting.popleft()
                for other in (s for i in self.on_shaft[here] for s in self.elements[i].shafts):
                    if level[other] < 0:
                        level[other] = level[here] + 1
                        waiting.append(other)
        return level

    def _inputs(self, i: int) -> tuple[int, ...]:
        shafts = self.elements[i].shafts
        lowest = min(self.level[s] for s in shafts)
        return tuple(s for s in shafts if self.level[s] == lowest)

    def _rank(self, i: int) -> tuple[int, int]:
        """Source, bodies, what is held fast, loads."""
        e = self.elements[i]
        if i in self.sources:
            return 0, i
        if isinstance(e.block, (Inertia, Mass)):
            return 1, i
        return (
            3 if type(e.block) in _FIRST or (len(type(e.block).flanges) == 1 and not isinstance(e.block, Fixed)) else 2
        ), i

    def order(self, deep: bool) -> list[int]:
        """Elements so that each follows what it needs: the newest first (deep), or the oldest first."""
        missing = [set(needs) for needs in self.needs]
        follow = defaultdict[int, list[int]](list)
        for i, needs in enumerate(self.needs):
            for needed in needs:
                follow[needed].append(i)
        ready = deque(
            sorted(
                (i for i, needs in enumerate(missing) if not needs),
                key=lambda i: (self.sources.get(i, len(missing)), i),
            )
        )
        found: list[int] = []
        while ready:
            i = ready.popleft()
            found.append(i)
            free = []
            for after in follow[i]:
                missing[after].discard(i)
                if not missing[after]:
                    free.append(after)
            free.sort(key=self._turn)
            if deep:
                ready.extendleft(reversed(free))
            else:
                ready.extend(free)
        assert len(found) == len(self.elements), "levels leave no circle"
        return found

    def _turn(self, i: int) -> tuple[bool, bool, int]:
        """Riders first, then what closes on shafts that there are, then the rest as it was added."""
        e: Element = self.elements[i]
        return (not e.is_rider, len(self._inputs(i)) < len(e.shafts), i)
