"""The load of a vehicle on its driven wheels."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language.block import Block, Effect
from gearblocks.language.contributions import Acts, Body, Contribution, Energy, Rate, Shows, Stick
from gearblocks.language.fields import Flange, State, effect, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Value, constant_value
from gearblocks.language.watches import Watch

GRAVITY = 9.80665  # m/s2, standard


class TyreSlip(Effect):
    """Longitudinal force of the tyres over their slip, in the form of Bakker, Nyborg and Pacejka (SAE 870421, 1987).

        slip = (radius w - v)/sqrt(v^2 + low_speed^2),   F = D sin(C atan(stiffness slip/(C D))),   D = grip normal force

    C: shape; 1 rises to D without falling again. Below low_speed the tyre is a viscous coupling.

    Example:
        car = gb.Vehicle(mass=1200.0, wheel_radius=0.3, tyre=gb.TyreSlip(stiffness=1e5, grip=1.0, low_speed=0.5))
    """

    stiffness: Value = param("force per slip at small slip", "N", gt=0)
    grip: Value = param("largest force over normal force", gt=0)
    low_speed: Value = param("speed below which the slip is viscous", "m/s", gt=0)
    shape: Value = param("shape factor C", default=1.0, ge=1, le=2)


class Vehicle(Block):
    """A vehicle as its driven wheels feel it: mass, drag of the air, rolling resistance, slope. Forward is positive.

        flange o---( )            v = wheel_radius w where the wheels roll
                ~~~~~~~ road

        m v' = F - air_density drag_area/2 v abs(v) - rolling m g cos(grade) sign(v) - m g sin(grade)

    F: force of the road on the tyres (output force). Without tyre the wheels roll: v = wheel_radius w, and the mass is
    an inertia m wheel_radius^2 on the flange; with tyre=TyreSlip(...) v and s are states of the block (start values:
    initial={"car.v": ...}). drag_area: drag coefficient times front area; grade: angle of the slope in rad, positive
    uphill; both and rolling may be left out. Rolling resistance is dry friction: at v = 0 it holds the vehicle against up to
    rolling m g cos(grade). With tyre, v is no speed of a shaft and nothing holds: the resistance then jumps at v = 0, unless
    rolling_speed is given: sign(v) is then v/sqrt(v^2 + rolling_speed^2), with or without tyre. Work on the slope counts as
    supplied.

    Example:
        rig = gb.Drivetrain("car")
        car = rig.add("car", gb.Vehicle(mass=1200.0, wheel_radius=0.3, drag_area=0.6, rolling=0.012, grade="2 deg"))
        rig.chain(rig.add("drive", gb.Torque(tau=400.0)), car)
    """

    flange = Flange("axle of the driven wheels")
    mass: Value = param("mass", "kg", gt=0)
    wheel_radius: Value = param("rolling radius of the wheels", "m", gt=0)
    drag_area: Value | None = param("drag coefficient times front area", "m2", default=None, ge=0, belongs_to="drag")
    rolling: Value | None = param("rolling resistance over normal force", default=None, ge=0, belongs_to="rolling")
    rolling_speed: Value | None = param(
        "speed below which rolling resistance fades", "m/s", default=None, gt=0, belongs_to="rolling"
    )
    grade: Signal | None = signal("angle of the slope", "rad", default=None)
    air_density: Value = param("density of the air", "kg/m3", default=1.2, ge=0)
    tyre: TyreSlip | None = effect("slip of the tyres", default=None)
    v = State("speed of the vehicle", "m/s")
    s = State("distance", "m")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A slope that no road has, and a rolling speed without rolling resistance."""
        if isinstance(self.grade, (int, float)) and abs(self.grade) >= 1.5:
            yield f"grade = {self.grade!r} rad must be within +-1.5: it is an angle in rad"
        if self.rolling_speed is not None and self.rolling is None:
            yield "rolling_speed needs rolling, the coefficient of rolling resistance"

    def would_show(self, effect: str) -> Iterator[Watch]:
        """The wheels would spin, or lock, beyond the grip of the tyres on level road."""
        if effect == "tyre" and self.tyre is not None:
            most = constant_value(self.tyre.grip) * constant_value(self.mass) * GRAVITY
            yield Watch("force", "the force exceeds the grip of the tyres", most)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Resistance, and the tyres between wheels and road."""
        rigid = self.tyre is None
        wheel = s.wheel_radius * s.flange.w
        v = wheel if rigid else s.v
        resistance, climb, normal = self._forces(s, v)
        resistance = s.named("R", resistance, "drag of the air and rolling resistance", "N")
        force = -s.flange.tau / s.wheel_radius
        if rigid:
            yield Body(s.flange, s.mass * s.wheel_radius**2)
            yield Acts(s.flange, -s.wheel_radius * (resistance + climb))
            yield Energy(loss=resistance * v)
            if s.rolling is not None and s.rolling_speed is None:
                most = s.rolling * normal
                yield Stick("rolling", s.flange.w, s.wheel_radius * most)
                direction, _, held = s.stick("rolling")
                resistance = resistance + direction * most - held / s.wheel_radius
        else:
            force, slip = _grip(s, wheel, v, normal)
            yield Acts(s.flange, -s.wheel_radius * force)
            yield Rate(s.v, (force - resistance - climb) / s.mass)
            yield Rate(s.s, v)
            yield Energy(stored=s.mass * v**2 / 2, loss=force * (wheel - v) + resistance * v)
            yield Shows("slip", slip, "1", "slip of the tyres")
        yield Shows("v", v, "m/s", "speed")
        yield Shows("s", s.wheel_radius * s.flange.phi if rigid else s.s, "m", "distance")
        yield Shows("force", force, "N", "force of the road on the tyres")
        yield Shows("resistance", resistance, "N", "drag and rolling resistance against the motion")

    def _forces(self, s: Any, v: Any) -> tuple[Any, Any, Any]:
        """Resistance against v without dry friction, the part of the weight along the slope, and the normal force."""
        import sympy as sp

        weight = s.mass * sp.Float(GRAVITY)
        climb: Any = sp.Integer(0)
        normal = weight
        if s.grade is not None:
            climb, normal = weight * sp.sin(s.grade), weight * sp.cos(s.grade)
        resistance: Any = sp.Integer(0)
        if s.drag_area is not None:
            resistance += s.air_density * s.drag_area * v * sp.Abs(v) / 2
        if s.rolling is not None and (self.tyre is not None or s.rolling_speed is not None):
            side = sp.sign(v) if s.rolling_speed is None else v / sp.sqrt(v**2 + s.rolling_speed**2)
            resistance += s.rolling * normal * side
        return resistance, climb, normal


def _grip(s: Any, wheel: Any, v: Any, normal: Any) -> tuple[Any, Any]:
    """Force on the tyres and their slip."""
    import sympy as sp

    tyre = s.tyre
    slip = s.named("kappa", (wheel - v) / sp.sqrt(v**2 + tyre.low_speed**2), "slip of the tyres")
    most = s.named("D", tyre.grip * normal, "largest force on the tyres", "N")
    force = most * sp.sin(tyre.shape * sp.atan(tyre.stiffness * slip / (tyre.shape * most)))
    return s.named("F", force, "force of the road on the tyres", "N"), slip
