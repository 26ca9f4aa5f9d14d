"""Torque converter, belt drive and universal joint."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gearblocks.language.block import Block, Effect
from gearblocks.language.contributions import Acts, Contribution, Energy, Shows, Tie
from gearblocks.language.fields import Flange, effect, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Table, Value, constant_value
from gearblocks.language.watches import Excitation, Watch

_REST = 1e-6  # rad/s: keeps the speed ratio of a torque converter defined at rest


class TorqueConverter(Block):
    """Hydrodynamic torque converter or coupling, quasi-static, with tables over the speed ratio nu = w_t/w_i.

        impeller o---(|)---o turbine

        impeller torque  T_i = capacity(nu) w_i abs(w_i),    turbine torque  T_t = ratio(nu) T_i

    Speeds are against the housing (the ground when not connected), which takes the difference of the torques. Outside
    the tables the end values are held, so capacity must reach 0 (free) or less (the turbine drives) at its upper end.
    nu is taken as w_t w_i/(w_i^2 + 1e-12 rad2/s2). Tables by which the converter would give more power than it takes
    are refused. torque: T_t. The effect `slip` is both tables; without it (both None) the lock-up clutch is closed for good:
    impeller and turbine are one shaft.

    Example:
        rig = gb.Drivetrain("start on a converter")
        capacity = gb.Table([0.0, 0.9, 1.0], [2e-3, 1.5e-3, 0.0])
        converter = rig.add("converter", gb.TorqueConverter(capacity=capacity, ratio=gb.Table([0.0, 0.9], [2.0, 1.0])))
        engine, axle = rig.add("engine", gb.Inertia(J=0.2, w0=100.0)), rig.add("axle", gb.Inertia(J=2.0))
        rig.chain(rig.add("drive", gb.Torque(tau=60.0)), engine, converter, axle)
    """

    impeller, turbine = Flange("impeller, the driving side"), Flange("turbine, the driven side")
    housing = Flange("housing of the stator", ground=True)
    capacity: Table | None = option(
        "torque capacity T_i/w_i^2 in N m s2/rad2, over the speed ratio; None: locked up", belongs_to="slip"
    )
    ratio: Table | None = option("torque ratio T_t/T_i, over the speed ratio; None: locked up", belongs_to="slip")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Tables that are none, that jump, or that create energy."""
        if self.capacity is None and self.ratio is None:
            return
        wrong = [
            f"{name} = {table!r:.80} must be a linear or cubic gb.Table over the speed ratio, not periodic"
            for name, table in (("capacity", self.capacity), ("ratio", self.ratio))
            if not isinstance(table, Table) or table.periodic or table.kind == "step"
        ]
        yield from wrong or self._gains(self.capacity, self.ratio)

    def _gains(self, capacity: Any, ratio: Any) -> Iterator[str]:
        """The speed ratio at which most power comes from nothing, looked for on a grid and far outside."""
        joints = np.concatenate([capacity.x, ratio.x])
        inside = np.linspace(joints.min(), joints.max(), 2001)
        far = 10 * (np.ptp(joints) + np.abs(joints).max())
        nu = np.unique(np.concatenate([joints, inside, [-far, far]]))
        lost = capacity.values(nu) * (1 - ratio.values(nu) * nu)
        worst = int(np.argmin(lost))
        if lost[worst] < -1e-12 * np.abs(capacity.values(nu)).max():
            where = {far: "above the last point", -far: "below the first point"}.get(nu[worst], f"at {nu[worst]:.4g}")
            yield (
                f"the tables give more power than they take, most at a speed ratio {where}: "
                "capacity (1 - ratio nu) must be >= 0 everywhere; let capacity end at 0 or below"
            )

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Torques on impeller, turbine and housing, or the tie of the lock-up clutch."""
        import sympy as sp

        if self.capacity is None:
            yield Tie(s.impeller.phi - s.turbine.phi)
            yield Shows("torque", s.turbine.tau, "N m", "torque on the turbine")
            return
        w_i, w_t = s.impeller.w - s.housing.w, s.turbine.w - s.housing.w
        nu = s.named("nu", w_t * w_i / (w_i**2 + sp.Float(_REST**2)), "speed ratio")
        taken = s.named("T_i", s.local("capacity", nu=nu) * w_i * sp.Abs(w_i), "torque that the impeller takes", "N m")
        given = s.named("T_t", s.local("ratio", nu=nu) * taken, "torque on the turbine", "N m")
        yield Acts(s.impeller, -taken)
        yield Acts(s.turbine, given)
        yield Acts(s.housing, taken - given)
        yield Energy(loss=taken * w_i - given * w_t)
        yield Shows("torque", given, "N m", "torque on the turbine")
        yield Shows("impeller_torque", taken, "N m", "torque that the impeller takes")
        yield Shows("speed_ratio", nu, "1", "turbine over impeller speed")
        yield Shows("loss_power", taken * w_i - given * w_t, "W", "power lost in the fluid")


class Creep(Effect):
    """Elastic creep of a belt: torque through slip speed.

        slip = (w_a - ratio w_b)/sqrt(w_a^2 + low_speed^2),    tau = stiffness slip, or less where limit is given

    The belt runs onto each pulley with the strain of its tight or slack side, so the relative slip is the difference of
    the two forces over the axial stiffness E A of the belt (Reynolds, On the efficiency of belts or straps as
    communicators of work, 1874): stiffness = radius_a E A. limit: torque at which the belt slides as a whole,
    approached as tau = stiffness slip / sqrt(1 + (stiffness slip/limit)^2). Below low_speed the law is a viscous one.

    Example:
        belt = gb.BeltDrive(ratio=0.8, slip=gb.Creep(stiffness=2e3, low_speed=1.0, limit=80.0))
    """

    stiffness: Value = param("torque on a per relative slip", "N m", gt=0)
    low_speed: Value = param("speed of a below which the slip is viscous", "rad/s", gt=0, symbol="omega_0")
    limit: Value | None = param("largest torque on a", "N m", default=None, gt=0, symbol="T_max")


class BeltDrive(Block):
    """Belt between two pulleys turning the same way: phi_a = ratio phi_b without slip (ratio = r_b/r_a), about the housing.

        a o---( )======(   )---o b

    A rigid tie, or with slip=Creep(...) a torque through slip speed. A crossed belt has a negative ratio.

    Example:
        rig = gb.Drivetrain("fan drive")
        engine, fan = rig.add("engine", gb.Inertia(J=0.1)), rig.add("fan", gb.Inertia(J=0.02))
        rig.chain(rig.add("drive", gb.Torque(tau=5.0)), engine, rig.add("belt", gb.BeltDrive(ratio=0.8)), fan)
    """

    a, b = Flange("driving pulley"), Flange("driven pulley")
    housing = Flange("frame", ground=True)
    ratio: float = exact("ratio phi_a/phi_b without slip")
    slip: Creep | None = effect("elastic creep", default=None)
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A ratio of zero."""
        if self.ratio == 0:
            yield "ratio = 0 must not be 0"

    def would_show(self, effect: str) -> Iterator[Watch]:
        """Where the creep has a limit, the belt slides as a whole beyond it."""
        if effect == "slip" and self.slip is not None and self.slip.limit is not None:
            most = constant_value(self.slip.limit) * abs(self.ratio)
            yield Watch("torque", "the torque exceeds that at which the belt slides", most)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie, or the creep torque on both pulleys and the frame."""
        import sympy as sp

        if self.slip is None:
            yield Tie((s.a.phi - s.housing.phi) - s.ratio * (s.b.phi - s.housing.phi))
            yield Shows("torque", s.b.tau, "N m", "torque on flange b")
            return
        w_a = s.a.w - s.housing.w
        sliding = w_a - s.ratio * (s.b.w - s.housing.w)
        slip = s.named("s", sliding / sp.sqrt(w_a**2 + s.slip.low_speed**2), "relative slip")
        tau = s.slip.stiffness * slip
        if s.slip.limit is not None:
            tau = tau / sp.sqrt(1 + (tau / s.slip.limit) ** 2)
        tau = s.named("T", tau, "torque of the belt on the driving pulley", "N m")
        yield Acts(s.a, -tau)
        yield Acts(s.b, s.ratio * tau)
        yield Acts(s.housing, (1 - s.ratio) * tau)
        yield Energy(loss=tau * sliding)
        yield Shows("torque", s.ratio * tau, "N m", "torque on flange b")
        yield Shows("slip", slip, "1", "relative slip")
        yield Shows("loss_power", tau * sliding, "W", "power lost by creep")


class UniversalJoint(Block):
    """Universal (Hooke's, Cardan) joint between two shafts that meet at an angle: tan phi_b = tan phi_a / cos(angle).

        a o---<X>---o b        at an angle between the shafts

        phi_b = phi_a + atan(q sin(2 phi)/(1 - q cos(2 phi))),    phi = phi_a + phase,  q = tan(angle/2)^2

    w_b/w_a swings between cos(angle) and 1/cos(angle) twice a turn: cos(angle) where the fork of a lies across the plane
    of both shafts (phi = 90 degrees), 1/cos(angle) where it lies in it. The same law over all turns, without jumps.
    torque: on flange b.

    Example:
        rig = gb.Drivetrain("propeller shaft")
        joint = rig.add("joint", gb.UniversalJoint(angle="20 deg"))
        rig.chain(rig.add("engine", gb.Speed(w=100.0)), joint, rig.add("axle", gb.Inertia(J=0.2)))
    """

    a, b = Flange("driving fork"), Flange("driven fork")
    angle: Value = param("angle between the shafts", "rad", gt=-1.5, lt=1.5, symbol="beta")
    phase: Value | None = param("position of the fork of a at phi_a = 0", "rad", default=None)

    def excitations(self) -> Iterator[Excitation]:
        """Twice a turn."""
        yield from super().excitations()
        yield Excitation("the joint", order=2.0, flange="a")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie."""
        import sympy as sp

        q = s.named("q", sp.tan(s.angle / 2) ** 2, "tan(angle/2)^2")

        def lead(flange: Any, q: Any) -> Any:
            twice = 2 * (flange.phi if s.phase is None else flange.phi + s.phase)
            return sp.atan(q * sp.sin(twice) / (1 - q * sp.cos(twice)))

        ahead = s.b.phi - s.a.phi
        yield Tie(ahead - lead(s.a, q), inverse=(s.a, lambda: ahead + lead(s.b, -q)))
        yield Shows("torque", s.b.tau, "N m", "torque on flange b")
