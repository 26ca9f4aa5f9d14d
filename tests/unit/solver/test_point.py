"""A model at one point: derivatives of its compiled laws, and a look that leaves no trace."""

import numpy as np
import pytest

import gearblocks as gb
from benchmarks.cases import P4
from benchmarks.problems import p1, train
from gearblocks.solver.point import derivative, differenced_state_matrix, opened, state_matrix
from gearblocks.solver.structures import Code, Method, Options


def test_a_long_chain_needs_few_evaluations():
    calls = 0

    def second_differences(x):
        nonlocal calls
        calls += 1
        return np.diff(x, 2)

    n = 4096
    derivative(second_differences, np.zeros(n), np.arange(n), np.ones(n))
    assert calls < 120  # 2 x 3 groups in each of 12 rounds, and the values


def test_a_look_at_a_point_changes_nothing_of_a_run():
    model = gb.build(p1())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        assert sim.start(Options(Method.DP8, 1, 1e-9, 0.0, np.inf, np.inf), 0.0) == Code.DONE
        sim.advance(1e-3)
        before, y = sim.save(), sim.state()
        for what in ("rates", "outputs", "energies", "modes"):
            sim.probe(0.3, 1.1 * y, np.array([-1.0]), what, means=True)
        assert sim.save() == before
        sim.advance(2e-3)
        looked_at = sim.state()
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.start(Options(Method.DP8, 1, 1e-9, 0.0, np.inf, np.inf), 0.0)
        sim.advance(1e-3)
        sim.advance(2e-3)
        assert np.array_equal(looked_at, sim.state())


def test_at_their_means_time_no_longer_matters():
    model = gb.build(p1())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.0) as point:
            later = point.at(t=1e-5)
            assert not np.array_equal(point.rates(), later.rates())
            assert np.array_equal(point.at(means=True).rates(), later.at(means=True).rates())
            assert (state_matrix(point.at(means=True)) != state_matrix(later.at(means=True))).nnz == 0


@pytest.mark.parametrize("means", [False, True])
@pytest.mark.parametrize("problem", [P4(n=40), P4(n=41)], ids=["even", "odd"])
@pytest.mark.few(1)
def test_the_derivatives_of_the_laws_are_those_that_differences_find(problem, means):
    model = gb.build(train(problem))
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.01) as point:
            held = point.at(means=means, modes=np.where(np.arange(len(point.modes)) % 3 == 0, 0.0, point.modes))
            exact, found = state_matrix(held), differenced_state_matrix(held)
            largest = abs(exact).max(axis=1).toarray()
            assert (np.abs((exact - found).toarray()) <= 1e-8 * largest.reshape(-1, 1)).all()
