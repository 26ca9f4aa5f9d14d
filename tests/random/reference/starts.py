"""Start values of a run: those given, those that follow from ties, and nodes without inertia in balance."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np

from tests.random.description import senses
from tests.random.reference.equilibrium import at_rest
from tests.random.reference.given_starts import asks_more, told
from tests.random.reference.switches import NoEvidenceError, is_zero
from tests.random.reference.system import Array


def start(d: Any, perturbation: float, given: Array | None = None, draw: int = 0) -> Array:
    """Start values that agree with the given ones and the ties. given: angles at which a run starts at rest."""
    s, random = d.s, Random(f"reference {d.s.train.seed}" + f" {draw}" * (draw > 0))
    if asks_more(s.train):
        return told(d, perturbation, given, random)
    rows, angles, speeds, sped = [], [], [], []
    for p in s.train.bodies:
        row = s.N[s.index[p.node("a")]]
        for name, values, kept in ((("phi0", "s0"), angles, rows), (("w0", "v0"), speeds, sped)):
            value = p.field(name[0], p.field(name[1]))
            if value is not None:
                kept.append(row)
                values.append(value)
    n = s.N.shape[1]
    s.context.t = 0.0
    tied = [g.ra - g.ratio * g.rb for g in s.lossy]
    for turned, angle in (tie.starts for tie in s.nonlinear if tie.starts is not None):
        rows.append(turned @ s.N)
        angles.append(angle(s.context))
    q = _met(s, rows + tied, _fit(rows + tied, angles + [0.0] * len(tied), n))
    guided = [x.rate(q, np.zeros(n), s.context) for x in s.nonlinear]
    v0 = _fit(sped + tied + [x[0] for x in guided], speeds + [0.0] * len(tied) + [x[1] for x in guided], n)
    if perturbation:
        free = _free(tied + [x[0] for x in guided], n)
        change = free @ np.array([random.uniform(-1, 1) for _ in range(free.shape[1])])
        v0 = v0 + perturbation * _speeds(s, v0) * change
    qr, vr = s.Ur.T @ q, s.Ur.T @ v0
    s.context.t = 0.0
    driven = np.array([x(s.context) for x in d.driven_from])
    y = np.concatenate([qr, _balanced(d, qr, vr), vr, driven, np.array(s.start)])
    return at_rest(d, y, None if given is None else given[0]) if s.train.initial == "static" else y


def _met(s: Any, rows: list[Array], q: Array) -> Array:
    """Start angles moved until nonlinear ties hold, by Newton's method from those that `rows` ask for, which stay."""
    ties = [x for x in s.nonlinear if x.apart is not None]
    if not any(float(side @ s.N @ q) != 0 for x in ties for side in x.sides):
        return q  # all at zero, where each of them holds
    for _ in range(60):
        missed = [x.apart(q, s.context) for x in ties]
        A = np.array([*rows, *(x.rate(q, np.zeros(len(q)), s.context)[0] for x in ties)])
        if max(abs(x) for x in missed) <= 1e-14 * max(1.0, float(np.abs(q).max())):
            break
        q = q - np.linalg.lstsq(A, np.r_[np.zeros(len(rows)), missed], rcond=1e-12)[0]
    else:
        raise NoEvidenceError("start angles that a nonlinear tie does not meet")
    free = _free(list(A), len(q))
    if any(not is_zero(side @ s.N @ free) for x in ties for side in x.sides if float(side @ s.N @ q) != 0):
        raise NoEvidenceError("a nonlinear tie off zero at angles that nobody gives")
    return q


def _balanced(d: Any, qr: Array, vr: Array) -> Array:
    """Start angles of nodes without inertia: nobody gives them, so they rest in balance with what is at rest."""
    s, c = d.s, d.s.context
    if not d.n1:
        return np.zeros(0)
    c.t, c.s, Z = 0.0, list(s.start), np.hstack([s.Z1, s.Z2])
    wp = np.array([drive(c) for drive in d.drives])  # signals of other torques read speeds, and none of a massless node
    c.X, c.V = (s.R @ (s.Ur @ qr)).tolist(), (s.R @ (s.Ur @ vr) + s.RP @ wp).tolist()
    push = s.torque_rows.T @ np.array([f(c) for _, f, _ in s.torques]) if s.torques else np.zeros(len(Z))
    stiffness = Z.T @ s.K @ Z
    if np.linalg.cond(stiffness) > 1e10:
        raise NoEvidenceError("a massless node that only dampers hold")
    return np.asarray(np.linalg.solve(stiffness, Z.T @ (push - s.K @ (s.Ur @ qr)))[: d.n1])


def _speeds(s: Any, v0: Array) -> Array:
    """For every coordinate the largest start speed of those that hang together with it, at least 1."""
    group = {name: {name} for name in s.node_names}
    for part in s.train.parts:
        names = [n for _, n in part.at if n in group] + [p.node("a") for p in s.train.bodies if p.name in senses(part)]
        joined = set().union(*(group[n] for n in names))
        group |= dict.fromkeys(joined, joined)
    out = np.empty(len(v0))
    for i in range(len(v0)):
        near = s.N[[s.index[n] for n in group[s.node_names[int(np.argmax(np.abs(s.N[:, i])))]]]]
        out[i] = max(float(np.abs(v0[np.abs(near).max(axis=0) > 0]).max()), 1.0)
    return out


def _fit(rows: list[Array], values: list[float], n: int) -> Array:
    if not rows:
        return np.zeros(n)
    A, b = np.array(rows), np.array(values)
    x = np.linalg.lstsq(A, b, rcond=1e-12)[0]
    if np.abs(A @ x - b).max() > 1e-9 * max(1.0, np.abs(b).max()):
        raise NoEvidenceError("start values that contradict each other")
    return np.asarray(x)


def _free(rows: list[Array], n: int) -> Array:
    """Directions that the rows leave open."""
    if not rows:
        return np.eye(n)
    _, size, V = np.linalg.svd(np.array(rows).reshape(-1, n))
    rank = int((size > 1e-10 * size.max()).sum())
    return np.asarray(V[rank:].T)
