"""Starts that no values of bodies tell: rolling, between bodies, by accelerations.

The start of a run is taken, and it is looked at whether it is as asked: by rows over nodes, and by the accelerations that the
equations here give there.
"""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np

from tests.random.description import Part, Train
from tests.random.reference.switches import NoEvidenceError
from tests.random.reference.system import Array, System

NEAR = 1e-12
MET = 1e-6  # of an acceleration that is met by a start


class WrongStartError(Exception):
    """A start that is not as asked."""


def asks_more(train: Train) -> bool:
    """Whether values of bodies and ties alone do not tell the start."""
    relative = any(p.field(n) is not None for p in train.parts for n in ("phi_rel0", "w_rel0", "alpha0", "a0"))
    return train.initial not in (None, "static") or relative


def told(d: Any, perturbation: float, given: Array | None, random: Random) -> Array:
    """The start of a run, as a state; WrongStartError where it is not as asked."""
    s: System = d.s
    if given is None or s.has_massless or s.nonlinear or d.np:
        raise NoEvidenceError("this start")
    bodies = s.N[[s.index[p.node("a")] for p in s.train.bodies]]
    if np.linalg.matrix_rank(bodies) < bodies.shape[1]:
        raise NoEvidenceError("a start that bodies do not tell")
    q, v = (np.linalg.lstsq(bodies, x, rcond=1e-12)[0] for x in given)
    for name, found, asked in _conditions(s, q, v, given):
        if abs(found - asked) > NEAR * max(float(np.abs(given).max()), 1.0):
            raise WrongStartError(f"{name} = {found:.9g} at the start, asked for {asked:.9g}")
    if perturbation:
        change = np.array([random.uniform(-1, 1) for _ in v])
        if s.lossy:  # their speeds stay in their ratio
            tied = np.array([g.ra - g.ratio * g.rb for g in s.lossy])
            change -= np.linalg.pinv(tied) @ (tied @ change)
        v = v + perturbation * max(float(np.abs(v).max(initial=0.0)), 1.0) * change
    y = np.concatenate([q, v, np.zeros(d.np), np.array(s.start)])
    _accelerations(d, y)
    return y


def _conditions(s: System, q: Array, v: Array, given: Array) -> list[tuple[str, float, float]]:
    """(what, found, asked) of every value that a start asks for."""
    rolls, out = s.train.initial is not None, []
    named: dict[str, float] = dict(s.train.initial) if isinstance(s.train.initial, tuple) else {}
    angle, speed = {"phi": 0, "s": 0}, {"w": 1, "v": 1}
    for i, p in enumerate(s.train.bodies):
        out += [(n, float(given[(angle | speed)[n[-1]], i]), x) for n, x in named.items() if n.split(".")[0] == p.name
                and n[-1] in "swv"]  # fmt: skip
        out += [(n, float(given[0, i]), x) for n, x in named.items() if n == f"{p.name}.phi"]
        for field, value in (("phi0", given[0, i]), ("s0", given[0, i]), ("w0", given[1, i]), ("v0", given[1, i])):
            if p.field(field) is not None and not rolls:
                out.append((f"{p.name}.{field}", float(value), p.field(field)))
    for p in s.train.parts:
        if p.block in ("Shaft", "Lash"):
            row = (s.node(p.node("b")) - s.node(p.node("a"))) @ s.N
            twist, rate = p.field("phi_rel0", undeformed(p)), p.field("w_rel0", 0.0)
            asks = rolls or any(x.field("phi_rel0") is not None for x in s.train.parts)
            out += [(f"{p.name}.twist", float(row @ q), twist)] if asks or p.field("phi_rel0") is not None else []
            asks = rolls or any(x.field("w_rel0") is not None for x in s.train.parts)
            out += [(f"{p.name}.twist_rate", float(row @ v), rate)] if asks or p.field("w_rel0") is not None else []
    for pair in s.pairs if rolls else ():
        deflection, rate = pair.deflection(s.N @ q, s.N @ v)
        out += [(f"{pair.name}.deflection", deflection, 0.0), (f"{pair.name}.deflection_rate", rate, 0.0)]
    if rolls:
        out += [("a gear with losses", float((g.ra - g.ratio * g.rb) @ v), 0.0) for g in s.lossy]
    return out


def undeformed(p: Part) -> float:
    """The twist at which an element carries nothing."""
    low, high = p.field("lower"), p.field("upper")
    return float(p.field("rest", 0.0) + max(0.0 if low is None else low, 0.0) + min(0.0 if high is None else high, 0.0))


def _accelerations(d: Any, y: Array) -> None:
    s: System = d.s
    asked = [(p, p.field("alpha0", p.field("a0"))) for p in s.train.bodies]
    if all(value is None for _, value in asked):
        return
    if not d.plain:
        raise NoEvidenceError("start accelerations beside switched constraints")
    for _ in range(2):  # signals that read what others compute
        a = s.N @ d(0.0, y)[d.cut[1] : d.cut[2]]
    for p, value in asked:
        found = float(a[s.index[p.node("a")]])
        if value is not None and abs(found - value) > MET * max(abs(found), abs(value)):
            raise WrongStartError(f"{p.name}.alpha = {found:.9g} at the start, asked for {value:.9g}")
