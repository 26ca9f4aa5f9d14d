"""Switched constraints written out: the case distinction of friction, locks, stops and lossy ties of a whole train.

    active:  G v = 0, lower <= lambda <= upper;    inactive:  lambda from the law of sliding

and, for given modes, the constraint forces in closed form. Knows nothing of how a mode is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import sympy as sp

from gearblocks.equations.notation import exactly
from gearblocks.errors import ParameterError, did_you_mean
from gearblocks.laws.printer import plain_text


@final
@dataclass(frozen=True)
class Sentence:
    """Words and expressions in a row."""

    parts: tuple[Any, ...]

    def __str__(self) -> str:
        return "".join(x if isinstance(x, str) else plain_text(x) for x in self.parts)


@final
@dataclass(frozen=True, eq=False)
class SwitchedConstraint:
    """A switched constraint of a train: a Stick, a Stop, or the tie or loss of a LossyTie (`kind`).

    torque: symbol of its constraint force, positive where it drives its slip up (a force where the slip is that of
    sliders); slip: symbol of the slip, or of the rate of the gap, and `sliding` its expression in speeds.

    lower, upper: force bounds (None: without). forward, backward: sizes of the torque against the slip. engaged: > 0 where
    friction is pressed. gap, restitution: of a Stop. lost: of a loss, its torque by direction and by whether the tie,
    whose torque is `tie`, drives; inside: the torque whose sign tells that. shown: symbols of direction, activity and
    constraint torque.
    """

    path: str
    torque: Any
    slip: Any
    sliding: Any
    lower: Any
    upper: Any
    forward: Any
    backward: Any
    engaged: Any
    gap: Any
    restitution: Any
    shown: tuple[Any, Any, Any]
    kind: str = "friction"
    tie: Any = None
    lost: Mapping[tuple[int, bool], Any] | None = None
    inside: Mapping[tuple[int, bool], Any] | None = None

    @property
    def is_stop(self) -> bool:
        """Whether it is a unilateral contact."""
        return self.gap is not None

    def mapped(self, new: Any) -> SwitchedConstraint:
        """The same with every expression replaced by new(expression)."""
        names = ("sliding", "lower", "upper", "forward", "backward", "engaged", "gap", "restitution")
        changed = {n: None if (e := getattr(self, n)) is None else new(e) for n in names}
        of_case = [n for n in ("lost", "inside") if getattr(self, n) is not None]
        for name in of_case:
            changed[name] = {case: new(e) for case, e in getattr(self, name).items()}
        values: dict[str, Any] = {n: changed.get(n, getattr(self, n)) for n in self.__dataclass_fields__}
        if values["sliding"].is_Symbol:
            one = {self.slip: values["sliding"]}
            values |= {n: e.xreplace(one) for n, e in changed.items() if isinstance(e, sp.Basic)}
            for name in of_case:
                values[name] = {case: e.xreplace(one) for case, e in values[name].items()}
            values["slip"] = values["sliding"]
        return SwitchedConstraint(**values)

    def expressions(self) -> list[Any]:
        """Everything that stands in its cases."""
        found = (self.sliding, self.lower, self.upper, self.forward, self.backward, self.engaged)
        cases = [*(self.lost or {}).values(), *(self.inside or {}).values()]
        return [x for x in (*found, self.gap, self.restitution, *cases) if x is not None]

    def torque_in(self, mode: int, sign: int = 1) -> Any:
        """The torque in a mode (1, -1: slides; 2: free; of a stop 0: open), None while active. sign: of the tie's
        torque."""
        if self.is_stop:
            return None if mode == 1 else sp.Integer(0)
        if self.kind == "tie":
            return None
        if self.lost is not None and mode:
            return self.lost[mode, mode == sign]
        return {1: -self.forward, -1: self.backward, 2: sp.Integer(0)}.get(mode)

    def shown_in(self, mode: int) -> dict[Any, Any]:
        """Direction, activity and constraint torque in a mode."""
        active = self.torque_in(mode) is None
        direction = mode if mode in (1, -1) and not self.is_stop else 0  # of a tie the sign of its torque
        values = (sp.Integer(direction), sp.Integer(active), self.torque if active else sp.Integer(0))
        return dict(zip(self.shown, values, strict=True))

    def meanings(self) -> tuple[str, str, str]:
        """Words for the symbols of direction, activity and constraint torque."""
        direction = ": sign of the torque" if self.kind == "tie" else ": 1 while it slides forward, -1 backward, else 0"
        word = "closed" if self.is_stop else "stuck"
        return direction, f": 1 while {word}, else 0", f": the torque while {word}, else 0"

    # -- in words -----------------------------------------------------------------------------------------------------

    def cases(self) -> Iterator[Any]:
        """What it does in each of its states, line by line."""
        if self.slip != self.sliding:
            yield sp.Eq(self.slip, self.sliding, evaluate=False)
        of = {"stop": self._of_stop, "tie": self._of_tie, "loss": self._of_loss}
        yield from of.get(self.kind, self._of_stick)()

    def _of_stick(self) -> Iterator[Any]:
        zero = sp.Integer(0)
        both = self.lower is not None and self.upper is not None
        if both and self.forward == self.backward and self.slip not in self.forward.free_symbols:
            law = sp.Eq(self.torque, -self.forward * sp.sign(self.slip), evaluate=False)
            yield Sentence(("slides, ", sp.Ne(self.slip, zero, evaluate=False), ": ", law))
        elif self.lower is not None or self.upper is not None:
            for words, relation, mode in (("forward", sp.Gt, 1), ("backward", sp.Lt, -1)):
                law = sp.Eq(self.torque, self.torque_in(mode), evaluate=False)
                if (self.upper if mode < 0 else self.lower) is not None:
                    yield Sentence((f"slides {words}, ", relation(self.slip, zero, evaluate=False), ": ", law))
        still = sp.Eq(self.slip, zero, evaluate=False)
        held = sp.Eq(sp.Symbol(f"{self.slip.name}'", real=True), zero, evaluate=False)
        yield Sentence(("sticks, ", still, ": ", held, " determines ", self.torque, *self._within()))
        if not self.engaged.is_positive:
            law = sp.Eq(self.torque, zero, evaluate=False)
            yield Sentence(("free, ", sp.Le(self.engaged, zero, evaluate=False), ": ", law))

    def _within(self) -> tuple[Any, ...]:
        """Words for the bounds of the constraint torque."""
        lower, upper = self.lower, self.upper
        if lower is None and upper is None:
            return (", without limit",)
        if lower is not None and upper is not None and sp.expand(lower + upper) == 0:
            return (", ", sp.Le(sp.Abs(self.torque), upper, evaluate=False))
        bounds = [sp.Ge(self.torque, lower, evaluate=False)] if lower is not None else []
        bounds += [sp.Le(self.torque, upper, evaluate=False)] if upper is not None else []
        return (", ", bounds[0], *((" and ", bounds[1]) if len(bounds) == 2 else ()))

    def _of_tie(self) -> Iterator[Any]:
        still = sp.Eq(self.slip, sp.Integer(0), evaluate=False)
        yield Sentence(("always ", still, ": ", self.torque, " is what keeps it at 0"))

    def _of_loss(self) -> Iterator[Any]:
        zero = sp.Integer(0)
        for (mode, drives), torque in (self.lost or {}).items():
            inside = (self.inside or {})[mode, drives]
            turns = (sp.Gt if mode > 0 else sp.Lt)(self.slip, zero, evaluate=False)
            relation = (sp.Ge if mode > 0 else sp.Le) if drives else (sp.Lt if mode > 0 else sp.Gt)
            words = "drives" if drives else "is driven"
            law = sp.Eq(self.torque, torque, evaluate=False)
            yield Sentence((f"{words}, ", turns, " and ", relation(inside, zero, evaluate=False), ": ", law))
        still = sp.Eq(self.slip, zero, evaluate=False)
        yield Sentence(
            ("sticks, ", still, ": ", self.torque, " is what keeps it at rest, between its values in either direction")
        )

    def _of_stop(self) -> Iterator[Any]:
        zero = sp.Integer(0)
        none = sp.Eq(self.torque, zero, evaluate=False)
        yield Sentence(("open, ", sp.Gt(self.gap, zero, evaluate=False), ": ", none))
        push = sp.Ge(self.torque, zero, evaluate=False)
        yield Sentence(("closed, ", sp.Eq(self.gap, zero, evaluate=False), ": ", self.torque,
                        " is what keeps the gap at 0, as long as ", push))  # fmt: skip
        rebound = sp.Mul(-self.restitution, self.slip)
        yield Sentence(("impact as the gap closes: ", self.slip, " becomes ", rebound))


def in_order(switched_constraints: Sequence[SwitchedConstraint], used: set[Any]) -> list[Any]:
    """The cases of all of them, and what the symbols of their modes mean that are among those used."""
    meaning = [
        Sentence((x, words))
        for c in switched_constraints
        for x, words in zip(c.shown, c.meanings(), strict=True)
        if x in used
    ]
    return [line for c in switched_constraints for line in c.cases()] + meaning


def wanted(switched_constraints: Sequence[SwitchedConstraint], modes: Mapping[str, float]) -> dict[str, int]:
    """Modes by path, checked. Raises ParameterError for an unknown name or mode."""
    known = {r.path: r for r in switched_constraints}
    found: dict[str, int] = {}
    for name, mode in modes.items():
        ends = [p for p in known if p == name or p.endswith("." + name)]
        if name not in known and len(ends) != 1:
            raise ParameterError(f"modes: no friction or stop is named '{name}'{did_you_mean(name, known)}")
        path = name if name in known else ends[0]
        allowed, words = _MODES[known[path].kind]
        if mode not in allowed:
            raise ParameterError(f"modes: '{path}' = {mode!r} must be one of: {words}")
        found[path] = int(mode)
    ties = {r.torque: r.path for r in switched_constraints if r.kind == "tie"}
    for r in switched_constraints:
        if r.tie in ties and (r.path in found) != (ties[r.tie] in found):
            raise ParameterError(f"modes: '{r.path}' and '{ties[r.tie]}' belong together; give both, or none")
    return found


_MODES = {
    "friction": ((0, 1, -1, 2), "0 stuck, 1 forward, -1 backward, 2 free"),
    "stop": ((0, 1), "1 closed, 0 open"),
    "loss": ((0, 1, -1), "0 stuck, 1 forward, -1 backward"),
    "tie": ((1, -1), "1 its torque is positive, -1 negative"),
}


def constraint_torques(
    switched_constraints: Sequence[SwitchedConstraint],
    mass: Any,
    forcing: Any,
    v: Sequence[Any],
    rates: Mapping[Any, Any],
    t: Any,
) -> list[Any]:
    """Constraint forces T of an active set: G M^-1 (f + F T) + acceleration bias = 0, W T = -(...) with W = G M^-1 F.

    The minimum-norm split where rows of G are dependent. forcing: f + F T, without definitions of these torques. rates: of
    angles and of what stands for functions of these.
    """
    moving = [i for i in range(mass.shape[0]) if any(mass[i, j] != 0 for j in range(mass.shape[1]))]
    torques = [r.torque for r in switched_constraints]
    G = sp.Matrix([[sp.diff(r.sliding, x) for x in v] for r in switched_constraints])
    bias = sp.Matrix(
        [
            sum((sp.diff(r.sliding, x) * w for x, w in rates.items()), sp.diff(r.sliding, t))
            for r in switched_constraints
        ]
    )
    bare = forcing.xreplace(dict.fromkeys(torques, sp.Integer(0)))
    F = forcing.jacobian(torques)[moving, :]
    M, G, bare = mass.extract(moving, moving), G[:, moving], sp.Matrix([bare[i] for i in moving])
    rows = list(G.T.rref()[1])  # the first of dependent ones
    own = G[rows, :]
    answer = _over(M, sp.Matrix.hstack(bare, F))
    free, delassus = own * answer[:, :1] + bias[rows, :], own * answer[:, 1:]
    dependent = len(rows) < len(switched_constraints)  # then the minimum-norm split
    forces = -delassus.T * (delassus * delassus.T).LUsolve(free) if dependent else -delassus.LUsolve(free)
    return [_short(x) for x in forces]


def _short(expr: Any) -> Any:
    """The same in few terms: what is rational in the symbols is reduced, decimals are left as they are."""
    numbers = {x: sp.Dummy(real=True) for x in expr.atoms(sp.Float)}
    ratios = {x: sp.Rational(near.numerator, near.denominator) for x in expr.atoms(sp.Rational) if (near := exactly(x))}
    whole = sp.together(expr.xreplace({**ratios, **numbers}))
    found = [sp.factor_terms(whole)]
    if sp.count_ops(whole) < _MANY:
        found += [sp.factor_terms(sp.cancel(whole)), sp.factor(whole)]
    return min(found, key=sp.count_ops).xreplace({x: number for number, x in numbers.items()})


_MANY = 400
"""Operations up to which an expression is reduced; polynomials of many symbols take long."""


def _over(mass: Any, right: Any) -> Any:
    """M^-1 times a matrix."""
    if mass.is_diagonal():
        return sp.Matrix(mass.rows, right.cols, lambda i, j: right[i, j] / mass[i, i])
    return mass.LUsolve(right)
