"""The unknowns of implicit methods: states of blocks, then speeds of their own, then those of shafts without inertia."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gearblocks.assemble import Assembly
from gearblocks.batchcode import BatchCode
from gearblocks.coordinates import Combination
from gearblocks.generator import Generator
from gearblocks.kinematics import Driven
from gearblocks.laws import exact_value
from gearblocks.rational import Exact
from gearblocks.symbols import MOVING

Row = dict[int, Exact]
"""Something of a group as a combination: of unknowns, or of numbers of speeds."""


class Unknowns:
    """Numbers of the unknowns, and how the speeds and torques of groups belong to them.

    n_simple: states before them; first_speed: the unknown of the first speed. speeds: of each group, over unknowns;
    torques, growths: where the torque on a group counts, and the rate of it (shafts that springs alone hold).
    NotImplementedError for motions whose gains or accelerations change with the state.
    """

    def __init__(self, g: Generator) -> None:
        lay, assembly = g.lay, g.assembly
        for code in g.codes:
            _check_drives(code)
        self.lay, self.plain = lay, assembly.plain
        self.n_simple = lay.n_coordinates + (len(assembly.angles) if lay.angle0 < lay.n else 0)
        self.first_speed = lay.v0 - self.n_simple
        self.count = lay.n + assembly.n_hidden - self.n_simple
        self.rows = speed_rows(assembly)
        self.speeds = [{self.first_speed + i: a for i, a in row.items()} for row in self.rows]
        damped = g.massless.damped if g.massless is not None else []
        held = {self.first_speed + assembly.n_speeds + i for i, by_damper in enumerate(damped) if not by_damper}
        self.by_rate = bool(held)
        self.torques = [{i: a for i, a in row.items() if i not in held} for row in self.speeds] if held else self.speeds
        self.growths = [{i: a for i, a in row.items() if i in held} for row in self.speeds] if held else []

    def columns(self, code: BatchCode, x: Any) -> list[Row]:
        """The unknowns behind a flange speed or state of each instance."""
        return self._of(code, x, self.speeds)

    def equations(self, code: BatchCode, x: Any) -> list[Row]:
        """The equations that the torque on a flange, its rate of change or the rate of a state belongs to."""
        is_rate = code.law.pool.slots[x].role == "growth"
        return self._of(code, x, self.growths if is_rate else self.torques)

    def _of(self, code: BatchCode, x: Any, of_group: list[Row]) -> list[Row]:
        slot = code.law.pool.slots[x]
        if slot.role == "state":
            first = self.lay.state0[code.number, slot.of] - self.n_simple
            return [{first + e: 1} for e in range(code.n)]
        return [of_group[group] for group in code.batch.groups[slot.of]]


def speed_rows(assembly: Assembly) -> list[Row]:
    """The speed of each group over the speeds of free groups, by number; what moves by itself is left aside."""
    free = assembly.n_speeds + assembly.n_hidden
    rows: list[Row] = [{group: 1} if group < free else {} for group in range(assembly.n_groups)]
    for f in assembly.followers:  # each after what it follows
        sources = f.row.groups if f.row is not None else driven_row(assembly, f.drive)
        total = Combination()
        for source, c in sources.items():
            total.add(Combination(rows[source]), c)
        rows[f.group] = total.groups
    return rows


def driven_row(assembly: Assembly, drive: Driven | None) -> Mapping[int, Exact]:
    """The constant gains of a drive on the groups that it reads."""
    assert drive is not None
    law = next(b.law for b in assembly.batches if drive.component in b.components)
    total = Combination()
    for flange, (group, factor) in drive.factors.items():
        total.add(Combination({group: factor}), exact_value(law.drives[drive.number].gains[flange], {}))
    return total.groups


def tilts(assembly: Assembly) -> list[Mapping[int, Exact]]:
    """How defined angles change with the angles of other groups, drives included."""
    rows = (row for _, row in assembly.definitions)
    return [row.groups if isinstance(row, Combination) else driven_row(assembly, row) for row in rows]


def _check_drives(code: BatchCode) -> None:
    for drive in code.drives:
        level = max(code.law.pool.level(drive.bias), code.law.pool.level(drive.surplus))
        if level == MOVING or not all(gain.is_number for gain in drive.gains.values()):
            raise NotImplementedError(f"the motion that '{code.paths[0]}' prescribes changes with the state")
