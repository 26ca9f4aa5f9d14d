"""Static starts of small trains by dense matrices are those by sparse ones."""

import numpy as np
import pytest

import gearblocks as gb
from benchmarks.cases import P4
from benchmarks.problems import p1, train
from gearblocks.errors import SimulationError
from gearblocks.solver import matrix_algebra

ROUNDING = 1e-12  # Newton's method ends at rounding; a few dozen operations follow


def _chained(name, *blocks):
    rig = gb.Drivetrain(name)
    rig.chain(*(rig.add(f"part{i}", block) for i, block in enumerate(blocks)))
    return rig


def _held():
    brake = gb.Brake(capacity=50.0)
    shaft = gb.Shaft(k=400.0, c=0.3)
    return _chained("held", gb.Torque(tau=8.0), gb.Inertia(J=0.3), shaft, gb.Inertia(J=2.0), brake)


def _massless():
    soft, stiff = gb.Shaft(k=400.0, c=0.3), gb.Shaft(k=9e3, c=0.1)
    return _chained("massless", gb.Torque(tau=8.0), gb.Inertia(J=0.3), soft, stiff, gb.Inertia(J=2.0))


def _gap():
    lash = gb.Lash(k=1e4, half_gap=1e-2)
    return _chained("gap", gb.Torque(tau=8.0), gb.Inertia(J=0.3), lash, gb.Inertia(J=2.0), gb.Brake(capacity=50.0))


def _loose():
    """More than the brake carries: no equilibrium."""
    brake = gb.Brake(capacity=5.0)
    shaft = gb.Shaft(k=400.0, c=0.3)
    return _chained("loose", gb.Torque(tau=8.0), gb.Inertia(J=0.3), shaft, gb.Inertia(J=2.0), brake)


def _start(model, initial):
    run = gb.simulate(model, t_end=1e-9, initial=initial)
    return {name: run[name][0] for name in run}


TRAINS = {"p1": p1, "chain": lambda: train(P4(n=8)), "held": _held, "massless": _massless, "gap": _gap}


@pytest.mark.parametrize("initial", ["static", "static_at_start"])
@pytest.mark.parametrize("name", TRAINS)
@pytest.mark.few(1)
def test_dense_and_sparse_starts_agree(name, initial, monkeypatch):
    model = gb.build(TRAINS[name]())
    dense = _start(model, initial)
    monkeypatch.setattr(matrix_algebra, "SMALL", 0)
    sparse = _start(model, initial)
    assert dense.keys() == sparse.keys()
    size = max(np.abs([*sparse.values()]))
    assert [key for key in dense if abs(dense[key] - sparse[key]) > ROUNDING * size] == []


def test_both_name_what_carries_nothing(monkeypatch):
    model, words = gb.build(_loose()), []
    for small in (matrix_algebra.SMALL, 0):
        monkeypatch.setattr(matrix_algebra, "SMALL", small)
        with pytest.raises(SimulationError) as stopped:
            gb.simulate(model, t_end=1e-9, initial="static")
        words.append(str(stopped.value))
    assert words[0] == words[1] and "part4" in words[0]
