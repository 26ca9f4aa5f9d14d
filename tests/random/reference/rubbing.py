"""Dry friction that sticks, one-way and positive locks, inner friction of shafts, and gears with losses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.random.description import Part
from tests.random.expressions import Node, walk
from tests.random.reference.switches import Context, NoEvidenceError, Signal, Table1
from tests.random.reference.system import Array, Dry, Lossy, Member, System


def group(s: System, row: Array, member: Member) -> None:
    """Adds a friction element to the group with the same slip, or to a new one. Rows over nodes; `merge` joins the rest."""
    member.heat = s.heats.get(member.name, -1)
    s.dry.append(Dry(row, [member]))


def merge(s: System) -> None:
    """Groups with parallel rows over the reduced coordinates become one; what cannot slip goes."""
    groups: list[Dry] = []
    for d in s.dry:
        row = d.row @ s.N
        if np.abs(row).max(initial=0.0) < 1e-12:
            continue
        for other in groups:
            i = int(np.argmax(np.abs(other.row)))
            scale = row[i] / other.row[i]
            if np.abs(row - scale * other.row).max() < 1e-10 * np.abs(row).max():
                for m in d.members:
                    m.scale *= scale
                other.members += d.members
                break
        else:
            groups.append(Dry(row, d.members))
    s.dry = groups


def _always(_: Context) -> float:
    return 1.0


def constant(s: System, row: Array, size: float, name: str) -> None:
    """Dry friction of one size."""
    group(s, row, Member(name, 1.0, _always, lambda c, slip: size, lambda c: (-size, size)))


def _friction_fields(s: System, p: Part) -> tuple[Signal, Callable[[Context, float], float], Signal]:
    """Engagement, sliding force over the slip, and what is held at rest."""
    peak = p.field("peak", 1.0)
    if _is_law(p.field("capacity")):
        law = _law(s, p.field("capacity"))
        return lambda c: law(c, 0.0), law, lambda c: peak * law(c, 0.0)
    if p.field("capacity") is not None:
        capacity = s.compile(p.field("capacity"))
        return capacity, lambda c, slip: capacity(c), lambda c: peak * capacity(c)
    engagement, force = s.compile(p.field("engagement")), p.field("geometry", 1.0) * p.field("force_max")
    mu = p.field("mu")
    if not isinstance(mu, Node):
        return engagement, lambda c, slip: mu * force * engagement(c), lambda c: peak * mu * force * engagement(c)
    if mu.op != "table" and not _is_law(mu):
        now = s.compile(mu)
        return (
            engagement,
            lambda c, slip: now(c) * force * engagement(c),
            lambda c: peak * now(c) * force * engagement(c),
        )
    if _is_law(mu):
        law = _law(s, mu)
        return (
            engagement,
            lambda c, slip: law(c, slip) * force * engagement(c),
            lambda c: peak * law(c, 0.0) * force * engagement(c),
        )
    xs, ys, kind, periodic, _ = mu.args
    table = Table1(s.sw, xs, ys, kind, periodic)
    rest = value_at(xs, ys, kind, 0.0)
    return (
        engagement,
        lambda c, slip: table(abs(slip)) * force * engagement(c),
        lambda c: peak * rest * force * engagement(c),
    )


def _is_law(x: Any) -> bool:
    """Whether the slip stands in a field."""
    return any(n.op == "slip" for n in walk(x))


def _law(s: System, x: Any) -> Callable[[Context, float], float]:
    """A field over the size of the slip, of one that does not stand still."""
    at = [0.0]
    found = s.compile(x, lambda c: at[0])

    def law(c: Context, slip: float) -> float:
        at[0] = abs(slip)
        return found(c)

    return law


def value_at(xs: tuple[float, ...], ys: tuple[float, ...], kind: str, x: float) -> float:
    """A table's value, held outside."""
    if kind == "linear":
        return float(np.interp(x, xs, ys))
    from scipy.interpolate import CubicSpline

    return float(CubicSpline(xs, ys)(min(max(x, xs[0]), xs[-1])))


def _not_engaged(s: System, p: Part) -> Signal:
    """What a one-way clutch holds at rest where it is not engaged."""
    mu = p.field("mu")
    if p.field("force_max") is None:
        return lambda c: 0.0
    force = 1e-4 * p.field("geometry", 1.0) * p.field("force_max")
    if isinstance(mu, Node) and mu.op != "table" and not _is_law(mu):
        now = s.compile(mu)
        return lambda c: force * now(c)
    if _is_law(mu):
        law = _law(s, mu)
        return lambda c: force * law(c, 0.0)
    rest = value_at(*mu.args[:3], 0.0) if isinstance(mu, Node) else mu
    return lambda c: force * rest


def clutch(s: System, p: Part) -> None:
    """Clutch, one-way clutch, and synchronizer: slip w_b - w_a."""
    row = s.node(p.node("b")) - s.node(p.node("a"))
    engaged, sliding, held = _friction_fields(s, p)
    if p.block == "OneWayClutch":
        least = _not_engaged(s, p)
        on = s.sw.new()
        more = s.sw.new()

        def slides(c: Context, slip: float) -> float:
            value = sliding(c, slip)
            return value if s.sw(on, engaged(c)) else 0.0

        def limits(c: Context) -> tuple[float, float]:
            value, rest = held(c) if s.sw(on, engaged(c)) else 0.0, least(c)
            return -(value if s.sw(more, value - rest) else rest), math.inf

        group(s, row, Member(p.name, 1.0, _always, slides, limits, one_way=True))
        return
    member = Member(p.name, 1.0, engaged, sliding, lambda c: (-held(c), held(c)), switch=s.sw.new())
    if p.block == "Synchronizer":
        member.teeth = s.compile(p.field("engaged"))
        s.synchronizers = [*getattr(s, "synchronizers", []), (member, s.sw.new())]
    group(s, row, member)


def brake(s: System, p: Part) -> None:
    """Slip w_a - w_housing."""
    row = s.node(p.node("a")) - s.node(p.node("housing"))
    engaged, sliding, held = _friction_fields(s, p)
    group(s, row, Member(p.name, 1.0, engaged, sliding, lambda c: (-held(c), held(c)), switch=s.sw.new()))


def freewheel(s: System, p: Part) -> None:
    """w_b - w_a >= 0 without friction."""
    row = s.node(p.node("b")) - s.node(p.node("a"))
    group(s, row, Member(p.name, 1.0, _always, lambda c, slip: 0.0, lambda c: (0.0, math.inf), one_way=True))


def drag(p: Part) -> float:
    """Torque over the square of the speed, of air and oil together."""
    return float(sum(dict(p.field(n).args[1])["c"] for n in ("windage", "churning") if p.field(n) is not None))


def bearing(s: System, p: Part) -> None:
    """coulomb + rise exp(-(w/speed)^2) + viscous abs(w), or a table; and what drags with the square of the speed."""
    row = s.node(p.node("a")) - s.node(p.node("housing"))
    peak, c2 = p.field("peak", 1.0), drag(p)
    if _is_law(p.field("torque")):
        law = _law(s, p.field("torque"))
        dragged = lambda c, w: law(c, w) + c2 * w * w  # noqa: E731
        group(s, row, Member(p.name, 1.0, _always, dragged, lambda c: (-peak * law(c, 0.0), peak * law(c, 0.0))))
        return
    if p.field("torque") is not None:
        xs, ys, kind, periodic, _ = p.field("torque").args
        table, rest = Table1(s.sw, xs, ys, kind, periodic), peak * value_at(xs, ys, kind, 0.0)
        dragged = lambda c, w: table(abs(w)) + c2 * w * w  # noqa: E731
        group(s, row, Member(p.name, 1.0, _always, dragged, lambda c: (-rest, rest)))
        return
    coulomb, viscous = p.field("coulomb"), p.field("viscous", 0.0)
    stribeck = dict(p.field("stribeck").args[1]) if p.field("stribeck") is not None else {"rise": 0.0, "speed": 1.0}
    rise, speed = stribeck["rise"], stribeck["speed"]
    held = peak * (coulomb + rise)
    group(
        s, row,
        Member(p.name, 1.0, _always,
               lambda c, w: coulomb + rise * math.exp(-((w / speed) ** 2)) + viscous * abs(w) + c2 * w * w,
               lambda c: (-held, held)),
    )  # fmt: skip


def dog(s: System, p: Part) -> None:
    """Locked without limit while engaged > 0."""
    row = s.node(p.node("b")) - s.node(p.node("a"))
    engaged = s.compile(p.field("engaged"))
    member = Member(
        p.name, 1.0, engaged, lambda c, slip: 0.0, lambda c: (-math.inf, math.inf), switch=s.sw.new(), dog=True
    )
    group(s, row, member)


@dataclass
class Iwan:
    """A slider of a friction behind a spring: mode 0 holds, +-1 slips that way."""

    row: int
    state: int
    friction: float
    mode: int = 0
    value: list[float] = field(default_factory=lambda: [1.0, 1.0])

    def margins(self) -> list[float]:
        """>= 0 while the mode is right."""
        return self.value


def inner_friction(s: System, row: Array, fields: dict[str, Any], name: str) -> None:
    """A dry slider beside a spring, or at the end of a spring of its own."""
    if fields.get("stiffness") is None:
        constant(s, row, fields["friction"], name)
        return
    unit = Iwan(s.law_row(row), s.state(), fields["friction"])
    k = fields["stiffness"]
    s.iwan.append(unit)

    def law(c: Context, f: list[float]) -> None:
        force, rate = c.s[unit.state], c.V[unit.row]
        f[unit.row] -= force
        f[-1 - unit.state] = 0.0 if unit.mode else k * rate
        if unit.mode:
            unit.value = [unit.mode * rate, 1.0]
        else:
            unit.value = [unit.friction - force, unit.friction + force]
        if unit.mode and name in s.heats:
            f[-1 - s.heats[name]] += force * rate

    s.laws.append(law)


def lossy_gear(s: System, p: Part) -> None:
    """Rows over nodes; a table over abs(w_a) is linear in between and held outside."""
    a = s.node(p.node("a")) - s.node(p.node("housing"))
    b = s.node(p.node("b")) - s.node(p.node("housing"))
    rows, heat = p.field("loss_table"), s.heats.get(p.name, -1)
    if rows is None and p.field("efficiency") is None:
        s.ties.append(a - p.field("ratio") * b)
        return
    if rows is None or len(rows) == 1:
        one = (*p.field("efficiency"), *p.field("bearing", (0.0, 0.0))) if rows is None else tuple(rows[0][1:])
        s.lossy.append(Lossy(a, b, p.field("ratio"), lambda w: one, heat=heat))
        return
    x = tuple(r[0] for r in rows)
    tables = [Table1(s.sw, x, tuple(r[i] for r in rows), "linear", False) for i in range(1, 5)]
    s.lossy.append(Lossy(a, b, p.field("ratio"), lambda w: tuple(t(w) for t in tables), heat=heat))  # type: ignore[arg-type]


def worm(s: System, p: Part) -> None:
    """eta1 = (cos a - mu tan g)/(cos a + mu/tan g), eta2 = (cos a - mu/tan g)/(cos a + mu tan g)."""
    c, t, mu = (
        math.cos(p.field("pressure_angle", 0.3490658503988659)),
        math.tan(p.field("lead_angle")),
        p.field("friction"),
    )
    one, two = (c - mu * t) / (c + mu / t), (c - mu / t) / (c + mu * t)
    if two == 0:
        raise NoEvidenceError("a worm between free and self-locking")
    a = s.node(p.node("a")) - s.node(p.node("housing"))
    b = s.node(p.node("b")) - s.node(p.node("housing"))
    s.lossy.append(Lossy(a, b, p.field("ratio"), lambda w: (one, two, 0.0, 0.0), heat=s.heats.get(p.name, -1)))
