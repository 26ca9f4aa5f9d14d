"""The largest and the least of many: made soon, and the right number."""

import functools
import pickle
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.expression import as_expr, evaluate, to_sympy
from gearblocks.language.extrema import extremum
from gearblocks.model.build import make_program
from gearblocks.train.graph import flatten


def _inputs(n: int) -> list[gb.Input]:
    return [gb.Input(f"u{i}", float(i)) for i in range(n)]


def _parameters(n: int) -> list[gb.Parameter]:
    return [gb.Parameter(f"p{i}", float(i)) for i in range(n)]


def _turns(values: list[Any]) -> Any:
    """The largest and the least by turns, one inside the other."""
    return functools.reduce(lambda a, b: gb.maximum(gb.minimum(a, b), b / 2), values)


def _driven(torque: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("driven")
    rig.chain(rig.add("drive", gb.Torque(tau=torque)), rig.add("body", gb.Inertia(J=1.0)))
    return rig


LAWS: dict[str, Callable[[], Any]] = {
    "maximum": lambda: functools.reduce(gb.maximum, _inputs(40)),
    "minimum, the new one first": lambda: functools.reduce(lambda a, b: gb.minimum(b, a), _inputs(40)),
    "maximum at once": lambda: gb.maximum(*_inputs(40)),
    "of Parameters": lambda: functools.reduce(gb.maximum, _parameters(40)),
    "of waves": lambda: gb.maximum(*(gb.sin(i * gb.time) for i in range(1, 41))),
    "by turns": lambda: _turns(_inputs(12)),
    "by turns, of Parameters": lambda: _turns(_parameters(12)),
    "with sums between": lambda: functools.reduce(lambda a, b: gb.maximum(a, b) + b, _inputs(20)),
}


@pytest.mark.parametrize("law", LAWS)
def test_the_largest_of_many_is_built_soon(law: str) -> None:
    """Twice as many took thirty times as long: 14 inputs 23 s, 50 more than 2 min."""
    train = flatten(_driven(LAWS[law]()).tree())
    began = time.process_time()
    make_program(train)
    assert time.process_time() - began < 3.0


@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize(("kind", "numbers"), [(gb.maximum, np.max), (gb.minimum, np.min)])
def test_the_largest_of_many_waves_is_the_largest(kind: Any, numbers: Any, nested: bool) -> None:
    waves = [gb.sin((1 + i) * gb.time + i) * (1 + 0.1 * i) for i in range(11)]
    law = functools.reduce(kind, waves) if nested else kind(*waves)
    t = np.linspace(0.0, 3.0, 400)
    run = gb.simulate(_driven(law), t=t, rtol=1e-9)
    values = np.array([(1 + 0.1 * i) * np.sin((1 + i) * t + i) for i in range(11)])
    assert run["body.alpha"] == pytest.approx(numbers(values, axis=0), abs=1e-12)


def test_by_turns_it_is_the_number_that_python_has() -> None:
    given = {f"u{i}": float(x) for i, x in enumerate(np.random.default_rng(3).normal(size=12))}
    law = _turns(_inputs(12))
    expected = evaluate(as_expr(law), lambda leaf: given[leaf.args[0].name])
    run = gb.simulate(_driven(law), t=[0.0, 1.0], inputs=given)
    assert run["body.alpha"] == pytest.approx([expected] * 2, abs=1e-14)


def test_of_parameters_it_follows_them() -> None:
    model = gb.build(_driven(gb.maximum(*_parameters(9)) - gb.minimum(*_parameters(9), 3.0)))
    for which in range(9):
        run = gb.simulate(model, t=[0.0, 1.0], parameters={f"p{which}": 20.0})
        expected = 20.0 - (0.0 if which else 1.0)
        assert run["body.alpha"] == pytest.approx([expected] * 2, abs=1e-12)


def test_the_largest_of_the_largest_is_one_node() -> None:
    a, b, c = _inputs(3)
    assert str(gb.maximum(gb.maximum(a, b), c)) == str(gb.maximum(a, b, c))
    assert str(gb.maximum(gb.minimum(a, b), c)) != str(gb.minimum(gb.maximum(a, b), c))
    conditions = [u > 0.5 for u in map(as_expr, _inputs(3))]
    assert sp.And(*map(to_sympy, map(as_expr, conditions))) == to_sympy(
        as_expr(conditions[0] & conditions[1] & conditions[2])
    )


def test_a_node_of_many_is_sympys_in_all_but_the_time() -> None:
    x = sp.symbols("x0:8", real=True)
    made = extremum("Max", (*x, 1, sp.Rational(1, 2), sp.Max(x[0], x[1]), x[2]))
    assert isinstance(made, sp.Max) and set(made.args) == {*x, sp.Integer(1)}
    assert made.subs({s: i for i, s in enumerate(x)}) == 7
    assert made.xreplace({x[0]: x[1]}).func is made.func and sp.sstr(made).startswith("Max(")
    assert pickle.loads(pickle.dumps(made)) == made
    assert extremum("Min", x[:3]) == sp.Min(*x[:3])


def test_a_condition_on_a_value_with_cases_is_taken() -> None:
    """sympy makes a choice between conditions of it."""
    u = _inputs(3)
    inner = gb.piecewise((u[1], u[0] > 0.5), (2.0, True))
    law = gb.piecewise((10.0, inner > 1.5), (20.0, True))
    for given in ({"u0": 1.0, "u1": 1.0}, {"u0": 1.0, "u1": 1.8}, {"u0": 0.0, "u1": 1.0}):
        chosen = given["u1"] if given["u0"] > 0.5 else 2.0
        run = gb.simulate(_driven(law), t=[0.0, 1.0], inputs=given)
        assert run["body.alpha"] == pytest.approx([10.0 if chosen > 1.5 else 20.0] * 2)
