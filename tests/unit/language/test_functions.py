"""Functions of numbers are numbers, of signals expressions, of symbols of a law sympy expressions, all by the same names."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.expression import Expr, as_expr, evaluate, to_sympy
from gearblocks.train.json_form import parse

P = gb.Parameter("P", 0.5)
ONE = ("sin", "cos", "tan", "tanh", "exp", "log", "sqrt")


def _at(expr: Any, t: float) -> float:
    return evaluate(as_expr(expr), lambda leaf: t if leaf.op == "time" else leaf.args[0].value)


@pytest.mark.parametrize("name", ONE)
def test_a_function_is_that_of_the_mathematics_for_numbers_signals_and_symbols(name: str) -> None:
    function, expected = getattr(gb, name), getattr(math, name)
    assert function(0.7) == expected(0.7)
    assert type(function(np.float64(0.7))) is float
    made = function(gb.time + P)
    assert isinstance(made, Expr)
    assert _at(made, 0.2) == pytest.approx(expected(0.7), rel=1e-15)
    assert str(parse(str(made), {"P": P})) == str(made)
    x = sp.Symbol("x")
    assert function(x + 1) == getattr(sp, name)(x + 1)


@pytest.mark.parametrize(
    ("make", "at_3"),
    [
        (lambda x: gb.minimum(x, 2, 0.5), 0.5),
        (lambda x: gb.maximum(1.0, x), 3.0),
        (lambda x: gb.Heaviside(x - 3), 1.0),
        (lambda x: gb.Heaviside(x - 3.1), 0.0),
        (lambda x: gb.piecewise((1, x < 1), (x, x < 5), (7, True)), 3.0),
        (lambda x: gb.sin(gb.pi * x / 6), 1.0),
    ],
)
def test_signals_are_compared_and_switched(make: Any, at_3: float) -> None:
    assert isinstance(make(gb.time), Expr)
    assert _at(make(gb.time), 3.0) == at_3
    x = sp.Symbol("x", real=True)
    assert float(make(x).subs(x, 3)) == pytest.approx(at_3)


def test_numbers_alone_are_worked_out_and_go_wherever_a_number_goes() -> None:
    assert gb.minimum(3, 1, 2) == 1.0
    assert gb.maximum(3, 1) == 3.0
    assert gb.Heaviside(0) == 1.0
    assert gb.pi == math.pi
    assert gb.Table([0.0, gb.sqrt(2)], [0.0, 1.0]).x[1] == math.sqrt(2)


def test_a_sympy_expression_of_signals_stays_a_signal() -> None:
    made = gb.exp(sp.sin(to_sympy(gb.time)))
    assert isinstance(made, Expr)
    assert _at(made, 0.5) == math.exp(math.sin(0.5))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.sqrt(-1.0), r"'sqrt\(-1\)' is no finite real number"),
        (lambda: gb.log(0), r"'log\(0\)' is no finite real number"),
        (lambda: gb.exp(1e4), "no finite real number"),
        (lambda: gb.minimum(3), r"minimum compares two or more values, one by one, not \(3,\)"),
        (lambda: gb.maximum([1, 2]), "maximum compares two or more values"),
        (lambda: gb.tanh("x"), "'x' cannot stand in an expression"),
        (lambda: gb.exp(np.array([1.0, 2.0])), "cannot stand in an expression"),
    ],
)
def test_what_has_no_value_is_refused_by_name(make: Any, words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        make()


class Stiffening(gb.Block):
    """A spring that stiffens, written with functions of gearblocks."""

    a, b = gb.Flange("left"), gb.Flange("right")
    k = gb.param("stiffness", "N m/rad", gt=0)
    limit = gb.param("largest torque", "N m", gt=0)

    def physics(self, s: Any) -> Any:
        twist = s.b.phi - s.a.phi
        torque = s.limit * gb.tanh(s.k * twist / s.limit)
        yield gb.Acts(s.a, torque)
        yield gb.Acts(s.b, -torque)
        yield gb.Shows("torque", gb.piecewise((gb.minimum(torque, s.limit), twist > 0), (torque, True)), "N m")


def test_a_law_may_be_written_with_them() -> None:
    rig = gb.Drivetrain("stiffening")
    left, right = rig.add("left", gb.Fixed()), rig.add("right", gb.Inertia(J=0.1, phi0=0.02))
    rig.chain(left, rig.add("spring", Stiffening(k=1e3, limit=5.0)), right)
    run = gb.simulate(rig, t_end=0.1)
    assert run["spring.torque"][0] == pytest.approx(5.0 * math.tanh(1e3 * 0.02 / 5.0), rel=1e-12)
    assert np.abs(run["spring.torque"]).max() <= 5.0


def test_inputs_and_loads_take_them() -> None:
    rig = gb.Drivetrain("soft start")
    tau = gb.maximum(0.0, 2.0 * gb.tanh(gb.time / 0.1)) * gb.exp(-gb.time)
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=0.01)))
    run = gb.simulate(rig, t=[0.0, 0.05, 0.2])
    assert run["drive.torque"] == pytest.approx([2 * math.tanh(t / 0.1) * math.exp(-t) for t in run.t], rel=1e-12)


def test_heaviside_is_1_from_the_jump_on() -> None:
    rig = gb.Drivetrain("step")
    rig.chain(rig.add("drive", gb.Torque(tau=gb.Heaviside(gb.time - 0.5))), rig.add("disc", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=1.0)
    assert run["disc.w"][-1] == pytest.approx(0.5, rel=1e-12)
    assert [event.t for event in run.events] == pytest.approx([0.5], rel=1e-12)
    at_once = gb.simulate(rig.set({"drive.tau": gb.Heaviside(gb.time)}), t_end=1.0)
    assert at_once["drive.torque"][0] == 1.0
