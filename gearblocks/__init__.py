"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C."""

from gearblocks.blocks import (
    Angle,
    BeltDrive,
    Creep,
    Damper,
    DCMotor,
    Differential,
    EddyCurrentBrake,
    Engine,
    Fixed,
    Force,
    GearMesh,
    Governor,
    IdealGear,
    IdealPlanetary,
    Inertia,
    Lash,
    Mass,
    NonCircularGear,
    PlanetaryGear,
    Rack,
    Shaft,
    Speed,
    SpeedLoad,
    SplineCoupling,
    Torque,
    TorqueConverter,
    TyreSlip,
    UniversalJoint,
    Vehicle,
)
from gearblocks.declare import (
    Acts,
    Block,
    Body,
    Effect,
    Energy,
    Flange,
    Motion,
    Parts,
    Potential,
    Rate,
    Shows,
    Start,
    State,
    Switch,
    Tie,
    effect,
    exact,
    option,
    param,
    signal,
)  # fmt: skip
from gearblocks.drivetrain import Drivetrain, build, classify, poincare, simulate, stroboscopic
from gearblocks.effects import Backlash, Fourier, Harmonic, MeshLaw, Profile, Square, ToothFriction
from gearblocks.errors import (
    CompileError,
    GearblocksError,
    ModelError,
    ParameterError,
    SimulationError,
    UnknownNameError,
)  # fmt: skip
from gearblocks.expression import cos, piecewise, sin
from gearblocks.library import Model
from gearblocks.maps import Table2
from gearblocks.pitch import design_ratio
from gearblocks.ratio_law import RatioLaw, RatioLawError, driver_angle
from gearblocks.signals import Input, Parameter, Table, sense, time, twist
from gearblocks.trajectory import Trajectory
from gearblocks.units import rpm

__version__ = "0.1.0"

__all__ = [
    "Acts", "Angle", "Backlash", "BeltDrive", "Block", "Body", "CompileError", "Creep", "DCMotor", "Damper",
    "Differential", "Drivetrain", "EddyCurrentBrake", "Effect", "Energy", "Engine", "Fixed", "Flange", "Force",
    "Fourier", "GearMesh", "GearblocksError", "Governor", "Harmonic", "IdealGear", "IdealPlanetary", "Inertia", "Input",
    "Lash", "Mass", "MeshLaw", "Model", "ModelError", "Motion", "NonCircularGear", "Parameter", "ParameterError",
    "Parts", "PlanetaryGear", "Potential", "Profile", "Rack", "Rate", "RatioLaw", "RatioLawError", "Shaft", "Shows",
    "SimulationError", "Speed", "SpeedLoad", "SplineCoupling", "Square", "Start", "State", "Switch", "Table", "Table2",
    "Tie", "ToothFriction", "Torque", "TorqueConverter", "Trajectory", "TyreSlip", "UniversalJoint", "UnknownNameError",
    "Vehicle", "build", "classify", "cos", "design_ratio", "driver_angle", "effect", "exact", "option", "param",
    "piecewise", "poincare", "rpm", "sense", "signal", "simulate", "sin", "stroboscopic", "time", "twist",
]  # fmt: skip
