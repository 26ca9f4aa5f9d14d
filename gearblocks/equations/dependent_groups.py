"""Dependent groups written out: the equations of motion over the independent groups alone.

    w = K w_i + b,  w' = K w_i' + a      K: gains, b: velocity bias, a: acceleration bias
    K' J K w_i' = K' (tau - J a)         virtual work of the inertias and torques of all groups

Knows nothing of blocks: inertias and torques are expressions by group.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.assembly.tables import Assembly
from gearblocks.laws.prescribed_motion import PrescribedMotion
from gearblocks.laws.rational import Exact


@dataclass(slots=True)
class DependentGroups:
    """symbols: angles and speeds of dependent groups over the others; gains: rows of K; acceleration_bias: a.

    n: number of groups that are not dependent (independent or massless). rates: of angles of which only the speed is
    prescribed. angles: those of bodies that are no linear function of others, by their symbols.
    """

    n: int
    n_groups: int
    symbols: dict[Any, Any] = field(default_factory=dict)
    gains: list[dict[int, Any]] = field(default_factory=list)
    acceleration_bias: list[Any] = field(default_factory=list)
    rates: dict[Any, Any] = field(default_factory=dict)
    angles: dict[Any, Any] = field(default_factory=dict)

    def put(self, expr: Any) -> Any:
        """An expression over groups that are not dependent."""
        return sp.sympify(expr).xreplace(self.symbols) if self.symbols else expr

    def balance(self, masses: Sequence[Any], torques: Sequence[Mapping[str, Any]]) -> tuple[Any, list[dict[str, Any]]]:
        """K' J K, and the terms of K' (tau - J a) by the part of the train that they come from ("": of inertias), from the
        inertias and torques of all groups."""
        mass = sp.zeros(self.n, self.n)
        forcing: list[dict[str, Any]] = [{} for _ in range(self.n)]
        for group in range(self.n_groups):
            terms = {path: self.put(torque) for path, torque in torques[group].items()}
            if self.acceleration_bias[group] != 0:
                terms[""] = -masses[group] * self.acceleration_bias[group]
            for i, a in self.gains[group].items():
                for path, term in terms.items():
                    forcing[i][path] = forcing[i].get(path, 0) + a * term
                for j, b in self.gains[group].items():
                    mass[i, j] += a * b * masses[group]
        return mass, forcing

    def inertia(self, mass: Any, group: int) -> Any:
        """The inertia that a torque on a group meets: 1 / (k M^-1 k'), k: its row of K."""
        row = self.gains[group]
        speeds = [i for i in range(self.n) if any(mass[i, j] != 0 for j in range(self.n))]
        if not row or not set(row) <= set(speeds):
            return sp.oo
        block = _block(mass, set(row))
        vector = sp.Matrix([row.get(i, 0) for i in block])
        return 1 / (vector.T * mass.extract(block, block).inv() * vector)[0, 0]


def _block(mass: Any, rows: set[int]) -> list[int]:
    """The groups that are coupled to some by the mass matrix, these included."""
    found = set(rows)
    while new := {j for i in found for j in range(mass.shape[0]) if mass[i, j] != 0} - found:
        found |= new
    return sorted(found)


def over_independent_groups(
    assembly: Assembly, prescribed: Mapping[tuple[int, int], PrescribedMotion], q: Sequence[Any], v: Sequence[Any],
    scales: Sequence[Any], offset: Callable[[str], Any], body: Callable[[int], Any],
) -> DependentGroups:  # fmt: skip
    """Dependent groups over the others, in the symbols q, v of all groups, which scales take to those of the assembly.

    offset: the symbol of a ground angle; body: that of the angle of a body of a group, None where it has none.
    """
    n = assembly.n_speeds + assembly.n_massless
    found = DependentGroups(n, assembly.n_groups)
    found.gains = [{i: sp.Integer(1)} if i < n else {} for i in range(assembly.n_groups)]
    found.acceleration_bias = [sp.Integer(0)] * assembly.n_groups
    for f in assembly.dependent_groups:
        own = 1 / scales[f.group]
        speed: Any = sp.Integer(0)
        if f.row is not None:
            gains = {g: rational(c) * scales[g] * own for g, c in f.row.groups.items()}
            angle: Any = sum((c * q[g] for g, c in gains.items()), sp.Integer(0))
            angle += sum((rational(c) * own * offset(path) for path, c in f.row.offsets.items()), sp.Integer(0))
        else:
            assert f.prescribed is not None
            motion, scale = prescribed[f.prescribed.component, f.prescribed.number], rational(f.prescribed.scale) * own
            factors = f.prescribed.factors
            gains = {
                g: found.put(motion.gains[name]) * rational(c) * scales[g] * own for name, (g, c) in factors.items()
            }
            angle = None if motion.angle is None else scale * motion.angle
            speed += found.put(scale * motion.velocity_bias)
            found.acceleration_bias[f.group] = found.put(scale * motion.acceleration_bias)
        for source, c in gains.items():
            speed += c * found.put(v[source])
            found.acceleration_bias[f.group] += c * found.acceleration_bias[source]
            for i, a in found.gains[source].items():
                found.gains[f.group][i] = found.gains[f.group].get(i, 0) + c * a
        found.symbols[v[f.group]] = speed
        if angle is None:
            found.rates[q[f.group]] = speed
        elif f.row is None and gains and (own_angle := body(f.group)) is not None:
            found.symbols[q[f.group]], found.angles[own_angle] = own_angle, found.put(angle)
        else:
            found.symbols[q[f.group]] = found.put(angle)
    return found


def rational(c: Exact) -> Any:
    """An exact number in sympy."""
    return sp.Rational(c.numerator, c.denominator)
