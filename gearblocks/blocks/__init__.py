"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.couplings import BeltDrive, Creep, TorqueConverter, UniversalJoint
from gearblocks.blocks.gears import Differential, IdealGear, IdealPlanetary
from gearblocks.blocks.machines import DCMotor, EddyCurrentBrake, Engine, Governor
from gearblocks.blocks.meshes import GearMesh
from gearblocks.blocks.noncircular import NonCircularGear
from gearblocks.blocks.planetary import PlanetaryGear
from gearblocks.blocks.sliders import Force, Mass, Rack
from gearblocks.blocks.sources import Angle, Speed, SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft
from gearblocks.blocks.vehicles import TyreSlip, Vehicle

__all__ = [
    "Angle",
    "BeltDrive",
    "Creep",
    "DCMotor",
    "Damper",
    "Differential",
    "EddyCurrentBrake",
    "Engine",
    "Fixed",
    "Force",
    "GearMesh",
    "Governor",
    "IdealGear",
    "IdealPlanetary",
    "Inertia",
    "Lash",
    "Mass",
    "NonCircularGear",
    "PlanetaryGear",
    "Rack",
    "Shaft",
    "Speed",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
    "TorqueConverter",
    "TyreSlip",
    "UniversalJoint",
    "Vehicle",
]
