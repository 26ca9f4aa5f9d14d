"""Expressions take what a signal can be, and refuse the rest with words."""

import functools
import math
import pickle
import sys
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.expression import as_expr, evaluate, finite_number, from_sympy, to_sympy
from gearblocks.language.refusals import ConditionError
from gearblocks.train.json_form import parse

NAN, INF = float("nan"), float("inf")
P, U = gb.Parameter("P", 2.0), gb.Input("u", 3.0)


def _at(expr: Any, t: float) -> float:
    return evaluate(as_expr(expr), lambda leaf: t if leaf.op == "time" else leaf.args[0].value)


@pytest.mark.parametrize(
    ("expr", "value"),
    [
        (3 + 2 * gb.time, 7.0),
        (P * gb.time**2 - 1, 7.0),
        (1 / (gb.time + 2), 0.25),
        (gb.sin(gb.time) + gb.cos(0 * gb.time), math.sin(2.0) + 1),
        (np.sin(gb.time), math.sin(2.0)),
        (np.float64(3) * gb.time, 6.0),
        (np.maximum(gb.time, P), 2.0),
        (gb.piecewise((1, gb.time < 1), (5, True)), 5.0),
        (abs(-P), 2.0),
    ],
)
def test_arithmetic_of_signals_gives_the_numbers_it_says(expr: Any, value: float) -> None:
    assert _at(expr, 2.0) == pytest.approx(value, rel=1e-15)


def test_an_expression_survives_printing_pickling_and_sympy() -> None:
    expr = gb.sin(3 * gb.time) * P + gb.sense("a.w") ** 2 - 1 / (gb.time + 4)
    assert str(parse(str(expr), {"P": P})) == str(expr)
    assert str(pickle.loads(pickle.dumps(expr))) == str(expr)
    assert to_sympy(from_sympy(to_sympy(expr))) == to_sympy(expr)


@pytest.mark.parametrize("x", [NAN, INF, "3", True, None, 1j, np.array([1.0, 2.0]), 10**400, object()])
def test_what_is_no_finite_number_is_refused_by_name(x: Any) -> None:
    with pytest.raises(gb.ParameterError, match="J of the motor = "):
        finite_number("J of the motor", x)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.time * NAN, "nan must be a finite number"),
        (lambda: gb.time + INF, "inf must be a finite number"),
        (lambda: gb.time * (1 + 2j), "cannot stand in an expression"),
        (lambda: gb.time * "a", "cannot stand in an expression"),
        (lambda: gb.time * np.array([1.0, 2.0]), "cannot stand in an expression"),
        (lambda: np.array([1.0, 2.0]) * gb.time, "cannot stand in an expression"),
        (lambda: gb.sin(None), "cannot stand in an expression"),
        (lambda: math.sin(gb.time), "is an expression, not a number: use gb.sin"),
        (lambda: math.sin(P), "is an expression, not a number"),
        (lambda: np.floor(gb.time), "np.floor takes no expression"),
        (lambda: gb.piecewise(1, 2), r"must be \(value, condition\)"),
        (lambda: gb.piecewise((1, gb.time == 1), (2, True)), "made with < or >"),
        (lambda: gb.piecewise((1, gb.time < 1)), "end it with"),
        (lambda: gb.sense(3), "name of an output as text"),
        (lambda: gb.sense(gb.Inertia(J=1.0)), "name of an output as text"),
        (lambda: to_sympy(1 / as_expr(0)), "no finite real number"),
        (lambda: to_sympy(as_expr(9) ** (as_expr(9) ** 9) + gb.time), "no finite real number"),
        (lambda: to_sympy(1 / (gb.time - gb.time)), "no finite real number"),
    ],
)
def test_an_expression_that_means_nothing_is_refused(make: Any, words: str) -> None:
    with pytest.raises(gb.GearblocksError, match=words):
        make()


@pytest.mark.parametrize(
    "ask",
    [
        lambda c: 1 if c else 0, lambda c: c and True, lambda c: np.where(c, 1, 0), lambda c: not c, lambda c: max(gb.time, P),
        lambda c: 0 < gb.time < 1, lambda c: all([gb.sense("a.w") <= P, c]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("made", [lambda: gb.time > 1, lambda: as_expr(gb.time > 1), lambda: gb.sin(gb.time) >= P])
def test_a_condition_that_is_asked_whether_it_holds_names_piecewise(ask: Any, made: Any) -> None:
    with pytest.raises((gb.GearblocksError, TypeError), match=r"write gb\.piecewise\(\(value, condition\)") as told:
        ask(made())
    assert isinstance(told.value, TypeError)


def test_a_condition_stays_one_of_sympy() -> None:
    held = sp.Piecewise((1, gb.time > P), (2, gb.time <= P), (3, True))
    assert held == sp.Piecewise((1, sp.Gt(to_sympy(gb.time), to_sympy(as_expr(P)))), (2, True))
    assert as_expr(held).op == "Piecewise" and _at(held, 3.0) == 1.0 and _at(held, 1.0) == 2.0
    condition = pickle.loads(pickle.dumps(gb.time > P))
    assert isinstance(condition, sp.Gt) and str(from_sympy(condition)) == "(time > parameter('P'))"


@pytest.mark.parametrize(
    ("expr", "words"),
    [
        (sp.Symbol("x") + 1, "the symbol 'x'.*make it gb.Parameter"),
        (sp.Symbol("t"), "the symbol 't'"),
        (sp.Function("phi")(sp.Symbol("t")), "cannot stand in a signal"),
        (sp.I, "cannot stand"),
        (sp.zoo, "cannot stand"),
        (sp.oo, "finite"),
        (sp.nan, "finite"),
    ],
)
def test_foreign_sympy_is_refused_with_the_field_it_was_meant_for(expr: Any, words: str) -> None:
    with pytest.raises(gb.GearblocksError, match=f"(?s)tau.*{words}"):
        gb.Drivetrain("r").add("load", gb.Torque(tau=expr))


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')", "().__class__", "time.__class__", "lambda: 1", "[1]", "open('x')", "1e999",
        "sin()", "sin(1, 2)", "sin(x=1)", "Piecewise(1)", "Min()", "table('x')", "parameter('none')", "input('P')",
        "time and 1", "f'{time}'", "x := 3", "1+", "", "*time", "(" * 3000 + ")" * 3000, "1" + "+1" * 20000, "nan", "1j",
        "'a'", "True", "\0",
    ],
)  # fmt: skip
def test_text_is_read_as_an_expression_and_never_run(text: str) -> None:
    with pytest.raises(gb.GearblocksError):
        parse(text, {"P": P})


def test_long_sums_and_products_are_one_node_and_keep_their_text() -> None:
    u = [gb.Input(f"u{i}", 1.0) for i in range(1000)]
    total = sum(u)
    assert len(total.args) == 1001 and str(total).startswith("0 + input('u0') + input('u1') + ")
    assert evaluate(total, lambda leaf: leaf.args[0].start) == 1000.0
    falling = functools.reduce(lambda a, b: b + a, u)
    assert evaluate(falling, lambda leaf: leaf.args[0].start) == 1000.0
    product = functools.reduce(lambda a, b: a * b, [1 + 0.001 * x for x in u])
    assert evaluate(product, lambda leaf: leaf.args[0].start) == pytest.approx(1.001**1000)
    assert len(sp.Add.make_args(to_sympy(functools.reduce(lambda a, b: a - b, u)))) == 1000


@pytest.mark.long
def test_a_train_takes_a_sum_of_a_thousand_signals() -> None:
    rig = gb.Drivetrain("many")
    torque = sum(gb.Input(f"u{i}", 1.0) for i in range(1000))
    rig.chain(rig.add("drive", gb.Torque(tau=torque)), rig.add("body", gb.Inertia(J=10.0)))
    assert gb.simulate(rig, t_end=1.0, outputs="body.w")["body.w"][-1] == pytest.approx(100.0, rel=1e-12)


# -- truth ------------------------------------------------------------------------------------------------------------

X = gb.sense("w.w")


@pytest.fixture(params=[False, True], ids=["alone", "beside sympy"])
def beside_sympy(request, monkeypatch):
    """Conditions are expressions of ours, or sympy's where sympy is in use."""
    if not request.param:
        monkeypatch.delitem(sys.modules, "sympy")


@pytest.mark.usefixtures("beside_sympy")
@pytest.mark.parametrize(
    ("asked", "says"),
    [
        (lambda: X and 3, r"'sense\('w.w'\)' is a value that a run gives, neither true nor false: compare it"),
        (lambda: U or 3, r"'input\('u'\)' is a value that a run gives"),
        (lambda: not X, r"join conditions by & and \|, each in brackets"),
        (lambda: 3 if gb.Parameter("k", 0.0) else 4, "is asked by `is not None`"),
        (lambda: 0 < X < 1, r"in place of a < x < b write \(a < x\) & \(x < b\)"),
        (lambda: (X > 0) and (U < 1), r"write & and \| and ~ with each condition in brackets"),
        (lambda: not ((X > 0) & (U < 1)), r"'And\(.*\)' is a condition, not a truth"),
        (lambda: not ~((X > 0) | (U < 1)), r"'Not\(.*\)' is a condition, not a truth"),
        (lambda: X & (U > 0), r"'sense\('w.w'\)' is no condition: & goes with such, each in brackets"),
        (lambda: (X > 0) | U, r"'input\('u'\)' is no condition: \| goes with such"),
        (lambda: ~X, r"'sense\('w.w'\)' is no condition: ~ goes with such"),
        (lambda: X > 0 & U < 1, "is no condition: & goes with such, each in brackets"),
        (lambda: 5 * (X > 0), r"is a condition, no number: in place of 5 \* \(x > 0\) write gb.piecewise"),
        (lambda: ((X > 0) & (U > 0)) + 1, "is a condition, no number"),
        (lambda: gb.maximum(X > 0, 1), "is a condition, no number"),
        (lambda: gb.piecewise((1, X), (0, True)), "is a value: compare it, such as x > 0.5"),
        (lambda: gb.piecewise((1, X == 2), (0, True)), r"== and != compare no values: abs\(x - 2\) < 0.5"),
        (lambda: gb.piecewise((1, X != 2), (0, True)), "stands before others, which its condition True keeps from"),
    ],
)
def test_what_asks_for_a_truth_before_any_run_is_told_how_conditions_are_written(asked, says):
    with pytest.raises((gb.ParameterError, ConditionError), match=says):
        asked()


@pytest.mark.usefixtures("beside_sympy")
def test_conditions_are_joined_by_and_or_and_not():
    both, one, none = (X > 0) & (U < 1), (X > 0) | (U < 1), ~(X > 0)
    for condition, truths in ((both, (0, 0, 0, 1)), (one, (1, 0, 1, 1)), (none, (1, 1, 0, 0))):
        law = gb.piecewise((1.0, condition), (0.0, True))
        for (x, u), truth in zip(((-1, 0), (-1, 2), (1, 2), (1, 0)), truths, strict=True):
            values = {"sense": x, "input": u}
            assert evaluate(law, lambda e, values=values: values[e.op]) == truth
