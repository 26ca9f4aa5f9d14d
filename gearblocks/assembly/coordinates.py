"""Relative coordinates: which deflections are states, which are dependent, and where absolute angles come from.

    u_j = sum of c_ji phi_i     independent forms become states u; a form that closes a loop is an exact combination of them

Each compliant element asks for one linear form of the group angles. Absolute angles remain only for groups that no form
determines. Knows nothing of what acts along a form.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Mapping

from gearblocks.assembly.elimination import Combination, Elimination, Row, solved
from gearblocks.train.disjoint_sets import DisjointSets

_ROUNDING = 1e-14  # of the sizes of what cancels


class Coordinates:
    """Takes forms one by one; `definitions`: each eliminated group angle over what is left.

    given: groups with a prescribed angle, with those that they depend on: they are never
    eliminated, and none of these is defined by them. rows: the forms that are coordinates.
    first, last: groups that are eliminated before all others (their angle follows from others more exactly than from their
    speed: massless ones), and after all others (their speed is prescribed).
    """

    def __init__(
        self, given: Mapping[int, Collection[int]] | None = None, first: Container[int] = (), last: Container[int] = ()
    ) -> None:
        self.given = given or {}
        self._first, self._last = first, last
        self._has_ranks = bool(first) or bool(last)
        self.rows: list[Row] = []
        self._forms: list[Combination] = []
        self._elimination = Elimination(_ROUNDING)
        self._met = DisjointSets[int]()  # groups that stand in one form, directly or through others

    @property
    def definitions(self) -> dict[int, Combination]:
        """Of the eliminated group angles."""
        return self._elimination.definitions

    def take(self, form: Combination) -> int | Combination:
        """The number of a new coordinate, or what the form is a combination of."""
        left = self._elimination.left(form.groups)
        free: Collection[int] = left
        if self.given:
            free = left.keys() - self.given.keys() - self._upstream([g for g in left if g in self.given])
        if not free:
            whole = self._elimination.reduced(form)
            whole.groups = {g: c for g, c in whole.groups.items() if g in left}
            return whole
        apart = self._join(list(form.groups))
        raw = [g for g in form.groups if g in free and g not in self.definitions] if apart else []
        if raw and self.given:  # what cancels in the reduced form still stands in the definitions that the form names
            behind = self._upstream(self._prescribed_behind(form))
            raw = [g for g in raw if g not in behind]
        pivot = raw[-1] if raw else next(g for g in left if g in free)
        for g in (*reversed(raw), *(g for g in left if g in free)) if self._has_ranks else ():
            pivot = g if self._rank(g) < self._rank(pivot) else pivot
        base = form if pivot in raw else self._elimination.reduced(form)
        number = len(self.rows)
        minus_itself = Combination(base.groups, {number: -1, **base.coordinates}, base.offsets)
        self._elimination.solve(minus_itself, pivot)
        self.rows.append(form.groups)
        self._forms.append(form)
        return number

    def outward(self) -> dict[int, Combination]:
        """`definitions`, each by its own form alone: from the ground and from the groups that no form determines outwards, so
        that no angle is a difference of coordinates that it does not depend on. `definitions` themselves where forms can only
        be solved together, or (without circles) where angles are prescribed."""
        if self.given:
            return self._without_circles()
        definitions = self.definitions
        naming: dict[int, list[int]] = {}
        # unknown groups of a form: how many, and their sum
        open_, names = [0] * len(self._forms), [0] * len(self._forms)
        for number, form in enumerate(self._forms):
            for g in form.groups:
                if g in definitions:
                    naming.setdefault(g, []).append(number)
                    open_[number] += 1
                    names[number] += g
        found: dict[int, tuple[int, Combination]] = {}
        ready = [number for number, left in enumerate(open_) if left == 1]
        for number in ready:
            if not open_[number]:
                return definitions
            pivot = names[number]
            found[number] = pivot, self._solved(number, pivot)
            for other in naming[pivot]:
                open_[other] -= 1
                names[other] -= pivot
                if open_[other] == 1 and other not in found:
                    ready.append(other)
        return dict(found[i] for i in sorted(found)) if len(found) == len(open_) else definitions

    def _without_circles(self) -> dict[int, Combination]:
        """`definitions`; in full where a prescribed angle reads a group that names it in turn: what cancels in full may stand
        in the parts."""
        found = dict(self.definitions)
        for group, sources in self.given.items():
            if group in self._named(sources):
                found |= {g: self._elimination.reduced(Combination({g: 1})) for g in sources if g in found}
        return found

    def _named(self, sources: Iterable[int]) -> set[int]:
        """The groups that these name, themselves, by their definitions or as prescribed angles."""
        found: set[int] = set()
        stack = list(sources)
        while stack:
            g = stack.pop()
            if g not in found:
                found.add(g)
                stack += self.definitions[g].groups if g in self.definitions else self.given.get(g, ())
        return found

    def _solved(self, number: int, pivot: int) -> Combination:
        """A group by the form of a coordinate."""
        form = self._forms[number]
        return solved(Combination(form.groups, {number: -1, **form.coordinates}, form.offsets), pivot)

    def _rank(self, group: int) -> int:
        return 0 if group in self._first else 2 if group in self._last else 1

    def _upstream(self, prescribed: list[int]) -> set[int]:
        """The groups, not eliminated, that the angles of prescribed groups depend on."""
        found: set[int] = set()
        stack = list(prescribed)
        while stack:
            sources = self.given.get(stack.pop(), ())
            new = {g for source in sources for g in self._elimination.gains(source)} - found
            found |= new
            stack += new
        return found

    def _prescribed_behind(self, form: Combination) -> list[int]:
        """The prescribed groups that a form names, itself or through definitions."""
        named = set(form.groups)
        for pivot in self._elimination.order(form.groups):
            named |= self.definitions[pivot].groups.keys()
        return [g for g in named if g in self.given]

    def _join(self, groups: list[int]) -> bool:
        """Notes that a form joins these groups. True when none of them was joined to another one before, so that none
        can be defined by another; else only the expanded form is safe from going round in a circle."""
        roots = {self._met.root(g) for g in groups}
        for g in groups[1:]:
            self._met.join(g, groups[0])
        return len(roots) == len(groups)
