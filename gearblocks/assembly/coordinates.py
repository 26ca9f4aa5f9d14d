"""Relative coordinates: which deflections are states, which follow from them, and where absolute angles come from.

Each compliant element asks for one linear form of the group angles. Independent forms become states; a form that
closes a loop is an exact combination of them. Absolute angles remain only for groups that nothing else determines.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from gearblocks.laws.rational import Exact, over

_ROUNDING = 1e-14  # of the sizes of what cancels
_K = TypeVar("_K", int, str)


@dataclass(slots=True)
class Combination:
    """Exact combination of group angles, coordinates and offsets of the ground (paths of parameters)."""

    groups: dict[int, Exact] = field(default_factory=dict)
    coordinates: dict[int, Exact] = field(default_factory=dict)
    offsets: dict[str, Exact] = field(default_factory=dict)

    def add(self, other: Combination, factor: Exact) -> None:
        """Adds factor times another combination."""
        _accumulate(self.groups, other.groups, factor)
        _accumulate(self.coordinates, other.coordinates, factor)
        _accumulate(self.offsets, other.offsets, factor)


def _accumulate(target: dict[_K, Exact], source: Mapping[_K, Exact], factor: Exact) -> None:
    for key, value in source.items():
        total = target.get(key, 0) + factor * value
        if total:
            target[key] = total
        else:
            target.pop(key, None)


class Elimination:
    """Takes forms one by one; `definitions` say how each eliminated group angle follows from what is left.

    given: groups whose angles follow otherwise (a prescribed angle), with those that they follow from: they are never
    eliminated, and none of these is defined by them.
    """

    def __init__(self, given: Mapping[int, Collection[int]] | None = None) -> None:
        self.given = given or {}
        self.definitions: dict[int, Combination] = {}
        self._gains: dict[int, dict[int, Exact]] = {}
        self._tops: dict[int, int] = {}
        self.n = 0
        self.rows: list[dict[int, Exact]] = []

    def take(self, form: Combination) -> int | Combination:
        """The number of a new coordinate, or what the form is a combination of."""
        left = self._left(form)
        free = left.keys() - self.given.keys() - self._upstream([g for g in left if g in self.given])
        if not free:
            whole = self.expand(form)
            whole.groups = {g: c for g, c in whole.groups.items() if g in left}
            return whole
        apart = self._join(list(form.groups))
        raw = [g for g in form.groups if g in free and g not in self.definitions] if apart else []
        pivot = raw[-1] if raw else next(g for g in left if g in free)
        base = form if raw else self.expand(form)
        c = base.groups[pivot]
        definition = Combination({}, {self.n: over(1, c)}, {})
        definition.add(Combination(dict(base.groups), dict(base.coordinates), dict(base.offsets)), over(-1, c))
        definition.groups.pop(pivot, None)
        self.definitions[pivot] = definition
        self._gains[pivot] = dict(definition.groups)
        self.rows.append(dict(form.groups))
        self.n += 1
        return self.n - 1

    def _upstream(self, driven: list[int]) -> set[int]:
        """The groups that are not eliminated from which the angles of driven groups follow."""
        found: set[int] = set()
        stack = list(driven)
        while stack:
            new = {root for s in self.given.get(stack.pop(), ()) for root in self._roots(s)} - found
            found |= new
            stack += new
        return found

    def _left(self, form: Combination) -> dict[int, Exact]:
        """Factors of the form on the groups that are not eliminated. What floats leave where they cancel is nothing: three
        times 120 degrees, in factors that are cosines, close the circle."""
        left: dict[int, Exact] = {}
        for group, c in form.groups.items():
            _accumulate(left, self._roots(group), c)
        if all(isinstance(c, int) for c in left.values()):
            return left
        sizes = dict.fromkeys(left, 0.0)
        for group, c in form.groups.items():
            for g, gain in self._roots(group).items():
                if g in sizes:
                    sizes[g] += abs(float(c) * float(gain))
        return {g: c for g, c in left.items() if abs(float(c)) > _ROUNDING * sizes[g]}

    def _join(self, groups: list[int]) -> bool:
        """Notes that a form joins these groups. True when none of them was joined to another one before, so that none
        can be defined by another; else only the expanded form is safe from going round in a circle."""
        tops = []
        for g in groups:
            while (up := self._tops.setdefault(g, g)) != g:
                self._tops[g] = self._tops.setdefault(up, up)
                g = up
            tops.append(g)
        self._tops.update(dict.fromkeys(tops, tops[0]))
        return len(set(tops)) == len(tops)

    def _roots(self, group: int) -> dict[int, Exact]:
        """Gain of a group on the groups that are not eliminated (its coordinates left aside)."""
        if group not in self.definitions:
            return {group: 1}
        gains = self._gains[group]
        while any(g in self.definitions for g in gains):
            new: dict[int, Exact] = {}
            for g, c in gains.items():
                _accumulate(new, self._gains[g] if g in self.definitions else {g: 1}, c)
            gains = self._gains[group] = new
        return gains

    def order(self, wanted: list[int]) -> list[int]:
        """Eliminated groups needed for `wanted`, each after those it is defined by."""
        done: dict[int, None] = {}
        for start in wanted:
            stack = [(start, False)]
            while stack:
                group, ready = stack.pop()
                if group in done or group not in self.definitions:
                    continue
                if ready:
                    done[group] = None
                    continue
                stack.append((group, True))
                stack.extend((g, False) for g in self.definitions[group].groups)
        return list(done)

    def expand(self, form: Combination) -> Combination:
        """The form in coordinates, offsets and groups that are not eliminated."""
        result = Combination(dict(form.groups), dict(form.coordinates), dict(form.offsets))
        for group in reversed(self.order(list(form.groups))):
            c = result.groups.pop(group, 0)
            if c:
                result.add(self.definitions[group], c)
        return result
