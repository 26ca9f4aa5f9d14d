"""One-step methods as tables."""

from __future__ import annotations

import dataclasses
import math

import pytest

from gearblocks.solver.methods import DP5, DP8, METHODS, RK4, Tableau, render_tables
from gearblocks.solver.rosenbrock import RODAS, trees

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


def test_the_implicit_method_meets_every_order_condition_up_to_order_five() -> None:
    assert [len(list(trees(size))) for size in range(1, 6)] == [1, 1, 2, 4, 9]
    assert len(list(RODAS.residuals())) == 17
    assert max(abs(missed) for _, missed in RODAS.residuals()) < 1e-12  # published to 16 digits, up to 150 in size


def test_the_dense_output_of_the_implicit_method_has_order_four() -> None:
    for theta in (0.1, 0.5, 0.9):
        assert max(abs(missed) for _, missed in RODAS.residuals(theta, order=4)) < 1e-12
    assert RODAS.weights_at(1.0) == pytest.approx(RODAS.b, abs=1e-12)


def test_the_implicit_method_forgets_what_is_infinitely_stiff() -> None:
    assert abs(RODAS.damping_at_infinity()) < 1e-12


def test_the_quadrature_of_the_tail_is_exact_for_cubics_inside_a_step_and_of_order_six_at_its_end() -> None:
    places = {0: 0.0, RODAS.stages: 1.0, RODAS.stages + 1: RODAS.nodes[0], RODAS.stages + 2: RODAS.nodes[1]}
    rows = RODAS.quadrature_weights()
    for theta in (0.0, 0.3, 1.0):
        for power in range(6 if theta == 1.0 else 4):
            r1, r2, r3, r4 = (math.fsum(row[j] * place**power for j, place in places.items()) for row in rows)
            value = theta * (r1 + (1 - theta) * (r2 + theta * (r3 + (1 - theta) * r4)))
            assert value == pytest.approx(theta ** (power + 1) / (power + 1), abs=1e-14)


def test_a_wrong_coefficient_of_an_implicit_method_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"'Rodas5P 5\(4\)': row 1 of beta sums to"):
        dataclasses.replace(RODAS, d=(*RODAS.d[:1], 0.1, *RODAS.d[2:]))
    with pytest.raises(ValueError, match="must have i entries"):
        dataclasses.replace(RODAS, a=(*RODAS.a[:-1], (1.0,)))
    wrong = (*RODAS.coupling[:6], (*RODAS.coupling[6][:5], -28.0), RODAS.coupling[7])
    with pytest.raises(ValueError, match=r"the condition of tree .* is missed by"):
        dataclasses.replace(RODAS, coupling=wrong)
