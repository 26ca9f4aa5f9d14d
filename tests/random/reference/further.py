"""Fluid, belts with creep, and friction of teeth, written anew from the catalogue."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from tests.random.description import Part
from tests.random.reference.switches import Context, NoEvidenceError, Table1
from tests.random.reference.system import System

REST = 1e-12  # rad2/s2


def converter(s: System, p: Part) -> None:
    """T_i = capacity(nu) w_i abs(w_i), T_t = ratio(nu) T_i, nu = w_t w_i/(w_i^2 + REST).

    nu runs through a whole table while w_i passes 0 by 1e-12: edges are located by nu (w_i^2 + REST), which is smooth there.
    """
    i, t, heat = s.law_row(s.node(p.node("impeller"))), s.law_row(s.node(p.node("turbine"))), s.heats.get(p.name, -1)
    capacity, ratio = (Table1(s.sw, *p.field(name).args[:4]) for name in ("capacity", "ratio"))
    forward = s.sw.new()

    def law(c: Context, f: list[float]) -> None:
        w_i, w_t = c.V[i], c.V[t]
        weight = w_i * w_i + REST
        nu = w_t * w_i / weight
        taken = capacity(nu, weight) * w_i * w_i * (1 if s.sw(forward, w_i) else -1)
        given = ratio(nu, weight) * taken
        f[i] -= taken
        f[t] += given
        if heat >= 0:
            f[-1 - heat] += taken * w_i - given * w_t

    s.laws.append(law)


def creep(s: System, p: Part) -> None:
    """tau = K slip/sqrt(1 + (K slip/limit)^2), slip = (w_a - ratio w_b)/hypot(w_a, low_speed)."""
    a, b = s.node(p.node("a")) - s.node(p.node("housing")), s.node(p.node("b")) - s.node(p.node("housing"))
    i, j, ratio, fields = s.law_row(a), s.law_row(b), p.field("ratio"), dict(p.field("slip").args[1])
    heat = s.heats.get(p.name, -1)

    def law(c: Context, f: list[float]) -> None:
        tau = fields["stiffness"] * (c.V[i] - ratio * c.V[j]) / math.hypot(c.V[i], fields["low_speed"])
        if "limit" in fields:
            tau /= math.hypot(1.0, tau / fields["limit"])
        f[i] -= tau
        f[j] += ratio * tau
        if heat >= 0:
            f[-1 - heat] += tau * (c.V[i] - ratio * c.V[j])

    s.laws.append(law)


def tooth_friction(
    s: System, p: Part, i: int, j: int, radii: tuple[float, float], sign: float
) -> Callable[[Context, list[float], float], None] | None:
    """Friction of a normal force N on pinion and wheel; one or two pairs share it (external pairs of standard addendum)."""
    effect: Any = p.field("friction")
    if effect is None:
        return None
    fields = dict(effect.args[1])
    if fields.get("direction") == "square_wave":
        wave = s.compile(fields["wave"])

        def along(c: Context, f: list[float], N: float) -> None:
            f[i] -= radii[0] * fields["mu"] * wave(c) * N
            f[j] -= sign * radii[1] * fields["mu"] * wave(c) * N

        return along
    if sign < 0 or p.field("module") is None or "transition" not in fields or len(fields) > 2:
        raise NoEvidenceError("this friction of teeth")
    z, m, alpha = p.field("teeth"), p.field("module"), p.field("pressure_angle")
    path = [math.sqrt((m * x / 2 + m) ** 2 - r * r) - r * math.tan(alpha) for x, r in zip(z, radii, strict=True)]
    pitch = math.pi * m * math.cos(alpha)
    double = (path[0] + path[1]) / pitch - 1
    edges = Cycle(s, double)
    pushes = s.sw.new()

    def across(c: Context, f: list[float], N: float) -> None:
        cycle, two = edges(z[0] * c.X[i] / (2 * math.pi))
        normal = N if s.sw(pushes, N) else -N
        for pair in range(2 if two else 1):
            xi = -path[1] + pitch * (cycle + pair)
            rho = (radii[0] * math.tan(alpha) + xi, radii[1] * math.tan(alpha) - xi)
            v = rho[0] * c.V[i] + rho[1] * c.V[j]
            F = fields["mu"] * normal / (2 if two else 1) * v / math.hypot(v, fields["transition"])
            f[i] -= F * rho[0]
            f[j] -= F * rho[1]

    return across


class Cycle:
    """The part of a mesh cycle since the last pair came, and whether the one before is still there; on frozen segments."""

    def __init__(self, s: System, double: float) -> None:
        self.table = Table1(s.sw, (0.0, double, 1.0), (1.0, 0.0, 1.0), "step", True)

    def __call__(self, cycles: float) -> tuple[float, bool]:
        i, left, x = self.table.locate(cycles)
        return (x - left, True) if i == 0 else (x - left + self.table.x[1], False)
