"""check() with inputs and times as simulate() takes them; arguments that make no sense are refused by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks import run
from fmu_export.checks.inputs import plain, sampled
from fmu_export.checks.instance import Plan, Unpacked, times_of
from gearblocks.solver.library import Model

RAMP = gb.Table([0.0, 0.005, 0.015], [-20.0, 30.0, 5.0])
SQUARE = gb.Table([0.0, 0.002, 0.004], [10.0, -10.0, 10.0], kind="step", periodic=True)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"t_end": "soon"}, "t_end = 'soon' must be a number, or text"), ({"t_end": "3 mm"}, "belongs here is in s"),
        ({"t_end": float("nan")}, "t_end = nan must be a finite number"),
        pytest.param({"t_end": "-1 ms"}, "t_end = -0.001 s must be later", marks=pytest.mark.long),
        ({"steps": 0}, "steps = 0 must be a whole number"), ({"steps": 2.5}, "steps = 2.5 must"),
        ({"steps": True}, "steps = True"),
        ({"inputs": {"tau": lambda t: t}}, r"input 'tau' is a function.*give \(t, y\) or a gb.Table"),
        ({"inputs": {"tau": ([0, 1], [1])}}, "input 'tau': t has 2 numbers and y has 1"),
        ({"inputs": {"tau": float("inf")}}, "input 'tau' = inf must be a finite number"),
        ({"inputs": [1.0]}, "inputs = .* must be a dict"),
        ({"tend": 1.0}, "check has no argument 'tend'.*did you mean 't_end'"),
        ({"inputs": {"tua": 1.0}}, "no input 'tua'; there are tau - did you mean 'tau'"),
        pytest.param(
            {"inputs": {"tau": "3 mm"}}, "input 'tau' = '3 mm' is in mm .* belongs here is in N m", marks=pytest.mark.long
        ),
    ],
)  # fmt: skip
def test_arguments_that_make_no_sense_are_refused_by_name(packed: Path, given: dict[str, Any], words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        fmu_export.check(packed, **given)


def _played(unpacked: Unpacked, inputs: dict[str, Any], steps: int) -> tuple[Any, Plan]:
    begin, stop = times_of(unpacked.description, 0.02)
    plan, results = Plan(unpacked, begin, stop, steps), list[Any]()
    given = sampled(plain(inputs), unpacked.description, unpacked.own, plan.points)
    assert run.check_run(plan, given, results).ok
    item = run.compare(plan, given, results[0], {})
    assert item.ok and "equal bits" in item.words, item.words
    return results[0], plan


@pytest.mark.parametrize("given", [12.0, "12 N m", "0.012 kN m"])
def test_a_constant_is_what_the_run_gets(unpacked: Unpacked, model: Model, given: Any) -> None:
    result, plan = _played(unpacked, {"tau": given}, 40)
    alone = gb.simulate(model, t=plan.points, inputs={"tau": 12.0}, outputs="wheel.w")
    np.testing.assert_allclose(result["wheel.w"], alone["wheel.w"], rtol=0, atol=1e-5 * np.abs(alone["wheel.w"]).max())


@pytest.mark.parametrize(
    "given", [RAMP, SQUARE, ([0.0, 0.01, 0.02], [0.0, 40.0, -40.0])], ids=["table", "periodic steps", "pair"]
)
def test_what_follows_time_is_held_over_each_communication_step(unpacked: Unpacked, model: Model, given: Any) -> None:
    """The run equals one with the samples as steps, within the errors of both (rtol = 1e-6 over a few periods)."""
    result, plan = _played(unpacked, {"tau": given}, 50)
    table = given if isinstance(given, gb.Table) else gb.Table(*given)
    held = gb.Table(plan.points, table.values(plan.points), kind="step")
    alone = gb.simulate(model, t=plan.points, inputs={"tau": held}, outputs="wheel.w")
    np.testing.assert_allclose(result["wheel.w"], alone["wheel.w"], rtol=0, atol=1e-4 * np.abs(alone["wheel.w"]).max())


@pytest.mark.parametrize(
    ("inputs", "words"),
    [
        ({"tau": RAMP}, "inputs tau as given, held over each step"),
        pytest.param(None, "inputs tau at their start values (inputs= gives others)", marks=pytest.mark.long),
    ],
)
def test_a_report_says_what_the_inputs_were(packed: Path, inputs: Any, words: str) -> None:
    report = fmu_export.check(packed, steps=70, t_end="14 ms", inputs=inputs)
    said = next(item.words for item in report.items if item.name == "run")
    assert said.startswith("fmpy: 70 steps to t = 0.014 s") and words in said


@pytest.mark.long
def test_an_input_is_given_in_the_unit_that_the_train_declares(tmp_path: Path) -> None:
    rig = gb.Drivetrain("driven")
    speed, tau = gb.Input("n", start=60.0, unit="rpm"), gb.Input("T", start=0.1, unit="kN m")
    rig.chain(
        rig.add("drive", gb.Speed(w=speed, filter=50.0)), rig.add("motor", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k="20 kN m/rad", c=20.0)), rig.add("load", gb.Inertia(J=1.0)),
        rig.add("brake", gb.Torque(tau=tau)),
    )  # fmt: skip
    path = fmu_export.export(rig, tmp_path / "driven.fmu", t_end="100 ms", communication_step="1 ms", max_step="10 ms")
    report = fmu_export.check(path, inputs={"n": 120.0, "T": ([0.0, 0.1], [0.1, 0.3])})
    assert report.ok, str(report)
    from fmpy import extract, read_model_description

    description = read_model_description(str(path))
    assert (
        description.defaultExperiment.stopTime in (0.1, "0.1") and float(description.defaultExperiment.stepSize) == 1e-3
    )
    unpacked = Unpacked(Path(extract(str(path), str(tmp_path / "out"))), description)
    result, _ = _played(unpacked, {"n": 120.0, "T": 0.2}, 20)
    assert result["motor.w"][-1] == pytest.approx(120 * np.pi / 30, rel=0.1)
    assert set(result["brake.torque"]) == {200.0}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"t_end": "soon"}, "t_end = 'soon' must be a number, or text"), ({"t_end": -1.0}, "t_end = -1.0 s must be positive"),
        ({"communication_step": "3 rad"}, "belongs here is in s"), ({"communication_step": "0 ms"}, "must be > 0"),
        ({"step": "1 mm", "method": "rk4"}, "step = '1 mm'"), ({"patience": "long"}, "patience = 'long'"),
        ({"max_step": None, "step": 0.0}, "step = 0.0 s must be > 0"),
    ],
)  # fmt: skip
def test_times_of_an_export_are_checked_by_name(
    model: Model, tmp_path: Path, given: dict[str, Any], words: str
) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        fmu_export.export(model, tmp_path / "never.fmu", **given)
