"""Gearboxes whose gap lies behind the gear: no inertia is between, so that the side of the gap turns with the other one, and
the loss is dry friction there whose size follows from the force in the gap.

    phi_n = phi_h + (phi_a - phi_h)/ratio,   x = phi_b - phi_n,   F = contact(x, x'),   u = -F/ratio  (leaves the gear)
    entering e: (u + tau1)/eta1 where it drives, eta2 (u + tau2) where it is driven, 0 between;   lost = e - u
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.random.description import Part
from tests.random.reference import contacts, rubbing
from tests.random.reference.switches import Context, NoEvidenceError, Table1
from tests.random.reference.system import Member, System

Values = Callable[[float], tuple[float, ...]]


def gearbox(s: System, p: Part) -> None:
    """A gear with losses, and behind it a spring with a gap."""
    a, ratio = s.node(p.node("a")) - s.node(p.node("housing")), p.field("ratio")
    row = s.node(p.node("b")) - s.node(p.node("housing")) - a / ratio
    lash = Part(
        p.name, "Lash" if p.field("half_gap") is not None else "Shaft", p.fields, p.at
    )  # without a gap: no clip
    i, (force, spring) = s.law_row(row), contacts.contact(s, lash, p.field("k"))
    s.elastic.append(row)
    heat, now = s.heats.get(p.name, -1), {"F": 0.0}

    def before(c: Context) -> None:
        now["F"] = force(c.X[i], c.V[i], 1.0)[0]

    def law(c: Context, f: list[float]) -> None:
        f[i] -= now["F"]
        if heat >= 0:
            f[-1 - heat] += (now["F"] - spring(c.X[i])) * c.V[i]

    s.commands.append(before)
    s.laws.append(law)
    values = _values(s, p)
    if values is None:
        return
    at_rest = _at_rest(p)
    if at_rest[1] < 0 or at_rest[2] > at_rest[3]:
        raise NoEvidenceError("a gearbox of which what leaves does not tell what enters")

    def sliding(c: Context, slip: float) -> float:
        ahead = _direction(s, member, slip)
        return lost(-ahead * now["F"] / ratio, values(abs(slip)))

    def limits(c: Context) -> tuple[float, float]:
        return -lost(-now["F"] / ratio, at_rest), lost(now["F"] / ratio, at_rest)

    member = Member(p.name, 1.0, lambda c: 1.0, sliding, limits)
    rubbing.group(s, a, member)


def lost(u: float, values: tuple[float, ...]) -> float:
    """What goes lost of what enters, along the motion, where u leaves."""
    eta1, eta2, tau1, tau2 = values
    enters = (u + tau1) / eta1 if u + tau1 >= 0 else min(eta2 * (u + tau2), 0.0)
    return enters - u


def _direction(s: System, member: Member, slip: float) -> float:
    """The direction in which the group of a member slides."""
    for d in s.dry:
        if member in d.members and d.mode in (1, -1):
            return float(d.mode) if member.scale > 0 else -float(d.mode)
    return 1.0 if slip >= 0 else -1.0


def _rows(p: Part) -> Any:
    rows = p.field("loss_table")
    if rows is None and p.field("efficiency") is not None:
        rows = ((0.0, *p.field("efficiency"), *p.field("bearing", (0.0, 0.0))),)
    return rows


def _at_rest(p: Part) -> tuple[float, ...]:
    rows = _rows(p)
    x = tuple(r[0] for r in rows)
    return tuple(rubbing.value_at(x, tuple(r[i] for r in rows), "linear", 0.0) for i in range(1, 5))


def _values(s: System, p: Part) -> Values | None:
    rows = _rows(p)
    if rows is None:
        return None
    if len(rows) == 1:
        return lambda w: tuple(rows[0][1:])
    x = tuple(r[0] for r in rows)
    tables = [Table1(s.sw, x, tuple(r[i] for r in rows), "linear", False) for i in range(1, 5)]
    return lambda w: tuple(t(w) for t in tables)
