"""`gearblocks doc`: the reference of every public name; and the example of every block and effect runs."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

import fmu_export
import gearblocks as gb
from gearblocks.cli.main import BAD_INPUT, main
from gearblocks.language.reference import example_of

KINDS = [
    kind
    for name in gb.__all__
    if isinstance(kind := getattr(gb, name), type) and issubclass(kind, gb.Block | gb.Effect)
    if kind not in (gb.Block, gb.Effect)
]
LONGEST = 0.1  # s


def _run(kind: type) -> dict[str, Any]:
    scope: dict[str, Any] = {"gb": gb}
    exec(compile(example_of(kind), f"example of {kind.__name__}", "exec"), scope)  # noqa: S102  our own docstring
    return scope


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.few(20)
def test_the_example_of_a_block_or_effect_runs_and_has_it(kind: type) -> None:
    assert f"gb.{kind.__name__}(" in example_of(kind)
    scope = _run(kind)
    if "rig" in scope:
        scope["rig"].train()  # nothing is left open
        assert kind.__name__ in scope["rig"].describe()
    else:
        assert issubclass(kind, gb.Effect)
        made = [x for x in scope.values() if isinstance(x, gb.Block | gb.Effect)]
        assert made
        assert not [p for x in made for p in x.problems()]


@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in KINDS if issubclass(kind, gb.Block)])
def test_the_train_of_an_example_can_be_simulated(kind: type) -> None:
    run = gb.simulate(_run(kind)["rig"], t_end=LONGEST)
    assert run.complete
    assert run.energy.residual < 1e-3


def test_doc_prints_what_help_says(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc", "GearMesh"]) == 0
    out = capsys.readouterr().out
    assert inspect.getdoc(gb.GearMesh) in out
    assert out.startswith(
        "gb.GearMesh(\n    teeth: tuple[int, int],\n    external: bool,\n    module: Value | None = None,\n"
    )


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("gb.Fixed", "gb.Fixed(phi0: Value = 0.0)\n"),
        ("gearblocks.rpm", "gb.rpm(speed: Any)"),
        ("time", "gb.time\n"),
        ("GearblocksError", "Base of all errors raised on purpose"),
    ],
)
def test_doc_knows_every_public_name_with_or_without_its_package(
    name: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doc", name]) == 0
    assert says in capsys.readouterr().out


def test_what_a_train_or_a_run_can_do_is_told_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc", "Drivetrain"]) == 0
    out = capsys.readouterr().out
    assert "\n  .add(name, part)\n      Adds a block, or a copy of a train, under a name" in out
    assert "\n  .outputs(*patterns)\n" in out
    assert main(["doc", "Trajectory"]) == 0
    assert "\n  .names\n      Names of all recorded outputs." in capsys.readouterr().out


def test_arguments_that_are_given_by_name_are_marked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc", "simulate"]) == 0
    assert capsys.readouterr().out.startswith(
        "gb.simulate(\n    train: Drivetrain | Model,\n    *,\n    t_end: float | str | None"
    )


@pytest.mark.parametrize(
    ("function", "answer", "words"),
    [
        ("contact_loss", "ContactLoss", ["time_share: of the time", ".time_share\n"]),
        ("speed_sweep", "SpeedSweep", ["Response of output", ".plot("]),
        ("orders", "OrderMap", ["Amplitudes of output", ".plot("]),
    ],
)
def test_doc_tells_what_an_answer_without_a_public_name_has(
    function: str, answer: str, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doc", function]) == 0
    out = capsys.readouterr().out
    assert not [x for x in (f"\nAnswers {answer}\n", *words) if x not in out.replace("`", "")]


@pytest.mark.parametrize("name", ["simulate", "sweep", "peak", "sense", "rpm"])
def test_doc_tells_no_answer_twice(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc", name]) == 0
    assert "\nAnswers " not in capsys.readouterr().out  # it has a page of its own, or is a quantity, signal or number


def test_doc_tells_the_type_of_an_answer_and_what_quantities_mean(capsys: pytest.CaptureFixture[str]) -> None:
    for name, says in (
        ("sweep", "\n) -> Study\n"), ("time", "The time of the run [s]. Stands in expressions"), ("pi", "3.14159"),
        ("fmu_export.export", "fmu_export.export(\n"), ("check", "fmu_export.check("),
    ):  # fmt: skip
        assert main(["doc", name]) == 0
        assert says in capsys.readouterr().out, name


def test_doc_alone_lists_every_name_that_is_no_error_with_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 118
    listed = {line.split()[0]: line.split(maxsplit=1)[1:] for line in lines if line.startswith("  ")}
    public = {n: getattr(gb, n) for n in gb.__all__ if not n.startswith("_")}
    errors = {n for n, x in public.items() if isinstance(x, type) and issubclass(x, BaseException)}
    assert set(listed) == public.keys() - errors | set(fmu_export.__all__)
    assert {"Table", "Drivetrain", "time", "export"} <= set(listed)
    assert all(words for words in listed.values()) and not any(
        w[0].count("(") > w[0].count(")") for w in listed.values() if not w[0].endswith("...")
    )


def test_an_unknown_name_names_near_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doc", "GearMsh"]) == BAD_INPUT
    error = capsys.readouterr().err
    assert "no block or other public name 'GearMsh' - did you mean 'GearMesh'?" in error
    assert "`gearblocks doc` lists all names" in error
