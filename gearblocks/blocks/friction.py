"""Dry friction with stick: clutch, brake, bearing, and what such elements share.

Slides: force mu N against the slip. Stuck: slip = 0, constraint force within +-peak times the sliding force at rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from gearblocks.language.block import Block, Effect
from gearblocks.language.contributions import Acts, Contribution, Energy, Rate, Shows, Start, Stick
from gearblocks.language.expression import Expr, as_expr, evaluate
from gearblocks.language.fields import Flange, State, effect, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Table, Value

CAPACITY: Any = signal("torque that it transmits while it slips", "N m", default=None, ge=0, over="slip")
MU: Any = signal("coefficient of friction, also over abs(slip)", default=None, ge=0, over="slip")
FORCE_MAX: Any = param("largest normal force", "N", default=None, ge=0, symbol="F_max")
ENGAGEMENT: Any = signal("normal force over the largest one", default=None, symbol="f_n")
GEOMETRY: Any = param("friction torque over mu times normal force", "m", default=1.0, gt=0, symbol="r_e")
PEAK: Any = param("largest torque while stuck over the slip torque at rest", default=1.0, ge=1, symbol="p")


@dataclass(frozen=True, slots=True)
class DryFriction:
    """Symbols of a friction element: free where engaged <= 0; sliding force; bounds of the constraint force."""

    engaged: Any
    sliding: Any
    limit: Any


def friction_problems(block: Any) -> Iterator[str]:
    """Problems of capacity, or of mu, force_max and engagement; geometry and force_max belong to the latter."""
    normal = ("mu", "force_max", "engagement")
    given = [name for name in normal if getattr(block, name) is not None]
    if block.capacity is not None and given:
        yield f"capacity and {', '.join(given)} are both given; give capacity, or mu, force_max and engagement"
    elif block.capacity is None and not given:
        yield "what it can transmit is missing: give capacity, or mu, force_max and engagement"
    elif given and len(given) < len(normal):
        yield f"{', '.join(given)}: {', '.join(n for n in normal if n not in given)} missing; give all three, or capacity"
    if block.capacity is not None and block.geometry != 1:
        yield f"geometry = {block.geometry!r} goes with mu, force_max and engagement; capacity is the torque itself"
    yield from over_slip_problems("mu", block.mu)
    if _is_over_slip(block.capacity):
        yield from over_slip_problems("capacity", block.capacity)


def _is_over_slip(value: Any) -> bool:
    """Whether gb.slip stands in an expression."""
    return isinstance(value, Expr) and any(leaf.op == "local" and leaf.args[0] == "slip" for leaf in value.leaves())


def over_slip_problems(name: str, table: Any) -> Iterator[str]:
    """Problems of a table over abs(slip), which must not be periodic, or of an expression of gb.slip; none is negative."""
    if isinstance(table, Expr):
        yield from _expression_problems(name, table)
    if not isinstance(table, Table):
        return
    if table.extrapolate == "linear" and table.y[-1] < table.y[-2]:
        yield f"{name} = {table!r} falls at its end and would come below 0: let it end level, or extrapolate='hold'"
    if table.periodic:
        yield f"{name} = {table!r} must not be periodic: it goes over the size of the slip"
    if least_value(table) < 0:
        yield f"{name} = {table!r} must be >= 0 everywhere: friction takes energy, it gives none"


def least_value(table: Table) -> float:
    """The least of a table within its points, between those of a spline too."""
    points = np.interp(np.linspace(0, len(table.x) - 1, 32 * len(table.x)), np.arange(len(table.x)), table.x)
    return float(min(np.min(table.y), np.min(table.values(points))))


def _expression_problems(name: str, law: Expr) -> Iterator[str]:
    """Of an expression of the slip and of Parameters: no value at rest, or a negative one; others nothing is known of."""
    for x in (0.0, *np.geomspace(1e-3, 1e4, 141).tolist()):
        try:
            value = evaluate(law, partial(_leaf_at, x))
        except (ValueError, ZeroDivisionError, OverflowError):
            value = math.nan
        except (AttributeError, KeyError, TypeError):
            return
        if x == 0.0 and not math.isfinite(value):
            yield f"{name} = '{law}' has no value at slip 0, where it sticks"
            return
        if value < 0:
            yield f"{name} = '{law}' is {value:.4g} at slip {x:.4g}, and must be >= 0: friction takes energy, it gives none"
            return


def _leaf_at(slip: float, leaf: Expr) -> float:
    """The number of a Parameter, the slip, or a table over either; AttributeError for what changes by itself."""
    if leaf.op == "local" and leaf.args[0] == "slip":
        return slip
    if leaf.op == "table":
        inner = evaluate(as_expr(leaf.args[1]), partial(_leaf_at, slip))
        return float(leaf.args[0].values(inner))
    if leaf.op != "parameter":
        raise AttributeError(leaf.op)
    return float(leaf.args[0].si)


def _is_over_time(value: Any) -> bool:
    """Whether a signal is a table over time."""
    found = as_expr(value) if isinstance(value, (Table, Expr)) else None
    return found is not None and found.op == "table" and as_expr(found.args[1]).op == "time"


def over_slip(s: Any, field: str, size: Any) -> Any:
    """A field over abs(slip) = size, with powers of it that have a value where a step looks past 0."""
    import sympy as sp

    from gearblocks.laws.functions import SignedPower

    found = s.local(field, slip=size)
    powers = {e: SignedPower(e.base, e.exp, 0) for e in found.atoms(sp.Pow) if e.base == size and not e.exp.is_Integer}
    return found.xreplace(powers) if powers and not s.reading else found


def dry_friction(block: Any, s: Any, slip: Any) -> DryFriction:
    """The friction of a block with the common fields, over the slip."""
    import sympy as sp

    if block.capacity is not None:
        if not _is_over_slip(block.capacity):
            capacity = s.capacity
            if not _is_over_time(block.capacity):  # a table over time is C(t) itself
                capacity = s.named("C", capacity, "torque that it transmits while it slips", "N m")
            return DryFriction(capacity, capacity, s.peak * capacity)
        sliding, held = over_slip(s, "capacity", sp.Abs(slip)), s.local("capacity", slip=sp.Integer(0))
        sliding = s.named("C", sliding, "torque that it transmits while it slips", "N m")
        held = s.named("C_0", held, "that torque where the slip is 0", "N m")
        return DryFriction(held, sliding, s.peak * held)
    engaged = s.named("f_n", s.engagement, "normal force over the largest one")
    pressed = s.geometry * s.force_max * engaged
    mu, mu_0 = over_slip(s, "mu", sp.Abs(slip)), s.local("mu", slip=sp.Integer(0))
    sliding = s.named("C", pressed * mu, "torque that it transmits while it slips", "N m")
    at_rest = sliding if mu == mu_0 else s.named("C_0", pressed * mu_0, "that torque where the slip is 0", "N m")
    return DryFriction(engaged, sliding, s.peak * at_rest)


def relative_motion(s: Any, slip: Any, angle: Any, direction: Any, stuck: Any) -> Iterator[Contribution]:
    """phi_rel, which stays bit for bit while stuck; w_rel, then exactly 0; and mode."""
    yield Start(s.phi_rel, angle)
    yield Rate(s.phi_rel, (1 - stuck) * slip)
    yield Shows("phi_rel", s.phi_rel, "rad", "relative angle")
    yield Shows("w_rel", (1 - stuck) * slip, "rad/s", "slip")
    mode = direction + 2 * (1 - stuck) * (1 - direction**2)
    yield Shows("mode", mode, "1", "0 stuck, +1 slips forward, -1 backward, 2 free")


def friction_element(
    s: Any, slip: Any, angle: Any, found: DryFriction, against: bool = False
) -> Iterator[Contribution]:
    """A friction element and its outputs. against: the torque counts positive where it brakes forward slip."""
    yield Stick("", slip, found.limit, found.sliding, found.engaged)
    direction, stuck, held = s.stick("")
    yield from relative_motion(s, slip, angle, direction, stuck)
    force = held - direction * found.sliding
    if against:
        yield Shows("torque", -force, "N m", "braking torque, positive against forward rotation")
    else:
        yield Shows("torque", force, "N m", "torque on flange b")
    yield Shows("loss_power", direction * found.sliding * slip, "W", "power lost by friction")


class Clutch(Block):
    """A friction clutch between two shafts: dry friction that sticks.

        a o---| |---o b        w_rel = w_b - w_a, phi_rel = phi_b - phi_a, torque: on b

    While it slips the torque against the slip is capacity, or geometry mu(abs(w_rel)) force_max engagement; mu as a number,
    a Table over abs(w_rel) or an expression of gb.slip, which stands for that and may stand in capacity too. While it is
    stuck w_rel is exactly 0, phi_rel does not move, and it holds up to peak times the slip torque at rest, either way
    (Coulomb friction with a static peak; the fields are those of Modelica.Mechanics.Rotational.Components.Clutch, whose
    cgeo is geometry: n (r_o + r_i)/2 for n faces). capacity or engagement <= 0: free. mode: 0 stuck, +1 where w_rel > 0,
    -1 where w_rel < 0, 2 free. loss_power: power lost by slipping.

    Example:
        rig = gb.Drivetrain("start of a car")
        engine, car = rig.add("engine", gb.Inertia(J=0.2, w0=200.0)), rig.add("car", gb.Inertia(J=1.0))
        clutch = rig.add("clutch", gb.Clutch(capacity=gb.Table([0.0, 1.0], [0.0, 80.0])))
        rig.chain(engine, clutch, car)
        print(gb.simulate(rig, t_end=2.0)["clutch.mode"][-1])  # 0: it sticks
    """

    a, b = Flange("driving side", slider=None), Flange("driven side", slider=None)
    capacity: Signal | None = CAPACITY
    mu: Signal | None = MU
    force_max: Value | None = FORCE_MAX
    engagement: Signal | None = ENGAGEMENT
    geometry: Value = GEOMETRY
    peak: Value = PEAK
    phi_rel = State("relative angle", "rad")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting or missing fields."""
        yield from friction_problems(self)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Friction along w_b - w_a."""
        slip = s.b.w - s.a.w
        yield from friction_element(s, slip, s.b.phi - s.a.phi, dry_friction(self, s, slip))


class Brake(Block):
    """A friction brake between a shaft and its housing (the ground when not connected).

        a o---| |---# housing        w_rel = w_a - w_housing, phi_rel = phi_a - phi_housing

    Law, fields and modes as of `Clutch`. torque > 0 brakes forward rotation: the shaft gets -torque, the housing
    +torque. While it holds, torque is what it takes to hold, of either sign.

    Example:
        rig = gb.Drivetrain("stopping")
        rig.chain(rig.add("wheel", gb.Inertia(J=0.5, w0=100.0)), rig.add("brake", gb.Brake(capacity=40.0)))
    """

    a = Flange("braked shaft", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    capacity: Signal | None = CAPACITY
    mu: Signal | None = MU
    force_max: Value | None = FORCE_MAX
    engagement: Signal | None = ENGAGEMENT
    geometry: Value = GEOMETRY
    peak: Value = PEAK
    phi_rel = State("angle from the housing", "rad")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting or missing fields."""
        yield from friction_problems(self)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Friction along w_a - w_housing."""
        slip = s.a.w - s.housing.w
        yield from friction_element(s, slip, s.a.phi - s.housing.phi, dry_friction(self, s, slip), against=True)


class Stribeck(Effect):
    """More friction near rest: rise exp(-(w/speed)^2) on top of the Coulomb part.

    The form of Bo and Pavelescu (1982, Wear 82, 277-289) with the exponent 2.

    Example:
        bearing = gb.BearingFriction(coulomb=0.2, viscous=1e-3, stribeck=gb.Stribeck(rise=0.1, speed=2.0))
    """

    rise: Value = param("friction torque at rest above the Coulomb part", "N m", ge=0, symbol="T_S")
    speed: Value = param("speed at which 1/e of the rise is left", "rad/s", gt=0, symbol="omega_S")


class FluidDrag(Effect):
    """Drag of what turns in air (windage) or dips into oil (churning): torque c w abs(w) against the motion.

        c = rho C_m S_m R^3/2

    with the density rho, the pitch radius R, the wetted surface S_m and the drag coefficient C_m (Changenet and Velex 2007, J.
    Mech. Des. 129, 128-133, doi 10.1115/1.2403727, there for churning). C_m is a constant here: it knows nothing of Reynolds
    and Froude numbers.

    Example:
        bearing = gb.BearingFriction(viscous=1e-3, churning=gb.FluidDrag(c=2e-6))
    """

    c: Value = param("torque over the square of the speed", "N m s2/rad2", ge=0)


class BearingFriction(Block):
    """Friction of a bearing between a shaft and its housing (the ground when not connected); it sticks at rest.

        a o---(o)---# housing

        abs(torque) = coulomb + rise exp(-(w/speed)^2) + viscous abs(w) + c w^2,   or torque(abs(w)) + c w^2

    torque: a Table over abs(w), or an expression of gb.slip, which stands for abs(w): 2.0 + 1.5*gb.exp(-0.3*gb.slip).
    rise and speed: of stribeck=Stribeck(...); c: of windage=FluidDrag(...) and churning=FluidDrag(...), the drag of what the
    bearing carries. Stuck, it holds up to peak times the value at w = 0. Signs, outputs and modes as of `Brake`; it is never
    free. Without coulomb and Table the rest is a drag that never sticks (no phi_rel, no mode), or nothing.

    Example:
        rig = gb.Drivetrain("coasting down")
        bearing = rig.add("bearing", gb.BearingFriction(coulomb=0.2, viscous=1e-3))
        rig.chain(rig.add("rotor", gb.Inertia(J=0.05, w0=50.0)), bearing)
    """

    a = Flange("shaft", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    torque: Table | Expr | None = signal(
        "friction torque over abs(w): a gb.Table, or an expression of gb.slip", "N m", default=None,
        belongs_to="friction", over="slip", symbol="M",
    )  # fmt: skip
    coulomb: Value | None = param(
        "friction torque that does not depend on speed", "N m", default=None, ge=0, belongs_to="coulomb", symbol="T_C"
    )
    viscous: Value | None = param(
        "friction torque per speed", "N m s/rad", default=None, ge=0, belongs_to="viscous", symbol="c"
    )
    stribeck: Stribeck | None = effect("more friction near rest", default=None)
    windage: FluidDrag | None = effect("drag in the air", default=None)
    churning: FluidDrag | None = effect("drag in the oil", default=None)
    peak: Value | None = param(
        "largest torque while stuck over the slip torque at rest", default=1.0, ge=1, belongs_to="coulomb", symbol="p"
    )
    phi_rel = State("angle from the housing", "rad")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting fields."""
        if self.torque is not None and not (isinstance(self.torque, Table) or _is_over_slip(self.torque)):
            words = "must be a gb.Table over abs(w) or an expression of gb.slip; a constant torque is coulomb"
            yield f"torque = {str(self.torque) if isinstance(self.torque, Expr) else self.torque!r:.80} {words}"
        if self.torque is not None and self.coulomb is not None:
            yield "give either torque, a Table over abs(w), or coulomb"
        elif self.effects().keys() <= {"heat"} and self.peak is not None:  # an emptied bearing has no peak
            yield "give either torque, a Table over abs(w), or coulomb, or viscous, windage or churning"
        if self.torque is not None and (self.viscous is not None or self.stribeck is not None):
            yield "viscous and stribeck go with coulomb; put them into the Table"
        if self.stribeck is not None and self.coulomb is None and self.torque is None:
            yield "stribeck rises above coulomb; give coulomb (0.0 where there is none)"
        if not self._sticks and self.peak not in (None, 1):
            yield f"peak = {self.peak!r} is that of coulomb or of a Table; give one of them"
        if self._sticks and self.peak is None:
            yield "peak = None must be a number >= 1, the default is 1"
        yield from over_slip_problems("torque", self.torque)

    @property
    def _sticks(self) -> bool:
        return self.torque is not None or self.coulomb is not None

    def effects(self) -> dict[str, Any]:
        """The parts of its friction."""
        return {n: e for n, e in super().effects().items() if n != "coulomb" or self.coulomb is not None}

    def without_effect(self, name: str) -> Block:
        """Without its Coulomb part nothing holds at rest, and nothing rises there."""
        changed = super().without_effect(name)
        if changed.__dict__["torque"] is None and changed.__dict__["coulomb"] is None:
            changed = changed.changed(stribeck=None, peak=None)
        return changed

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Friction along w_a - w_housing, or the drag that is left of it."""
        import sympy as sp

        slip = s.a.w - s.housing.w
        size = self._size(s, sp.Abs(slip), slip)
        if self._sticks:
            found = DryFriction(sp.Integer(1), size, s.peak * self._size(s, sp.Integer(0), sp.Integer(0)))
            yield from friction_element(s, slip, s.a.phi - s.housing.phi, found, against=True)
        elif size != 0:
            torque = s.named("T", self._drag(s, sp.Abs(slip)) * slip, "braking torque", "N m")
            yield Acts(s.a, -torque)
            yield Acts(s.housing, torque)
            yield Energy(loss=torque * slip)
            yield Shows("w_rel", slip, "rad/s", "slip")
            yield Shows("torque", torque, "N m", "braking torque, positive against forward rotation")
            yield Shows("loss_power", torque * slip, "W", "power lost by friction")

    def _size(self, s: Any, speed: Any, w: Any) -> Any:
        """Friction torque at abs(w) = speed."""
        import sympy as sp

        drag = self._drag(s, speed) * speed
        if self.torque is not None:
            return over_slip(s, "torque", speed) + drag
        size = sp.Integer(0) if self.coulomb is None else s.coulomb
        if self.stribeck is not None:
            size = size + s.stribeck.rise * sp.exp(-((w / s.stribeck.speed) ** 2))
        return size + drag

    def _drag(self, s: Any, speed: Any) -> Any:
        """Viscous and fluid drag per speed."""
        import sympy as sp

        drag = sp.Integer(0) if self.viscous is None else s.viscous
        for fluid in ("windage", "churning"):
            if getattr(self, fluid) is not None:
                drag = drag + getattr(s, fluid).c * speed
        return drag
