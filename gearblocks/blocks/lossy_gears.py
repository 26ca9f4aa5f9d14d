"""Gears that lose power in proportion to what they transmit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from math import cos, isfinite, tan
from typing import Any

from gearblocks.errors import ModelError
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, LossyTie, Parts, Shows, Tie
from gearblocks.language.fields import Flange, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Table
from gearblocks.language.watches import Watch, beyond


class LossyGear(Block):
    """A rigid gear pair with losses of its teeth and bearings, without inertia: phi_a = ratio phi_b about the housing.

        a o---||        w_a = ratio w_b
              ||---o b

        tau_b = -ratio T,   tau_a: what enters at a,   T: what leaves at b (both positive where a drives forward)
        a drives b, sign(w_a) T + tau1 >= 0:  tau_a = (T + sign(w_a) tau1)/eta1
        b drives a, sign(w_a) T + tau2 < 0:   tau_a = (T + sign(w_a) tau2) eta2

    (Pelchen, Schweiger, Otter, Modeling and simulating the efficiency of gearboxes and of planetary gearboxes, 2nd
    Modelica Conference, 2002.) Give efficiency=(eta1, eta2) and, where wanted, bearing=(tau1, tau2) in N m; or
    loss_table, rows of (abs(w_a), eta1, eta2, tau1, tau2), linear in between and held outside. eta2 < 0: b cannot drive
    a (self-locking); pushed on from b it asks a for torque all the same. Where tau1 < tau2 no torque enters at a between
    the two cases; where tau1 > tau2 both hold in between and the present one goes on; where a run begins there, a drives.
    At rest it sticks while tau_a lies between what both directions would ask for; there nothing starts to move that can stay
    at rest. A side may be without inertia: at b where a has some, at a or both with tau1 = tau2 and eta2 > 0.
    mode: 0 stuck, else the sign of w_a.
    Raises SimulationError where the losses admit no acceleration: a self-locking gear that b drives while it turns jams,
    as the friction grows faster than what slows it down, where J_a ratio^2 < -eta2 J_b. A run that begins with such a gear
    turning against its load is refused too: there it has two accelerations.

    Example:
        rig = gb.Drivetrain("hoist")
        motor, drum = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("drum", gb.Inertia(J=0.5))
        gear = rig.add("gear", gb.LossyGear(ratio=20, efficiency=(0.9, 0.85)))
        rig.chain(rig.add("drive", gb.Torque(tau=1.0)), motor, gear, drum)
    """

    a, b = Flange("driving side"), Flange("driven side")
    housing = Flange("housing", ground=True)
    ratio: float = exact("ratio phi_a/phi_b")
    efficiency: tuple[float, float] | None = param(
        "efficiencies (a drives, b drives)",
        default=None,
        many=True,
        le=1,
        belongs_to="loss",
        each=("efficiency where a drives", "efficiency where b drives"),
        positive=(0,),
    )
    bearing: tuple[float, float] | None = param(
        "bearing torques at a (a drives, b drives)",
        "N m",
        default=None,
        many=True,
        ge=0,
        belongs_to="loss",
        each=("bearing torque at a where a drives", "bearing torque at a where b drives"),
        symbol="T_b",
    )
    loss_table: tuple[tuple[float, ...], ...] | None = option(
        "losses by speed: rows of (abs(w_a), eta1, eta2, tau1, tau2)", default=None, many=True, belongs_to="loss"
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Losses that are given twice, or are none."""
        if self.ratio == 0:
            yield "ratio = 0 must not be 0"
        if self.loss_table is not None and (self.efficiency is not None or self.bearing is not None):
            yield "loss_table holds efficiencies and bearing torques; leave efficiency and bearing out"
        if self.bearing is not None and self.efficiency is None and self.loss_table is None:
            yield "bearing torques need efficiency=(eta1, eta2) beside; (1, 1) where the teeth lose nothing"
        for name in ("efficiency", "bearing"):
            value = getattr(self, name)
            if value is not None and len(value) != 2:
                yield f"{name} = {value!r} must be two numbers: a drives b, b drives a"
        if self.efficiency is not None and len(self.efficiency) == 2:
            yield from _efficiency_problems("efficiency", *self.efficiency)
        if self.loss_table is not None:
            yield from _table_problems(self.loss_table)

    def beyond_tables(self) -> Iterator[tuple[str, Watch]]:
        """The rows of its loss table, as far as the housing does not turn."""
        w, *columns = zip(*(self.loss_table or [(0.0,) * 5]), strict=True)
        if len(w) > 1:
            for watch in (x for column in columns for x in beyond(Table(w, column), "a.w")):
                yield "loss_table", replace(watch, unless="housing.w")
                return

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie and what it loses."""
        import sympy as sp

        w_a, w_b = s.a.w - s.housing.w, s.b.w - s.housing.w
        if self.efficiency is None and self.loss_table is None:
            yield Tie((s.a.phi - s.housing.phi) - s.ratio * (s.b.phi - s.housing.phi))
            yield Shows("torque", s.b.tau, "N m", "torque on flange b")
            yield Shows("loss_power", sp.Integer(0), "W", "power lost")
            yield Shows("mode", sp.Integer(2), "1", "2: it loses nothing and never sticks")
            return
        eta1, eta2, tau1, tau2 = self._values(s, sp.Abs(w_a))
        yield LossyTie(s.ratio * w_b - w_a, w_a, (1 / eta1 - 1, tau1), (eta2 - 1, tau2))
        sign, _, leaving = s.stick("tie")
        direction, _, held = s.stick("loss")
        side = direction * sign  # 1: a drives, -1: b drives, 0: at rest, or nothing enters
        drives, driven = side * (side + 1) / 2, side * (side - 1) / 2
        entering = drives * (leaving + direction * tau1) / eta1 + driven * (leaving + direction * tau2) * eta2
        entering += (1 - direction**2) * (leaving - held)
        yield Shows("torque", s.ratio * leaving, "N m", "torque on flange b")
        yield Shows("torque_a", entering, "N m", "torque that enters at flange a")
        yield Shows("loss_power", (entering - leaving) * w_a, "W", "power lost")
        yield Shows("mode", direction, "1", "0 stuck, +1 turns forward, -1 backward")

    def _values(self, s: Any, speed: Any) -> tuple[Any, Any, Any, Any]:
        """eta1, eta2, tau1, tau2 at a speed."""
        import sympy as sp

        if self.efficiency is not None:
            zero = sp.Integer(0)
            bearing = s.bearing if self.bearing is not None else (zero, zero)
            return (*s.efficiency, *bearing)
        assert self.loss_table is not None
        w, *columns = zip(*(self.loss_table if s.reading else _from_rest(self.loss_table)), strict=True)
        if len(w) == 1:
            eta1, eta2, tau1, tau2 = (sp.Float(c[0]) for c in columns)
        else:
            eta1, eta2, tau1, tau2 = (
                s.tabled(Table(w, c), speed, "loss_table", name=name, words=f"{words}, over |w_a|", unit=unit)
                for c, (name, words, unit) in zip(columns, _COLUMNS, strict=True)
            )
        return eta1, eta2, tau1, tau2


_COLUMNS = (
    ("eta_1", "efficiency where a drives", "1"),
    ("eta_2", "efficiency where b drives", "1"),
    ("tau_1", "bearing torque at a where a drives", "N m"),
    ("tau_2", "bearing torque at a where b drives", "N m"),
)
"""Name, words and unit of what a loss table says over the speed."""


def _from_rest(rows: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
    """The rows with the first line drawn on below a speed of 0, where it is never read: no joint, and so no event, at rest."""
    if len(rows) < 2 or rows[0][0] != 0:
        return rows
    first, second = rows[:2]
    return (tuple(2 * a - b for a, b in zip(first, second, strict=True)), *rows[1:])


def _efficiency_problems(where: str, eta1: Any, eta2: Any) -> Iterator[str]:
    numbers = [x if isinstance(x, (int, float)) else 1.0 for x in (eta1, eta2)]
    if not 0 < numbers[0] <= 1:
        yield f"{where}: eta1 = {eta1!r} must be > 0 and <= 1"
    if not (numbers[1] <= 1 and numbers[1] != 0):
        yield f"{where}: eta2 = {eta2!r} must be <= 1 and not 0 (< 0: self-locking)"


def _is_finite(x: Any) -> bool:
    return isinstance(x, (int, float)) and isfinite(x)


def _table_problems(rows: Any) -> Iterator[str]:
    good = isinstance(rows, tuple) and all(
        isinstance(r, tuple) and len(r) == 5 and all(map(_is_finite, r)) for r in rows
    )
    if not rows or not good:
        yield f"loss_table = {rows!r:.80} must be rows of five finite numbers: abs(w_a), eta1, eta2, tau1, tau2"
        return
    speeds = [r[0] for r in rows]
    if speeds[0] < 0 or any(b <= a for a, b in pairwise(speeds)):
        yield f"loss_table: the speeds {speeds} must be >= 0 and grow from row to row"
    if len({r[2] > 0 for r in rows}) > 1:
        yield "loss_table: eta2 must be > 0 in all rows or < 0 in all; in between it would pass 0"
    for row in rows:
        yield from _efficiency_problems(f"loss_table at {row[0]:g} rad/s", row[1], row[2])
        if min(row[3:]) < 0:
            yield f"loss_table at {row[0]:g} rad/s: bearing torques must be >= 0"


class Worm(Block):
    """A worm gear with the losses of its teeth: a LossyGear between the worm a and the wheel b, phi_a = ratio phi_b.

        a o---[//////]
                (  )---o b

        eta1 = (cos(alpha) - mu tan(gamma))/(cos(alpha) + mu/tan(gamma))     the worm drives
        eta2 = (cos(alpha) - mu/tan(gamma))/(cos(alpha) + mu tan(gamma))     the wheel drives; <= 0: self-locking

    with the lead angle gamma at the pitch cylinder, the normal pressure angle alpha and the coefficient of friction mu
    (Niemann, Winter: Maschinenelemente III, 1983). Wheel and worm need inertia.

    Example:
        rig = gb.Drivetrain("self-locking lift")
        motor, lift = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("lift", gb.Inertia(J=0.5))
        worm = rig.add("worm", gb.Worm(ratio=40, lead_angle="4 deg", friction=0.1))
        rig.chain(rig.add("drive", gb.Torque(tau=2.0)), motor, worm, lift)
    """

    a, b = Flange("worm"), Flange("wheel")
    housing = Flange("housing", ground=True)
    ratio: float = exact("ratio phi_a/phi_b")
    lead_angle: float = option("lead angle gamma", "rad")
    friction: float | None = option("coefficient of friction mu; None: without losses", belongs_to="loss")
    pressure_angle: float = option("normal pressure angle alpha", "rad", default=0.3490658503988659)
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Angles and friction without a gear."""
        if self.ratio == 0:
            yield "ratio = 0 must not be 0"
        for name, top in (("lead_angle", 1.5), ("pressure_angle", 1.5), ("friction", 10.0)):
            value = getattr(self, name)
            if name == "friction" and value is None:
                return
            if not (isinstance(value, (int, float)) and (0 < value < top or (name == "friction" and value == 0))):
                yield f"{name} = {value!r} must be a number > 0 (friction >= 0) and < {top:g}"
                return
        if self.friction is not None and self.friction * tan(self.lead_angle) >= cos(self.pressure_angle):
            yield f"friction = {self.friction!r} is so large at this lead angle that the worm cannot drive either"

    def efficiency(self) -> tuple[float, float]:
        """eta1, eta2 of its geometry."""
        c, t, mu = cos(self.pressure_angle), tan(self.lead_angle), self.friction or 0.0
        return (c - mu * t) / (c + mu / t), (c - mu / t) / (c + mu * t)

    def parts(self) -> Parts:
        """The gear that it is."""
        eta1, eta2 = self.efficiency()
        if self.friction is None:
            return self._of(LossyGear(ratio=self.ratio, heat=self.heat))
        if eta2 == 0:
            raise ModelError(
                "the wheel drives with efficiency 0, neither free nor self-locking; change friction a little"
            )
        return self._of(LossyGear(ratio=self.ratio, efficiency=(eta1, eta2), heat=self.heat))

    def _of(self, gear: LossyGear) -> Parts:
        return Parts({"gear": gear}, (), {n: ("gear", n) for n in ("a", "b", "housing")})

    def physics(self, s: Any) -> Iterator[Contribution]:  # noqa: ARG002  its parts have physics
        """None of its own."""
        return iter(())
