"""The unknowns of implicit methods where gains change with the position: rows whose numbers are computed in every matrix.

A row says how something changes with the unknowns; entry -1 - s stands for what a step adds to the kinematic state s
besides its rate: the state changes by g (r_s + B x). Let A be the gains of all groups on the speeds, T the torques of the
laws and m the inertias. The equations are A' (T - m alpha) = 0 with alpha at fixed accelerations of the speeds, and

    speeds         dw_f = sum gain dw + d(sum gain w + velocity bias)/d(phi, w of blocks)
    accelerations  da_f = sum gain da + d(sum gain alpha + acceleration bias)/d(phi, w, states)
    torques        a gain that changes also changes the torque that f adds to its source

so that the derivatives of the mass matrix need no form of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from typing import Any

from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.kinematics import DependentGroup, PrescribedRow
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.function import Function
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.jacobian.prescribed_derivatives import (
    MotionDerivatives,
    Slope,
    number_of,
    prescribed_derivatives,
)
from gearblocks.codegen.jacobian.row_values import Numbers, Row
from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.laws.rational import Exact

Term = tuple[int, int, int]
"""4 place + (0 diag, 1 lower, 2 upper, 3 kept), and the two numbers that a value is multiplied with."""


class Varying:
    """Numbers of the unknowns, and rows of everything that laws read. Interface as Unknowns, and:

    numbers; functions: of the derivatives of prescribed motions; gains: (offset, number of the gain); accelerations: by group;
    reduced: (group whose torque goes to its source, equation of the source, change of the gain); kept: by (unknown, kinematic
    state) the number of the entry of dG/ds.
    """

    def __init__(self, g: Generator) -> None:
        assembly, lay = g.assembly, g.lay
        self.assembly, self.lay, self.plain = assembly, lay, False
        self.angles = assembly.angles if lay.angle0 < lay.n else []
        self.n_kinematic = assembly.n_steady
        if self.n_kinematic == lay.n_coordinates and assembly.steady.issuperset(self.angles):
            self.n_kinematic += len(self.angles)
        self.first_speed = lay.v0 - self.n_kinematic
        self.count = lay.n + assembly.n_massless - self.n_kinematic
        damped = g.massless.damped if g.massless is not None else []
        sprung = {self.first_speed + assembly.n_speeds + i for i, by_damper in enumerate(damped) if not by_damper}
        self.by_rate = bool(sprung)
        self.numbers = Numbers()
        self.one, self.zero, self.g = self.numbers.constant(1), self.numbers.constant(0), self.numbers.place()
        self.functions: list[Function] = []
        self.gains: list[tuple[int, int]] = []
        self.kept: dict[tuple[int, int], int] = {}
        self._place = {group: i for i, (group, _) in enumerate(assembly.definitions)}
        self._angles: dict[int, Row] = {}
        self._kinematic: dict[int, Row] = {}
        self._rates: dict[int, Row] = {}
        self._loops: dict[int, Row] = {}
        self._prescribed = _prescribed(self, g)
        self._group_motions(sprung)

    # -- rows of groups -----------------------------------------------------------------------------------------------

    def _group_motions(self, sprung: set[int]) -> None:
        """Gains on the speeds, speeds and accelerations of all groups, those of constant gains first. sprung: groups between
        springs alone, whose equation is the rate of the balance (no prescribed motion moves with one)."""
        a, n = self.assembly, self.assembly.n_groups
        free = range(a.n_speeds + a.n_massless)
        self.torques: list[Row] = [{self.first_speed + i: self.one} if i in free else {} for i in range(n)]
        self.speeds: list[Row] = [dict(row) for row in self.torques]
        self.accelerations: list[Row] = [{} for _ in range(n)]
        for f in a.dependent_groups:
            self.torques[f.group] = self.numbers.combine((c, self.torques[s]) for s, c in self._gains(f))
        self.torque_rates = [{x: c for x, c in row.items() if x in sprung} for row in self.torques]
        self.torques = [{x: c for x, c in row.items() if x not in sprung} for row in self.torques]
        for f in a.dependent_groups:
            if f.group in a.steady:
                self.speeds[f.group] = self._speed(f)
        for group, row in a.definitions:
            if isinstance(row, PrescribedRow):
                self.angle(group)
        self.reduced: list[tuple[int, Row, Row]] = []
        for f in a.dependent_groups:
            if f.group not in a.steady:
                self.speeds[f.group] = self._speed(f)
            terms = [(c, self.accelerations[s]) for s, c in self._gains(f)]
            if f.prescribed is not None:
                terms += self._prescribed[f.group].terms("acceleration")
                for source, change in self._prescribed[f.group].changes():
                    self.reduced.append((f.group, self.torques[source], self.numbers.combine(change)))
            self.accelerations[f.group] = self.numbers.combine(terms)
        with_inertia = a.with_inertia | set(range(a.n_speeds))
        self.with_inertia = [row if group in with_inertia else {} for group, row in enumerate(self.torques)]

    def _gains(self, f: DependentGroup) -> list[tuple[int, int]]:
        """(source, offset of the gain)."""
        if f.row is not None:
            return [(source, self.numbers.constant(c)) for source, c in f.row.groups.items()]
        return self._prescribed[f.group].gains

    def _speed(self, f: DependentGroup) -> Row:
        terms = [(c, self.speeds[s]) for s, c in self._gains(f)]
        return self.numbers.combine(
            terms + (self._prescribed[f.group].terms("speed") if f.prescribed is not None else [])
        )

    def angle(self, group: int) -> Row:
        """How the angle of a group changes."""
        if group in self._angles:
            return self._angles[group]
        total = Combination({group: 1})
        waiting = [-self._place[group]] if group in self._place else []
        while waiting:  # the last definition first: all that it reads come before it
            at, row = self.assembly.definitions[-heappop(waiting)]
            if isinstance(row, Combination) and (c := total.groups.pop(at, 0)):
                total.add(row, c)
                for source in row.groups.keys() & self._place.keys():
                    heappush(waiting, -self._place[source])
        terms = [(self.numbers.constant(c), self.coordinate(j)) for j, c in total.coordinates.items()]
        terms += [(self.numbers.constant(c), self._base(s)) for s, c in total.groups.items()]
        return self._angles.setdefault(group, self.numbers.combine(terms))

    def _base(self, group: int) -> Row:
        """The same for an angle that is a state, or prescribed."""
        if group not in self._place:
            return self._moved(self.lay.angle0 + self.angles.index(group))
        if group not in self._angles:
            motion = self._prescribed[group]
            terms = [(c, self.angle(s)) for s, c in motion.gains] + motion.terms("angle")
            self._angles[group] = self.numbers.combine(terms)
        return self._angles[group]

    def coordinate(self, j: int) -> Row:
        """How coordinate j changes."""
        return self._moved(j)

    def _moved(self, place: int) -> Row:
        """How a coordinate or an angle changes, by its offset in y."""
        if place >= self.n_kinematic:
            return self._state(place)
        if place not in self._kinematic:
            row = self.numbers.combine([(self.g, self.rate(place))])
            self._kinematic[place] = {**row, -1 - place: self.one}
        return self._kinematic[place]

    def rate(self, place: int) -> Row:
        """How the rate of a coordinate or an angle changes."""
        if place >= self.lay.n_coordinates:
            return self.speeds[self.angles[place - self.lay.angle0]]
        if place not in self._rates:
            row = self.assembly.rows[place]
            self._rates[place] = self.numbers.combine(
                (self.numbers.constant(c), self.speeds[i]) for i, c in row.items()
            )
        return self._rates[place]

    def _state(self, place: int) -> Row:
        return {place - self.n_kinematic: self.one}

    def loop(self, k: int) -> Row:
        """How a combination that closes a loop changes."""
        if k not in self._loops:
            c = self.assembly.dependents[k]
            terms = [(self.numbers.constant(a), self.coordinate(j)) for j, a in c.coordinates.items()]
            terms += [(self.numbers.constant(a), self.angle(i)) for i, a in c.groups.items()]
            self._loops[k] = self.numbers.combine(terms)
        return self._loops[k]

    # -- what a batch reads -------------------------------------------------------------------------------------------

    def columns(self, code: BatchCode, x: Any) -> list[Row]:
        """The unknowns behind what a law reads, for each instance."""
        meaning, batch = code.law.pool.roles[x], code.batch
        if meaning.role == "state":
            return [self._state(self.lay.state0[code.number, meaning.of] + e) for e in range(code.n)]
        if meaning.role == "coordinate":
            read = self.loop if batch.dependent[meaning.of] else self.coordinate
            return [read(j) for j in batch.sources[meaning.of]]
        if meaning.role == "phi":
            return [self.angle(group) for group in batch.groups[meaning.of]]
        return [self.speeds[group] for group in batch.groups[meaning.of]]

    def equations(self, code: BatchCode, x: Any) -> list[Row]:
        """The equations that the torque on a flange, its rate of change or the rate of a state belongs to."""
        meaning = code.law.pool.roles[x]
        if meaning.role == "state":
            return self.columns(code, x)
        rows = self.torque_rates if meaning.role == "torque_rate" else self.torques
        return [rows[i] for i in code.batch.groups[meaning.of]]

    def rates(self) -> Iterator[tuple[Row, Row]]:
        """(equation, row) of every coordinate and angle that is no kinematic state."""
        for place in range(self.n_kinematic, self.lay.n_coordinates + len(self.angles)):
            yield self._state(place), self.rate(place)

    def own(self) -> Iterator[tuple[Row, Row]]:
        """(equation, row) of everything that comes from the motions themselves."""
        yield from self.rates()
        yield from zip(self.with_inertia, self.accelerations, strict=True)
        yield from ((row, change) for _, row, change in self.reduced)

    def kinematic_rates(self) -> list[dict[int, Exact]]:
        """B: rates of the kinematic states over the unknowns."""
        rows = [self.rate(place) for place in range(self.n_kinematic)]
        if not all(map(self.numbers.is_constant, rows)):
            raise NotImplementedError("a kinematic state whose rate is no fixed combination")
        return [{x: self.numbers.start[i] for x, i in row.items()} for row in rows]

    def entry(self, pattern: Pattern, row: Row, other: Row) -> list[Term]:
        """Where a value between two rows goes."""
        found: list[Term] = []
        for i, a in row.items():
            for j, b in other.items():
                if j < 0:
                    key = 4 * self.kept.setdefault((i, -1 - j), len(self.kept)) + 3
                else:
                    key = 4 * i if i == j else 4 * pattern.place(i, j) + (1 if pattern.is_lower(i, j) else 2)
                found.append((key, a, b))
        return found


# -- prescribed motions -----------------------------------------------------------------------------------------------


class _Prescribed:
    """One group with prescribed motion. gains: (source, offset of the gain)."""

    def __init__(
        self, unknowns: Varying, g: Generator, number: int, row: PrescribedRow, slopes: MotionDerivatives
    ) -> None:
        self.unknowns, self.row, self.slopes = unknowns, row, slopes
        self.code = next(code for code in g.codes if row.component in code.batch.components)
        self.e = self.code.batch.components.index(row.component)
        law_gains = self.code.law.prescribed[row.number].gains
        self.gains: list[tuple[int, int]] = []
        for flange, (group, factor) in row.factors.items():
            if law_gains[flange].is_number:
                place = unknowns.numbers.constant(number_of(law_gains[flange]) * factor)
            else:
                assert g.dependent is not None
                place = unknowns.numbers.place()
                unknowns.gains.append((place, g.dependent.gain_index[number, flange]))
            self.gains.append((group, place))

    def terms(self, what: str) -> list[tuple[int, Row]]:
        """What the speed, the acceleration or the angle changes by while the sources keep their motion."""
        return self._rows(getattr(self.slopes, what))

    def changes(self) -> Iterator[tuple[int, list[tuple[int, Row]]]]:
        """(source, what its gain changes by)."""
        for flange, (group, _) in self.row.factors.items():
            if self.slopes.gains[flange]:
                yield group, self._rows(self.slopes.gains[flange])

    def _rows(self, slopes: Slope) -> list[tuple[int, Row]]:
        numbers, found = self.unknowns.numbers, []
        for x, places in slopes.items():
            row = self.unknowns.columns(self.code, x)[self.e]
            meaning = self.code.law.pool.roles[x]
            if meaning.role in ("w", "phi"):
                row = numbers.combine([(numbers.constant(self.code.batch.gains[meaning.of][self.e]), row)])
            found.append((places[self.e], row))
        return found


def _prescribed(unknowns: Varying, g: Generator) -> dict[int, _Prescribed]:
    """Prescribed motions by dependent group, and the functions of their derivatives."""
    order = {
        (f.prescribed.component, f.prescribed.number): i
        for i, f in enumerate(g.assembly.dependent_groups)
        if f.prescribed is not None
    }
    found: dict[int, _Prescribed] = {}
    for code in g.codes:
        for number in range(len(code.prescribed)):
            places = [order[c, number] for c in code.batch.components]
            rows = [d for i in places if (d := g.assembly.dependent_groups[i].prescribed) is not None]
            slopes, function = prescribed_derivatives(code, number, rows, unknowns.numbers)
            unknowns.functions.append(function)
            found |= {d.group: _Prescribed(unknowns, g, i, d, slopes) for i, d in zip(places, rows, strict=True)}
    return found
