"""Draws kinematic schemes into docs/pictures/: the README's own spur pair, a shipped model, and the symbols of all blocks.

python docs/draw_trains.py
"""

from __future__ import annotations

import re
from pathlib import Path

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.files import write_text
from gearblocks.train.handles import Handle

DOCS = Path(__file__).parent
PICTURES = DOCS / "pictures"
FALLING = gb.Table([0, 1], [1.0, 0.0])


def quickstart() -> gb.Drivetrain:
    """The train of the README's first example, made by its own lines up to the equations."""
    readme = (DOCS.parent / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"<!-- tested -->\n```python\n(.*?)```", readme, flags=re.DOTALL)
    scope: dict[str, object] = {}
    exec(blocks[0].partition("\neq = ")[0], scope)  # noqa: S102  the README's own code
    rig = scope["rig"]
    assert isinstance(rig, gb.Drivetrain)
    return rig


def _named(rig: gb.Drivetrain, *blocks: gb.Block) -> list[Handle]:
    """Blocks that bear the names of their classes."""
    return [rig.add(type(block).__name__, block) for block in blocks]


def symbols_on_a_shaft() -> gb.Drivetrain:
    """Couplings in line, sources, loads and brakes."""
    rig = gb.Drivetrain("symbols on a shaft")
    blocks = (
        gb.Engine(torque_map=gb.Table2([0, 100], [0, 1], [[0, 10], [0, 10]]), throttle=1.0), gb.Inertia(J=1.0),
        gb.TorqueConverter(capacity=FALLING, ratio=FALLING), gb.Shaft(k=1.0, c=1.0), gb.Damper(c=1.0),
        gb.Lash(k=1.0, half_gap=0.1), gb.SplineCoupling(teeth=20, radius=0.1, k=1.0), gb.UniversalJoint(angle=0.1),
        gb.Clutch(capacity=1.0), gb.DogClutch(engaged=1.0), gb.Synchronizer(engaged=1.0, capacity=1.0),
        gb.OneWayClutch(capacity=1.0), gb.Freewheel(), gb.HardStop(lower=-1.0, upper=1.0, restitution=0.5),
        gb.BearingFriction(coulomb=1.0), gb.Brake(capacity=1.0),
        gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, excitation=1.0), gb.Governor(target=1.0, gain=1.0),
        gb.SpeedLoad(coeffs=(0.0, 0.0, 1.0)), gb.Torque(tau=1.0), gb.Vehicle(mass=1.0, wheel_radius=1.0),
    )  # fmt: skip
    rig.chain(*_named(rig, *blocks))
    _named(rig, gb.ThermalMass(C=1.0), gb.ThermalConductance(G=1.0, a="ThermalMass", b=293.15))
    return rig


def symbols_between_shafts() -> gb.Drivetrain:
    """Pairs from one axis to another, and sliders."""
    rig = gb.Drivetrain("symbols between shafts")
    mesh = gb.GearMesh(teeth=(20, 60), external=False, module=1e-3, pressure_angle=0.35)
    *pairs, belt, rack, mass, chassis, force, tyre = _named(
        rig, gb.DCMotor(R=1.0, L=1.0, k=1.0, u=1.0), gb.IdealGear(ratio=-2.0), mesh,
        gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.2), external=True), gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.9)),
        gb.Gearbox(ratio=2.0, efficiency=(0.9, 0.9), k=1.0), gb.Worm(ratio=20.0, lead_angle=0.1, friction=0.05),
        gb.BeltDrive(ratio=1.0), gb.Rack(radius=1.0), gb.Mass(m=1.0),
        gb.Chassis(mass=1.0), gb.Force(f=1.0),
        gb.Tyre(radius=1.0, stiffness=1.0, grip=1.0, low_speed=1.0, normal_force=1.0),
    )  # fmt: skip
    rig.chain(*pairs, belt)
    rig.connect(belt.b, rack.flange)
    rig.connect(rack.slider, mass.a)
    rig.connect(mass.b, chassis.a)
    rig.connect(chassis.b, force.flange, tyre.vehicle)
    rig.connect(tyre.wheel, belt.b)
    return rig


def symbols_of_sets() -> gb.Drivetrain:
    """Planetary sets, a differential, a brake, fixed ends, prescribed motion."""
    rig = gb.Drivetrain("symbols of sets")
    planets = gb.PlanetaryGear(
        z_sun=20, z_planet=20, z_ring=60, planets=4, module=1e-3, pressure_angle=0.35, planet_inertia=1.0
    )
    speed, first, second, differential, wall, angle, torque, brake, acceleration = _named(
        rig, gb.Speed(w=1.0), gb.IdealPlanetary(ratio=2.0), planets, gb.Differential(), gb.Fixed(), gb.Angle(phi=1.0),
        gb.Torque(tau=1.0), gb.Brake(capacity=1.0), gb.Acceleration(alpha=1.0),
    )  # fmt: skip
    rig.connect(speed.flange, first.sun)
    rig.connect(first.ring, wall.flange)
    rig.connect(first.carrier, second.sun)
    rig.connect(second.ring, brake.a)
    rig.connect(second.carrier, differential.carrier)
    rig.connect(differential.left, angle.flange)
    rig.connect(differential.right, torque.flange, acceleration.flange)
    return rig


TRAINS = {
    "scheme_spur_pair.svg": quickstart,
    "scheme_gearbox.svg": lambda: scripts.make("automatic_gearbox"),
    "symbols_on_a_shaft.svg": symbols_on_a_shaft,
    "symbols_between_shafts.svg": symbols_between_shafts,
    "symbols_of_sets.svg": symbols_of_sets,
}


def pictures() -> dict[str, str]:
    """File names in docs/pictures/ and what belongs in them."""
    return {name: str(make().draw()) for name, make in TRAINS.items()}


if __name__ == "__main__":
    for name, text in pictures().items():
        write_text(PICTURES / name, text)
        print(f"wrote {PICTURES / name}")
