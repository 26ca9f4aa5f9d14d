"""The dense Jacobian and inertia of small models are the sparse ones, and refuse what these refuse."""

import numpy as np
import pytest

import gearblocks as gb
from benchmarks.cases import P4
from benchmarks.problems import p1, p2, train
from gearblocks.solver.matrix_algebra import DENSE
from gearblocks.solver.point import opened, state_matrix

ROUNDING = 1e-13  # of the largest derivative of a state: a few dozen operations


def _chained(name, *blocks):
    rig = gb.Drivetrain(name)
    rig.chain(*(rig.add(f"part{i}", block) for i, block in enumerate(blocks)))
    return rig


def _massless():
    """Two springs in a row with nothing between: a speed that is no state."""
    motor, wheel = gb.Inertia(J=0.3, w0=5.0), gb.Inertia(J=2.0, w0=5.0)
    return _chained("massless", gb.Torque(tau=2.0), motor, gb.Shaft(k=400.0, c=0.3), gb.Shaft(k=9e3, c=0.1), wheel)


def _held():
    """A brake that holds a wheel on a shaft: constraint forces."""
    motor, shaft, wheel = gb.Inertia(J=0.3), gb.Shaft(k=400.0, c=0.3), gb.Inertia(J=2.0)
    return _chained("held", gb.Torque(tau=1.0), motor, shaft, wheel, gb.Brake(capacity=50.0))


TRAINS = {"p1": p1, "p2": p2, "chain": lambda: train(P4(n=12)), "massless": _massless, "held": _held}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.parametrize("means", [False, True])
def test_dense_derivatives_are_the_sparse_ones(name, means):
    model = gb.build(TRAINS[name]())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.02) as point:
            sparse = state_matrix(point.at(means=means)).toarray()
            dense = state_matrix(point.at(means=means, algebra=DENSE))
            assert isinstance(dense, np.ndarray) and dense.shape == sparse.shape
            largest = np.abs(sparse).max(axis=1, keepdims=True)
            assert (np.abs(dense - sparse) <= ROUNDING * largest).all()
            assert ((dense != 0) == (sparse != 0)).all()  # what does not depend is exactly zero
            if sim.has_jacobian:
                assert np.array_equal(sim.inertia(0.02, point.y, dense=True), sim.inertia(0.02, point.y).toarray())


def test_derivatives_that_are_no_numbers_are_refused():
    model = gb.build(p1())
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        with opened(sim, model.program, 0.0) as point:
            sim.parameters[:] = np.nan
            sim.changed()
            for dense in (False, True):
                with pytest.raises(ArithmeticError):
                    sim.jacobian(0.0, point.y, point.modes, dense=dense)
