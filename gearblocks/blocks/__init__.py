"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.gears import Differential, GearMesh, IdealGear, IdealPlanetary
from gearblocks.blocks.sources import Angle, Speed, SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft

__all__ = [
    "Angle",
    "Damper",
    "Differential",
    "Fixed",
    "GearMesh",
    "IdealGear",
    "IdealPlanetary",
    "Inertia",
    "Lash",
    "Shaft",
    "Speed",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
]
