"""Drivetrain dynamics: blocks are composed, assembled into equations of motion, and run in generated C.

A name is imported with its module when it is first used: the shell's help needs none of them, a run no linear tools.
"""

import logging
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gearblocks.analysis.campbell import Campbell, campbell
    from gearblocks.analysis.contact_intervals import contact_loss
    from gearblocks.analysis.designs import latin_hypercube, random_cases
    from gearblocks.analysis.dynamic_quantities import dynamic_factor, line, period
    from gearblocks.analysis.linearization import FrequencyResponse, Linearization, frequency_response, linearize
    from gearblocks.analysis.modes import Modes, modes
    from gearblocks.analysis.parameter_study import study, sweep
    from gearblocks.analysis.pitch_pictures import draw_pitch_curves
    from gearblocks.analysis.quantities import (
        at,
        count,
        energy_lost,
        event_time,
        last,
        mean,
        peak,
        points,
        rms,
        std,
        trough,
    )
    from gearblocks.analysis.quantity import Quantity
    from gearblocks.analysis.regimes.attraction import basins
    from gearblocks.analysis.regimes.bifurcation import bifurcation
    from gearblocks.analysis.regimes.branch import continue_orbit
    from gearblocks.analysis.regimes.exponents import lyapunov
    from gearblocks.analysis.regimes.line_spectrum import spectrum
    from gearblocks.analysis.regimes.orbit import periodic_orbit
    from gearblocks.analysis.regimes.order_map import orders
    from gearblocks.analysis.regimes.regime import classify
    from gearblocks.analysis.regimes.swept_speed import speed_sweep
    from gearblocks.analysis.scenes.fit import fit
    from gearblocks.analysis.scenes.price import price
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.analysis.scenes.work_precision import work_precision
    from gearblocks.analysis.sections import poincare, stroboscopic
    from gearblocks.analysis.study_result import Study
    from gearblocks.blocks import (
        Acceleration,
        Angle,
        BearingFriction,
        BeltDrive,
        Brake,
        Chassis,
        Clutch,
        Creep,
        Damper,
        DCMotor,
        Differential,
        DogClutch,
        EddyCurrentBrake,
        Engine,
        Fixed,
        FluidDrag,
        Force,
        Freewheel,
        Gearbox,
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
        ThermalConductance,
        ThermalMass,
        Torque,
        TorqueConverter,
        Tyre,
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
        Superposition,
        ToothFriction,
    )
    from gearblocks.drivetrain import Drivetrain
    from gearblocks.errors import (
        CompileError,
        GearblocksError,
        GearblocksWarning,
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
    from gearblocks.language.fields import Flange, State, effect, exact, option, param, signal
    from gearblocks.language.functions import (
        Heaviside,
        cos,
        exp,
        log,
        maximum,
        minimum,
        pi,
        piecewise,
        rpm,
        sin,
        sqrt,
        tan,
        tanh,
    )
    from gearblocks.language.heat import HeatPort
    from gearblocks.language.signals import Input, Parameter, Table, distance, sense, slip, temperature, time, twist
    from gearblocks.language.starts import rolling
    from gearblocks.language.tables import Table2
    from gearblocks.language.watches import Excitation, Watch
    from gearblocks.language.waveforms import pulse, trapezoid
    from gearblocks.running import build, carried_start, simulate
    from gearblocks.simulation.comparison import compare
    from gearblocks.simulation.trajectory import Trajectory
    from gearblocks.solver.library import Model

__version__ = "0.1.0"

__all__ = [
    "Acceleration", "Acts", "Angle", "Backlash", "BearingFriction", "BeltDrive", "Block", "Body", "Brake", "Campbell",
    "Chassis", "Clutch", "CompileError", "Creep", "DCMotor", "Damper", "Differential", "DogClutch", "Drivetrain",
    "EddyCurrentBrake", "Effect", "Energy", "Engine", "Excitation", "Fixed", "Flange", "FluidDrag", "Force", "Fourier",
    "Freewheel", "FrequencyResponse", "GearMesh", "GearblocksError", "GearblocksWarning", "Gearbox", "Governor",
    "HardStop", "Harmonic", "HeatPort", "Heaviside", "Hold", "HuntCrossley", "Hysteresis", "IdealGear",
    "IdealPlanetary", "Inertia", "Input", "Lash", "Linearization", "LossyGear", "LossyTie", "Mass", "MeshLaw", "Model",
    "ModelError", "Modes", "Motion", "NonCircularGear", "OneWayClutch", "Parameter", "ParameterError", "Parts",
    "PlanetaryGear", "Potential", "Profile", "Quantity", "Rack", "Rate", "RatioLaw", "RatioLawError", "Scene", "Shaft",
    "Shows", "SimulationError", "Speed", "SpeedLoad", "SplineCoupling", "Square", "Start", "State", "Stick", "Stop",
    "Stribeck", "Study", "Superposition", "Switch", "Synchronizer", "Table", "Table2", "ThermalConductance",
    "ThermalMass", "Tie", "ToothFriction", "Torque", "TorqueConverter", "Trajectory", "Tyre", "TyreSlip",
    "UniversalJoint", "UnknownNameError", "Vehicle", "Watch", "Worm", "at", "basins", "bifurcation", "build",
    "campbell", "carried_start", "classify", "compare", "contact_loss", "continue_orbit", "cos", "count",
    "design_ratio", "distance", "draw_pitch_curves", "driver_angle", "dynamic_factor", "effect", "energy_lost",
    "event_time", "exact", "exp", "fit", "frequency_response", "last", "latin_hypercube", "line", "linearize", "log",
    "lyapunov", "maximum", "mean", "minimum", "modes", "option", "orders", "param", "peak", "period", "periodic_orbit",
    "pi", "piecewise", "poincare", "points", "price", "pulse", "random_cases", "rms", "rolling", "rpm", "sense",
    "signal", "simulate", "sin", "slip", "spectrum", "speed_sweep", "sqrt", "std", "stroboscopic", "study", "sweep",
    "tan", "tanh", "temperature", "time", "trapezoid", "trough", "twist", "work_precision",
]  # fmt: skip

_NAMES = {
    "analysis.campbell": "Campbell campbell",
    "analysis.contact_intervals": "contact_loss",
    "analysis.designs": "latin_hypercube random_cases",
    "analysis.linearization": "FrequencyResponse Linearization frequency_response linearize",
    "analysis.modes": "Modes modes",
    "analysis.parameter_study": "study sweep",
    "analysis.dynamic_quantities": "dynamic_factor line period",
    "analysis.pitch_pictures": "draw_pitch_curves",
    "analysis.quantities": "at count energy_lost event_time last mean peak points rms std trough",
    "analysis.quantity": "Quantity",
    "analysis.regimes.attraction": "basins",
    "analysis.regimes.bifurcation": "bifurcation",
    "analysis.regimes.branch": "continue_orbit",
    "analysis.regimes.exponents": "lyapunov",
    "analysis.regimes.line_spectrum": "spectrum",
    "analysis.regimes.orbit": "periodic_orbit",
    "analysis.regimes.order_map": "orders",
    "analysis.regimes.regime": "classify",
    "analysis.regimes.swept_speed": "speed_sweep",
    "analysis.scenes.fit": "fit",
    "analysis.scenes.price": "price",
    "analysis.scenes.scene": "Scene",
    "analysis.scenes.work_precision": "work_precision",
    "analysis.sections": "poincare stroboscopic",
    "analysis.study_result": "Study",
    "blocks": (
        "Acceleration Angle BearingFriction BeltDrive Brake Chassis Clutch Creep Damper DCMotor Differential DogClutch "
        "EddyCurrentBrake Engine Fixed FluidDrag Force Freewheel Gearbox GearMesh Governor HardStop IdealGear IdealPlanetary "
        "Inertia Lash LossyGear Mass NonCircularGear OneWayClutch PlanetaryGear Rack Shaft Speed SpeedLoad "
        "SplineCoupling Stribeck Synchronizer ThermalConductance ThermalMass Torque TorqueConverter Tyre TyreSlip "
        "UniversalJoint Vehicle Worm"
    ),
    "blocks.effects": (
        "Backlash Fourier Harmonic HuntCrossley Hysteresis MeshLaw Profile Square Superposition ToothFriction"
    ),
    "drivetrain": "Drivetrain",
    "errors": "CompileError GearblocksError GearblocksWarning ModelError ParameterError SimulationError UnknownNameError",
    "geometry.ratio_curves": "RatioLawError",
    "geometry.ratio_design": "design_ratio",
    "geometry.ratio_fit": "driver_angle",
    "geometry.ratio_law": "RatioLaw",
    "language.block": "Block Effect",
    "language.contributions": (
        "Acts Body Energy Hold LossyTie Motion Parts Potential Rate Shows Start Stick Stop Switch Tie"
    ),
    "language.fields": "Flange State effect exact option param signal",
    "language.functions": "Heaviside cos exp log maximum minimum pi piecewise rpm sin sqrt tan tanh",
    "language.heat": "HeatPort",
    "language.signals": "Input Parameter Table distance sense slip temperature time twist",
    "language.starts": "rolling",
    "language.tables": "Table2",
    "language.watches": "Excitation Watch",
    "language.waveforms": "pulse trapezoid",
    "running": "build carried_start simulate",
    "simulation.comparison": "compare",
    "simulation.trajectory": "Trajectory",
    "solver.library": "Model",
}
"""Public names by the module that they come from, below this one."""
logging.getLogger(__name__).addHandler(logging.NullHandler())  # what is logged appears where the user asks for it

_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    """A public name, or a room of the package, when it is first used."""
    if name in _HOME:
        value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
        globals()[name] = value
        return value
    if not name.startswith("_") and find_spec(f"{__name__}.{name}") is not None:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'{_near(name)}")


def _near(name: str) -> str:
    """What to do about a name that is not there; names with an underscore are asked for by machines, in great number."""
    if name.startswith("_"):
        return ""
    from gearblocks.errors import ELSEWHERE, OF_NUMPY, did_you_mean

    if name in ELSEWHERE:
        return f"; here it is gb.{ELSEWHERE[name]}"
    if name in OF_NUMPY:
        return f"; np.{OF_NUMPY[name]} of numpy takes expressions such as gb.time"
    alike = [known for known in __all__ if known[0].isupper() == name[0].isupper()]
    return f"; dir({__name__}) lists its names{did_you_mean(name, alike) or did_you_mean(name, __all__)}"


def __dir__() -> list[str]:
    """The public names; the rooms of the package are no part of them."""
    return sorted([*__all__, *(name for name in globals() if name.startswith("__") and name != "__getattr__")])
