"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C."""

from gearblocks.analysis.campbell import Campbell, campbell
from gearblocks.analysis.designs import latin_hypercube, random_cases
from gearblocks.analysis.linearization import FrequencyResponse, Linearization, frequency_response, linearize
from gearblocks.analysis.modes import Modes, modes
from gearblocks.analysis.parameter_study import study, sweep
from gearblocks.analysis.quantities import at, count, energy_lost, event_time, last, mean, peak, points, rms, trough
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.sections import classify, poincare, stroboscopic
from gearblocks.analysis.study_result import Study
from gearblocks.blocks import (
    Angle,
    BearingFriction,
    BeltDrive,
    Brake,
    Clutch,
    Creep,
    Damper,
    DCMotor,
    Differential,
    DogClutch,
    EddyCurrentBrake,
    Engine,
    Fixed,
    Force,
    Freewheel,
    GearMesh,
    Governor,
    HardStop,
    IdealGear,
    IdealPlanetary,
    Inertia,
    Lash,
    LossyGear,
    Mass,
    NonCircularGear,
    OneWayClutch,
    PlanetaryGear,
    Rack,
    Shaft,
    Speed,
    SpeedLoad,
    SplineCoupling,
    Stribeck,
    Synchronizer,
    Torque,
    TorqueConverter,
    TyreSlip,
    UniversalJoint,
    Vehicle,
    Worm,
)
from gearblocks.blocks.effects import (
    Backlash,
    Fourier,
    Harmonic,
    HuntCrossley,
    Hysteresis,
    MeshLaw,
    Profile,
    Square,
    ToothFriction,
)
from gearblocks.drivetrain import Drivetrain, build, simulate
from gearblocks.errors import (
    CompileError,
    GearblocksError,
    ModelError,
    ParameterError,
    SimulationError,
    UnknownNameError,
)  # fmt: skip
from gearblocks.geometry.ratio_curves import RatioLawError
from gearblocks.geometry.ratio_design import design_ratio
from gearblocks.geometry.ratio_fit import driver_angle
from gearblocks.geometry.ratio_law import RatioLaw
from gearblocks.language.block import Block, Effect
from gearblocks.language.contributions import (
    Acts,
    Body,
    Energy,
    Hold,
    LossyTie,
    Motion,
    Parts,
    Potential,
    Rate,
    Shows,
    Start,
    Stick,
    Stop,
    Switch,
    Tie,
)
from gearblocks.language.expression import cos, piecewise, sin
from gearblocks.language.fields import Flange, State, effect, exact, option, param, signal
from gearblocks.language.signals import Input, Parameter, Table, sense, time, twist
from gearblocks.language.tables import Table2
from gearblocks.language.units import rpm
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model

__version__ = "0.1.0"

__all__ = [
    "Acts", "Angle", "Backlash", "BearingFriction", "BeltDrive", "Block", "Body", "Brake", "Campbell", "Clutch",
    "CompileError", "Creep", "DCMotor", "Damper", "Differential", "DogClutch", "Drivetrain", "EddyCurrentBrake",
    "Effect", "Energy", "Engine", "Fixed", "Flange", "Force", "Fourier", "Freewheel", "FrequencyResponse",
    "GearMesh", "GearblocksError", "Governor", "HardStop", "Harmonic", "Hold", "HuntCrossley", "Hysteresis",
    "IdealGear", "IdealPlanetary", "Inertia", "Input", "Lash", "Linearization", "LossyGear", "LossyTie", "Mass",
    "MeshLaw", "Model", "ModelError", "Modes", "Motion", "NonCircularGear", "OneWayClutch", "Parameter",
    "ParameterError", "Parts", "PlanetaryGear", "Potential", "Profile", "Quantity", "Rack", "Rate", "RatioLaw",
    "RatioLawError", "Shaft", "Shows", "SimulationError", "Speed", "SpeedLoad", "SplineCoupling", "Square", "Start",
    "State", "Stick", "Stop", "Stribeck", "Study", "Switch", "Synchronizer", "Table", "Table2", "Tie",
    "ToothFriction", "Torque", "TorqueConverter", "Trajectory", "TyreSlip", "UniversalJoint", "UnknownNameError",
    "Vehicle", "Worm", "at", "build", "campbell", "classify", "cos", "count", "design_ratio", "driver_angle",
    "effect", "energy_lost", "event_time", "exact", "frequency_response", "last", "latin_hypercube", "linearize",
    "mean", "modes", "option", "param", "peak", "piecewise", "poincare", "points", "random_cases", "rms", "rpm",
    "sense", "signal", "simulate", "sin", "stroboscopic", "study", "sweep", "time", "trough", "twist",
]  # fmt: skip


def __dir__() -> list[str]:
    """The public names; the rooms of the package are no part of them."""
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])
