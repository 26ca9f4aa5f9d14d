"""Errors say everything they know, and survive the way between processes."""

import pickle

from gearblocks.errors import CompileError, ModelError, SimulationError, UnknownNameError, did_you_mean


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
