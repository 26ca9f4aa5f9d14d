"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C."""

from gearblocks.blocks import (
    Angle,
    Damper,
    Differential,
    Fixed,
    GearMesh,
    IdealGear,
    IdealPlanetary,
    Inertia,
    Lash,
    Shaft,
    Speed,
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
from gearblocks.effects import Backlash, Fourier, Harmonic, Profile, Square
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
    "Acts", "Angle", "Backlash", "Block", "Body", "CompileError", "Damper", "Differential", "Drivetrain", "Effect",
    "Energy", "Fixed", "Flange", "Force", "Fourier", "GearMesh", "GearblocksError", "Harmonic", "IdealGear",
    "IdealPlanetary", "Inertia", "Input", "Lash", "Model", "ModelError", "Motion", "Parameter", "ParameterError",
    "Parts", "Potential", "Profile", "Rate", "Shaft", "Shows", "SimulationError", "Speed", "SpeedLoad",
    "SplineCoupling", "Square", "Start", "State", "Switch", "Table", "Tie", "Torque", "Trajectory", "UnknownNameError",
    "build", "classify", "cos", "effect", "exact", "option", "param", "piecewise", "poincare", "rpm", "sense", "signal",
    "simulate", "sin", "stroboscopic", "time", "twist",
]  # fmt: skip
