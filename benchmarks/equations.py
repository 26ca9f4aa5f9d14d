"""The right-hand sides of P1, P2 and P3 as a user of the peers would write them: sympy, numba, casadi."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.cases import P1, P2, P3

Rates = Callable[[Any, Any], Any]


def p1_rates(p: P1, cos: Callable[[Any], Any], dead_zone: Callable[[Any, float], Any]) -> Rates:
    """f(t, y) of P1 in twists phi_i - phi_(i+1) and speeds; cos and dead_zone belong to the peer."""
    j1, j2, j3, j4 = p.J
    left_c, right_c = p.c_shafts
    r, k, c, half = p.radius, p.k_mesh, p.c_mesh, p.half_gap

    def rates(t: Any, y: Any) -> list[Any]:
        a, d, e, w1, w2, w3, w4 = (y[i] for i in range(7))
        wave = cos(p.w * t)
        left = p.k_shaft * a + left_c * (w1 - w2)
        mesh = r * (c * r * (w2 - w3) + k * (1 + p.ripple * wave) * dead_zone(r * d, half))
        right = p.k_shaft * e + right_c * (w3 - w4)
        torque = p.torque * (1 + p.swing * wave)
        speeds = [(torque - left) / j1, (left - mesh) / j2, (mesh - right) / j3, (right - p.torque) / j4]
        return [w1 - w2, w2 - w3, w3 - w4, *speeds]

    return rates


def p2_rates(p: P2, cos: Callable[[Any], Any], dead_zone: Callable[[Any, float], Any]) -> Rates:
    """f(t, y) of P2 in deflection and rate."""

    def rates(t: Any, y: Any) -> list[Any]:
        wave = cos(p.w * t)
        force = 2 * p.zeta * y[1] + (1 + p.eps * wave) * dead_zone(y[0], p.half_gap)
        return [y[1], p.load + p.swing * p.w**2 * wave - force]

    return rates


def p3_rates(p: P3, cos: Callable[[Any], Any], dead_zone: Callable[[Any, float], Any]) -> Rates:
    """f(t, y) of P3 in the states of `P3.start`, without the zeros at their end."""
    (c_sun, c_ring), (sun_phases, ring_phases) = p.c_meshes, p.phases
    rs, rp, rr, b = p.r_sun, p.r_planet, p.r_ring, p.half_gap

    def rates(t: Any, y: Any) -> list[Any]:
        u, angle, sun, carrier, ring, *planets = (y[i] for i in range(4, 13))
        at_sun, at_ring, slips, pulls = 0.0, 0.0, [], []
        for i, planet in enumerate(planets):
            slip = rs * (sun - carrier) + rp * (planet - carrier)
            other = rp * (planet - carrier) - rr * (ring - carrier)
            k_sun = p.k_sun * (1 + p.ripple * cos(p.w * t + sun_phases[i]))
            k_ring = p.k_ring * (1 + p.ripple * cos(p.w * t + ring_phases[i]))
            f = c_sun * slip + k_sun * dead_zone(y[i], b)
            g = c_ring * other + k_ring * dead_zone(y[i] - u, b)
            slips.append(slip)
            pulls.append(-rp * (f + g) / p.j_planet)
            at_sun, at_ring = at_sun + f, at_ring + g
        load = p.torque * (1 + rr / rs)
        d_sun = (p.torque * (1 + p.swing * cos(p.w * t)) - rs * at_sun) / p.j_sun
        d_carrier = ((rs + rp) * at_sun - (rr - rp) * at_ring - load) / p.j_carrier
        d_ring = (rr * at_ring - p.k_ground * angle - p.c_ground * ring) / p.j_ring
        return [*slips, rs * (sun - carrier) + rr * (ring - carrier), ring, d_sun, d_carrier, d_ring, *pulls]

    return rates


def rates_of(p: P1 | P2 | P3, cos: Callable[[Any], Any], dead_zone: Callable[[Any, float], Any]) -> tuple[Rates, int]:
    """f(t, y) and the number of states."""
    if isinstance(p, P3):
        return p3_rates(p, cos, dead_zone), 13
    return (p1_rates(p, cos, dead_zone), 7) if isinstance(p, P1) else (p2_rates(p, cos, dead_zone), 2)


def lambdified(p: P1 | P2 | P3) -> Callable[[float, Any], Any]:
    """f(t, y) by sympy.lambdify, the dead zone as a Piecewise."""
    import sympy as sp

    def dead_zone(x: Any, b: float) -> Any:
        return sp.Piecewise((x - b, x > b), (x + b, x < -b), (0, True))

    rates, n = rates_of(p, sp.cos, dead_zone)
    t, y = sp.Symbol("t"), sp.symbols(f"y:{n}")
    made: Callable[[float, Any], Any] = sp.lambdify((t, y), rates(t, y), "numpy")
    return made


def numba_source(p: P1 | P2 | P3) -> str:
    """Python text of f(t, y, dy) with all numbers written out, common subexpressions taken out by sympy."""
    import sympy as sp

    gap = sp.Function("gap")
    rates, n = rates_of(p, sp.cos, lambda x, b: gap(x, b))
    t, y = sp.Symbol("t"), sp.symbols(f"y_:{n}")
    common, last = sp.cse(rates(t, y))
    lines = ["def f(t, y, dy, p):", *(f"    y_{i} = y[{i}]" for i in range(n))]

    def text(value: Any) -> str:
        return str(sp.pycode(value, user_functions={"gap": "gap"}, fully_qualified_modules=False))

    lines += [f"    {symbol} = {text(value)}" for symbol, value in common]
    lines += [f"    dy[{i}] = {text(value)}" for i, value in enumerate(last)]
    return "\n".join(lines)


def numba_rates(p: P1 | P2 | P3) -> Any:
    """A numba C callback with the signature of numbalsoda."""
    from math import cos

    import numba
    from numbalsoda import lsoda_sig

    @numba.njit
    def gap(x: float, b: float) -> float:
        return x - b if x > b else x + b if x < -b else 0.0

    scope: dict[str, Any] = {"cos": cos, "gap": gap}
    exec(numba_source(p), scope)  # noqa: S102  the text is our own, made above
    return numba.cfunc(lsoda_sig)(scope["f"])


def casadi_rates(p: P1 | P2 | P3) -> dict[str, Any]:
    """The problem as casadi's integrator takes it."""
    import casadi as ca

    def dead_zone(x: Any, b: float) -> Any:
        return ca.if_else(x > b, x - b, ca.if_else(x < -b, x + b, 0.0))

    rates, n = rates_of(p, ca.cos, dead_zone)
    t, y = ca.SX.sym("t"), ca.SX.sym("y", n)
    return {"t": t, "x": y, "ode": ca.vertcat(*rates(t, y))}
