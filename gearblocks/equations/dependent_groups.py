"""Equations of a train whose shafts follow others, for people: everything over the shafts that turn by themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.assembly.tables import Assembly
from gearblocks.laws.prescribed_motion import Drive
from gearblocks.laws.rational import Exact


@dataclass(slots=True)
class Carried:
    """angles, speeds: of followers, over free ones; rows: their speeds' slopes; surplus: accelerations besides.

    n: number of free shafts (with a speed of their own, or without inertia). paced: rates of angles of which only the
    speed is prescribed.
    """

    n: int
    n_groups: int
    symbols: dict[Any, Any] = field(default_factory=dict)
    rows: list[dict[int, Any]] = field(default_factory=list)
    surplus: list[Any] = field(default_factory=list)
    paced: dict[Any, Any] = field(default_factory=dict)

    def put(self, expr: Any) -> Any:
        """An expression over free shafts."""
        return sp.sympify(expr).xreplace(self.symbols) if self.symbols else expr

    def balance(self, masses: Sequence[Any], torques: Sequence[Any]) -> tuple[Any, list[Any]]:
        """Mass matrix and right side from the inertias and torques of all groups."""
        mass = sp.zeros(self.n, self.n)
        forcing = [sp.Integer(0)] * self.n
        for group in range(self.n_groups):
            torque = self.put(torques[group])
            for i, a in self.rows[group].items():
                forcing[i] += a * (torque - masses[group] * self.surplus[group])
                for j, b in self.rows[group].items():
                    mass[i, j] += a * b * masses[group]
        return mass, forcing

    def inertia(self, mass: Any, group: int) -> Any:
        """The inertia that a torque on a group meets: 1 / (row M^-1 row')."""
        row = self.rows[group]
        speeds = [i for i in range(self.n) if any(mass[i, j] != 0 for j in range(self.n))]
        if not row or not set(row) <= set(speeds):
            return sp.Symbol("oo", real=True)
        block = _block(mass, set(row))
        vector = sp.Matrix([row.get(i, 0) for i in block])
        return 1 / (vector.T * mass.extract(block, block).inv() * vector)[0, 0]


def _block(mass: Any, rows: set[int]) -> list[int]:
    """The shafts that are coupled to some by the mass matrix, these included."""
    found = set(rows)
    while new := {j for i in found for j in range(mass.shape[0]) if mass[i, j] != 0} - found:
        found |= new
    return sorted(found)


def carry(
    assembly: Assembly, drives: Mapping[tuple[int, int], Drive], q: Sequence[Any], v: Sequence[Any],
    offset: Callable[[str], Any],
) -> Carried:  # fmt: skip
    """How followers follow, in the symbols q, v of all groups."""
    n = assembly.n_speeds + assembly.n_hidden
    carried = Carried(n, assembly.n_groups)
    carried.rows = [{i: sp.Integer(1)} if i < n else {} for i in range(assembly.n_groups)]
    carried.surplus = [sp.Integer(0)] * assembly.n_groups
    for f in assembly.followers:
        speed: Any = sp.Integer(0)
        if f.row is not None:
            gains = {g: _rational(c) for g, c in f.row.groups.items()}
            angle: Any = sum((c * q[g] for g, c in gains.items()), sp.Integer(0))
            angle += sum((_rational(c) * offset(path) for path, c in f.row.offsets.items()), sp.Integer(0))
        else:
            assert f.drive is not None
            drive, scale = drives[f.drive.component, f.drive.number], _rational(f.drive.scale)
            gains = {g: carried.put(drive.gains[name]) * _rational(c) for name, (g, c) in f.drive.factors.items()}
            angle = None if drive.angle is None else scale * drive.angle
            speed += carried.put(scale * drive.bias)
            carried.surplus[f.group] = carried.put(scale * drive.surplus)
        for source, c in gains.items():
            speed += c * carried.put(v[source])
            carried.surplus[f.group] += c * carried.surplus[source]
            for i, a in carried.rows[source].items():
                carried.rows[f.group][i] = carried.rows[f.group].get(i, 0) + c * a
        carried.symbols[v[f.group]] = speed
        if angle is None:
            carried.paced[q[f.group]] = speed
        else:
            carried.symbols[q[f.group]] = carried.put(angle)
    return carried


def _rational(c: Exact) -> Any:
    return sp.Rational(c.numerator, c.denominator)
