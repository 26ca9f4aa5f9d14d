"""The task of a study: every name resolved, every value checked, and what tells it from another study.

Nothing is run before all of it is known to fit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from types import FunctionType, MethodType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.designs import Design
from gearblocks.analysis.lane_measuring import fits_lanes
from gearblocks.analysis.measuring import function_name, widths_of
from gearblocks.analysis.quantity import Quantity
from gearblocks.analysis.sections import Section, check_frequency
from gearblocks.analysis.study_point import Axis, Measure, Task, Window, point_vector, points_in_si, span_of
from gearblocks.errors import ParameterError, UnknownNameError, did_you_mean
from gearblocks.language.expression import finite_number
from gearblocks.language.signals import Table
from gearblocks.language.starts import is_rolling, values_of
from gearblocks.model.value_rules import check_rows
from gearblocks.simulation.arguments import (
    begin_of,
    check_jacobian,
    in_given_unit,
    is_static,
    method_options,
    parameter_vector,
    resolve,
    sample_times,
    set_inputs,
)  # fmt: skip
from gearblocks.simulation.input_series import with_tables
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.cache import digest
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Options
from gearblocks.train.content import content_of

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How the runs of a study are made; the arguments of `gb.simulate`, and the section."""

    t_end: float | str | None
    t: Any
    t_start: float | str | None
    section: Section | None
    transient: int
    keep: int
    method: str
    rtol: float
    step: float | str | None
    max_step: float | str | None
    locate: bool
    steps_per_period: int | None
    inputs: Mapping[str, Any] | None
    parameters: Mapping[str, float | str] | None
    initial: Any


def task_of(
    model: Model, design: Design, quantity: Any, settings: Settings, fields: Set[str]
) -> tuple[Task, tuple[str, ...]]:
    """The task, and the unit of each quantity. fields: paths of the train that are no parameters of the model, as they make
    its structure. Raises ParameterError and UnknownNameError by name."""
    program, s = model.program, settings
    measures = measures_of(quantity, "a study needs")
    window = _window(s)
    options = _options(s, window)
    axes = tuple(_axis(model, path, s.initial, fields) for path in design.paths)
    varied = [axis.offset for axis in axes if axis.kind == "parameter"]
    base = parameter_vector(model, s.parameters or {}, s.initial, later=varied)
    points = points_in_si(axes, design.points)
    _check_axes(model, points, axes, s, base)
    arguments: dict[str, Any] = {
        "t_start": s.t_start, "method": "rk4" if s.steps_per_period else s.method, "rtol": s.rtol, "step": s.step,
        "max_step": s.max_step, "locate": s.locate,
    }  # fmt: skip
    if s.t is not None:
        arguments["t"] = s.t
    task = Task(
        replace(model, rules=None), axes, base, measures, (), window, options, dict(with_tables(s.inputs)), s.initial,
        arguments, steps_per_period=int(s.steps_per_period or 0), given_starts=_given_starts(model, s),
    )  # fmt: skip
    with model.library.open() as sim:
        set_inputs(sim, program, task.inputs)
        check_jacobian(options, program, sim.has_jacobian)
    if s.section is not None:
        check_frequency(s.section, program)
    span = span_of(task, point_vector(task, points[0]))
    units = tuple(m.unit(span) if isinstance(m, Quantity) else "" for m in measures)
    widths = widths_of(task, points)
    in_lanes = s.steps_per_period is not None and fits_lanes(task)
    return replace(task, widths=widths, in_lanes=in_lanes), units


def _given_starts(model: Model, s: Settings) -> frozenset[int]:
    """Offsets of the start values that parameters and initial give."""
    program = model.program
    given = {program.parameter_numbers.get(path) for path in s.parameters or {}}
    if isinstance(s.initial, Mapping):
        starts = program.start_numbers
        given |= {program.starts[starts[name]].offset for name in s.initial if name in starts}
    return frozenset(i for i in given if i is not None)


def names_of(measures: Sequence[Measure]) -> tuple[str, ...]:
    """Names of the columns; of several functions without a name of their own quantity_1, quantity_2, ..."""
    names = [m.name if isinstance(m, Quantity) else function_name(m, "quantity") for m in measures]
    unnamed = [i for i, name in enumerate(names) if name == "quantity"]
    if len(unnamed) > 1:
        for number, i in enumerate(unnamed, 1):
            names[i] = f"quantity_{number}"
    return tuple(names)


def measures_of(quantity: Any, asks: str) -> tuple[Measure, ...]:
    """One or several quantities as a tuple, each once; asks: the words before "at least one" where there is none."""
    given = tuple(quantity) if isinstance(quantity, (list, tuple)) else (quantity,)
    if not given:
        raise ParameterError(f"quantity = (): {asks} at least one, such as gb.peak('mesh.force')")
    for one in given:
        if isinstance(one, FunctionType) and str(one.__module__).startswith("gearblocks."):
            raise ParameterError(
                f"quantity = gb.{one.__name__} makes quantities: call it, gb.{one.__name__}('mesh.force')"
            )
        if not isinstance(one, Quantity) and not (callable(one) and not isinstance(one, type)):
            raise ParameterError(
                f"quantity = {one!r:.80} must be one, such as gb.peak('mesh.force'), or a function of a trajectory"
            )
    names = names_of(given)
    for name in names:
        if names.count(name) > 1:
            raise ParameterError(
                f"the quantity '{name}' is given twice: each makes a column of its name; leave one out, or let a function be "
                "defined (def) by another name"
            )
    return given


def _options(s: Settings, window: Window) -> Options:
    """How a run is made. Raises ParameterError for settings that contradict each other."""
    count, method, step = s.steps_per_period, s.method, s.step
    if count is not None:
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 4:
            raise ParameterError(f"steps_per_period = {count!r} must be a whole number, >= 4")
        if not window.periodic:
            raise ParameterError("steps_per_period goes with a section and its periods: leave out t_end and t")
        if method not in ("auto", "rk4") or step is not None:
            raise ParameterError("steps_per_period means steps of method 'rk4': leave out method and step")
        method, step = "rk4", 1.0  # each point has its own
    return method_options(method, s.rtol, step, s.max_step, s.locate, window.end)[0]


_PERIODS = 300, 100
"""transient and keep where nothing is said."""


def _window(s: Settings) -> Window:
    begin = begin_of(s.t_start, s.initial)
    if s.section is not None and not isinstance(s.section, Section):
        raise ParameterError(f"section = {s.section!r:.80} must be one, such as gb.stroboscopic('speed')")
    if s.t_end is None and s.t is None and s.section is not None:
        for name, value, least in (("transient", s.transient, 0), ("keep", s.keep, 1)):
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
                raise ParameterError(f"{name} = {value!r} must be a whole number of periods, >= {least}")
        return Window(begin, float("inf"), s.section, int(s.transient), int(s.keep), periodic=True)
    if s.t_end is None and s.t is None:
        raise ParameterError("give t_end [s], sample times t, or a section with the periods transient and keep")
    _, end = sample_times(begin, s.t_end, s.t)
    if s.section is None and (s.transient, s.keep) != _PERIODS:
        raise ParameterError(
            f"transient = {s.transient!r} and keep = {s.keep!r} count periods of a section, and there is none: give "
            "section=gb.stroboscopic('speed'), or times to the quantities, as gb.rms('mesh.force', after=0.5) does"
        )
    return Window(begin, end, s.section)


def _axis(model: Model, path: str, initial: Any, fields: Set[str]) -> Axis:
    """Where the values of a path go: a parameter, a start value, or an input. Raises UnknownNameError, ParameterError."""
    program = model.program
    try:
        info = program.parameters[i := resolve(path, program.parameter_numbers, "parameter")]
    except UnknownNameError as unknown:
        starts, inputs = program.start_numbers, program.input_numbers
        if path in starts:
            if not (initial is None or isinstance(initial, Mapping) or is_rolling(initial)):
                raise ParameterError(
                    f"'{path}' is a start value, and initial = {initial!r:.40} gives all of them"
                ) from None
            return Axis(path, program.output_units.get(path, ""), "start", starts[path])
        if path in inputs:
            source = program.inputs[inputs[path]]
            return Axis(path, source.unit, "input", inputs[path], source.given_in)
        if "not unique" in str(unknown):
            raise
        if path in fields:
            raise _structural(path) from None
        near = did_you_mean(path, [*program.parameter_numbers, *starts, *inputs])
        raise UnknownNameError(f"there is no parameter, start value or input '{path}'{near}") from None
    if info.path in program.structural_paths:
        raise _structural(info.path)
    return Axis(info.path, info.unit, "parameter", i, info.given_in)


def check_varies(model: Model, path: str, initial: Any, fields: Set[str]) -> None:
    """ParameterError for a path that no study can vary: what is structural."""
    _axis(model, path, initial, fields)


def number_given(model: Model, path: str, value: Any, initial: Any, fields: Set[str]) -> float:
    """A value that brings its unit, in the unit in which bare numbers of its path are given."""
    axis = _axis(model, path, initial, fields)
    return in_given_unit(path, value, axis.unit, axis.given_in)


def _structural(path: str) -> ParameterError:
    return ParameterError(f"'{path}' is structural: make one study for each rig.set({{'{path}': ...}})")


def _check_axes(model: Model, points: Array, axes: Sequence[Axis], s: Settings, base: Array) -> None:
    """Every value against the rules of its parameter and its block; nothing is given twice."""
    program = model.program
    fixed = {
        "parameter": {program.parameters[resolve(p, program.parameter_numbers, "parameter")].path for p in s.parameters or {}},
        "start": set(values_of(s.initial)),
        "input": {program.inputs[resolve(name, program.input_numbers, "input")].name for name in s.inputs or {}},
    }  # fmt: skip
    for i, axis in enumerate(axes):
        if axis.path in fixed[axis.kind] or axis in axes[:i]:
            raise ParameterError(f"'{axis.path}' is given twice: once to vary, once fixed or under another name")
    check_rows(model, base, {axis.offset: points[:, i] for i, axis in enumerate(axes) if axis.kind == "parameter"})
    if is_static(s.initial) and any(axis.kind == "start" for axis in axes):
        raise ParameterError(f"initial = {s.initial!r} and start values that vary exclude each other")


# -- identity -----------------------------------------------------------------------------------------------------------


def identity(task: Task, design: Design) -> dict[str, str]:
    """Digests of all that the values of a study follow from, by the words in which a store of another study is refused."""
    o, w = task.options, task.window
    section = w.section.frequency if w.section else ""
    parts: dict[str, list[Any]] = {
        "the train": [task.model.program.key],
        "the fixed parameters": [_fixed(task)],
        "the grid": [task.axes, design.shape, design.points.tobytes()],
        "the quantities": [_measure_text(m) for m in task.measures],
        "the time": [w.begin, w.end, section, w.transient, w.keep, np.asarray(task.arguments.get("t", ())).tobytes()],
        "the method or tolerance": [
            o.method,
            o.locate,
            o.rtol,
            o.step,
            o.max_step,
            task.steps_per_period,
            task.in_lanes,
        ],
        "the inputs": [(name, _source_text(source)) for name, source in sorted(task.inputs.items())],
        "the start": [start_text(task.initial)],
    }
    return {name: digest(*(repr(part) for part in values)) for name, values in parts.items()}


def _fixed(task: Task) -> bytes:
    base = task.base.copy()
    base[[axis.offset for axis in task.axes if axis.kind == "parameter"]] = 0.0
    return base.tobytes()


def _measure_text(measure: Measure) -> str:
    return repr(measure) if isinstance(measure, Quantity) else _callable_text(measure)


def _callable_text(function: Callable[..., Any]) -> str:
    """A function by its content; an object that is called, or whose method is, by what it held when it was first given, as
    it may count its calls."""
    if isinstance(function, FunctionType):
        return content_of(function)
    if isinstance(function, MethodType):
        return content_of(function.__func__) + _first_content(function.__self__)
    return _first_content(function)


_FIRST: WeakKeyDictionary[Any, str] = WeakKeyDictionary()
"""Contents of objects when they were first given, as long as they live."""


def _first_content(thing: Any) -> str:
    try:
        return _FIRST.setdefault(thing, _FIRST.get(thing) or content_of(thing))
    except TypeError:  # what has no hash, or no weak references
        return content_of(thing)


def _source_text(source: Any) -> str:
    if isinstance(source, Table):
        return f"{np.asarray(source.x).tolist()} {np.asarray(source.y).tolist()} {source.kind} {source.periodic}"
    return _callable_text(source) if callable(source) else repr(finite_number("an input", source))


def start_text(initial: Any) -> str:
    """What tells a start from another one."""
    if isinstance(initial, Trajectory):
        final = initial.final_state
        return "" if final is None else f"{final.t!r} {final.y.tobytes()!r} {final.modes.tobytes()!r}"
    return repr(sorted(initial.items()) if isinstance(initial, Mapping) else initial)
