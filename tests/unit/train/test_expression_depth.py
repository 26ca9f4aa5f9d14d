"""Expressions that are nested deeper than Python follows are refused by name; long ones are not deep."""

import functools
import math
import operator
import time

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.model.build import make_program
from gearblocks.train.expression_depth import depth
from gearblocks.train.graph import flatten


def cases(count):
    return gb.piecewise(*((float(i), gb.time < (i + 1) / count) for i in range(count)), (0.0, True))


def nested(count):
    law = gb.sin(gb.time)
    for _ in range(count):
        law = 0.1 + gb.sin(law)
    return law


def rig(tau):
    train = gb.Drivetrain("deep")
    train.chain(train.add("drive", gb.Torque(tau=tau)), train.add("J", gb.Inertia(J=1.0)))
    return train


def test_depth_is_the_longest_way_to_a_leaf():
    assert depth(gb.time) == 1
    assert depth(sum(gb.sin(i * gb.time) for i in range(1, 1000))) == 4
    assert depth(nested(7)) == 2 + 2 * 7
    assert depth(cases(30)) > 30


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "law",
    [
        lambda: nested(400),
        lambda: gb.maximum(0.0, nested(400)) * gb.sense("J.w"),
    ],
    ids=["functions", "functions of a sense"],
)
@pytest.mark.parametrize("what", [gb.build, lambda train: train.equations(), lambda train: train.outputs()])
def test_what_is_nested_too_deep_is_refused_by_name(law, what):
    with pytest.raises(gb.ModelError, match=r"drive\.tau is an expression of \d+ levels") as told:
        what(rig(law()))
    assert "gb.Table" in str(told.value)


def test_a_recursion_that_no_expression_causes_stays_what_it_is(monkeypatch):
    monkeypatch.setattr("gearblocks.model.build._program", lambda *_: (_ for _ in ()).throw(RecursionError("other")))
    with pytest.raises(RecursionError, match="other"):
        gb.build(rig(nested(3)))


@pytest.mark.long
@pytest.mark.parametrize("law", ["sum", "product", "cases"])
def test_what_is_long_and_not_deep_runs(law):
    """w(1) of a thousand terms by their sum, of the product by its power, of a hundred cases by their mean."""
    if law == "sum":
        found = gb.simulate(rig(sum(2 * gb.time * i for i in range(1000))), t_end=1.0)["J.w"][-1]
        assert found == pytest.approx(499500.0, rel=1e-9)
    elif law == "product":
        tau = 1 + 0 * gb.time
        for _ in range(1000):
            tau = tau * (1 + gb.time / 1000)
        assert gb.simulate(rig(tau), t_end=1.0)["J.w"][-1] == pytest.approx((1.001**1001 - 1) * 1000 / 1001, rel=1e-5)
    else:
        assert gb.simulate(rig(cases(100)), t_end=1.0)["J.w"][-1] == pytest.approx(49.5, rel=1e-9)


def test_long_rows_of_cases_choose_the_first_that_holds_and_are_not_deep():
    law = gb.piecewise(*((i + gb.sense("J.w"), gb.time < (i + 1) / 40) for i in range(40)), (-1.0, True))
    train = rig(law)
    steps = np.cumsum([{"(": 1, ")": -1}.get(c, 0) for c in gb.build(train).program.source])
    assert steps.max() < 25  # brackets inside one another; 40 with one in the other
    t = np.array([0.0125, 0.4875, 0.9875, 1.5])
    run = gb.simulate(train, t=t, rtol=1e-9)
    assert run["drive.torque"] == pytest.approx([0, 19, 39, -1] + run["J.w"] * [1, 1, 1, 0], rel=1e-12)


def _inputs(count):
    return [gb.Input(f"u{i}", float(i)) for i in range(count)]


def _all(count):
    conditions = [u > 0.5 for u in _inputs(count)]
    return gb.piecewise((1.0, functools.reduce(operator.and_, conditions)), (0.0, True))


LONG = {
    "a sum": lambda: sum(_inputs(600)),
    "a product of Parameters": lambda: math.prod(gb.Parameter(f"p{i}", 1.0) for i in range(500)),
    "a table over a sum": lambda: gb.Table([0.0, 1.0, 2.0], [0.0, 1.0, 3.0])(sum(_inputs(500))),
    "a table over the largest": lambda: gb.Table([0.0, 1.0, 2.0], [0.0, 1.0, 3.0])(gb.maximum(*_inputs(60))),
    "a sum of sizes": lambda: sum(abs(u) for u in _inputs(200)),
    "conditions in a row": lambda: _all(150),
}


@pytest.mark.parametrize("kind", LONG)
def test_what_is_long_and_not_deep_is_built_soon(kind):
    train = flatten(rig(LONG[kind]()).tree())
    began = time.process_time()
    make_program(train)
    assert time.process_time() - began < 4.0


def test_a_table_over_a_long_sum_is_located():
    """Its enclosure is added by halves, of which one is small here; the sum passes the joint for a moment within a step."""
    sizes = [1e-4 if i < 60 else 0.02 for i in range(120)]
    rates = [1 + i / 100 for i in range(120)]

    def total(w, sin):
        return sum(size * sin(rate * w) for size, rate in zip(sizes, rates, strict=True))

    joint = (1 - 1e-6) * float(total(np.linspace(0.0, 2.0, 200_001), np.sin).max())
    table = gb.Table([-5.0, joint, 5.0], [0.5, 1.0, 3.0])
    run = gb.simulate(rig(table(total(gb.sense("J.w"), gb.sin))), t=np.linspace(0.0, 2.0, 11), rtol=1e-6)
    assert run["J.alpha"] == pytest.approx(np.interp(total(run["J.w"], np.sin), table.x, table.y), abs=1e-12)
    assert len(run.events) == 2
