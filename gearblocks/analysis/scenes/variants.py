"""Variants of a train: which effects may be taken away together, by groups of alike ones, and the train without them.

Taking compliance away takes along all that rests on it; what actually goes is asked of the train. Knows nothing of runs.
"""

from __future__ import annotations

import glob
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import final

from gearblocks.drivetrain import Drivetrain

_NUMBER = re.compile(r"\d+")


@final
@dataclass(frozen=True, slots=True)
class Part:
    """What may be taken away as one: a name for it, and the effects that go, all of them ("shaft.damping" with
    "shaft.compliance")."""

    name: str
    effects: frozenset[str]

    def __or__(self, other: Part) -> Part:
        return Part(f"{self.name} + {other.name}", self.effects | other.effects)


def without(train: Drivetrain, effects: Iterable[str]) -> Drivetrain:
    """The train without these effects, and without those that rest on them."""
    names = [glob.escape(name) for name in effects]
    return train.without(*names) if names else train


def gone(train: Drivetrain, effects: Iterable[str]) -> frozenset[str]:
    """All effects that go with these."""
    return frozenset(train.effects()).difference(without(train, effects).effects())


def parts(train: Drivetrain) -> tuple[Part, ...]:
    """Single effects of a train; alike ones, whose names differ in numbers alone, as one ("mesh[*].backlash")."""
    groups: dict[str, list[str]] = {}
    for name in train.effects():
        groups.setdefault(_NUMBER.sub("*", name), []).append(name)
    return tuple(Part(key if len(names) > 1 else names[0], gone(train, names)) for key, names in groups.items())


def elements(train: Drivetrain) -> tuple[Part, ...]:
    """All effects of an element, or of alike elements, as one; where an effect already takes all of them along, that is it."""
    single = {part.effects for part in parts(train)}
    groups: dict[str, list[str]] = {}
    for name in train.effects():
        groups.setdefault(_NUMBER.sub("*", name.rpartition(".")[0]), []).append(name)
    found = []
    for key, names in groups.items():
        everything = gone(train, names)
        if everything not in single:
            owners = {name.rpartition(".")[0] for name in names}
            found.append(Part(f"{key if len(owners) > 1 else next(iter(owners))}.*", everything))
    return tuple(found)


def members(train: Drivetrain, part: Part) -> Iterator[Part]:
    """The single ones of a group of alike effects."""
    tops = [name for name in part.effects if _NUMBER.sub("*", name) == part.name or name == part.name]
    for name in sorted(tops):
        yield Part(name, gone(train, [name]))
