"""What gearblocks raises: errors that name the thing, the value, the rule and the way out.

Every error can be pickled, so that it survives the way back from a worker process.
"""

from __future__ import annotations

import logging
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from inspect import CO_VARARGS, CO_VARKEYWORDS
from numbers import Integral, Real
from types import FunctionType
from typing import Any, TypeVar, cast

_F = TypeVar("_F", bound=Callable[..., Any])  # pyright knows a specifier of fields by its own type alone

_OURS = re.compile(r"(gearblocks|fmu_export)(\.|$)")

log = logging.getLogger("gearblocks")
"""What was built, compiled or taken from the cache (INFO, DEBUG), what ran (DEBUG), and every GearblocksWarning."""


class GearblocksError(Exception):
    """Base of all errors raised on purpose; catching it catches nothing else."""


class GearblocksWarning(UserWarning):
    """Something went another way than asked, or a result is less right than one would take it to be: by name, with a remedy."""


def warn(message: str) -> None:
    """A GearblocksWarning at the nearest line of somebody else's code that led here, and the same in the log."""
    log.warning("%s", message)
    warnings.warn(message, GearblocksWarning, stacklevel=_calls_within() + 1)


def _calls_within() -> int:
    """How many calls up from the caller the first line outside the packages is; all the way where there is none."""
    calls, frame = 1, sys._getframe(2)
    while _OURS.match(frame.f_globals.get("__name__", "")) and frame.f_back is not None:
        calls, frame = calls + 1, frame.f_back
    return calls


class ModelError(GearblocksError):
    """A train that cannot be built. `problems` holds every complaint found, not only the first."""

    def __init__(self, problems: str | Sequence[str]) -> None:
        self.problems: tuple[str, ...] = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        if len(self.problems) == 1:
            return self.problems[0]
        return "\n".join((f"{len(self.problems)} problems:", *(f"  - {problem}" for problem in self.problems)))


class UnknownAttributeError(ModelError, AttributeError):
    """A flange or field that a part has not, said with the near ones; hasattr understands it."""


class ParameterError(GearblocksError, ValueError):
    """A value that its parameter, input or option does not admit."""


class UnknownNameError(GearblocksError, KeyError):
    """A name that nothing carries; the message lists the near ones."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class StorageError(GearblocksError):
    """A file that cannot be read or written; whatever it held before is untouched."""


class CompileError(GearblocksError):
    """No compiler, or one that refuses. `command` and `output` hold what was run and what it said."""

    def __init__(self, message: str, command: Sequence[str] = (), output: str = "") -> None:
        self.message, self.command, self.output = message, tuple(command), output
        super().__init__(message, self.command, output)

    def __str__(self) -> str:
        lines = [self.message]
        if self.command:
            lines.append("    command: " + " ".join(self.command))
        tail = self.output.rstrip().splitlines()[-20:]
        return "\n".join(lines + ["    " + line for line in tail])


class SimulationError(GearblocksError):
    """A run that cannot go on: when, in which component, why, and what helps.

    `trajectory` is everything computed until then, or None when nothing was.
    """

    def __init__(self, time: float, component: str, cause: str, remedy: str, trajectory: Any = None) -> None:
        self.time, self.component, self.cause, self.remedy = time, component, cause, remedy
        self.trajectory = trajectory
        super().__init__(time, component, cause, remedy, trajectory)

    def __str__(self) -> str:
        place = f"'{self.component}': " if self.component else ""
        remedy = f"; {self.remedy}" if self.remedy else ""
        return f"{place}{self.cause} at t = {self.time:.9g} s{remedy}"


def missing_attribute(
    thing: object, name: str, *, parts: Iterable[str] = (), outputs: Iterable[str] = ()
) -> UnknownAttributeError | AttributeError:
    """The error of an attribute that a train, a run or a study has not: by what it is a part, an output, a function of its own,
    or another attribute."""
    if name.startswith("_"):
        return AttributeError(name)
    kind = type(thing).__name__
    of = {"Drivetrain": "rig", "Study": "study"}.get(kind, "run")
    ways = (
        [f"rig['{name}']"]
        if name in parts
        else [f"{of}[{x!r}]" for x in outputs if x == name or x.endswith(f".{name}")][:3]
    )
    if not ways and name in _FUNCTIONS and of != "study":
        ways = [f"gb.{name}({of}, ...)"]
    own = [x for x in dir(thing) if not x.startswith("_")]
    if not ways and (meant := _MEANT.get(name)) in own:
        ways = [f"{of}.{meant}"]
    ways = ways or [f"{of}['{part}']" for part in near_names(name, parts)[:1]]
    if not ways and kind == "Drivetrain" and name in _TAKING_OUT:
        return UnknownAttributeError(f"a Drivetrain has no attribute '{name}': {STAYS}")
    near = "" if ways else did_you_mean(name, own)
    return UnknownAttributeError(
        f"a {kind} has no attribute '{name}'{near}; {f'write {chr(32).join(ways)}' if ways else _LISTED[of]}"
    )


_LISTED = {
    "rig": "rig.outputs() and rig.parameters() list names",
    "run": "run.names lists the outputs",
    "study": "study[name] gives a quantity or the values of a path, study.names and study.paths list these",
}
"""Where the names of a train, a run and a study are found."""

_MEANT = {
    "time": "t", "to_pandas": "to_dataframe", "df": "to_dataframe", "dataframe": "to_dataframe", "outputs": "names",
    "columns": "names", "to_dataset": "to_xarray", "xarray": "to_xarray", "dataset": "to_xarray", "data": "to_xarray",
    "coords": "paths", "svg": "draw", "to_svg": "draw",
}  # fmt: skip
"""Attributes by what other packages call them."""


_TAKING_OUT = ("remove", "delete", "drop", "pop", "discard", "disconnect", "clear")
"""What other packages call taking something out."""

STAYS = (
    "a part stays in its train; leave it out where the train is made, in a function with an argument for it, say; "
    "effects go by rig.without('mesh.backlash')"
)

_FUNCTIONS = ("build", "simulate", "modes", "linearize", "sweep", "study", "campbell", "fit", "classify", "rms", "peak")
"""What a train or a run is given to, and has not itself."""


def by_name_only(function: _F) -> _F:
    """The function, with ParameterErrors for values without a name that need one, for names that it has not, and, where it ends
    in an error of Python's, for values of another sort than its annotations say."""
    code, defaults = function.__code__, function.__kwdefaults__ or {}
    n, name = code.co_argcount, function.__qualname__.removesuffix(".__init__").rpartition(".")[2]
    any_number = code.co_flags & CO_VARARGS
    known = code.co_varnames[: n + code.co_kwonlyargcount]
    first = known[:1].count("self")  # of those that a caller gives
    by_place, by_name = known[: n - len(function.__defaults__ or ())], [x for x in known[n:] if x not in defaults]
    listed = ", ".join(sorted(known[n:] or known[first:]))
    truths = {x for x, annotation in function.__annotations__.items() if annotation == "bool"}
    names = [f"*{code.co_varnames[len(known)]}"] if any_number else []
    call = f"{name}({', '.join([*by_place[first:], *names, *(f'{x}=...' for x in by_name)])})"

    def called(*given: Any, **named: Any) -> Any:
        if not named and not by_name and len(by_place) <= len(given) <= n:
            return function(*given, **named)
        if len(given) > n and not any_number:
            way = (
                f"is given without a name; name it: {listed}"
                if known[n:]
                else _too_many(function, given[n], known[first:])
            )
            raise ParameterError(f"{name}: {given[n]!r:.80} {way}")
        for argument in named:
            if argument not in known or argument in known[:first]:
                near = did_you_mean(argument, known[first:])
                has = f"it has {', '.join(sorted(known[first:]))}" if known[first:] else "it has none"
                raise ParameterError(f"{name} has no argument '{argument}'; {has}{near or f'; write {call}'}")
            if argument in truths and type(named[argument]).__name__ not in ("bool", "bool_"):
                raise ParameterError(f"{argument} = {named[argument]!r:.80} must be True or False")
        if twice := [x for x in known[first : min(len(given), n)] if x in named]:
            raise ParameterError(f"{name}: {twice[0]} is given twice, by its place and by its name; write {call}")
        if missing := [x for x in (*by_place[len(given) :], *by_name) if x not in named]:
            raise ParameterError(f"{name} needs {' and '.join(missing)}; write {call}")
        return function(*given, **named)

    @wraps(function)
    def checked(*given: Any, **named: Any) -> Any:
        try:
            return called(*given, **named)
        except (TypeError, ValueError, AttributeError, OverflowError) as error:
            ours = isinstance(error, GearblocksError) and not isinstance(error, UnknownAttributeError)
            values = {**dict(zip(known, given, strict=False)), **named}
            if not ours and (problem := misfit(function, values)):
                raise ParameterError(problem) from error
            raise

    return cast("_F", checked)


def misfit(function: Callable[..., Any], values: Mapping[str, Any]) -> str:
    """What a value must be that is of another sort than the annotation of its argument says, else "". Of a name that stands for
    several classes, or for none, nothing is known."""
    for argument, value in values.items():
        annotation = function.__annotations__.get(argument)  # as text: they are postponed
        sorts = [x.strip() for x in _TOP_LEVEL.split(annotation)] if isinstance(annotation, str) else ["Any"]
        if not any(_fits(value, sort, function.__globals__) for sort in sorts):
            return f"{argument} = {value!r:.80} must be {' or '.join(dict.fromkeys(_words_of(sort) for sort in sorts))}"
    return ""


_TOP_LEVEL = re.compile(r"\|(?![^\[]*\])")
"""What separates the sorts of an annotation, but not those within brackets."""
_SORTS: Mapping[str, tuple[str, tuple[type, ...]]] = {
    "str": ("text", (str,)), "bool": ("True or False", (bool,)), "None": ("None", (type(None),)),
    "int": ("a whole number", (Integral,)), "float": ("a number", (Real,)),
    "Mapping": ("a dict of names and values", (Mapping,)), "Sequence": ("a list", (Sequence,)),
    "tuple": ("a tuple", (tuple,)), "list": ("a list", (list,)),
}  # fmt: skip
"""Sorts of annotations, in words and as classes."""


def _fits(value: Any, sort: str, scope: Mapping[str, Any]) -> bool:
    """Whether a value is of a sort; what nothing is known of fits."""
    name, _, inner = sort.rstrip("]").partition("[")
    kinds: Any = _SORTS[name][1] if name in _SORTS else scope.get(name)
    try:
        if not isinstance(value, kinds):
            return False
    except TypeError:  # no class, or one that cannot be asked
        return True
    if name in ("int", "float"):
        return not isinstance(value, bool) and value == value
    if name == "Sequence" and isinstance(value, (str, bytes)):
        return False
    within = _SORTS.get(inner.split(",")[0].strip()) if name in ("Mapping", "Sequence", "list") else None
    return within is None or all(isinstance(x, within[1]) for x in value)


def _words_of(sort: str) -> str:
    name, _, inner = sort.rstrip("]").partition("[")
    return (
        f"{_SORTS[name][0] if name in _SORTS else f'a {name}'}{' of texts' * (name == 'Sequence' and inner == 'str')}"
    )


def _too_many(function: Callable[..., Any], value: Any, known: Sequence[str]) -> str:
    """Why a function without further arguments does not take this one. What answers with text writes no file."""
    text = function.__annotations__.get("return") == "str" and isinstance(value, str) and "." in value
    way = f"it takes {', '.join(known) or 'nothing'}"
    if text:
        way = f"what it answers is text, written to a file by pathlib.Path({value!r}).write_text"
    return f"is more than it takes; {way}"


_C = TypeVar("_C", bound=type)


def arguments_told(kind: _C) -> _C:
    """A class whose public methods, and `__init__` where it is the class's own, are `by_name_only`."""
    for name, member in [*vars(kind).items()]:
        function = member.__func__ if isinstance(member, staticmethod) else member
        if not isinstance(function, FunctionType) or (name.startswith("_") and name != "__init__"):
            continue
        if function.__code__.co_flags & CO_VARKEYWORDS or hasattr(function, "__wrapped__"):
            continue
        told = by_name_only(function)
        setattr(kind, name, staticmethod(told) if isinstance(member, staticmethod) else told)
    return kind


ELSEWHERE = {
    "Spring": "Shaft", "SpringDamper": "Shaft", "Disc": "Inertia", "Disk": "Inertia", "Flywheel": "Inertia", "Ground": "Fixed",
    "ElastoBacklash": "Lash", "ElastoBacklash2": "Lash", "ElastoGap": "Lash", "Position": "Angle", "Move": "Angle",
    "Accelerate": "Acceleration", "SupportFriction": "BearingFriction", "FreeWheel": "Freewheel", "Coupling": "IdealGear",
    "IdealLever": "IdealGear", "IdealGearR2T": "Rack", "IdealRollingWheel": "Rack", "EddyCurrentTorque": "EddyCurrentBrake",
    "EddyCurrentForce": "EddyCurrentBrake", "LinearSpeedDependentTorque": "SpeedLoad", "LinearSpeedDependentForce": "SpeedLoad",
    "QuadraticSpeedDependentTorque": "SpeedLoad", "QuadraticSpeedDependentForce": "SpeedLoad", "TorqueStep": "Torque",
    "ConstantTorque": "Torque", "Torque2": "Torque", "ForceStep": "Force", "ConstantForce": "Force", "Force2": "Force",
    "ConstantSpeed": "Speed", "HeatCapacitor": "ThermalMass", "ThermalConductor": "ThermalConductance",
    "Convection": "ThermalConductance", "CombiTimeTable": "Table", "Pulse": "pulse", "Trapezoid": "trapezoid",
    "Planetary": "IdealPlanetary",
    "Motor": "Torque", "Signal": "Input", "Constant": "Parameter", "min": "minimum", "max": "maximum", "Min": "minimum",
    "Max": "maximum", "Piecewise": "piecewise", "where": "piecewise", "select": "piecewise", "if_else": "piecewise",
    "load": "Trajectory.load", "run": "simulate", "solve": "simulate", "Simulation": "simulate", "Train": "Drivetrain",
    "System": "Drivetrain", "eigenmodes": "modes",
}  # fmt: skip
"""What other packages call a thing, and its name here."""

OF_NUMPY = {
    "atan": "arctan", "arctan": "arctan", "atan2": "arctan2", "arctan2": "arctan2", "asin": "arcsin", "arcsin": "arcsin",
    "acos": "arccos", "arccos": "arccos", "sinh": "sinh", "cosh": "cosh", "sign": "sign", "abs": "abs", "power": "power",
}  # fmt: skip
"""Functions that have no name here: numpy's take expressions."""


def by_name(what: str, values: Any) -> Mapping[str, Any]:
    """`values` if they are given by name, else a ParameterError."""
    if not isinstance(values, Mapping):
        raise ParameterError(f"{what} = {values!r:.80} must be a dict of names and values")
    return values


def near_names(name: str, candidates: Iterable[str]) -> list[str]:
    """The three candidates that are nearest to `name`, if any is near."""
    import difflib

    return difflib.get_close_matches(name, list(candidates), n=3, cutoff=0.6)


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """The question " - did you mean 'pinion'?" when some candidate is near to `name`, else the empty string."""
    if not isinstance(name, str):
        return ""
    known = list(candidates)
    near = near_names(name, known)
    if not near:
        folded = name.casefold()
        near = [x for x in known if x.casefold().endswith("." + folded) or x.casefold() == folded]
        near = (near or [x for x in known if len(name) > 2 and x.casefold().startswith(folded)])[:3]
    if not near:
        return ""
    return " - did you mean " + " or ".join(f"'{other}'" for other in near) + "?"
