"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.gears import GearMesh, IdealGear
from gearblocks.blocks.sliders import Force, Mass, Rack
from gearblocks.blocks.sources import SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft

__all__ = [
    "Damper",
    "Fixed",
    "Force",
    "GearMesh",
    "IdealGear",
    "Inertia",
    "Lash",
    "Mass",
    "Rack",
    "Shaft",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
]
