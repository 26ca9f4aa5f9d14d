"""One-step methods as tables."""

from __future__ import annotations

import dataclasses
import math

import pytest

from gearblocks.solver.methods import DP5, DP8, METHODS, RK4, Tableau, render_tables
from gearblocks.solver.rosenbrock import RODAS

EXPLICIT = [method for method in METHODS if isinstance(method, Tableau)]


def _heun() -> Tableau:
    return Tableau(name="Heun 2(1)", order=2, source="textbook", c=(0, 1), a=((), (1,)), b=(1 / 2, 1 / 2), b_hat=(1, 0))


@pytest.mark.parametrize("method", EXPLICIT, ids=lambda m: m.name)
def test_quadrature_conditions_hold_up_to_the_order(method: Tableau) -> None:
    for power in range(method.order):
        moment = math.fsum(b * c**power for b, c in zip(method.b, method.c, strict=True))
        assert moment == pytest.approx(1 / (power + 1), abs=1e-13)  # coefficients are rounded to 16 digits


@pytest.mark.parametrize("method", EXPLICIT, ids=lambda m: m.name)
def test_the_dense_polynomial_integrates_powers_of_time(method: Tableau) -> None:
    theta, weights = 0.3, method.dense_weights()
    column = [0.0] * method.all_stages
    for m in reversed(range(method.rows)):
        factor = 1 - theta if m % 2 == 0 else theta
        column = [weights[m][j] + factor * column[j] for j in range(method.all_stages)]
    for power in range(min(method.order, 2 if method.rows == 3 else 4)):
        moment = theta * math.fsum(w * c**power for w, c in zip(column, method.all_c, strict=True))
        assert moment == pytest.approx(theta ** (power + 1) / (power + 1), abs=1e-12)


def test_a_new_method_is_one_more_table() -> None:
    heun = _heun()
    assert (heun.stages, heun.all_stages, heun.rows, heun.error_power) == (2, 3, 3, 2)
    assert heun.error_weights == ((-1 / 2, 1 / 2, 0.0),)


def test_a_wrong_row_sum_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"tableau 'Heun 2\(1\)': row 1 of a sums to 0.9"):
        dataclasses.replace(_heun(), a=((), (0.9,)))


def test_weights_that_do_not_sum_to_one_are_refused() -> None:
    with pytest.raises(ValueError, match="b sums to"):
        dataclasses.replace(_heun(), b=(1 / 2, 1 / 3))


def test_a_stage_that_uses_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="earlier stages"):
        dataclasses.replace(_heun(), a=((), (0, 1)))


def test_the_tables_are_the_same_text_every_time() -> None:
    assert render_tables() == render_tables()
    assert [m.name in render_tables() for m in (RK4, DP5, DP8, RODAS)] == [True] * 4
