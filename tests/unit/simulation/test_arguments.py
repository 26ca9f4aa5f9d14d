"""Arguments of a run: each bad one is named with its value."""

from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

NAN, INF = float("nan"), float("inf")


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=1.0e3, c=1.0)),
        rig.add("wheel", gb.Inertia(J=0.1)),
    )
    return rig


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(_rig())


def _refused(model: Any, words: str, **arguments: Any) -> None:
    with pytest.raises((gb.ParameterError, gb.UnknownNameError)) as caught:
        gb.simulate(model, **arguments)
    assert words in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give either t_end"),
        ({"t_end": 1.0, "t": [0, 1]}, "give either t_end"),
        *(({"t_end": x}, "t_end = ") for x in (NAN, INF, 0, -1, "1", [1], 1j, True, gb.time)),
        *(({"t": x}, "t ") for x in ([1, 0], [0, 0], [0, NAN], [], "abc", [[0, 1]], [-1, 0], [0, 1j], ["a"], gb.time)),
        ({"t_end": 1.0, "t_start": 1.0}, "must be later than the start"),
        ({"t_end": 1.0, "t_start": "x"}, "t_start = 'x' must be a number"),
        *(({"t_end": 1.0, "rtol": x}, "rtol = ") for x in (0, -1, NAN, 1, "1", None, 1e-20)),
        *(({"t_end": 1.0, "step": x}, "step = ") for x in (0, -1, NAN, INF, "x")),
        *(({"t_end": 1.0, "max_step": x}, "max_step = ") for x in (0, -1, NAN, "x")),
        *(({"t_end": 1.0, "method": x}, "method = ") for x in ("rk5", "radau", 4, None, ["dp5"])),
        ({"t_end": 1.0, "method": "rk4"}, "give step="),
        *(({"t_end": 1.0, "locate": x}, "locate = ") for x in ("x", None, 2)),
        ({"t_end": 1.0, "progress": 3}, "progress = 3 must be a function"),
        ({"tend": 1.0}, "simulate has no argument 'tend'"),
        ({"tend": 1.0}, "did you mean 't_end'"),
        *(({"t_end": 1.0, "outputs": x}, "outputs = ") for x in (3, None, ["motor.w", 3])),
        *(({"t_end": 1.0, "outputs": x}, "no output matches") for x in ("mtor.*", "motr.w", "", ["motor.w", "x"])),
        ({"t_end": 1.0, "inputs": {"tua": 1}}, "did you mean 'tau'"),
        *(
            ({"t_end": 1.0, "inputs": {"tau": x}}, "input 'tau' = ")
            for x in (NAN, INF, "x", None, [1, 2], 1j, True, gb.time, sp.sin(gb.time), gb.Parameter("x", 1.0))
        ),
        *(({"t_end": 1.0, what: x}, f"{what} = ") for what in ("inputs", "parameters") for x in ("tau", ["tau"], 3)),
        *(({"t_end": 1.0, what: {3: 4}}, "must be text, not 3") for what in ("inputs", "parameters", "initial")),
        ({"t_end": 1.0, "parameters": {"motor.j": 1}}, "did you mean 'motor.J'"),
        ({"t_end": 1.0, "parameters": {"J": 1}}, "is not unique: it could be motor.J, wheel.J"),
        *(
            ({"t_end": 1.0, "parameters": {"motor.J": x}}, "motor.J = ")
            for x in (-1, NAN, "x", None, [1], True, 1j, gb.time)
        ),
        *(({"t_end": 1.0, "initial": {"motor.w": x}}, "motor.w = ") for x in (NAN, "x", None, True)),
        ({"t_end": 1.0, "initial": {"motr.w": 1}}, "did you mean 'motor.w'"),
        *(({"t_end": 1.0, "initial": x}, "initial = ") for x in ("satic", 3, ["motor.w"], np.zeros(4))),
    ],
)
def test_a_bad_argument_is_named_with_its_value(model: gb.Model, arguments: dict[str, Any], words: str) -> None:
    _refused(model, words, **arguments)


def test_what_is_no_train_and_values_without_a_name_are_refused(model: gb.Model) -> None:
    for thing in (gb.Inertia(J=1.0), None, "rig", gb.Drivetrain, {}):
        with pytest.raises(gb.GearblocksError, match="is no Drivetrain"):
            gb.simulate(thing, t_end=1.0)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match=r"1\.0 is given without a name"):
        gb.simulate(model, 1.0)


def test_a_run_of_another_train_cannot_be_continued(model: gb.Model) -> None:
    other = gb.Drivetrain("other")
    other.add("a", gb.Inertia(J=1.0))
    run = gb.simulate(other, t_end=0.1)
    _refused(model, "is of another train", t_end=1.0, initial=run)


@pytest.mark.parametrize("given", [1 / gb.time, gb.Parameter("p", 1.0), None, [1.0, 2.0], True])
def test_an_input_that_is_given_what_it_does_not_take_says_what_it_takes(given: Any) -> None:
    rig = gb.Drivetrain("rig")
    rotor = rig.add("rotor", gb.Inertia(J=0.1))
    rig.connect(rig.add("drive", gb.Torque(tau=gb.Input("tau", unit="N m"))).flange, rotor.a)
    with pytest.raises(
        gb.ParameterError, match=r"input 'tau' = .* must be a number, text with its unit, a gb\.Table"
    ) as told:
        gb.simulate(rig, t_end=0.1, inputs={"tau": given})
    expression = isinstance(given, gb.Parameter) or "1/time" in str(told.value)
    assert ("an expression belongs into the field" in str(told.value)) == expression


def test_an_inertia_that_is_zero_is_told_as_that_and_not_as_a_ratio() -> None:
    rig = gb.Drivetrain("light")
    rig.chain(
        rig.add("torque", gb.Torque(tau=1.0)), rig.add("disc", gb.Inertia(J=0.0)), rig.add("spring", gb.Shaft(k=1.0, c=0.1)),
        rig.add("body", gb.Inertia(J=1.0)),
    )  # fmt: skip
    with pytest.raises(gb.ParameterError, match=r"'disc\.J' is 0, which is structural"):
        gb.simulate(rig, t_end=1.0, parameters={"disc.J": 1.0})
