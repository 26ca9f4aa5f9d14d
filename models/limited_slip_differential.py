"""Limited-slip differential on a road with ice under one wheel: a torque-sensing clutch between the axle shafts.

    motor - propshaft - carrier | left  - wheel - tyre \\
                                | right - wheel - tyre / car        clutch: left to right

The differential gives both shafts half of the carrier's torque T. The clutch carries up to M = preload + bias T from the
faster one to the slower one (gears in the differential press its plates in proportion to T; here the torque of the
propshaft is sensed). Its torque makes the difference of the wheels: as long as 2 M exceeds what the tyres differ by, both
wheels turn as one; on ice the left one spins and the right one still gets T/2 + M. `build` has the clutch, `unlocked`
has none and stands for the plain differential. From 2 s to 5 s the left wheel is on ice.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gearblocks as gb

MASS, RADIUS, GRAVITY = 1400.0, 0.3, 9.80665  # kg, m, m/s2
TORQUE, NO_LOAD_SPEED = 1200.0, 160.0  # of the motor at the axle, N m and rad/s
PRELOAD, BIAS = 40.0, 0.25  # N m, -
DRY, ICE = 0.9, 0.12  # friction of the road


class Tyre(gb.Block):
    """Longitudinal force of a tyre over its slip (radius w - v)/sqrt(v^2 + low_speed^2), at most grip normal.

    F = D sin(C atan(stiffness slip/(C D))) with D = grip normal, C = 1.3: the form of Bakker, Nyborg and Pacejka
    (SAE 870421, 1987). It falls a little past its largest value.
    """

    wheel, road = gb.Flange("wheel"), gb.Flange("the car over the road", slider=True)
    radius: float = gb.param("rolling radius", "m", gt=0)
    normal: float = gb.param("normal force", "N", gt=0, symbol="F_z")
    stiffness: float = gb.param("force per slip at small slip", "N", gt=0)
    grip: Any = gb.signal("friction of the road", symbol="mu")
    low_speed: float = gb.param("speed below which the slip is viscous", "m/s", default=0.3, gt=0, symbol="v_0")

    def physics(self, s: Any) -> Iterator[Any]:
        """The force between wheel and car."""
        import sympy as sp

        shape, sliding = sp.Rational(13, 10), s.radius * s.wheel.w - s.road.v
        slip = s.named("kappa", sliding / sp.sqrt(s.road.v**2 + s.low_speed**2), "slip")
        most = s.named("D", s.grip * s.normal, "largest force", "N")
        force = s.named(
            "F", most * sp.sin(shape * sp.atan(s.stiffness * slip / (shape * most))), "force on the car", "N"
        )
        yield gb.Acts(s.wheel, -s.radius * force)
        yield gb.Acts(s.road, force)
        yield gb.Energy(loss=force * sliding)
        yield gb.Shows("force", force, "N", "force on the car")
        yield gb.Shows("slip", slip, "1", "slip")


def build() -> gb.Drivetrain:
    """The axle with its clutch, over ice from 2 s to 5 s."""
    return _axle(locking=True)


def unlocked() -> gb.Drivetrain:
    """The same axle with a plain differential."""
    return _axle(locking=False)


def _axle(*, locking: bool) -> gb.Drivetrain:
    rig = gb.Drivetrain("limited-slip differential" if locking else "plain differential")
    drive = rig.add("drive", gb.Torque(tau=TORQUE * (1 - gb.sense("motor.w") / NO_LOAD_SPEED) * _rise()))
    motor, shaft = rig.add("motor", gb.Inertia(J=6.0)), rig.add("propshaft", gb.Shaft(k=2.0e4, c=60.0))
    differential = rig.add("differential", gb.Differential())
    car = rig.add("car", gb.Mass(m=MASS))
    rig.chain(drive, motor, shaft)
    rig.connect(shaft.b, differential.carrier)
    grips = (gb.Table([0.0, 2.0, 2.05, 5.0, 5.05], [DRY, DRY, ICE, ICE, DRY]), DRY)
    wheels = []
    for side, grip in zip(("left", "right"), grips, strict=True):
        wheel = rig.add(f"wheel_{side}", gb.Inertia(J=1.1))
        tyre = rig.add(f"tyre_{side}", Tyre(radius=RADIUS, normal=MASS * GRAVITY / 4, stiffness=5.0e4, grip=grip))
        rig.connect(getattr(differential, side), wheel.a)
        rig.connect(wheel.b, tyre.wheel)
        rig.connect(tyre.road, car.a)
        wheels.append(wheel)
    rig.chain(car, rig.add("drag", gb.SpeedLoad(coeffs=(0.0, 0.0, 0.4))))
    if locking:
        pressed = PRELOAD + BIAS * abs(gb.sense("propshaft.torque"))
        clutch = rig.add("clutch", gb.Clutch(capacity=pressed))
        rig.connect(wheels[0].b, clutch.a)
        rig.connect(wheels[1].b, clutch.b)
    return rig


def _rise() -> Any:
    """The torque comes within half a second."""
    return gb.Table([0.0, 0.5], [0.0, 1.0])
