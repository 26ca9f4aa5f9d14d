"""Errors say everything they know, and survive the way between processes."""

import pickle
from operator import attrgetter

import pytest

import gearblocks as gb
from gearblocks.errors import (
    ELSEWHERE,
    CompileError,
    ModelError,
    ParameterError,
    SimulationError,
    UnknownNameError,
    by_name_only,
    did_you_mean,
)


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
    with pytest.raises(ParameterError, match=f"has no argument 'length'; it has over, step; {call}"):
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
    with pytest.raises(ParameterError, match="has no argument 'file'; it has path; write _shown\\(first, \\*others\\)"):
        _shown("a", file="d")  # type: ignore[call-arg]
    with pytest.raises(ParameterError, match="_shown needs first"):
        _shown()  # type: ignore[call-arg]


@pytest.mark.parametrize("name", ELSEWHERE)
def test_what_other_packages_call_a_thing_is_no_name_here_and_leads_to_one(name: str) -> None:
    with pytest.raises(AttributeError, match=f"here it is gb.{ELSEWHERE[name]}$"):
        getattr(gb, name)
    assert attrgetter(ELSEWHERE[name])(gb) is not None
