"""The implicit method as a table: its order conditions, and what is refused."""

from __future__ import annotations

import dataclasses
import math

import pytest

from gearblocks.solver.rosenbrock import RODAS, trees


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


def test_an_angle_over_the_stages_of_its_speed_is_what_it_would_be_as_a_state() -> None:
    """w' = 1 from w = 0: K_i = gamma (1 + sum_j coupling_ij K_j), and the angle is theta^2 / 2 inside the step too."""
    k: list[float] = []
    for coupling in RODAS.coupling:
        k.append(RODAS.gamma * (1.0 + math.fsum(c * x for c, x in zip(coupling, k, strict=True))))
    r1, r2, r3, r4 = (math.fsum(x * y for x, y in zip(row, k, strict=True)) for row in RODAS.angle_weights())
    for theta in (0.0, 0.3, 0.7, 1.0):
        value = theta * (r1 + (1 - theta) * (r2 + theta * (r3 + (1 - theta) * r4)))
        assert value == pytest.approx(theta**2 / 2, abs=1e-13)


def test_a_wrong_coefficient_of_an_implicit_method_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"'Rodas5P 5\(4\)': row 1 of beta sums to"):
        dataclasses.replace(RODAS, d=(*RODAS.d[:1], 0.1, *RODAS.d[2:]))
    with pytest.raises(ValueError, match="must have i entries"):
        dataclasses.replace(RODAS, a=(*RODAS.a[:-1], (1.0,)))
    wrong = (*RODAS.coupling[:6], (*RODAS.coupling[6][:5], -28.0), RODAS.coupling[7])
    with pytest.raises(ValueError, match=r"the condition of tree .* is missed by"):
        dataclasses.replace(RODAS, coupling=wrong)
