"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C."""

from gearblocks.blocks import (
    Damper,
    Fixed,
    GearMesh,
    IdealGear,
    Inertia,
    Lash,
    PlanetaryGear,
    Shaft,
    SpeedLoad,
    SplineCoupling,
    Torque,
)
from gearblocks.declare import (
    Acts,
    Block,
    Body,
    Effect,
    Energy,
    Flange,
    Force,
    Hold,
    Parts,
    Potential,
    Rate,
    Shows,
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
from gearblocks.effects import Backlash, Fourier, Harmonic, HuntCrossley, MeshLaw, Profile, Square, ToothFriction
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
from gearblocks.signals import Input, Parameter, Table, sense, time, twist
from gearblocks.trajectory import Trajectory
from gearblocks.units import rpm

__version__ = "0.1.0"

__all__ = [
    "Acts", "Backlash", "Block", "Body", "CompileError", "Damper", "Drivetrain", "Effect", "Energy", "Fixed", "Flange",
    "Force", "Fourier", "GearMesh", "GearblocksError", "Harmonic", "Hold", "HuntCrossley", "IdealGear", "Inertia",
    "Input", "Lash", "MeshLaw", "Model", "ModelError", "Parameter", "ParameterError", "Parts", "PlanetaryGear",
    "Potential", "Profile", "Rate", "Shaft", "Shows", "SimulationError", "SpeedLoad", "SplineCoupling", "Square",
    "State", "Switch", "Table", "Tie", "ToothFriction", "Torque", "Trajectory", "UnknownNameError", "build", "classify",
    "cos", "effect", "exact", "option", "param", "piecewise", "poincare", "rpm", "sense", "signal", "simulate", "sin",
    "stroboscopic", "time", "twist",
]  # fmt: skip
