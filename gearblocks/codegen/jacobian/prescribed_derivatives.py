"""Derivatives of prescribed motions, and of nonlinear rigid relations, by what they read, as numbers of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.assembly.kinematics import PrescribedRow
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.function import Argument, Function, column
from gearblocks.codegen.jacobian.law_derivatives import partial
from gearblocks.codegen.jacobian.row_values import Numbers
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.laws.rational import Exact, exact, exact_value

Slope = dict[Any, list[int]]
"""By symbol: the number of each instance."""


@dataclass(slots=True)
class MotionDerivatives:
    """What the speed, the acceleration and the angle of a group with prescribed motion, and the gain of each flange, change by.

    With the motion of the sources kept: speed and acceleration of the group by angles, speeds and states; the angle by
    states alone.
    """

    speed: Slope
    acceleration: Slope
    angle: Slope
    gains: dict[str, Slope]


def number_of(x: Any) -> Exact:
    """An expression without symbols as an exact number (of its double where it is irrational)."""
    x = sp.sympify(x)
    return exact_value(x, {}) if x.is_Rational else exact(float(x))


def prescribed_derivatives(
    code: BatchCode, number: int, rows: Sequence[PrescribedRow], numbers: Numbers
) -> tuple[MotionDerivatives, Function]:
    """The derivatives of prescribed motion `number` of a batch, and the function that computes those that are no numbers.

    rows: the prescribed motion of each instance. NotImplementedError where there is no formula.
    """
    motion, pool = code.prescribed[number], code.law.pool
    turning = {
        n: gain for n, gain in motion.gains.items() if code.batch.groups.get(n, [GROUND_GROUP])[0] != GROUND_GROUP
    }
    speed, acceleration = dict(partial(code, motion.velocity_bias)), dict(partial(code, motion.acceleration_bias))
    gains = {n: dict(partial(code, gain)) for n, gain in turning.items()}
    for n, slopes in gains.items():
        for x, slope in slopes.items():
            speed[x] = speed.get(x, 0) + slope * pool.symbol("w", n, f"w_{n}")
            acceleration[x] = acceleration.get(x, 0) + slope * pool.symbol("alpha", n, f"alpha_{n}")
    angle = {} if motion.angle is None else dict(partial(code, motion.angle))
    writer = _Writer(code, number, numbers)
    scales = [d.scale for d in rows]
    made = MotionDerivatives(
        writer.take(speed, scales), writer.take(acceleration, scales),
        writer.take({x: slope for x, slope in angle.items() if pool.roles[x].role == "state"}, scales),
        {n: writer.take(slopes, [d.factors[n][1] for d in rows]) for n, slopes in gains.items()},
    )  # fmt: skip
    return made, writer.function()


class _Writer:
    """Gives derivatives their offsets among the numbers."""

    def __init__(self, code: BatchCode, number: int, numbers: Numbers) -> None:
        self.code, self.name, self.numbers = code, f"prescribed_derivatives{number}", numbers
        self.targets: list[Assignment] = []
        self.args: list[Argument] = []

    def take(self, slopes: Mapping[Any, Any], scales: Sequence[Exact]) -> Slope:
        """The offsets of derivatives, each times the scale of its instance."""
        found: Slope = {}
        for x, slope in slopes.items():
            if slope.is_number:
                found[x] = [self.numbers.constant(number_of(slope) * scale) for scale in scales]
                continue
            i = len(self.targets)
            found[x] = [self.numbers.place() for _ in scales]
            name = f"{self.code.batch.name}_{self.name}"
            self.args.append(Argument("int", f"at{i}", column(f"{name}_at{i}", found[x])))
            self.args.append(Argument("double", f"by{i}", column(f"{name}_by{i}", [float(scale) for scale in scales])))
            self.targets.append(Assignment(Operand(Role.COEFFICIENTS, f"at{i}"), "=", slope, factor=f"by{i}"))
        return found

    def function(self) -> Function:
        """The function that computes them."""
        function = self.code.function(self.name, self.targets)
        function.take(self.args)
        return function
