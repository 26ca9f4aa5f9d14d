"""Coordinates of a train from its description: nodes, rigid ties by elimination, masses, springs and dampers as matrices.

    phi_nodes = N z + P p(t),    M z'' = f;    z = Ur qr + Z1 q1 + Z2 q2

Z1, Z2: directions without inertia, with and without damping; q1' and q2 follow from the balance there. Written anew in numpy;
knows nothing of gearblocks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.random.description import FIXED, Part, Train
from tests.random.expressions import Node, walk
from tests.random.reference.switches import Compiler, Context, NoEvidenceError, Signal, Switches, is_zero

Array = NDArray[np.float64]
BEHIND = ("alpha", "acceleration", "b.tau", "b.power", "torque")  # of bodies and rigid parts
Law = Callable[[Context, list[float]], None]


@dataclass
class Member:
    """One friction element of a group. scale: its slip over that of the group; limits: of what it holds, along its slip."""

    name: str
    scale: float
    engaged: Signal
    sliding: Callable[[Context, float], float]
    limits: Callable[[Context], tuple[float, float]]
    one_way: bool = False
    teeth: Signal | None = None  # of a synchronizer: asks for the lock
    locked: bool = False
    dog: bool = False
    on: bool = True
    switch: int = -1
    heat: int = -1  # state that counts what it loses


@dataclass
class Dry:
    """Friction elements with one and the same slip (but for a factor). mode: 0 stuck, +-1 slides, 2 free."""

    row: Array
    members: list[Member] = field(default_factory=list)
    mode: int = 0


@dataclass
class Stop:
    """A unilateral contact: gap = row q - bound >= 0. mode: 0 closed, 1 open."""

    row: Array
    bound: float
    restitution: float
    mode: int = 1
    heat: int = -1  # state that counts what impacts lose


@dataclass
class Lossy:
    """A lossy gear: tau_b = -ratio (tau_a - loss).

    mode: (0, 0) stuck, else (sign of w_a, 1: a drives, 0: b drives, 2: nothing enters at a).
    """

    ra: Array
    rb: Array
    ratio: float
    values: Callable[[float], tuple[float, float, float, float]]  # eta1, eta2, tau1, tau2 over abs(w_a)
    mode: tuple[int, int] = (0, 0)
    heat: int = -1  # state that counts what it loses


@dataclass
class Tie:
    """A nonlinear tie, or a motion that is prescribed: rate(q, v, context) -> (row, row v as asked, row a as asked).

    sides, apart: rows over nodes of both angles, and by how much they miss the tie; starts: of a prescribed node its row over
    nodes and its angle at the start.
    """

    rate: Callable[[Array, Array, Context], tuple[Array, float, float]]
    sides: tuple[Array, ...] = ()
    apart: Callable[[Array, Context], float] | None = None
    starts: tuple[Array, Signal] | None = None


@dataclass
class Pair:
    """A compliant pair whose ratio varies: q = F(phi_a + phase) - F(phase) + sign phi_b is 0 where it carries nothing."""

    name: str
    a: Array
    b: Array
    sign: float
    phase: float
    law: tuple[Callable[[float], float], Callable[[float], float]]

    def deflection(self, q: Array, v: Array) -> tuple[float, float]:
        """q and q' at angles and speeds of nodes."""
        F, m = self.law
        x = float(self.a @ q) + self.phase
        return F(x) - F(self.phase) + self.sign * float(self.b @ q), m(x) * float(self.a @ v) + self.sign * float(
            self.b @ v
        )


class System:
    """Everything the integration needs; filled by `elements`."""

    def __init__(self, train: Train, held: bool = False) -> None:
        self.train, self.held = train, held  # held: prescribed nodes are bodies that a tie moves
        self.sw = Switches()
        self.node_names = list(train.nodes())
        self.index = {n: i for i, n in enumerate(self.node_names)}
        self.J = np.zeros(len(self.node_names))
        self.ties: list[Array] = []
        self.prescribed: dict[str, tuple[Any, str]] = {}  # node -> (signal, "speed" or "angle")
        self.laws: list[Law] = []
        self.commands: list[Callable[[Context], None]] = []  # what signals of other parts read, before all else
        self.after: list[Law] = []  # rates of states that read accelerations
        self.stores: dict[str, Any] = {}  # thermal masses by name
        self.heats: dict[str, int] = {}  # state that counts the heat of a part
        self.law_rows: list[Array] = []  # over nodes, until `reduce`
        self.springs: list[tuple[Array, float]] = []
        self.dampers: list[tuple[Array, float]] = []
        self.torques: list[tuple[Array, Signal, bool]] = []  # row, signal, whether of time alone
        self.dry: list[Dry] = []
        self.stops: list[Stop] = []
        self.lossy: list[Lossy] = []
        self.nonlinear: list[Tie] = []
        self.iwan: list[Any] = []
        self.pairs: list[Pair] = []
        self.elastic: list[Array] = []  # deformations that a force answers, over nodes
        self.extra = 0  # number of further states
        self.start: list[float] = []  # their start values
        self.context = Context()
        self.sensed: dict[str, int] = {}
        self.aux: dict[str, int] = {}
        self.compile = Compiler(self.sw, self.sense, dict(train.inputs))

    # -- composing ----------------------------------------------------------------------------------------------------

    def node(self, name: str) -> Array:
        """The row of a node's angle."""
        row = np.zeros(len(self.node_names))
        if name not in FIXED:
            row[self.index[name]] = 1.0
        return row

    def law_row(self, row: Array) -> int:
        """A row whose value and rate laws read, and along which they act."""
        self.law_rows.append(row)
        return len(self.law_rows) - 1

    def state(self, start: float = 0.0) -> int:
        """A further state."""
        self.start.append(start)
        self.extra += 1
        return self.extra - 1

    def sense(self, path: str) -> Signal:
        """An output of a part as a signal."""
        name, _, output = path.partition(".")
        if output == "T":
            return lambda c: self.stores[name].temperature(c)
        if output not in ("phi", "w", "s", "v", "command"):
            return self.sensed_output(next(p for p in self.train.parts if p.name == name), output)
        if output in ("phi", "w", "s", "v"):
            if name not in self.sensed:
                body = next(p for p in self.train.parts if p.name == name)
                self.sensed[name] = self.law_row(self.node(body.node("a")))
            i = self.sensed[name]
            signal: Any = (lambda c: c.X[i]) if output in ("phi", "s") else (lambda c: c.V[i])
            return _Sensed(signal, i if output == "phi" else None)
        i = self.aux.setdefault(path, len(self.aux))
        return lambda c: c.aux[i]

    def follows_motion(self, x: Any) -> bool:
        """Whether a signal reads accelerations."""
        paths = [n.args[0].partition(".") for n in walk(x) if n.op == "sense"]
        rigid = {p.name for p in self.train.parts if p.block not in ("Shaft", "Damper")}
        return any(name in rigid and output in BEHIND for name, _, output in paths)

    def sensed_output(self, p: Part, output: str) -> Signal:
        """An output of a shaft, a damper or a body; of a gear or a clutch the torque on what hangs on its b alone."""
        if p.is_body and output in ("alpha", "acceleration"):
            i = self.law_row(self.node(p.node("a")))
            return lambda c: c.A[i]
        if p.block in ("Shaft", "Damper"):
            i = self.law_row(self.node(p.node("b")) - self.node(p.node("a")))
            k, c_ = p.field("k", 0.0), p.field("c", 0.0)
            at_a = self.law_row(self.node(p.node("a")))
            found: dict[str, Signal] = {
                "twist": lambda c: c.X[i], "twist_rate": lambda c: c.V[i], "w_rel": lambda c: c.V[i],
                "torque": lambda c: -k * c.X[i] - c_ * c.V[i], "loss_power": lambda c: c_ * c.V[i] ** 2,
                "a.power": lambda c: (k * c.X[i] + c_ * c.V[i]) * c.V[at_a],
            }  # fmt: skip
            if output in found and p.field("rest") is None and p.field("torque") is None:
                return found[output]
        near = [other for other in self.train.parts if other is not p and p.node("b") in [n for _, n in other.at]]
        if len(near) == 1 and near[0].is_body and output in ("b.tau", "b.power", "torque"):
            J, i = near[0].field("J"), self.law_row(self.node(p.node("b")))
            return (lambda c: J * c.A[i] * c.V[i]) if output == "b.power" else (lambda c: J * c.A[i])
        raise NoEvidenceError(f"the output {p.name}.{output}")

    def rises(self, states: Any) -> list[float]:
        """Rises of the temperatures of all thermal masses."""
        return [store.rise(states) for store in self.stores.values()]

    # -- reduction ----------------------------------------------------------------------------------------------------

    def reduce(self) -> None:
        """Eliminates ties and separates what has no inertia."""
        self._eliminate()
        n = self.N.shape[1]
        self.M = self.N.T @ (self.J[:, None] * self.N)
        self.MP = self.N.T @ (self.J[:, None] * self.P)
        self.R = np.array(self.law_rows).reshape(-1, len(self.node_names)) @ self.N
        self.RP = np.array(self.law_rows).reshape(-1, len(self.node_names)) @ self.P
        self.K, self.C = np.zeros((n, n)), np.zeros((n, n))
        self.KP, self.CP = np.zeros((n, self.P.shape[1])), np.zeros((n, self.P.shape[1]))
        for rows, matrix, driven in ((self.springs, self.K, self.KP), (self.dampers, self.C, self.CP)):
            for row, k in rows:
                r = row @ self.N
                matrix += k * np.outer(r, r)
                driven += k * np.outer(r, row @ self.P)
        self.torque_rows = np.array([row @ self.N for row, _, _ in self.torques]).reshape(-1, n)
        self._massless()

    def _eliminate(self) -> None:
        """N, P with phi = N z + P p: pivots are nodes of little inertia, prescribed nodes never."""
        count = len(self.node_names)
        given = [self.index[n] for n in self.prescribed]
        A = np.array(self.ties).reshape(-1, count).copy()
        order = sorted((i for i in range(count) if i not in given), key=lambda i: (self.J[i] > 0, -i))
        pivots: list[int] = []
        row = 0
        for column in order:
            if row >= len(A):
                break
            best = row + int(np.argmax(np.abs(A[row:, column])))
            if abs(A[best, column]) < 1e-9:
                continue
            A[[row, best]] = A[[best, row]]
            A[row] /= A[row, column]
            for other in range(len(A)):
                if other != row:
                    A[other] -= A[other, column] * A[row]
            pivots.append(column)
            row += 1
        if row < len(A) and not is_zero(A[row:]):
            raise NoEvidenceError("ties of prescribed motions")
        free = [i for i in range(count) if i not in pivots and i not in given]
        T = np.zeros((count, len(free) + len(given)))
        for j, i in enumerate([*free, *given]):
            T[i, j] = 1.0
            for k, pivot in enumerate(pivots):
                T[pivot, j] = -A[k, i]
        self.N, self.P = T[:, : len(free)], T[:, len(free) :]

    def _massless(self) -> None:
        n = len(self.M)
        eigen, U = np.linalg.eigh(self.M)
        none = eigen < 1e-13 * max(float(eigen.max(initial=0.0)), 1e-300)
        if not none.any():
            self.Ur, self.Z1, self.Z2 = np.eye(n), np.zeros((n, 0)), np.zeros((n, 0))
            self.Minv = np.linalg.inv(self.M)
            return
        self.Ur, Z = U[:, ~none], U[:, none]
        damped, V = np.linalg.eigh(Z.T @ self.C @ Z)
        top = max(float(damped.max(initial=0.0)), 1e-300)
        self.Z1, self.Z2 = Z @ V[:, damped > 1e-12 * top], Z @ V[:, damped <= 1e-12 * top]
        if self.Z1.shape[1] and damped.max() <= 0:
            raise NoEvidenceError("massless directions")
        if not is_zero(self.C @ self.Z2):
            raise NoEvidenceError("damping that is no square")
        self.Minv = self.Ur @ np.linalg.inv(self.Ur.T @ self.M @ self.Ur) @ self.Ur.T
        self.C11 = np.linalg.inv(self.Z1.T @ self.C @ self.Z1)
        K22 = self.Z2.T @ self.K @ self.Z2
        if len(K22) and np.linalg.cond(K22) > 1e8:
            raise NoEvidenceError("a massless node that nothing holds")
        self.K22 = np.linalg.inv(K22)
        units = [d.row for d in self.dry] + [s.row for s in self.stops] + [r for x in self.lossy for r in (x.ra, x.rb)]
        rows = [*self.R, *(r @ self.N for r in units)]
        if not all(is_zero(r @ Z) for r in rows):
            raise NoEvidenceError("a law or switch beside a massless node")
        for (_, _, timely), row in zip(self.torques, self.torque_rows, strict=True):
            if not timely and not is_zero(row @ Z):
                raise NoEvidenceError("a controlled torque on a massless node")

    @property
    def has_massless(self) -> bool:
        """Whether there are directions without inertia."""
        return self.Z1.shape[1] + self.Z2.shape[1] > 0


class _Sensed:
    """A sensed value that knows its row."""

    def __init__(self, signal: Signal, row: int | None) -> None:
        self.signal, self.row = signal, row

    def __call__(self, c: Context) -> float:
        return float(self.signal(c))


def derivative(x: Any) -> Any:
    """The derivative of a tree over time; NoEvidenceError where it has none."""
    if not isinstance(x, Node):
        return 0.0
    if x.op == "time":
        return 1.0
    if x.op == "+":
        return _sum(derivative(x.args[0]), derivative(x.args[1]))
    if x.op == "*":
        a, b = x.args
        return _sum(_product(derivative(a), b), _product(a, derivative(b)))
    if x.op == "sin":
        return _product(Node("cos", x.args), derivative(x.args[0]))
    if x.op == "cos":
        return _product(-1.0, _product(Node("sin", x.args), derivative(x.args[0])))
    if x.op == "exp":
        return _product(x, derivative(x.args[0]))
    raise NoEvidenceError(f"the rate of {x.op}")


def _sum(a: Any, b: Any) -> Any:
    if not isinstance(a, Node) and not isinstance(b, Node):
        return a + b
    return b if a == 0.0 else a if b == 0.0 else Node("+", (a, b))


def _product(a: Any, b: Any) -> Any:
    if not isinstance(a, Node) and not isinstance(b, Node):
        return a * b
    return 0.0 if a == 0.0 or b == 0.0 else b if a == 1.0 else a if b == 1.0 else Node("*", (a, b))
