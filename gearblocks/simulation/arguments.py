"""The arguments of a run: checked, resolved by name, and put into the solver's vectors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from gearblocks.codegen.program import InputInfo, ParameterInfo, Program
from gearblocks.errors import ParameterError, UnknownNameError, by_name, did_you_mean
from gearblocks.language.expression import Expr, finite_number
from gearblocks.language.fields import ANGLE, SPEED
from gearblocks.language.signals import Table, check_increasing
from gearblocks.language.starts import ROLLING, Rolling, is_rolling
from gearblocks.language.units import has_unit, number_in_si, parse_unit, seconds
from gearblocks.model.following_starts import followed
from gearblocks.model.listing import matches, near_patterns
from gearblocks.model.value_rules import check_numbers
from gearblocks.simulation.input_series import TimeSeries, table_of_series
from gearblocks.simulation.records import NamedValues
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array, Counters, Kind, Method, Options
from gearblocks.train.graph import blocks_of
from gearblocks.train.summary import expression_text
from gearblocks.train.values import field_paths, gone_with_effect

Start: TypeAlias = "Mapping[str, float | str] | Trajectory | Rolling | str | None"
"""What `initial` takes."""
InputSource: TypeAlias = "float | str | Table | Callable[[float], float] | tuple[ArrayLike, ArrayLike] | TimeSeries"
STATIC = ("static", "static_at_start")
METHODS = {method.name.lower(): method for method in Method if method is not Method.AUTO}
METHOD_NAMES = tuple(method.name.lower() for method in Method)
"""By number."""


def begin_of(t_start: float | str | None, initial: Any) -> float:
    if t_start is not None:
        return seconds("t_start", t_start)
    if isinstance(initial, Trajectory) and initial.final_state is not None:
        return initial.final_state.t
    return 0.0


def sample_times(begin: float, t_end: float | str | None, t: ArrayLike | None) -> tuple[Array | None, float]:
    """The samples (None: every accepted step) and the end of the run."""
    if (t is None) == (t_end is None):
        raise ParameterError("give either t_end (records every step) or t (an array of sample times)")
    if isinstance(t_end, (tuple, list)):
        raise ParameterError(f"t_end = {t_end!r:.80} must be a number; a run from another time than 0 has t_start= too")
    if t is None:
        assert t_end is not None
        end = seconds("t_end", t_end)
        if end <= begin:
            raise ParameterError(f"t_end = {end!r} s must be later than the start at {begin!r} s")
        return None, end
    try:
        samples = np.ascontiguousarray(t, dtype=np.float64)
    except (TypeError, ValueError, ParameterError):
        raise ParameterError(f"t = {t!r:.80} must be a row of numbers") from None
    if samples.ndim == 1 and not np.isfinite(samples).all():
        i = int(np.argmin(np.isfinite(samples)))
        raise ParameterError(f"t[{i}] = {samples[i]} must be a finite time; leave it out")
    if samples.ndim != 1 or len(samples) == 0:
        raise ParameterError(f"t must be a row of finite times, not an array of shape {samples.shape}")
    if samples[0] < begin:
        raise ParameterError(
            f"t[0] = {samples[0]} s must not be before the start at {begin!r} s; give t_start= or later times"
        )
    check_increasing("t", samples)
    return samples, float(samples[-1])


def method_options(
    method: str, rtol: float, step: float | str | None, max_step: float | str | None, locate: bool, end: float
) -> tuple[Options, str]:  # fmt: skip
    """The options of the solver, and why this method."""
    try:
        values, why = _checked_options(method, rtol, step, max_step, locate)
    except TypeError:  # what cannot be looked up is no number either: it is said by name
        values, why = _checked_options.__wrapped__(method, rtol, step, max_step, locate)
    return Options(*values, end), why


@lru_cache(maxsize=64, typed=True)
def _checked_options(
    method: str, rtol: float, step: float | str | None, max_step: float | str | None, locate: bool
) -> tuple[tuple[float, ...], str]:
    if method not in ("auto", *METHODS):
        raise ParameterError(
            f"method = {method!r} must be 'auto', {', '.join(map(repr, METHODS))}{did_you_mean(method, METHODS)}"
        )
    rtol = finite_number("rtol", rtol)
    if not 1e-14 <= rtol <= 0.1:
        raise ParameterError(f"rtol = {rtol!r} must lie between 1e-14 and 0.1")
    step, max_step = duration("step", step), duration("max_step", max_step)
    if not isinstance(locate, (bool, np.bool_)):
        raise ParameterError(f"locate = {locate!r} must be True or False")
    if method == "rk4" and step is None:
        raise ParameterError("method 'rk4' has a fixed step: give step= in s, or take 'dp5' or 'dp8'")
    why = "chosen by the user"
    if method == "auto":
        why = f"rtol = {rtol:g}: order 8 pays from 1e-3 down, order 5 above"
    number = METHODS.get(method, Method.AUTO)
    return (number, int(locate), rtol, step or 0.0, max_step or math.inf), why


def duration(name: str, value: float | str | None) -> float | None:
    """A time [s] above 0, or text with its unit; None stays."""
    number = None if value is None else seconds(name, value)
    if number is not None and number <= 0:
        raise ParameterError(
            f"{name} = {value!r} s must be > 0" if number == value else f"{name} = {value!r} must be > 0"
        )
    return number


def check_jacobian(options: Options, program: Program, has_jacobian: bool) -> None:
    """ParameterError where an implicit method is asked of a train whose laws give no Jacobian."""
    if options.method == Method.RODAS and not has_jacobian:
        raise ParameterError(
            f"method = 'rodas' needs the Jacobian, which '{program.name}' does not give: take 'dp8'. It is missing as a rule "
            "where a state follows from an acceleration or a constraint force that a block reads by gb.sense"
        )


def method_words(counters: Counters, why: str) -> tuple[str, str]:
    """The methods of a run, most steps first, and why: what was chosen, when the solver changed it and for what reason."""
    if counters.n_switches == 0:
        return METHOD_NAMES[counters.method], why
    taken = sorted((-counters.steps_by[m], m) for m in range(Method.AUTO) if counters.steps_by[m])
    names = [METHOD_NAMES[m] for _, m in taken]
    shown = min(counters.n_switches, len(counters.switch_t))
    changes = [(METHOD_NAMES[counters.switch_method[i]], counters.switch_t[i]) for i in range(shown)]
    first = next((name for name in names if name != "rodas"), "dp8")
    words = f"{why}; {first} to t = {changes[0][1]:.4g} s, then {changes[0][0]}"
    words += "".join(f", from {t:.4g} s {name}" for name, t in changes[1:3])
    if counters.n_switches > 3:
        words += f", {counters.n_switches} changes in all"
    counts = ", ".join(f"{-count} steps {METHOD_NAMES[m]}" for count, m in taken)
    return "+".join(names), f"{words} ({counts}): stability, not accuracy, set the steps of {first} while it was stiff"


def picked_outputs(program: Program, outputs: str | Sequence[str]) -> Mapping[str, int]:
    """The outputs that match and their numbers, in their order; UnknownNameError for a pattern that matches nothing."""
    if outputs == "*":
        return program.output_numbers
    patterns = [outputs] if isinstance(outputs, str) or not isinstance(outputs, Iterable) else list(outputs)
    if not all(isinstance(pattern, str) for pattern in patterns):
        raise ParameterError(f"outputs = {outputs!r:.80} must be a pattern or a list of patterns, such as ['mesh.*']")
    if patterns == ["*"]:
        return program.output_numbers
    names = program.output_numbers
    chosen: set[int] = set()
    for pattern in patterns:
        found = [names[pattern]] if pattern in names else [i for name, i in names.items() if matches(name, pattern)]
        if not found:
            raise UnknownNameError(
                f"no output matches '{pattern}'{near_patterns(pattern, names)}; rig.outputs() lists them"
            )
        chosen.update(found)
    return {program.outputs[i].name: i for i in sorted(chosen)}


def resolve(wanted: str, names: Mapping[str, int], what: str) -> int:
    """The number of a name, or of the only one that ends with it."""
    if not isinstance(wanted, str):
        name = getattr(wanted, "name", None)  # of a Parameter or an Input
        way = f"; write '{name}'" if isinstance(name, str) else ""
        raise UnknownNameError(f"the name of the {what} must be text, not {wanted!r:.80}{way}")
    if wanted in names:
        return names[wanted]
    ends = [name for name in names if name.endswith("." + wanted)]
    if len(ends) == 1:
        return names[ends[0]]
    if ends:
        raise UnknownNameError(f"{what} '{wanted}' is not unique: it could be {', '.join(sorted(ends))}")
    there = f"there are {listed([*names])}" if names else f"the train has no {what}"
    raise UnknownNameError(f"there is no {what} '{wanted}'; {there}{did_you_mean(wanted, names)}")


def listed(names: Sequence[str]) -> str:
    """The first of some names."""
    return ", ".join(names[:12]) + ", ..." * (len(names) > 12)


def check_start(name: str, start: Any) -> None:
    """ParameterError where an argument of this name does not say how a train stands."""
    if start is None or isinstance(start, (Mapping, Trajectory)) or is_static(start) or is_rolling(start):
        return
    raise ParameterError(
        f"{name} = {start!r:.80} must be start values such as {{'motor.w': 100.0}}, an earlier run, 'static', "
        f"'static_at_start', 'rolling' or gb.rolling(...){did_you_mean(start, (*STATIC, ROLLING))}"
    )


def parameter_vector(
    model: Model, changed: Mapping[str, float | str], initial: Any, values: Array | None = None,
    later: Collection[int] = (),
) -> Array:  # fmt: skip
    """The parameter vector (values: instead of that of the model) with changed parameters and start values, not to be written
    to. later: offsets of parameters that will vary, which are checked then. Start values follow the Parameters that they are
    given by, but for those that are given here; those of a rolling start are found later (rolling.py)."""
    program, values = model.program, model.values if values is None else values
    if not changed and initial is None and isinstance(changed, dict):
        return values
    result = np.array(values)
    names, structural = program.parameter_numbers, program.structural_paths
    given: list[int] = []
    if isinstance(initial, Trajectory):
        before = initial.meta.get("parameters", {})
        if isinstance(before, NamedValues) and before.numbers is names:
            result[:] = before.vector
        else:
            for path, value in dict(before).items():
                if path in names:
                    result[names[path]] = value
            given += np.flatnonzero(result != values).tolist()
    for path, value in by_name("parameters", changed).items():
        i = _number_of_parameter(model, path)
        info = program.parameters[i]
        if info.path in structural:
            why = program.why_structural(info.path)
            raise ParameterError(f"'{info.path}' {why}, which is structural: make a new train with rig.set(...)")
        result[i] = finite_number(info.path, number_of(info.path, value, info))
        given.append(i)
    if given:
        check_numbers(model, result, given, later)
    if any(program.parameters[i].path in model.start_parameters for i in given):
        result = with_followed(model, result, given)
    check_start("initial", initial)
    if isinstance(initial, Mapping) and initial:
        _initial(model, result, initial)
    return result


_STRUCTURAL = ("exact", "option", "effect")
"""Roles of fields that are no parameters of a run."""


def _number_of_parameter(model: Model, path: str) -> int:
    """The number of a parameter. Raises UnknownNameError, and ParameterError for a value that is structural."""
    try:
        return resolve(path, model.program.parameter_numbers, "parameter")
    except UnknownNameError:
        for component, block in blocks_of(model.tree) if model.tree is not None else ():
            for field in field_paths(block):
                full, role = f"{component}.{field}", type(block).fields[re.split(r"[.\[]", field)[0]].role
                if role in _STRUCTURAL and isinstance(path, str) and (full == path or full.endswith(f".{path}")):
                    raise ParameterError(
                        f"'{full}' is structural, no parameter of a run: make a new train with rig.set({{'{full}': ...}})"
                    ) from None
        left = model.left_out
        if left is not None and (gone := gone_with_effect(path, ((n, b) for n, b, _ in left.blocks), left.names)):
            raise UnknownNameError(gone) from None
        raise


def with_followed(model: Model, vector: Array, given: Collection[int]) -> Array:
    """The vector with the start values that follow from its Parameters, but for those at the offsets given."""
    starts = [i for i, p in enumerate(model.program.parameters) if p.start in (ANGLE, SPEED) and i not in given]
    result = np.array(vector)
    result[starts] = followed(model, vector)[starts]
    return result


def number_of(name: str, value: Any, info: ParameterInfo | InputInfo) -> Any:
    """A value in SI: it brings its unit, or is in that in which values are given; else it is left as it is."""
    if has_unit(value):
        return number_in_si(name, value, info.unit)
    return parse_unit(info.given_in).in_si(finite_number(name, value)) if info.given_in else value


def in_given_unit(name: str, value: Any, unit: str, given_in: str) -> float:
    """A value that brings its unit, in the one in which bare numbers of it are given ("": that of SI)."""
    number = number_in_si(name, value, unit)
    return parse_unit(given_in).of_si(number) if given_in else number


def is_static(initial: Any) -> bool:
    """Whether a start asks for the equilibrium."""
    return isinstance(initial, str) and initial in STATIC


def _initial(model: Model, result: Array, initial: Mapping[str, float | str]) -> None:
    program = model.program
    dependents = {f.name: f for f in program.dependent_starts if f.of in (ANGLE, SPEED)}
    initial = dict(initial)
    asked = {dependents[name]: initial.pop(name) for name in [*initial] if name in dependents}
    given: dict[int, tuple[str, float]] = {}
    for name, value in initial.items():
        info = program.starts[_number_of_start(program, name)]
        number = finite_number(info.name, start_number(program, info.name, value)) * info.factor
        of = program.parameters[info.offset]
        if model.start_parameters.get(of.path, 1) > 1 and abs(number - result[info.offset]) > 1e-12 * abs(number):
            raise ParameterError(
                f"initial: '{info.name}' starts as the Parameter '{of.path}' says, which stands elsewhere too: give "
                f"parameters={{'{of.path}': ...}}, or the block a number"
            )
        before = given.setdefault(info.offset, (name, number))
        if abs(before[1] - number) > 1e-12 * max(abs(number), abs(before[1])):
            raise ParameterError(
                f"the initial values of '{before[0]}' and '{name}' contradict each other through their ties"
            )
        result[info.offset] = number
    for dependent, wanted in asked.items():
        value = start_number(program, dependent.name, wanted)
        follows = sum(f * result[i] for i, f in zip(dependent.offsets, dependent.factors, strict=True))
        if abs(follows - value) > 1e-9 * max(abs(value), abs(follows)):
            names = ", ".join(program.parameters[i].path for i in dependent.offsets)
            raise ParameterError(
                f"initial: '{dependent.name}' = {value!r} contradicts the {follows:.9g} that follows from {names} through "
                f"its ties: give those"
            )


def _number_of_start(program: Program, name: str) -> int:
    """The number of a start value. Raises UnknownNameError."""
    try:
        return resolve(name, program.start_numbers, "initial value")
    except UnknownNameError as unknown:
        if name not in {state.name for state in program.states}:
            raise
        way = (
            "start values are given as angles and speeds of bodies; a run begins on an orbit by initial=orbit.starts[0]"
        )
        raise UnknownNameError(f"{unknown}. '{name}' is a state that follows from these: {way}") from None


def start_number(program: Program, name: str, value: Any) -> Any:
    """A start value in SI: it brings its unit, or is a bare number."""
    return number_in_si(name, value, program.output_units.get(name, "1")) if has_unit(value) else value


def set_inputs(sim: Simulation, program: Program, sources: Mapping[str, InputSource]) -> None:
    if not program.inputs and not sources and isinstance(sources, dict):
        return
    names = program.input_numbers
    sim.inputs[:] = program.input_starts
    for name, given in by_name("inputs", sources).items():
        source = table_of_series(name, given)
        if not names:
            raise UnknownNameError(
                f"there is no input '{name}', and the train has none: an input is declared where its value stands, such as "
                f"gb.Torque(tau=gb.Input('{name}', unit='N m')); other values are changed by parameters={{path: value}}"
            )
        i = resolve(name, names, "input")
        info = program.inputs[i]
        if info.given_in and (isinstance(source, Table) or callable(source)):
            source = _converted(source, parse_unit(info.given_in).factor)
        if isinstance(source, Table):
            source = source.reached
            period = float(source.x[-1] - source.x[0]) if source.periodic else 0.0
            kind = {"linear": Kind.LINEAR, "step": Kind.STEP, "cubic": Kind.CUBIC}[source.kind]
            sim.set_table(i, kind, np.asarray(source.x), np.asarray(source.y), source.second, period)
        elif callable(source):
            sim.set_function(i, partial(_answered, source))
        else:
            what = f"input '{info.name}'"
            _check_source(what, source)
            sim.inputs[i] = finite_number(what, number_of(what, source, info))


def _answered(source: Callable[[float], float], t: float) -> float:
    """What an input function answers. TypeError where that is no number."""
    value = source(t)
    if not hasattr(value, "__float__") or getattr(value, "shape", ()) != ():
        raise TypeError(f"it answered {value!r:.60}")
    return value


def _check_source(what: str, source: Any) -> None:
    """ParameterError where what an input is given is no number, nor anything else that it takes."""
    is_expression = isinstance(source, Expr) or hasattr(source, "_expr_") or bool(getattr(source, "free_symbols", ()))
    if is_expression or isinstance(source, bool) or not (has_unit(source) or hasattr(source, "__float__")):
        shown = expression_text(source) if isinstance(source, Expr) else repr(source)
        instead = "; an expression belongs into the field of the train where the Input stands" * is_expression
        ways = "text with its unit, a gb.Table, a pair (t, y), a Series over time or a function of the time in s"
        raise ParameterError(f"{what} = {shown:.80} must be a number, {ways}{instead}")


def _converted(source: Table | Callable[[float], float], factor: float) -> Table | Callable[[float], float]:
    """A source of values that are not in SI, in SI."""
    if isinstance(source, Table):
        return replace(source, y=factor * np.asarray(source.y))
    return lambda t: factor * source(t)
