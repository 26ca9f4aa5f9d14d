"""Switched constraints of one kind (friction, locks, stops, lossy gears): a row v = sum g_f w_f over the flange speeds.

Active: v = 0 with a constraint force in [lower, upper]. Inactive: a sliding force against v, forward or backward; of a stop,
none. Knows nothing of what is active, nor of trains.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp

from gearblocks.language.contributions import LossyTie, Stick, Stop
from gearblocks.laws.checks import in_pair
from gearblocks.laws.symbols import Pool

_EVALUATED = ("lower", "upper", "forward", "backward", "engaged", "gap", "restitution", "share")


@dataclass(slots=True)
class ConstraintLaw:
    """One switched constraint of a kind: a Stick, a Stop, or one of the two of a LossyTie.

    row: of G, by flange, d slip / d w. lower, upper: force bounds (None: without limit). forward, backward: sizes of the
    sliding force against the slip. of a Stop: gap and restitution. switches: numbers of its switches in the law by their
    event function: "slip" (or "gap", or "sign"), "hold", "engaged". impulse, impacts: names of states. of a LossyTie: the
    tie has `share`, the part of its constraint force that is lost while it slides; the loss has `losses` (share and rest
    driving, then coasting; the force inside is that of the tie along the slip and the rest).
    """

    name: str
    slip: Any
    row: dict[str, Any]
    lower: Any = None
    upper: Any = None
    forward: Any = sp.S.Zero
    backward: Any = sp.S.Zero
    engaged: Any = sp.S.One
    gap: Any = None
    restitution: Any = sp.S.Zero
    impulse: str | None = None
    impacts: str | None = None
    losses: tuple[Any, ...] | None = None
    share: Any = None
    partner: str | None = None
    switches: dict[str, int] = field(default_factory=dict)

    @property
    def is_stop(self) -> bool:
        """Whether it is a unilateral contact."""
        return self.gap is not None

    def map(self, f: Callable[[Any], Any]) -> ConstraintLaw:
        """With f(expression) in place of everything that the solver evaluates at an event."""
        values = {n: f(x) for n in _EVALUATED if (x := getattr(self, n)) is not None}
        losses = None if self.losses is None else tuple(f(x) for x in self.losses)
        return replace(self, **values, losses=losses)

    @property
    def kind(self) -> str:
        """friction, stop, tie (of a LossyTie) or loss."""
        if self.is_stop:
            return "stop"
        if self.share is not None:
            return "tie"
        return "loss" if self.losses else "friction"


def constraint_laws(pool: Pool, flanges: Mapping[str, Any], items: list[Any]) -> dict[str, ConstraintLaw]:
    """The switched constraints that a block yields, by name."""
    found: dict[str, ConstraintLaw] = {}
    for x in items:
        if isinstance(x, LossyTie):
            found |= {"tie": _tie(pool, flanges, x), "loss": _loss(pool, flanges, x)}
        else:
            found[x.name] = _stick(pool, flanges, x) if isinstance(x, Stick) else _stop(pool, flanges, x)
    return found


def _directions(pool: Pool) -> tuple[Any, Any]:
    """Symbols: direction of the loss, and sign of the constraint force of the tie."""
    return pool.symbol("direction", "loss", "dir_loss"), pool.symbol("direction", "tie", "dir_tie")


def _either(pool: Pool, item: LossyTie, driving: Any, coasting: Any, neither: Any) -> Any:
    """The value for the present directions: driving where slip and force inside have one sign, coasting where they have two;
    `neither` where nothing enters (the sign is 0), which there is only where the rests differ."""
    direction, sign = _directions(pool)
    side = direction * sign
    if sp.sympify(item.driving[1] - item.coasting[1]) == 0:
        same = (1 + side) / 2
        return same * sp.sympify(driving) + (1 - same) * sp.sympify(coasting)
    return side * (side + 1) / 2 * driving + side * (side - 1) / 2 * coasting + (1 - side**2) * neither


def row_of(pool: Pool, flanges: Mapping[str, Any], expr: Any, of: str) -> dict[str, Any]:
    """d expr / d (angle or speed) of each flange that moves it, through what it names."""
    moving = {n: getattr(f, of) for n, f in flanges.items()}
    spelled = sp.expand(pool.spelled(expr, set(moving.values())))
    return {n: c for n, x in moving.items() if (c := sp.diff(spelled, x)) != 0}


def _tie(pool: Pool, flanges: Mapping[str, Any], item: LossyTie) -> ConstraintLaw:
    slip = sp.expand(sp.sympify(item.tie))
    row = row_of(pool, flanges, slip, "w")
    direction, _ = _directions(pool)
    made = ConstraintLaw("tie", slip, row, partner="loss")
    made.share = direction**2 * _either(pool, item, item.driving[0], item.coasting[0], -1)
    return made.map(lambda e: along_slip(e, sp.expand(item.slip), direction))


def _loss(pool: Pool, flanges: Mapping[str, Any], item: LossyTie) -> ConstraintLaw:
    slip = sp.expand(sp.sympify(item.slip))
    row = row_of(pool, flanges, slip, "w")
    driving, coasting = ((1 + share) * rest for share, rest in (item.driving, item.coasting))
    size = _either(pool, item, driving, coasting, 0)
    made = ConstraintLaw("loss", slip, row, forward=size, backward=size, partner="tie")
    made.losses = tuple(sp.sympify(x) for x in (*item.driving, *item.coasting))
    return made.map(lambda e: along_slip(e, slip, _directions(pool)[0]))


def constraint_loss(pool: Pool, constraints: Mapping[str, ConstraintLaw]) -> Any:
    """Power that a lossy tie loses in proportion to its constraint force, or None."""
    if "tie" not in constraints or constraints["tie"].share is None:
        return None
    return constraints["tie"].share * pool.symbol("constraint_force", "tie", "held_tie") * constraints["loss"].slip


def _state(pool: Pool, state: Any) -> str | None:
    return None if state is None else pool.roles[state].of


def _stick(pool: Pool, flanges: Mapping[str, Any], item: Stick) -> ConstraintLaw:
    slip = sp.expand(sp.sympify(item.slip))
    row = row_of(pool, flanges, slip, "w")
    lower, upper = item.limit if isinstance(item.limit, tuple) else (-item.limit, item.limit)
    lower, upper = (None if sp.sympify(x).is_infinite else sp.sympify(x) for x in (lower, upper))
    if item.sliding is None:
        forward, backward = (sp.Integer(0) if x is None else x for x in (None if lower is None else -lower, upper))
    else:
        forward, backward = in_pair(item.sliding)
    direction = pool.symbol("direction", item.name, f"dir_{item.name}".rstrip("_"))
    made = ConstraintLaw(item.name, slip, row, lower, upper, sp.sympify(forward), sp.sympify(backward))
    made.engaged = sp.sympify(item.engaged)
    made.impulse = _state(pool, item.impulse)
    return made.map(lambda e: along_slip(e, slip, direction))


def _stop(pool: Pool, flanges: Mapping[str, Any], item: Stop) -> ConstraintLaw:
    gap = sp.expand(sp.sympify(item.gap))
    row = row_of(pool, flanges, gap, "phi")
    slip = sum((c * flanges[n].w for n, c in row.items()), sp.Integer(0))
    made = ConstraintLaw(item.name, slip, row, sp.Integer(0), None, gap=gap, restitution=sp.sympify(item.restitution))
    made.impulse, made.impacts = _state(pool, item.impulse), _state(pool, item.impacts)
    return made


def along(pool: Pool, constraint: ConstraintLaw, expr: Any) -> Any:
    """An expression with abs(slip) and sign(slip) of a switched constraint written with its direction."""
    return along_slip(
        expr, constraint.slip, pool.symbol("direction", constraint.name, f"dir_{constraint.name}".rstrip("_"))
    )


def sizes_of_slips(pool: Pool, constraints: Mapping[str, ConstraintLaw]) -> frozenset[Any]:
    """direction * slip of all that rub: what abs(slip) becomes along them."""
    return frozenset(
        sp.expand(pool.symbol("direction", x.name, f"dir_{x.name}".rstrip("_")) * x.slip)
        for x in constraints.values()
        if not x.is_stop
    )


def along_slip(expr: Any, slip: Any, direction: Any) -> Any:
    """abs(slip) as direction * slip, so that the law stays on one branch within a step."""

    def is_of_slip(e: Any) -> bool:
        return isinstance(e, (sp.Abs, sp.sign)) and sp.expand(e.args[0]) in (slip, sp.expand(-slip))

    def branch(e: Any) -> Any:
        if isinstance(e, sp.Abs):
            return direction * slip
        return direction if sp.expand(e.args[0]) == slip else -direction

    return expr.replace(is_of_slip, branch)


def sliding_force(pool: Pool, constraint: ConstraintLaw) -> Any:
    """The sliding force along the slip, 0 while active."""
    if constraint.is_stop:
        return sp.Integer(0)
    direction = pool.symbol("direction", constraint.name, f"dir_{constraint.name}".rstrip("_"))
    if constraint.forward == constraint.backward:
        return -direction * constraint.forward
    one = direction * (1 + direction) / 2 * constraint.forward
    return -one - direction * (1 - direction) / 2 * constraint.backward
