"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.gears import GearMesh, IdealGear
from gearblocks.blocks.noncircular import NonCircularGear
from gearblocks.blocks.sources import SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft

__all__ = [
    "Damper",
    "Fixed",
    "GearMesh",
    "IdealGear",
    "Inertia",
    "Lash",
    "NonCircularGear",
    "Shaft",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
]
