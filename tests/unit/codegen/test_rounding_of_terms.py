"""What rounding of a term is a part of."""

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.codegen.rounding_of_terms import size_of

t = sp.Symbol("t", real=True)


@pytest.mark.parametrize(
    ("expr", "at", "size"),
    [
        (3 - 3 * sp.cos(t), 0.0, 6.0),
        (2 * (1 - sp.exp(-t)), 0.0, 4.0),
        ((1 - sp.cos(t)) * (5 - t), 2.0, (1 - sp.cos(2.0)) * 7.0),
        ((4 - t) ** 3, 1.0, 3 * 9.0 * 5.0),
        (sp.sqrt(4 - t), 0.0, 1.0),
        (-7 * sp.sin(t), 1.0, 7 * sp.sin(1.0)),
        (sp.sin(1 - t), 1.0, 0.0),
    ],
)
def test_the_size_of_a_sum_is_that_of_its_summands(expr, at, size):
    assert float(size_of(expr).subs(t, at)) == pytest.approx(float(size))


def test_no_function_is_made_where_nothing_adds_up():
    def text(torque):
        rig = gb.Drivetrain("one")
        rig.chain(rig.add("source", gb.Torque(tau=torque)), rig.add("a", gb.Inertia(J=1.0)))
        return gb.build(rig).program.source

    assert "time_term_sizes" not in text(3 * gb.sin(2 * gb.time))
    assert "time_term_sizes" in text(3 + gb.sin(2 * gb.time))
