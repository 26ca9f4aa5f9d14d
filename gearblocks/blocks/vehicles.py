"""Vehicles: as a load on their driven wheels, or as a chassis on the road with a tyre per wheel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gearblocks.blocks.friction import least_value
from gearblocks.language.block import Block, Effect
from gearblocks.language.contributions import Acts, Body, Contribution, Energy, Rate, Shows, Stick, Tie
from gearblocks.language.expression import Expr, as_expr
from gearblocks.language.fields import Flange, State, effect, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Input, Signal, Table, Value, constant_value, value_at
from gearblocks.language.watches import Watch

GRAVITY = 9.80665  # m/s2, standard


ROLLING: Any = signal(
    "rolling resistance over normal force", default=None, ge=0, belongs_to="rolling", over="distance", symbol="f_r"
)
ROLLING_SPEED: Any = param(
    "speed below which rolling resistance fades", "m/s", default=None, gt=0, belongs_to="rolling", symbol="v_r"
)
DRAG_AREA: Any = param("drag coefficient times front area", "m2", default=None, ge=0, belongs_to="drag", symbol="A_d")
WIND: Any = signal(
    "speed of the air along the road, > 0 from behind", "m/s", default=None, over="distance", symbol="v_w"
)
GRADE: Any = signal(
    "angle of the slope, over time or gb.distance", "rad", default=None, gt=-1.5, lt=1.5, over="distance", symbol="alpha",
    why=": it is an angle in rad",
)  # fmt: skip

_LIFTED = 1e-9  # of the stiffness: a tyre is in the air up to so small a force
_APART = 1e-15  # of the stiffness, beside the largest force: keeps 0/0 away
_NO_SLIP = ": a wheel without it has no slip; leave the tyre out"


class TyreSlip(Effect):
    """Longitudinal force of the tyres over their slip, in the form of Bakker, Nyborg and Pacejka (SAE 870421, 1987).

        slip = (radius w - v)/sqrt(v^2 + low_speed^2),   F = D sin(C atan(stiffness slip/(C D))),   D = grip m g

    m g: the weight of the vehicle, all of which rests on the driven wheels (a block `Tyre` stands for one axle). C: shape;
    1 rises to D without falling again. Below low_speed the tyre is a viscous coupling.

    Example:
        car = gb.Vehicle(mass=1200.0, wheel_radius=0.3, tyre=gb.TyreSlip(stiffness=1e5, grip=1.0, low_speed=0.5))
    """

    stiffness: Value = param("force per slip at small slip", "N", gt=0)
    grip: Value = param("largest force over normal force", gt=0, symbol="mu")
    low_speed: Value = param("speed below which the slip is viscous", "m/s", gt=0, symbol="v_0")
    shape: Value = param("shape factor C", default=1.0, ge=1, le=2, symbol="C")


class Vehicle(Block):
    """A vehicle as its driven wheels feel it: mass, drag of the air, rolling resistance, slope. Forward is positive.

        flange o---( )            v = wheel_radius w where the wheels roll
                ~~~~~~~ road

        m v' = F - air_density drag_area/2 u abs(u) - rolling m g cos(grade) sign(v) - m g sin(grade),   u = v - wind

    F: force of the road on the tyres (output force). Without tyre the wheels roll: v = wheel_radius w, and the mass is
    an inertia m wheel_radius^2 on the flange; with tyre=TyreSlip(...) v and s are states of the block (start values:
    initial={"car.v": ...}). drag_area: drag coefficient times front area; grade: angle of the slope in rad, positive
    uphill; both and rolling may be left out. grade, rolling and wind may be signals, over the way too:
    grade=table(gb.distance). wheel_inertia: of all wheels, on the flange. A rolling that varies counts as 0 where it is below.
    Rolling resistance is dry friction: at v = 0 it holds the vehicle against up to rolling m g cos(grade). With tyre, v is no
    speed of a shaft and nothing holds: the resistance then jumps at v = 0, unless rolling_speed is given: sign(v) is then
    v/sqrt(v^2 + rolling_speed^2), with or without tyre. Work on the slope, and of the wind, counts as supplied. For several
    driven axles, a trailer or anything else on the chassis: `Chassis`, with a `Tyre` or a `Rack` per wheel.

    Example:
        rig = gb.Drivetrain("car")
        car = rig.add("car", gb.Vehicle(mass=1200.0, wheel_radius=0.3, drag_area=0.6, rolling=0.012, grade="2 deg"))
        rig.chain(rig.add("drive", gb.Torque(tau=400.0)), car)
    """

    flange = Flange("axle of the driven wheels")
    mass: Value = param("mass", "kg", gt=0)
    wheel_radius: Value = param("rolling radius of the wheels", "m", gt=0)
    wheel_inertia: Value | None = param("moment of inertia of all wheels", "kg m2", default=None, ge=0, symbol="J_w")
    drag_area: Value | None = DRAG_AREA
    rolling: Signal | None = ROLLING
    rolling_speed: Value | None = ROLLING_SPEED
    grade: Signal | None = GRADE
    wind: Signal | None = WIND
    air_density: Value = param("density of the air", "kg/m3", default=1.2, ge=0, symbol="rho")
    tyre: TyreSlip | None = effect("slip of the tyres", default=None)
    v = State("speed of the vehicle", "m/s")
    s = State("distance", "m")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A rolling speed without rolling resistance, and wind without drag."""
        yield from _road_problems(self)

    def would_show(self, effect: str) -> Iterator[Watch]:
        """The wheels would spin, or lock, beyond the grip of the tyres on level road."""
        if effect == "tyre" and self.tyre is not None:
            most = constant_value(self.tyre.grip) * constant_value(self.mass) * GRAVITY
            yield Watch("force", "the force exceeds the grip of the tyres", most)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Resistance, and the tyres between wheels and road."""
        rigid = self.tyre is None
        wheel = s.wheel_radius * s.flange.w
        v, way = (wheel, s.wheel_radius * s.flange.phi) if rigid else (s.v, s.s)
        road = _road(self, s, v, way, holds=rigid)
        resistance = s.named("R", road.resistance, "drag of the air and rolling resistance", "N")
        force = -s.flange.tau / s.wheel_radius
        if self.wheel_inertia is not None:
            force = force - s.wheel_inertia * s.flange.alpha / s.wheel_radius
            if not rigid:
                yield Body(s.flange, s.wheel_inertia)
        if rigid:
            inertia = s.mass * s.wheel_radius**2
            yield Body(s.flange, inertia if self.wheel_inertia is None else inertia + s.wheel_inertia)
            yield Acts(s.flange, -s.wheel_radius * (resistance + road.climb))
            yield Energy(loss=road.lost)
            if s.rolling is not None and s.rolling_speed is None:
                most = road.rolling
                yield Stick("rolling", s.flange.w, s.wheel_radius * most)
                direction, _, held = s.stick("rolling")
                resistance = resistance + direction * most - held / s.wheel_radius
        else:
            force, slip = _grip(s, s.tyre, wheel, v, road.normal)
            yield Acts(s.flange, -s.wheel_radius * force)
            yield Rate(s.v, (force - resistance - road.climb) / s.mass)
            yield Rate(s.s, v)
            lost = force * (wheel - v) + road.lost
            yield Energy(stored=s.mass * v**2 / 2, loss=lost)
            yield Shows("slip", slip, "1", "slip of the tyres")
        yield Shows("v", v, "m/s", "speed")
        yield Shows("s", way, "m", "distance")
        yield Shows("force", force, "N", "force of the road on the tyres")
        yield Shows("resistance", resistance, "N", "drag and rolling resistance against the motion")


class Chassis(Block):
    """A vehicle, or a trailer, as a sliding mass on the road: drag of the air, rolling resistance, slope. Forward is positive.

        a o---[ m ]---o b        s = s_a = s_b
             ~~~~~~~ road

        m v' = forces on a and b - air_density drag_area/2 u abs(u) - rolling m g cos(grade) sign(v) - m g sin(grade),
        u = v - wind

    What drives it are forces on a and b: a `Tyre` or a `Rack` (wheels that roll without slip) for each wheel, a coupling to a
    trailer (`Shaft`, `Lash` on sliders). All fields are those of `Vehicle`; at rest the rolling resistance holds. s0, v0: start
    values. Work on the slope, and of the wind, counts as supplied.

    Example:
        rig = gb.Drivetrain("car with four driven wheels")
        car = rig.add("car", gb.Chassis(mass=1200.0, drag_area=0.6, rolling=0.012))
        for name in ("front", "rear"):
            wheels = rig.add(name, gb.Inertia(J=2.0))
            tyre = gb.Tyre(radius=0.3, stiffness=5e4, grip=0.9, low_speed=0.5, normal_force=600.0 * 9.81)
            rig.chain(rig.add(f"drive_{name}", gb.Torque(tau=200.0)), wheels, rig.add(f"tyre_{name}", tyre), car)
    """

    a, b = Flange("front end", spare=True, slider=True), Flange("rear end", spare=True, slider=True)
    mass: Value = param("mass", "kg", gt=0)
    drag_area: Value | None = DRAG_AREA
    rolling: Signal | None = ROLLING
    rolling_speed: Value | None = ROLLING_SPEED
    grade: Signal | None = GRADE
    wind: Signal | None = WIND
    air_density: Value = param("density of the air", "kg/m3", default=1.2, ge=0, symbol="rho")
    s0: Value | None = param("start position", "m", default=None, start="angle")
    v0: Value | None = param("start speed", "m/s", default=None, start="speed")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A rolling speed without rolling resistance, and wind without drag."""
        yield from _road_problems(self)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """m s'' = sum of the forces on both flanges and of the road."""
        v, way = s.a.v, s.a.s
        yield Body(s.a, s.mass)
        yield Tie(s.a.s - s.b.s)
        road = _road(self, s, v, way, holds=True)
        resistance = s.named("R", road.resistance, "drag of the air and rolling resistance", "N")
        yield Acts(s.a, -resistance - road.climb)
        yield Energy(loss=road.lost)
        if s.rolling is not None and s.rolling_speed is None:
            yield Stick("rolling", v, road.rolling)
            direction, _, held = s.stick("rolling")
            resistance = resistance + direction * road.rolling - held
        yield Shows("s", way, "m", "distance")
        yield Shows("v", v, "m/s", "speed")
        yield Shows("acceleration", s.a.alpha, "m/s2", "acceleration")
        yield Shows("resistance", resistance, "N", "drag and rolling resistance against the motion")
        yield Shows("kinetic_energy", s.mass * v**2 / 2, "J", "kinetic energy")


class Tyre(Block):
    """The tyre of one wheel, or of the wheels of one axle, between its hub and the vehicle that rolls on the road.

        wheel o---( )---o vehicle        slip = (radius w - v)/sqrt(v^2 + low_speed^2)
                ~~~~~~~ road             F = D sin(C atan(stiffness slip/(C D))),   D = grip normal_force

    F drives the vehicle forward and brakes the wheel by radius F (the law of `TyreSlip`; C: shape). normal_force: the load of
    the wheel on the road, a signal; grip too may be one, such as that of a road that is wet from somewhere on. Where one of
    them comes to 0 or below (a wheel in the air) there is no force. What slips is lost. A wheel without inertia passes on what
    drives it, up to the grip.

    Example:
        rig = gb.Drivetrain("unicycle")
        tyre = gb.Tyre(radius=0.3, stiffness=2e4, grip=0.8, low_speed=0.2, normal_force="800 N")
        rig.chain(rig.add("wheel", gb.Inertia(J=0.5, w0=20.0)), rig.add("tyre", tyre), rig.add("rider", gb.Chassis(mass=80.0)))
    """

    wheel = Flange("hub of the wheel")
    vehicle = Flange("vehicle", slider=True)
    radius: Value = param("rolling radius", "m", gt=0)
    stiffness: Value = param("force per slip at small slip", "N", gt=0)
    grip: Signal = signal("largest force over normal force", gt=0, symbol="mu", why=_NO_SLIP)
    low_speed: Value = param("speed below which the slip is viscous", "m/s", gt=0, symbol="v_0")
    normal_force: Signal = signal("load on the road", "N", gt=0, symbol="F_z", why=_NO_SLIP)
    shape: Value = param("shape factor C", default=1.0, ge=1, le=2, symbol="C")
    heat: HeatPort | None = HEAT

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The force through the slip; what slips is lost."""
        wheel, v = s.radius * s.wheel.w, s.vehicle.v
        lifts = _varies(self.grip) or _varies(self.normal_force)
        force, slip = _grip(s, s, wheel, v, s.normal_force, lifts=lifts)
        yield Acts(s.wheel, -s.radius * force)
        yield Acts(s.vehicle, force)
        yield Energy(loss=force * (wheel - v))
        yield Shows("slip", slip, "1", "slip of the tyre")
        yield Shows("force", force, "N", "force of the road on the tyre")
        yield Shows("loss_power", force * (wheel - v), "W", "power lost by slip")


# -- the road -----------------------------------------------------------------------------------------------------------


def _road_problems(block: Any) -> Iterator[str]:
    """A rolling speed without rolling resistance, and wind without drag."""
    if block.rolling_speed is not None and block.rolling is None:
        yield "rolling_speed needs rolling, the coefficient of rolling resistance"
    if block.wind is not None and block.drag_area is None:
        yield "wind needs drag_area: it acts by the drag of the air"
    if _varies(block.rolling):
        yield from _rolling_problems(as_expr(block.rolling))


def _rolling_problems(law: Expr) -> Iterator[str]:
    """A table with points below 0, and what is below 0 as a run begins: it would drive."""
    drives = "must be >= 0: rolling resistance takes energy, it gives none"
    least = least_value(law.args[0]) if law.op == "table" else value_at(law, 0.0)
    if least < 0 and law.op == "table":
        yield f"rolling = {law.args[0]!r} comes to {least:.4g}, and {drives}"
    elif least < 0:
        yield f"rolling = '{law}' is {least:.4g} at t = 0, and {drives}; gb.maximum(..., 0) keeps it there"


@dataclass(frozen=True, slots=True)
class _Road:
    """Resistance against v without what sticks, the power that it takes (what the wind gives is supplied), weight along the
    slope, normal force, and rolling resistance."""

    resistance: Any
    lost: Any
    climb: Any
    normal: Any
    rolling: Any


def _road(block: Any, s: Any, v: Any, way: Any, *, holds: bool) -> _Road:
    """The forces of road and air; holds: rolling resistance is dry friction where it does not fade."""
    import sympy as sp

    def along(name: str) -> Any:
        return s.local(name, distance=way) if isinstance(getattr(block, name), Expr) else getattr(s, name)

    weight = s.mass * sp.Float(GRAVITY)
    climb: Any = sp.Integer(0)
    normal = weight
    if s.grade is not None:
        grade = along("grade")
        climb, normal = weight * sp.sin(grade), weight * sp.cos(grade)
    resistance: Any = sp.Integer(0)
    supplied: Any = sp.Integer(0)
    if s.drag_area is not None:
        wind = sp.Integer(0) if block.wind is None else along("wind")
        u = v if block.wind is None else s.named("u", v - wind, "speed against the air", "m/s")
        resistance += s.air_density * s.drag_area * u * sp.Abs(u) / 2
        supplied = -resistance * wind
    rolling = sp.Integer(0) if s.rolling is None else along("rolling") * normal
    if _varies(block.rolling):
        rolling = sp.Max(0, rolling)
    if s.rolling is not None and (not holds or s.rolling_speed is not None):
        side = sp.sign(v) if s.rolling_speed is None else v / sp.sqrt(v**2 + s.rolling_speed**2)
        resistance += rolling * side
    return _Road(resistance, resistance * v + supplied, climb, normal, rolling)


def _varies(value: Any) -> bool:
    """Whether a signal is more than a number or an expression of Parameters."""
    return isinstance(value, (Input, Table, Expr)) and any(x.op != "parameter" for x in as_expr(value).leaves())


def _grip(s: Any, tyre: Any, wheel: Any, v: Any, normal: Any, *, lifts: bool = False) -> tuple[Any, Any]:
    """Force on the tyres and their slip. lifts: there may be nothing that the tyre could transmit."""
    import sympy as sp

    slip = s.named("kappa", (wheel - v) / sp.sqrt(v**2 + tyre.low_speed**2), "slip of the tyres")
    most = s.named("D", tyre.grip * normal, "largest force on the tyres", "N")
    if not lifts:
        force = most * sp.sin(tyre.shape * sp.atan(tyre.stiffness * slip / (tyre.shape * most)))
    else:
        bears = most > _LIFTED * tyre.stiffness
        # in the air a number that stays
        divisor = sp.Piecewise((most + _APART * tyre.stiffness, bears), (tyre.stiffness, True))
        angle = sp.atan(tyre.stiffness * slip / (tyre.shape * divisor))
        force = sp.Piecewise((most * sp.sin(tyre.shape * angle), bears), (0, True))
    return s.named("F", force, "force of the road on the tyres", "N"), slip
