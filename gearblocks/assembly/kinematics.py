"""Dependent groups: how their motion follows from that of others by rigid constraints and prescribed motions.

    A phi + B offsets = 0    each row solved for one group of least reluctance;    phi_d = F(t, phi_s) for prescribed motions

Rigid constraints of two groups have merged them before; left are rows over three and more (an ideal planetary)
and prescribed motions (a prescribed angle, a non-circular pair). Dependent groups are ordered, each after its sources;
the others are free. Knows nothing of inertia: reluctance says which group had better stay free.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from gearblocks.assembly.elimination import Combination, Elimination, dependency_order
from gearblocks.errors import ModelError
from gearblocks.laws.rational import Exact


@dataclass(frozen=True, slots=True)
class GroupRow:
    """A rigid constraint over groups: sum of coefficient * angle + sum of factor * parameter (a ground angle) = 0.

    grounded: whether one of its shafts is at the ground.
    """

    path: str
    coefficients: Mapping[int, Exact]
    offsets: Mapping[str, Exact]
    grounded: bool


@dataclass(frozen=True, slots=True)
class PrescribedRow:
    """Prescribed motion `number` of a component: its dependent group, and the groups that it reads.

    factors: by flange that is read: (group, what the gain of the law is multiplied with). scale: 1 / gain of the flange.
    rides: another of its flanges belongs to the dependent group too, which scale and factors allow for.
    """

    component: int
    number: int
    path: str
    group: int
    scale: Exact
    factors: Mapping[str, tuple[int, Exact]]
    by_speed: bool
    rides: bool = False


@dataclass(frozen=True, slots=True)
class DependentGroup:
    """A dependent group: by a row over other groups and parameters, or by a prescribed motion (row None)."""

    group: int
    row: Combination | None
    prescribed: PrescribedRow | None = None

    @property
    def sources(self) -> list[int]:
        """The groups that it depends on directly."""
        if self.row is not None:
            return list(self.row.groups)
        assert self.prescribed is not None
        return [group for group, _ in self.prescribed.factors.values()]


@dataclass(slots=True)
class Kinematics:
    """Dependent groups in an order in which each comes after its sources; new: whether each row says something new."""

    dependent_groups: list[DependentGroup] = field(default_factory=list)
    new: list[bool] = field(default_factory=list)

    @property
    def dependent(self) -> dict[int, DependentGroup]:
        """By group."""
        return {f.group: f for f in self.dependent_groups}


def solve_dependent(
    rows: Iterable[GroupRow], prescribed: Iterable[PrescribedRow],
    reluctance: Mapping[int, tuple[int, ...]], ground_angles: Mapping[str, float]
) -> Kinematics:  # fmt: skip
    """Solves every row for one of its groups, the one with the least reluctance (inertia, a given start, ...).

    ground_angles: values of the offsets. ModelError for contradictions, for a group whose motion is prescribed twice, and for
    rigid constraints that would have to be solved through a nonlinear one.
    """
    solver = _Solver(dict(reluctance), dict(ground_angles))
    for motion in prescribed:
        solver.prescribe(motion)
    rows = list(rows)
    for row in rows:
        for group in row.coefficients:
            solver.count[group] = solver.count.get(group, 0) + 1
    new = [solver.take(row) for row in rows]
    return solver.finish(new)


class _Solver:
    def __init__(self, reluctance: dict[int, tuple[int, ...]], ground_angles: dict[str, float]) -> None:
        self.reluctance, self.ground_angles = reluctance, ground_angles
        self.count: dict[int, int] = {}
        self.rows = Elimination()
        self.paths: dict[int, str] = {}  # of the component whose row was solved for a group
        self.prescribed: dict[int, PrescribedRow] = {}

    def prescribe(self, motion: PrescribedRow) -> None:
        """Notes a prescribed motion."""
        before = self.prescribed.setdefault(motion.group, motion)
        if before is not motion:
            raise ModelError(
                f"'{before.path}' and '{motion.path}' both prescribe the motion of one shaft; leave one of them out, or "
                f"put a compliant element between"
            )
        if motion.group in {group for group, _ in motion.factors.values()}:
            raise ModelError(
                f"'{motion.path}' prescribes a motion between shafts that are tied rigidly to each other; give one of the "
                f"ties compliance"
            )

    def take(self, row: GroupRow) -> bool:
        """Solves one row; False if it says nothing new."""
        left = self.rows.reduced(Combination(dict(row.coefficients), {}, dict(row.offsets)))
        if not left.groups:
            self._agree(row, left)
            return False
        upstream = self._upstream(g for g in left.groups if g in self.prescribed)
        free = [g for g in left.groups if g not in self.prescribed and g not in upstream]
        if not free:
            names = ", ".join(f"'{self.prescribed[g].path}'" for g in left.groups if g in self.prescribed)
            raise ModelError(
                f"the tie of '{row.path}' would have to hold through the prescribed or nonlinear motion of {names}; give "
                f"one of them compliance"
            )
        if len(left.groups) == 1 and not row.grounded:
            raise ModelError(self._contradiction(row))
        pivot = min(free, key=lambda g: (*self.reluctance[g], self.count.get(g, 0), g))
        self.rows.solve(left, pivot)
        self.paths[pivot] = row.path
        return True

    def _upstream(self, groups: Iterable[int]) -> set[int]:
        """Every group that the motion of these prescribed ones depends on."""
        found: set[int] = set()
        stack = list(groups)
        while stack:
            new = [s for s in self._sources(stack.pop()) if s not in found]
            found.update(new)
            stack.extend(new)
        return found

    def _sources(self, g: int) -> list[int]:
        """The groups that a group depends on directly."""
        found = self._dependent(g)
        return found.sources if found else []

    def _dependent(self, g: int) -> DependentGroup | None:
        if g in self.prescribed:
            return DependentGroup(g, None, self.prescribed[g])
        return DependentGroup(g, self.rows.definitions[g]) if g in self.rows.definitions else None

    def _agree(self, row: GroupRow, left: Combination) -> None:
        """A row that contains nothing new: the ground angles must satisfy it."""
        terms = [float(c) * self.ground_angles[path] for path, c in left.offsets.items()]
        if abs(sum(terms)) > 1e-12 * sum(map(abs, terms)):
            names = ", ".join(f"'{path.rpartition('.')[0]}'" for path in left.offsets)
            raise ModelError(
                f"the tie of '{row.path}' contradicts the angles that {names} hold (by {sum(terms):.9g} rad): change one"
            )

    def _contradiction(self, row: GroupRow) -> str:
        names = {row.path}
        stack = list(row.coefficients)
        while stack:
            g = stack.pop()
            if g in self.paths and self.paths[g] not in names:
                names.add(self.paths[g])
                stack.extend(self.rows.definitions[g].groups)
        loop = ", ".join(f"'{name}'" for name in sorted(names))
        return f"the ties of {loop} contradict each other: nothing could move; check their ratios and tooth counts"

    def finish(self, new: list[bool]) -> Kinematics:
        """Dependent groups, each after its sources."""
        result = Kinematics(new=new)
        dependent = {**self.rows.definitions, **self.prescribed}
        for g in dependency_order(dependent, dependent, self._sources):
            found = self._dependent(g)
            assert found is not None
            result.dependent_groups.append(found)
        self._circles(result)
        return result

    def _circles(self, result: Kinematics) -> None:
        """Refuses prescribed motions that depend on each other in a circle."""
        seen: set[int] = set()
        dependent = result.dependent
        for f in result.dependent_groups:
            if any(s in dependent and s not in seen for s in f.sources):
                names = ", ".join(f"'{d.path}'" for d in self.prescribed.values())
                raise ModelError(f"the motions prescribed by {names} depend on each other; give one of them compliance")
            seen.add(f.group)
