"""The blocks that a train is composed of."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.gears import IdealGear
from gearblocks.blocks.meshes import GearMesh
from gearblocks.blocks.planetary import PlanetaryGear
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
    "PlanetaryGear",
    "Shaft",
    "SpeedLoad",
    "SplineCoupling",
    "Torque",
]
