"""`gb.build` and `gb.simulate`: what they take is said by name, and what they refuse too."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import pytest

import fmu_export
import gearblocks as gb
from gearblocks.errors import by_name_only
from gearblocks.simulation.run import run_model


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.add("disc", gb.Inertia(J=1.0, w0=1.0))
    return rig


def test_simulate_takes_what_runs_take_with_the_same_defaults() -> None:
    said, taken = inspect.signature(gb.simulate).parameters, inspect.signature(run_model).parameters
    assert next(iter(said)) == "train"
    assert {n: (p.default, p.kind) for n, p in said.items() if n != "train"} == {
        n: (p.default, p.kind) for n, p in taken.items() if n != "model"
    }
    assert all(f"{name}:" in gb.simulate.__doc__ or name in ("train", "t") for name in said)


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: gb.simulate(_rig(), t_endd=1.0), "simulate has no argument 't_endd'; it has initial, inputs, "),
        (lambda: gb.simulate(_rig(), t_endd=1.0), "did you mean 't_end'?"),
        (lambda: gb.simulate(_rig(), 1.0), "simulate: 1.0 is given without a name; name it: initial, inputs"),
    ],
)
def test_a_misspelt_or_nameless_argument_is_refused_by_name(act: Callable[[], Any], words: str) -> None:
    with pytest.raises(gb.ParameterError) as caught:
        act()
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "name",
    [
        "sweep",
        "study",
        "linearize",
        "frequency_response",
        "modes",
        "campbell",
        "poincare",
        "classify",
        "lyapunov",
        "periodic_orbit",
        "bifurcation",
        "speed_sweep",
        "spectrum",
        "basins",
        "continue_orbit",
    ],
)
def test_every_tool_names_the_argument_that_it_has_not(name: str) -> None:
    with pytest.raises(gb.ParameterError, match=f"{name} has no argument 'parametres'; .* did you mean 'parameters'"):
        getattr(gb, name)(_rig(), parametres={})
    assert "arguments" not in inspect.signature(getattr(gb, name)).parameters


def test_the_export_names_the_argument_that_it_has_not() -> None:
    with pytest.raises(gb.ParameterError, match=r"export has no argument 'outptus'; .* did you mean 'outputs'"):
        fmu_export.export(_rig(), "rig.fmu", outptus="*")


def test_a_train_may_be_named_too() -> None:
    assert gb.simulate(train=_rig(), t_end=1e-3).complete


def test_only_trains_and_models_are_built() -> None:
    model = gb.build(_rig())
    assert gb.build(model) is model
    with pytest.raises(gb.GearblocksError, match="3 is no Drivetrain and no Model"):
        gb.build(3)


def test_a_function_keeps_its_name_words_and_signature() -> None:
    @by_name_only
    def f(a: int, b: int = 2, *, c: int = 3) -> int:
        """Adds."""
        return a + b + c

    assert (f(1), f(1, 3, c=4), f(a=1, b=1)) == (6, 8, 5)
    assert (f.__name__, f.__doc__) == ("f", "Adds.")
    assert str(inspect.signature(f)) == "(a: 'int', b: 'int' = 2, *, c: 'int' = 3) -> 'int'"
    with pytest.raises(gb.ParameterError, match="f: 4 is given without a name; name it: c"):
        f(1, 2, 4)
    with pytest.raises(gb.ParameterError, match="f has no argument 'd'; it has a, b, c"):
        f(1, d=3)
