"""Derivatives and free symbols are those of sympy."""

import pytest
import sympy as sp

from gearblocks.laws.derivative import derivative
from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import DeadZone, TableAt

x, y, b = sp.symbols("x y b", real=True)
TABLE = sp.Symbol("table")
EXPRESSIONS = [
    sp.Integer(3), x, x * y, 2 * x**2 * sp.sin(x * y) / b, (x + y) ** 3, sp.exp(-(x**2)) + sp.cos(x) ** 2, x**y,
    sp.sqrt(x**2 + y**2), TableAt(TABLE, x * y, 0), b * DeadZone(x - y, b, 0), sp.Heaviside(x) * x, abs(x) * sp.tanh(x / b),
    sp.Max(x, y), sp.Piecewise((x**2, x > 0), (y * x, True)), sp.atan(x) * sp.log(x * b),
]  # fmt: skip


@pytest.mark.parametrize("expr", EXPRESSIONS, ids=str)
@pytest.mark.parametrize("by", [x, y])
def test_a_derivative_is_written_as_sympy_writes_it(expr, by):
    assert derivative(expr, by) == sp.diff(expr, by)


@pytest.mark.parametrize("expr", [*EXPRESSIONS, sp.Integral(x * y, (x, 0, b)), sp.Lambda(x, x * y)], ids=str)
def test_free_symbols_are_those_that_sympy_gathers(expr):
    assert symbols_in(expr) == expr.free_symbols
