"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.couplings import BeltDrive, Creep, TorqueConverter, UniversalJoint
from gearblocks.blocks.gears import GearMesh, IdealGear
from gearblocks.blocks.machines import DCMotor, EddyCurrentBrake, Engine, Governor
from gearblocks.blocks.sliders import Force, Mass, Rack
from gearblocks.blocks.sources import SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft
from gearblocks.blocks.vehicles import TyreSlip, Vehicle

__all__ = [
    "BeltDrive",
    "Creep",
    "DCMotor",
    "Damper",
    "EddyCurrentBrake",
    "Engine",
    "Fixed",
    "Force",
    "GearMesh",
    "Governor",
    "IdealGear",
    "Inertia",
    "Lash",
    "Mass",
    "Rack",
    "Shaft",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
    "TorqueConverter",
    "TyreSlip",
    "UniversalJoint",
    "Vehicle",
]
