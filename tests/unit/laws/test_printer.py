"""Expressions in C: plain C99, with numbers written out."""

import math
import re

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.laws.printer import c_text

X = sp.Symbol("x", positive=True)
NUMBERS = [
    sp.sqrt(2),
    1 / sp.sqrt(2),
    sp.sqrt(2) / 2,
    2 / sp.sqrt(sp.pi),
    sp.log(2),
    1 / sp.log(2),
    sp.pi / 2,
    sp.pi / 4,
    1 / sp.pi,
    sp.E,
]


@pytest.mark.parametrize("number", NUMBERS, ids=str)
def test_a_number_is_written_without_macros_that_c99_does_not_have(number):
    text = c_text(number * X, {X: "x"})
    assert not re.search(r"\bM_\w+", text)
    value = eval(text, {"x": 0.7, "sqrt": math.sqrt, "log": math.log, "pow": math.pow})  # noqa: S307  our own text
    assert value == pytest.approx(float(number) * 0.7, rel=1e-15)


def test_a_stiffness_in_terms_of_a_parameter_may_give_damping_its_root():
    scale = gb.Parameter("scale", 1.5, "1")
    ends = []
    for k in (200 * scale, 300.0):
        rig = gb.Drivetrain("a root of 2 in the law")
        rig.chain(
            rig.add("a", gb.Inertia(J=1.0, w0=1.0)),
            rig.add("shaft", gb.Shaft(k=k, damping_ratio=0.1)),
            rig.add("b", gb.Inertia(J=1.0)),
        )
        ends.append(gb.simulate(rig, t_end=1.0)["a.w"][-1])
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)
