"""The catalogue: blocks that a train is composed of, and their effects. Knows nothing of how laws are derived."""

from gearblocks.blocks.bodies import Fixed, Inertia
from gearblocks.blocks.couplings import BeltDrive, Creep, TorqueConverter, UniversalJoint
from gearblocks.blocks.friction import BearingFriction, Brake, Clutch, FluidDrag, Stribeck
from gearblocks.blocks.gearboxes import Gearbox
from gearblocks.blocks.gears import Differential, IdealGear, IdealPlanetary
from gearblocks.blocks.locking_couplings import DogClutch, Freewheel, OneWayClutch, Synchronizer
from gearblocks.blocks.lossy_gears import LossyGear, Worm
from gearblocks.blocks.machines import DCMotor, EddyCurrentBrake, Engine, Governor
from gearblocks.blocks.meshes import GearMesh
from gearblocks.blocks.noncircular import NonCircularGear
from gearblocks.blocks.planetary import PlanetaryGear
from gearblocks.blocks.sources import Acceleration, Angle, Speed, SpeedLoad, Torque
from gearblocks.blocks.spline import SplineCoupling
from gearblocks.blocks.springs import Damper, Lash, Shaft
from gearblocks.blocks.stops import HardStop
from gearblocks.blocks.thermal import ThermalConductance, ThermalMass
from gearblocks.blocks.translational import Force, Mass, Rack
from gearblocks.blocks.vehicles import Chassis, Tyre, TyreSlip, Vehicle

__all__ = [
    "Acceleration",
    "Angle",
    "BearingFriction",
    "BeltDrive",
    "Brake",
    "Chassis",
    "Clutch",
    "Creep",
    "DCMotor",
    "Damper",
    "Differential",
    "DogClutch",
    "EddyCurrentBrake",
    "Engine",
    "Fixed",
    "FluidDrag",
    "Force",
    "Freewheel",
    "GearMesh",
    "Gearbox",
    "Governor",
    "HardStop",
    "IdealGear",
    "IdealPlanetary",
    "Inertia",
    "Lash",
    "LossyGear",
    "Mass",
    "NonCircularGear",
    "OneWayClutch",
    "PlanetaryGear",
    "Rack",
    "Shaft",
    "Speed",
    "SpeedLoad",
    "SplineCoupling",
    "Stribeck",
    "Synchronizer",
    "ThermalConductance",
    "ThermalMass",
    "Torque",
    "TorqueConverter",
    "Tyre",
    "TyreSlip",
    "UniversalJoint",
    "Vehicle",
    "Worm",
]
