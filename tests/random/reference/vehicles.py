"""Vehicles, chassis and tyres on a road, written anew from the catalogue.

against = air_density/2 drag_area u abs(u) + rolling normal sign(v),   u = v - wind,   normal = m g cos(grade)
F = D sin(C atan(K slip/(C D))),   slip = (radius w - v)/hypot(v, low_speed),   D = grip normal_force
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from tests.random.description import Part
from tests.random.expressions import TIME, Node, rewrite
from tests.random.reference import rubbing
from tests.random.reference.heat import lost
from tests.random.reference.switches import Context, NoEvidenceError, Signal
from tests.random.reference.system import Array, Member, System

GRAVITY = 9.80665


def _over_time(x: Any) -> Any:
    """A table that does not say over what it goes, over time."""
    return Node("table", (*x.args[:4], TIME)) if isinstance(x, Node) and x.op == "table" and x.args[4] is None else x


class Road:
    """What acts along the road; way and speed: of the vehicle."""

    def __init__(self, s: System, p: Part, way: Signal, speed: Signal) -> None:
        self.weight, self.speed = p.field("mass") * GRAVITY, speed
        self.grade, self.wind, self.roll = (
            s.compile(rewrite(p.field(n, 0.0), _over_time), way) for n in ("grade", "wind", "rolling")
        )
        self.fading, self.sw = p.field("rolling_speed"), s.sw
        self.drag = 0.5 * p.field("air_density", 1.2) * p.field("drag_area", 0.0)
        self.ahead = s.sw.new() if self.drag else -1
        self.rolls = p.field("rolling") is not None

    def climb(self, c: Context) -> float:
        """Weight along the slope."""
        return self.weight * math.sin(self.grade(c))

    def rolling(self, c: Context) -> float:
        """Size of the rolling resistance."""
        return self.roll(c) * self.weight * math.cos(self.grade(c))

    def air(self, c: Context) -> tuple[float, float]:
        """Drag, and the speed against the air; a speed that friction holds is 0 but for rounding."""
        if not self.drag:
            return 0.0, 0.0
        u = self.speed(c) - self.wind(c)
        forward = self.sw(self.ahead, u if abs(u) > 1e-9 else 0.0)
        return self.drag * u * u * (1 if forward else -1), u

    def smooth(self, c: Context) -> tuple[float, float]:
        """Resistance without what sticks, and the power that it loses."""
        drag, u = self.air(c)
        if not (self.rolls and self.fading is not None):
            return drag, drag * u
        v = self.speed(c)
        fades = self.rolling(c) * v / math.hypot(v, self.fading)
        return drag + fades, drag * u + fades * v


def _rolls_dry(s: System, p: Part, row: Array, road: Road, arm: float) -> None:
    """Rolling resistance as dry friction along a row."""
    size = lambda c: arm * road.rolling(c)  # noqa: E731
    member = Member(p.name, 1.0, size, lambda c, slip: size(c), lambda c: (-size(c), size(c)), switch=s.sw.new())
    rubbing.group(s, row, member)


def vehicle(s: System, p: Part) -> None:
    """A mass that the wheels carry along, or with tyres a state of its own."""
    r, m, node = p.field("wheel_radius"), p.field("mass"), p.node("flange")
    row = s.node(node)
    s.J[s.index[node]] += p.field("wheel_inertia", 0.0)
    i = s.law_row(row)
    if p.field("tyre") is not None:
        _on_tyres(s, p, i)
        return
    s.J[s.index[node]] += m * r * r
    road = Road(s, p, lambda c: r * c.X[i], lambda c: r * c.V[i])
    _resists(s, p, road, i, r)
    if road.rolls and road.fading is None:
        _rolls_dry(s, p, row, road, r)


def _resists(s: System, p: Part, road: Road, i: int, arm: float) -> None:
    def law(c: Context, f: list[float]) -> None:
        f[i] -= arm * (road.smooth(c)[0] + road.climb(c))

    s.laws.append(law)
    lost(s, p, lambda c: road.smooth(c)[1])


def chassis(s: System, p: Part) -> None:
    """A sliding mass."""
    node = p.node("a")
    row = s.node(node)
    s.J[s.index[node]] += p.field("mass")
    i = s.law_row(row)
    road = Road(s, p, lambda c: c.X[i], lambda c: c.V[i])
    _resists(s, p, road, i, 1.0)
    if road.rolls and road.fading is None:
        _rolls_dry(s, p, row, road, 1.0)


def grip(fields: dict[str, Any]) -> Callable[[float, float, float], float]:
    """Force of a tyre over the speed of its tread, that of the vehicle, and the largest force."""
    shape, stiffness, low = fields.get("shape", 1.0), fields["stiffness"], fields["low_speed"]

    def force(tread: float, v: float, most: float) -> float:
        slip = (tread - v) / math.hypot(v, low)
        return most * math.sin(shape * math.atan(stiffness * slip / (shape * most)))

    return force


def _on_tyres(s: System, p: Part, i: int) -> None:
    v, way, r, m = s.state(), s.state(), p.field("wheel_radius"), p.field("mass")
    fields = dict(p.field("tyre").args[1])
    force, most = grip(fields), fields["grip"]
    road = Road(s, p, lambda c: c.s[way], lambda c: c.s[v])
    if road.rolls and road.fading is None:
        raise NoEvidenceError("rolling that jumps at rest")

    def law(c: Context, f: list[float]) -> None:
        tread, u = r * c.V[i], c.s[v]
        F = force(tread, u, most * road.weight * math.cos(road.grade(c)))
        against, power = road.smooth(c)
        f[i] -= r * F
        f[-1 - v] = (F - against - road.climb(c)) / m
        f[-1 - way] = u
        if p.name in s.heats:
            f[-1 - s.heats[p.name]] += power + F * (tread - u)

    s.laws.append(law)


def tyre(s: System, p: Part) -> None:
    """Between a wheel and what slides."""
    i, j, r = s.law_row(s.node(p.node("wheel"))), s.law_row(s.node(p.node("vehicle"))), p.field("radius")
    force, load, most = grip(dict(p.fields)), s.compile(p.field("normal_force")), s.compile(p.field("grip"))

    def slips(c: Context) -> float:
        return force(r * c.V[i], c.V[j], most(c) * load(c))

    def law(c: Context, f: list[float]) -> None:
        F = slips(c)
        f[i] -= r * F
        f[j] += F

    s.laws.append(law)
    lost(s, p, lambda c: slips(c) * (r * c.V[i] - c.V[j]))
