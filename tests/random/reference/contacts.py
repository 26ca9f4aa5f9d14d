"""Contacts: dead zones with what damping does in them, meshes along the line of action, splines, stops."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from scipy.optimize import brentq

from tests.random.description import Part
from tests.random.expressions import Node
from tests.random.reference.further import tooth_friction
from tests.random.reference.switches import Context, NoEvidenceError, Switches
from tests.random.reference.system import Array, Stop, System

NOTHING = (0.0, 0.0, 0.0)
Force = Callable[[float, float, float], tuple[float, float]]


def contact(s: System, p: Part, k: float) -> tuple[Force, Callable[[float], float]]:
    """(x, x', factor on k) -> (k factor g(x) + damping, G(x) the integral of g), and x -> k g(x).

    Damping: "clipped" c x' within +-abs(k g); "clipped_force" never pulling; "always" in the gap too; Hunt and Crossley.
    """
    gap: Any = p.field("backlash")
    if p.block == "Lash":
        gap = Node("object", ("Backlash", (("half_gap", p.field("half_gap")),)))
    if p.block == "Lash" and p.field("half_gap") is None:
        gap = Node("object", ("Ends", (("lower", p.field("lower")), ("upper", p.field("upper")))))
    choice = p.field("contact_damping", "clipped")
    zone = _zone(s.sw, gap)
    c = p.field("c")
    if isinstance(choice, Node):
        return _hunt_crossley(s, zone, k, dict(choice.args[1])["restitution"]), lambda x: k * zone(x)[0]
    if p.block == "Lash" and p.field("exponent") is not None:
        zone = _risen(zone, p.field("exponent"))
    if gap is None:
        viscosity = 0.0 if c is None else c
        return lambda x, rate, factor: (k * factor * x + viscosity * rate, x * x / 2), lambda x: k * x
    low, high, pushes = s.sw.new(), s.sw.new(), s.sw.new()

    def force(x: float, rate: float, factor: float) -> tuple[float, float]:
        g, G, side = zone(x)
        elastic, viscous = k * factor * g, 0.0 if c is None else c * rate
        if c is None or choice == "always":
            return elastic + viscous, G
        if choice == "clipped":
            bound = elastic * side
            above, below = s.sw(low, viscous + bound), s.sw(high, bound - viscous)
            if side == 0:
                return elastic, G
            return elastic + (viscous if above and below else (bound if above else -bound)), G
        on = s.sw(pushes, (elastic + viscous) * side)
        return (elastic + viscous if on and side else 0.0), G

    return force, lambda x: k * zone(x)[0]


def _zone(sw: Switches, gap: Any) -> Callable[[float], tuple[float, float, int]]:
    """g, its integral, and the side of a dead zone."""
    if gap is None:
        return lambda x: (x, x * x / 2, 1 if x >= 0 else -1)
    fields = dict(gap.args[1])
    if gap.args[0] == "Ends":
        return _ends(sw, fields["lower"], fields["upper"])
    if "gaps" in fields:
        return _teeth(sw, fields["gaps"])
    b = fields["half_gap"]
    if fields.get("law", "exact") == "smooth":
        w = fields["width"]
        return lambda x: (x + (math.hypot(x - b, w) - math.hypot(x + b, w)) / 2, _smooth_potential(x, b, w), 1)
    if fields.get("law", "exact") != "exact":
        raise NoEvidenceError("a polynomial backlash")
    ahead, behind = sw.new(), sw.new()

    def zone(x: float) -> tuple[float, float, int]:
        up, down = sw(ahead, x - b), sw(behind, -x - b)
        if up:
            return x - b, (x - b) ** 2 / 2, 1
        return (x + b, (x + b) ** 2 / 2, -1) if down else (0.0, 0.0, 0)

    zone.switches = (ahead, behind)  # type: ignore[attr-defined]
    return zone


def _ends(sw: Switches, lower: float | None, upper: float | None) -> Callable[[float], tuple[float, float, int]]:
    """A dead zone between two ends, one of which may be missing."""
    ahead, behind = sw.new(), sw.new()

    def zone(x: float) -> tuple[float, float, int]:
        up = upper is not None and sw(ahead, x - upper)
        down = lower is not None and sw(behind, lower - x)
        end = upper if up else lower
        if end is None or not (up or down):
            return 0.0, 0.0, 0
        return x - end, (x - end) ** 2 / 2, 1 if up else -1

    zone.switches = tuple(i for i, end in ((ahead, upper), (behind, lower)) if end is not None)  # type: ignore[attr-defined]
    return zone


def _risen(zone: Callable[[float], tuple[float, float, int]], n: float) -> Callable[[float], tuple[float, float, int]]:
    """A dead zone with g abs(g)^(n - 1) in place of g."""

    def risen(x: float) -> tuple[float, float, int]:
        g, _, side = zone(x)
        return g * abs(g) ** (n - 1), abs(g) ** (n + 1) / (n + 1), side

    return risen


def _smooth_potential(x: float, b: float, w: float) -> float:
    """Integral of x + (hypot(x - b, w) - hypot(x + b, w))/2 from 0."""

    def S(u: float) -> float:
        return (u * math.hypot(u, w) + w * w * math.asinh(u / w)) / 2

    return x * x / 2 + (S(x - b) - S(x + b)) / 2 + S(b)


def _teeth(sw: Switches, gaps: tuple[float, ...]) -> Callable[[float], tuple[float, float, int]]:
    pairs = [(sw.new(), sw.new(), b) for b in gaps]
    n = len(gaps)

    def zone(x: float) -> tuple[float, float, int]:
        g, side = 0.0, 0
        for ahead, behind, b in pairs:
            up, down = sw(ahead, x - b), sw(behind, -x - b)
            if up:
                g, side = g + (x - b) / n, 1
            elif down:
                g, side = g + (x + b) / n, -1
        return g, math.nan, side

    return zone


def _hunt_crossley(s: System, zone: Any, k: float, e: float) -> Force:
    """N = k g (1 + d x'/v), v the speed at which the contact began; d from the restitution; never pulling.

    A half wave of m x'' = -k x (1 + d x'/v) from v to -e v: d (1 + e) = ln((1 + d)/(1 - d e)). A contact that begins
    at no speed is not damped, and one in which the run begins, beyond its corner, until it has ended.
    """
    if not hasattr(zone, "switches"):
        raise NoEvidenceError("Hunt and Crossley without corners")
    d = 0.0
    if e < 1:
        d = brentq(lambda d: d * (1 + e) - math.log((1 + d) / (1 - d * e)), 0.1 * (1 - e), (1 - 1e-14) / e, xtol=1e-15)
    held: dict[str, Any] = {"slowness": None, "deepest": 0.0}
    pushes = s.sw.new()

    def ends() -> None:
        held.update(slowness=None, deepest=0.0)

    def struck() -> None:
        if held["deepest"] < 1e-15:  # it touches, and nothing has pressed it yet
            held["slowness"] = None

    for i in zone.switches:
        s.sw.on_flip[i] = ends
    s.sw.on_strike.append(struck)

    def force(x: float, rate: float, factor: float) -> tuple[float, float]:
        g, G, side = zone(x)
        inward = side * rate
        held["deepest"] = max(held["deepest"], side * g)
        if side == 0:
            held["slowness"] = None
        elif s.sw.fresh:
            held["slowness"] = 0.0 if abs(g) > 1e-12 * abs(x) else None
        elif held["slowness"] is None:
            held["slowness"] = 1.0 / inward if inward > s.context.small else 0.0
        damped = 1 + d * (held["slowness"] or 0.0) * inward
        on = s.sw(pushes, damped if side else 1.0)
        return (k * factor * g * damped if on else 0.0), G

    return force


def lash(s: System, p: Part) -> None:
    """A spring with a gap, or with `hits` rigid sides that hit each other."""
    row = s.node(p.node("b")) - s.node(p.node("a"))
    if p.field("hits"):
        hits(s, p, row, p.field("half_gap"))
        return
    i, (force, spring) = s.law_row(row), contact(s, p, p.field("k"))
    s.elastic.append(row)
    rest, heat = p.field("rest", 0.0), s.heats.get(p.name, -1)

    def law(c: Context, f: list[float]) -> None:
        x = c.X[i] - rest
        pushes = force(x, c.V[i], 1.0)[0]
        f[i] -= pushes
        if heat >= 0:
            f[-1 - heat] += (pushes - spring(x)) * c.V[i]

    s.laws.append(law)


def spline(s: System, p: Part) -> None:
    """x = radius (phi_a - phi_b)."""
    row, r = s.node(p.node("a")) - s.node(p.node("b")), p.field("radius")
    if p.field("hits"):
        hits(s, p, row, dict(p.field("backlash").args[1])["half_gap"] / r)
        return
    if p.field("stiffness_variation") is not None:
        raise NoEvidenceError("a spline with a varying stiffness")
    i, (force, spring) = s.law_row(row), contact(s, p, p.field("k"))
    s.elastic.append(row)
    heat = s.heats.get(p.name, -1)

    def law(c: Context, f: list[float]) -> None:
        x, rate = r * c.X[i], r * c.V[i]
        pushes = force(x, rate, 1.0)[0]
        f[i] -= r * pushes
        if heat >= 0:
            f[-1 - heat] += (pushes - spring(x)) * rate

    s.laws.append(law)


def mesh(s: System, p: Part) -> None:
    """x = r1 (phi_1 - phi_c) +- r2 (phi_2 - phi_c) - e; N dx/dphi on every flange; k(phi_1) from a potential."""
    one = s.node(p.node("pinion")) - s.node(p.node("carrier"))
    two = s.node(p.node("wheel")) - s.node(p.node("carrier"))
    teeth, sign = p.field("teeth"), 1.0 if p.field("external") else -1.0
    if p.field("k") is None and p.field("backlash") is None:
        s.ties.append(one + sign * teeth[1] / teeth[0] * two)
        return
    r1, r2 = radii = _base_radii(p)
    if p.field("k") is None:
        hits(s, p, one + sign * r2 / r1 * two, dict(p.field("backlash").args[1])["half_gap"] / r1)
        return
    i, j = s.law_row(one), s.law_row(two)
    k, z = p.field("k"), teeth[0]
    s.elastic.append(r1 * one + sign * r2 * two)
    force, spring = contact(s, p, k)
    heat = s.heats.get(p.name, -1)
    vary, error = (
        _excitation(s, p.field("stiffness_variation"), i, z),
        _excitation(s, p.field("transmission_error"), i, z),
    )
    rubs, s2 = tooth_friction(s, p, i, j, radii, sign), sign * r2
    given = (
        rubs is not None and dict(p.field("friction").args[1]).get("direction") == "square_wave"
    )  # supplied, no loss
    varies, errs = p.field("stiffness_variation") is not None, p.field("transmission_error") is not None
    if errs and p.field("backlash") is not None:
        _watched(s, p.field("transmission_error"), i, z)

    def law(c: Context, f: list[float]) -> None:
        v, v_phi, _ = vary(c) if varies else NOTHING
        e, e_phi, e_rate = error(c) if errs else NOTHING
        x = r1 * c.X[i] + s2 * c.X[j] - e
        rate = (r1 - e_phi) * c.V[i] + s2 * c.V[j] - e_rate
        N, G = force(x, rate, 1 + v)
        f[i] -= N * (r1 - e_phi) + (k * v_phi * G if v_phi else 0.0)
        f[j] -= N * s2
        before = f[i], f[j]
        if rubs is not None:
            rubs(c, f, N)
        before = (f[i], f[j]) if given else before
        if heat >= 0:
            f[-1 - heat] += (N - (1 + v) * spring(x)) * rate - (f[i] - before[0]) * c.V[i] - (f[j] - before[1]) * c.V[j]

    s.laws.append(law)


def _base_radii(p: Part) -> tuple[float, float]:
    if p.field("r_base") is not None:
        return tuple(p.field("r_base"))  # type: ignore[return-value]
    half = p.field("module") * math.cos(p.field("pressure_angle")) / 2
    return half * p.field("teeth")[0], half * p.field("teeth")[1]


def _excitation(s: System, effect: Any, i: int, z: int) -> Callable[[Context], tuple[float, float, float]]:
    """Value, its slope over the pinion's angle, and its rate over time, of a Fourier, Harmonic or Square."""
    if effect is None:
        return lambda c: (0.0, 0.0, 0.0)
    name, fields = effect.args[0], dict(effect.args[1])
    driven = fields.get("driven_by", "angle")
    if name == "Square":
        share, ripple, k = fields["contact_ratio"] - 1, fields["ripple"], s.sw.new()
        s.sw.phases.append((-1, driven))

        def square(c: Context) -> tuple[float, float, float]:
            upper = s.sw(k, math.cos(driven * c.t - math.pi * share) - math.cos(math.pi * share))
            return (2 * ripple * (1 - share) if upper else -2 * ripple * share), 0.0, 0.0

        return square
    if "sin" in fields or name not in ("Fourier", "Harmonic"):
        raise NoEvidenceError(f"this {name}")
    a, phase = fields["cos"], fields.get("phase", 0.0)
    if len(a) == 1:
        return _one_wave(a[0], phase, driven, i, z)

    def wave(c: Context) -> tuple[float, float, float]:
        theta = (z * c.X[i] if driven == "angle" else driven * c.t) + phase
        value = sum(x * math.cos(n * theta) for n, x in enumerate(a, 1))
        slope = -sum(n * x * math.sin(n * theta) for n, x in enumerate(a, 1))
        return (value, z * slope, 0.0) if driven == "angle" else (value, 0.0, driven * slope)

    return wave


def _watched(s: System, error: Any, i: int, z: int) -> None:
    """Asks for looks at the waves of a gap: while it is open no step is as short as they are."""
    fields = dict(error.args[1])
    driven, slower = fields.get("driven_by", "angle"), 4.0  # times the looks of a condition: dips are followed down
    row, factor = (i, float(z)) if driven == "angle" else (-1, float(driven))
    s.sw.phases.append((row, factor * len(fields.get("cos", (1.0,))) / slower))


def _one_wave(a: float, phase: float, driven: Any, i: int, z: int) -> Callable[[Context], tuple[float, float, float]]:
    if driven == "angle":

        def over_angle(c: Context) -> tuple[float, float, float]:
            theta = z * c.X[i] + phase
            return a * math.cos(theta), -z * a * math.sin(theta), 0.0

        return over_angle

    def over_time(c: Context) -> tuple[float, float, float]:
        theta = driven * c.t + phase
        return a * math.cos(theta), 0.0, -driven * a * math.sin(theta)

    return over_time


def hits(s: System, p: Part, row: Array, half_gap: float) -> None:
    """Rigid sides at both ends of a gap."""
    restitution = dict(p.field("contact_damping").args[1])["restitution"]
    stops(s, row, -half_gap, half_gap, restitution)


def stops(s: System, row: Array, lower: float | None, upper: float | None, restitution: float, heat: int = -1) -> None:
    """Unilateral contacts at either end."""
    if lower is not None:
        s.stops.append(Stop(row, lower, restitution, heat=heat))
    if upper is not None:
        s.stops.append(Stop(-row, -upper, restitution, heat=heat))
