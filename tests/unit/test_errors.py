"""Errors say everything they know, and survive the way between processes."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from fractions import Fraction
from inspect import CO_VARKEYWORDS, unwrap
from operator import attrgetter
from types import FunctionType
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import (
    ELSEWHERE,
    OF_NUMPY,
    CompileError,
    ModelError,
    ParameterError,
    SimulationError,
    UnknownNameError,
    arguments_told,
    by_name_only,
    did_you_mean,
    misfit,
)
from gearblocks.language.expression import evaluate


def test_a_model_error_lists_every_problem() -> None:
    error = ModelError(["Inertia 'motor': J = -1.0 kg m2 must be >= 0", "Shaft 'shaft': flange b is open"])
    assert str(error).splitlines() == [
        "2 problems:",
        "  - Inertia 'motor': J = -1.0 kg m2 must be >= 0",
        "  - Shaft 'shaft': flange b is open",
    ]
    assert str(ModelError("only one")) == "only one"


def test_a_simulation_error_names_time_component_cause_and_remedy() -> None:
    error = SimulationError(0.0132, "mesh", "step size fell below 1e-14", "the model may be stiff")
    assert str(error) == "'mesh': step size fell below 1e-14 at t = 0.0132 s; the model may be stiff"


def test_errors_can_be_sent_to_another_process() -> None:
    for error in (
        ModelError(["a", "b"]),
        SimulationError(1.0, "mesh", "cause", "remedy", {"t": 1.0}),
        CompileError("failed", ["cc", "-c"], "words"),
        UnknownNameError("no output 'x'"),
    ):
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error)
        assert str(again) == str(error)
        assert vars(again) == vars(error)


def test_a_compile_error_shows_the_command_and_the_end_of_what_the_compiler_said() -> None:
    text = str(CompileError("the C compiler failed", ["cc", "model.c"], "\n".join(f"line {i}" for i in range(100))))
    assert "cc model.c" in text
    assert "line 99" in text
    assert "line 5\n" not in text


def test_an_unknown_name_reads_as_a_sentence() -> None:
    error = UnknownNameError("no output 'mesh.forse'" + did_you_mean("mesh.forse", ["mesh.force", "wheel.w"]))
    assert isinstance(error, KeyError)
    assert str(error) == "no output 'mesh.forse' - did you mean 'mesh.force'?"


def test_no_near_name_asks_nothing() -> None:
    assert did_you_mean("zzz", ["pinion", "wheel"]) == ""


def test_a_last_part_finds_its_whole_path() -> None:
    assert did_you_mean("half_gap", ["mesh.backlash.half_gap"]) == " - did you mean 'mesh.backlash.half_gap'?"


@by_name_only
def _measured(train: str, speed: float = 1.0, *, over: str, step: float = 0.1) -> tuple[str, float, str, float]:
    return train, speed, over, step


def test_values_that_are_missing_misspelt_or_without_a_name_are_told_with_the_call() -> None:
    call = r"write _measured\(train, over=\.\.\.\)"
    with pytest.raises(ParameterError, match=f"_measured needs over; {call}"):
        _measured("rig", 2.0)  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match=f"_measured needs train and over; {call}"):
        _measured()  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match=f"has no argument 'length'; it has over, speed, step, train; {call}"):
        _measured("rig", length=3.0)  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="did you mean 'over'"):
        _measured("rig", ovr="mesh")  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="'mesh' is given without a name; name it: over, step"):
        _measured("rig", 2.0, "mesh")  # type: ignore[misc]
    assert _measured("rig", over="mesh") == _measured(train="rig", speed=1.0, over="mesh", step=0.1)


@by_name_only
def _shown(first: str, *others: str, path: str = "") -> tuple[str, tuple[str, ...], str]:
    return first, others, path


def test_a_function_of_any_number_of_values_takes_them_and_names_what_it_has_not() -> None:
    assert _shown("a", "b", "c", path="d") == ("a", ("b", "c"), "d")
    with pytest.raises(
        ParameterError, match="has no argument 'file'; it has first, path; write _shown\\(first, \\*others\\)"
    ):
        _shown("a", file="d")  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="_shown needs first"):
        _shown()  # type: ignore[call-arg]


@pytest.mark.parametrize("name", ELSEWHERE)
def test_what_other_packages_call_a_thing_is_no_name_here_and_leads_to_one(name: str) -> None:
    with pytest.raises(AttributeError, match=f"here it is gb.{ELSEWHERE[name]}$"):
        getattr(gb, name)
    assert attrgetter(ELSEWHERE[name])(gb) is not None


@pytest.mark.parametrize("name", OF_NUMPY)
def test_a_function_that_is_numpys_is_found_there_and_takes_expressions(name: str) -> None:
    with pytest.raises(AttributeError, match=f"np.{OF_NUMPY[name]} of numpy takes expressions"):
        getattr(gb, name)
    function = getattr(np, OF_NUMPY[name])
    others = [0.5] * (function.nin - 1)
    assert evaluate(function(gb.time, *others), lambda _: 0.25) == pytest.approx(function(0.25, *others), rel=1e-15)


@arguments_told
class _Box:
    def __init__(self, width: float) -> None:
        self.width = width

    def wider(self, by: float) -> float:
        return self.width + by

    def text(self) -> str:
        return str(self.width)

    def changed(self, **values: float) -> dict[str, float]:
        return values

    @staticmethod
    def of(side: float) -> _Box:
        return _Box(side)


def test_a_class_tells_of_the_arguments_of_all_its_methods() -> None:
    assert _Box.of(2.0).wider(by=1.0) == 3.0 and _Box(width=1.0).changed(width=2.0) == {"width": 2.0}
    for wrong, words in (
        (lambda: _Box(1.0, 2.0), "_Box: 2.0 is more than it takes; it takes width"),
        (lambda: _Box(1.0).wider(), r"wider needs by; write wider\(by\)"),
        (lambda: _Box(1.0).wider(1.0, by=2.0), "wider: by is given twice, by its place and by its name"),
        (lambda: _Box.of(edge=1.0), "of has no argument 'edge'; it has side"),
        (lambda: _Box(1.0).text(3), "text: 3 is more than it takes; it takes nothing"),
        (lambda: _Box(1.0).text("box.txt"), r"written to a file by pathlib.Path\('box.txt'\).write_text"),
    ):
        with pytest.raises(ParameterError, match=words):
            wrong()  # type: ignore[no-untyped-call]


def test_public_functions_and_methods_answer_wrong_arguments_in_words() -> None:
    made = {"Trajectory", "Model", "Linearization", "Modes", "Campbell", "FrequencyResponse", "Study", "Quantity"}
    for name in gb.__all__:
        thing = getattr(gb, name)
        if not callable(thing) or (isinstance(thing, type) and issubclass(thing, BaseException)):
            continue
        if name not in made:
            with pytest.raises(gb.GearblocksError):
                thing(no_such_argument=1)
        of_users = isinstance(thing, type) and not issubclass(thing, (gb.Block, gb.Effect, gb.Quantity, gb.Model))
        for member, function in vars(thing).items() if of_users else ():
            plain = isinstance(function, FunctionType) and not function.__code__.co_flags & CO_VARKEYWORDS
            if plain and not member.startswith("_"):
                assert hasattr(function, "__wrapped__"), f"{name}.{member}"


def test_a_beginning_is_near() -> None:
    assert did_you_mean("spline", ["spline_coupling", "gear_pair"]) == " - did you mean 'spline_coupling'?"
    assert did_you_mean("sp", ["spline_coupling", "gear_pair"]) == ""


@by_name_only
def _read(
    times: Sequence[float], names: Mapping[str, float] | None = None, *, count: int = 1, run: Fraction | str = "",
    what: Any = None,
) -> float:  # fmt: skip
    """What ends in an error of Python's where values are of another sort."""
    del run, what
    return sum(times) / count + sum(0.0 * value for value in (names or {}).values())


def test_values_of_another_sort_than_annotated_are_told_where_python_ends_in_an_error() -> None:
    assert _read([1.0, 2.0], {"a": 3.0}, count=2) == 1.5
    for wrong, words in (
        (lambda: _read(3.0), r"times = 3.0 must be a list"),
        (lambda: _read(["x"]), r"times = \['x'\] must be a list"),
        (lambda: _read([1.0], [("a", 3.0)]), r"names = .* must be a dict of names and values or None"),
        (lambda: _read([1.0], count="two"), r"count = 'two' must be a whole number"),
    ):
        with pytest.raises(ParameterError, match=words) as told:
            wrong()  # type: ignore[no-untyped-call]
        assert isinstance(told.value.__cause__, (TypeError, AttributeError))
    with pytest.raises(ZeroDivisionError):  # every value is of its sort: the error is another one's
        _read([1.0], count=0)
    read = unwrap(_read)
    fitting = {"times": (1, 2.0), "names": {"a": 1}, "count": 2, "run": "", "what": object()}
    assert misfit(read, fitting) == ""
    assert misfit(read, {"run": 3.5}) == "run = 3.5 must be a Fraction or text"
    assert misfit(read, {"count": float("nan")}) and misfit(read, {"count": True}) and misfit(read, {"times": "ab"})
