"""Prescribed motions: constraints solved for one flange, w = sum gain_f w_f + b and w' = sum gain_f w_f' + a.

b: velocity bias, dF/dt along time and states; a: acceleration bias, w' without the accelerations of the flanges. Constraints
that are linear with constant factors are rigid constraints instead. Knows nothing of trains, nor of what moves the other
flanges.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from gearblocks.errors import ModelError
from gearblocks.laws.derivative import derivative
from gearblocks.laws.functions import TableAt
from gearblocks.laws.symbols import CONSTANT, MOVING, Pool, time_symbol


@dataclass(slots=True)
class PrescribedMotion:
    """A prescribed motion of a flange: phi = angle, w = sum gains w + velocity_bias, w' = sum gains w' + acceleration_bias.

    angle: None where only the speed is prescribed. gains: by the other flanges.
    """

    flange: str
    gains: dict[str, Any]
    velocity_bias: Any
    acceleration_bias: Any
    angle: Any = None

    def map_rates(self, f: Callable[[Any], Any]) -> PrescribedMotion:
        """With f(expression) in place of gains, velocity bias and acceleration bias."""
        return replace(
            self,
            gains={n: f(g) for n, g in self.gains.items()},
            velocity_bias=f(self.velocity_bias),
            acceleration_bias=f(self.acceleration_bias),
        )


def written_out(zero: Any, unknowns: Set[Any]) -> Any:
    """A relation as a sum of products of the unknowns. What time alone moves and exponentials stay as they were given:
    multiplied out, exp(-((t - 17)/0.01)^2) would be inf times 0."""
    given: dict[Any, Any] = {}

    def hide(e: Any) -> Any:
        if isinstance(e, sp.exp) or (e.args and e.free_symbols.isdisjoint(unknowns) and e.has(time_symbol())):
            return given.setdefault(e, sp.Dummy(real=True))
        return e.func(*map(hide, e.args)) if e.args else e

    return sp.expand(hide(zero)).xreplace({dummy: e for e, dummy in given.items()})


def is_constant_tie(law: Any, flanges: Mapping[str, Any], zero: Any) -> bool:
    """Whether a relation of angles is a rigid constraint: sum c_f phi_f = 0, or = the start angle of the block."""
    slopes = [derivative(zero, f.phi) for f in flanges.values() if f.phi.is_Symbol]
    if any(law.pool.level(c) != CONSTANT for c in slopes):
        return False
    rest = zero.xreplace({f.phi: sp.Integer(0) for f in flanges.values()})
    meaning = law.pool.roles.get(-rest)
    return bool(rest == 0) or (meaning is not None and meaning.role == "own" and meaning.of in law.pool.starts)


def linear_tie(flanges: Mapping[str, Any], zero: Any) -> tuple[dict[str, Any], Any]:
    """Coefficients of the flange angles and the constant of a tie."""
    coefficients = {name: c for name, f in flanges.items() if (c := derivative(zero, f.phi)) != 0}
    return coefficients, zero.xreplace({f.phi: sp.Integer(0) for f in flanges.values()})


def prescribed_angle(
    law: Any, kind: str, flanges: Mapping[str, Any], zero: Any, rates: tuple[Any, Any] | None = None
) -> PrescribedMotion:
    """The prescribed motion phi = F(t, other angles) of a nonlinear relation, solved for the first flange in it that has a
    number as its factor. rates: its speed and acceleration, where they are given beside."""
    name, slope = _pivot(kind, zero, {n: f.phi for n, f in flanges.items()})
    flange = flanges[name]
    angle = -zero.xreplace({flange.phi: sp.Integer(0)}) / slope
    if rates is None:
        _check_smooth(law.pool, kind, angle)
    others = {n: f for n, f in flanges.items() if n != name}
    gains = {n: g for n, f in others.items() if (g := derivative(angle, f.phi)) != 0}
    if rates is not None:
        speed, acceleration = (sp.sympify(x) for x in rates)
        return PrescribedMotion(name, gains, speed, acceleration, angle)
    velocity_bias = _rate(law, kind, angle, {})
    by_gains = sum((g * others[n].w for n, g in gains.items()), sp.Integer(0))
    speeds = {f.phi: f.w for f in others.values()}
    acceleration_bias = _rate(law, kind, velocity_bias, speeds) + _rate(law, kind, by_gains, speeds)
    motion = PrescribedMotion(name, gains, velocity_bias, acceleration_bias, angle)
    if not law.pool.reading or all(g.is_number for g in gains.values()):
        return motion
    return _with_names(law, motion, {n: f.w for n, f in others.items()}, lambda e: _rate(law, kind, e, speeds))


def _with_names(
    law: Any, motion: PrescribedMotion, speeds: Mapping[str, Any], rate: Callable[[Any], Any]
) -> PrescribedMotion:
    """A prescribed motion for people: gains and velocity bias by their names, the acceleration bias by the rates of these."""
    number = str(len(law.prescribed) + 1) if law.prescribed else ""

    def named(letter: str, expr: Any, words: str, unit: str) -> tuple[Any, Any]:
        rates = {"1": "1/s", "rad/s": "rad/s2"}
        dots = law.pool.named(f"{letter}'", rate(expr), f"rate of the {words}", rates[unit])
        return law.pool.named(letter, expr, words, unit), dots

    gains, bias = {}, motion.velocity_bias
    acceleration: Any = sp.Integer(0)
    for name, gain in motion.gains.items():
        letter = f"K{number}" if len(motion.gains) == 1 else f"K{number}_{name}"
        gains[name], change = named(letter, gain, f"speed of {motion.flange} over that of {name}", "1")
        acceleration += change * speeds[name]
    if bias != 0:
        bias, change = named(f"b{number}", bias, f"speed of {motion.flange} in time", "rad/s")
        acceleration += change
    return PrescribedMotion(motion.flange, gains, bias, acceleration, motion.angle)


def prescribed_speed(law: Any, kind: str, flanges: Mapping[str, Any], zero: Any) -> PrescribedMotion:
    """The prescribed motion w = F(t, states) + sum gains w of a relation of speeds alone."""
    name, slope = _pivot(kind, zero, {n: f.w for n, f in flanges.items()})
    speed = -zero.xreplace({flanges[name].w: sp.Integer(0)}) / slope
    gains = {n: g for n, f in flanges.items() if n != name and (g := derivative(speed, f.w)) != 0}
    if any(g.free_symbols for g in gains.values()):
        raise ModelError(f"{kind}: the prescribed speed '{zero}' is not linear in the flange speeds")
    velocity_bias = speed.xreplace({f.w: sp.Integer(0) for f in flanges.values()})
    steps = any(law.pool.roles[table.args[0]].of.kind == "step" for table in velocity_bias.atoms(TableAt))
    if steps or velocity_bias.has(sp.Piecewise, sp.Heaviside, sp.sign):
        raise ModelError(
            f"{kind}: the prescribed speed '{velocity_bias}' jumps or may jump, which no finite torque can do; give a ramp as "
            "a linear Table, a smooth law, or filter=rad/s"
        )
    return PrescribedMotion(name, gains, velocity_bias, _rate(law, kind, velocity_bias, {}))


def frozen_motion(motion: PrescribedMotion, freeze: Callable[[Any], Any]) -> PrescribedMotion:
    """The prescribed motion with every condition as a mode."""
    return replace(motion.map_rates(freeze), angle=None if motion.angle is None else freeze(motion.angle))


def is_steady(law: Any, number: int) -> bool:
    """Whether the gains of a prescribed motion are numbers, and velocity bias and angle are linear in states (time aside)."""
    motion, pool = law.prescribed[number], law.pool
    if not all(gain.is_number for gain in motion.gains.values()):
        return False
    added = [sp.sympify(motion.velocity_bias), sp.Integer(0) if motion.angle is None else sp.sympify(motion.angle)]
    moving = [(e, x) for e in added for x in e.free_symbols if pool.level(x) == MOVING and pool.roles[x].role != "phi"]
    return all(pool.roles[x].role == "state" and derivative(e, x).is_number for e, x in moving)


def can_be_solved(zero: Any, flanges: Mapping[str, Any]) -> bool:
    """Whether a relation contains an angle with a number as its factor, so that it can be solved for that one."""
    return next(_pivots(zero, {n: f.phi for n, f in flanges.items()}), None) is not None


def _pivots(zero: Any, unknowns: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The flanges that have a number as their factor, and that."""
    for name, x in unknowns.items():
        slope = derivative(zero, x) if x.is_Symbol else sp.Integer(0)
        if slope != 0 and slope.is_number:
            yield name, slope


def _pivot(kind: str, zero: Any, unknowns: Mapping[str, Any]) -> tuple[str, Any]:
    """The flange to solve for, and its factor."""
    found = next(_pivots(zero, unknowns), None)
    if found is not None:
        return found
    raise ModelError(
        f"{kind}: the tie '{zero}' contains no flange linearly with a number as its factor, so it cannot be solved"
    )


def _rate(law: Any, kind: str, expr: Any, speeds: Mapping[Any, Any]) -> Any:
    """The time derivative of an expression of time, states and the angles in `speeds`."""
    for x in expr.free_symbols:
        if law.pool.roles[x].role == "input":
            beside = ", w and alpha beside it" if kind.split()[0] == "Angle" else ""
            raise ModelError(
                f"{kind}: the Input '{x}' has no time derivative, which a rigid motion needs: give filter=rad/s{beside}, or "
                "compliance"
            )
        if law.pool.roles[x].role == "sense":
            raise ModelError(f"{kind}: a sensed output ('{x}') cannot prescribe a rigid motion; give compliance")
    total = derivative(expr, time_symbol())
    total += sum((derivative(expr, x) * w for x, w in speeds.items() if expr.has(x)), sp.Integer(0))
    for state, rate in law.rates.items():
        symbol = law.pool.symbol("state", state, state)
        if expr.has(symbol):
            total += derivative(expr, symbol) * rate
    return total


def _check_smooth(pool: Pool, kind: str, angle: Any) -> None:
    """A prescribed angle must have a second derivative everywhere."""
    if angle.has(sp.Piecewise, sp.Heaviside, sp.sign, sp.Abs, sp.Max, sp.Min):
        raise ModelError(
            f"{kind}: the prescribed angle '{angle}' has corners or jumps, which no finite torque can follow; give a law "
            f"that is smooth twice over, or compliance"
        )
    for table in angle.atoms(TableAt):
        if pool.roles[table.args[0]].of.kind in ("linear", "step"):
            raise ModelError(f"{kind}: a prescribed angle needs a smooth Table: kind='cubic'")
