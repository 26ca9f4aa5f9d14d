"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C."""

from gearblocks.blocks import (
    Damper,
    Fixed,
    GearMesh,
    IdealGear,
    Inertia,
    Lash,
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
from gearblocks.linear import FrequencyResponse, Linearization, frequency_response, linearize
from gearblocks.orders import Campbell, campbell
from gearblocks.signals import Input, Parameter, Table, sense, time, twist
from gearblocks.trajectory import Trajectory
from gearblocks.units import rpm
from gearblocks.vibration import Modes, modes

__version__ = "0.1.0"

__all__ = [
    "Acts", "Backlash", "Block", "Body", "Campbell", "CompileError", "Damper", "Drivetrain", "Effect", "Energy",
    "Fixed", "Flange", "Force", "Fourier", "FrequencyResponse", "GearMesh", "GearblocksError", "Harmonic",
    "IdealGear", "Inertia", "Input", "Lash", "Linearization", "Model", "ModelError", "Modes", "Parameter",
    "ParameterError", "Parts", "Potential", "Profile", "Rate", "Shaft", "Shows", "SimulationError", "SpeedLoad",
    "SplineCoupling", "Square", "State", "Switch", "Table", "Tie", "Torque", "Trajectory", "UnknownNameError",
    "build", "campbell", "classify", "cos", "effect", "exact", "frequency_response", "linearize", "modes", "option",
    "param", "piecewise", "poincare", "rpm", "sense", "signal", "simulate", "sin", "stroboscopic", "time", "twist",
]  # fmt: skip
