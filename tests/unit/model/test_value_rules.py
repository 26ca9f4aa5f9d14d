"""Value rules: what a study varies is held to the rules of blocks, each set of values once; runs and scenes too."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.model.value_rules import check_rows
from gearblocks.solver.library import Model


def _rig(block: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("two")
    rig.chain(
        rig.add("one", gb.Inertia(J=1.0, w0=1.0)), rig.add("joint", block), rig.add("two", gb.Inertia(J=1.0))
    )  # fmt: skip
    return rig


@pytest.fixture(scope="module")
def gapped() -> Model:
    return gb.build(_rig(gb.Lash(k=100.0, c=1.0, lower=-0.1, upper=0.1)))


@pytest.fixture(scope="module")
def shared() -> Model:
    return gb.build(_rig(gb.Shaft(k=gb.Parameter("K", 100.0), c=0.1)))


def _swept(model: Model, axes: dict[str, Any], **more: Any) -> Any:
    return gb.sweep(model, axes, quantity=gb.last("one.w"), t_end=1e-3, **more)


def test_a_sweep_is_refused_before_it_runs(gapped: Model, shared: Model) -> None:
    with pytest.raises(gb.ParameterError, match=r"Lash 'joint': lower = 0.3 rad must be <= upper = 0.1 rad"):
        _swept(gapped, {"joint.lower": [-0.1, 0.0, 0.3]})
    with pytest.raises(gb.ParameterError, match=r"lower = 0.3 rad must be <= upper = 0.2 rad"):
        _swept(gapped, {"joint.lower": [-0.1, 0.3], "joint.upper": [0.2, 0.4]})
    with pytest.raises(gb.ParameterError, match=r"Shaft 'joint': k = -1.0 N m/rad .* must be > 0"):
        _swept(shared, {"K": [1.0, -1.0]})


def test_values_that_fit_together_alone_are_taken(gapped: Model) -> None:
    """The fixed end is beyond that of the train; with those that vary it is not."""
    study = _swept(gapped, {"joint.upper": [0.6, 0.7]}, parameters={"joint.lower": 0.5})
    assert np.isfinite(study.values).all()
    with pytest.raises(gb.ParameterError, match=r"lower = 0.5 rad must be <= upper = 0.1 rad"):
        _swept(gapped, {"two.J": [1.0, 2.0]}, parameters={"joint.lower": 0.5})


def test_a_model_of_another_process_is_held_to_them_too(gapped: Model) -> None:
    there = pickle.loads(pickle.dumps(gapped))
    with pytest.raises(gb.ParameterError, match=r"lower = 0.5 rad must be <= upper = 0.1 rad"):
        gb.simulate(there, t_end=1e-3, parameters={"joint.lower": 0.5})


def test_each_set_of_values_is_asked_once(gapped: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []
    problems = gb.Lash.problems

    def counted(block: gb.Lash) -> Any:
        asked.append(float(str(block.lower)))
        return problems(block)

    monkeypatch.setattr(gb.Lash, "problems", counted)
    numbers = gapped.program.parameter_numbers
    columns = {numbers["joint.lower"]: np.tile([-0.1, 0.0], 500), numbers["two.J"]: np.linspace(1.0, 2.0, 1000)}
    check_rows(gapped, gapped.values, columns)
    assert sorted(set(asked)) == [-0.1, 0.0]
    assert len(asked) == 2


def test_an_earlier_run_of_another_train_brings_no_values_that_a_block_refuses(shared: Model) -> None:
    stable = gb.build(_rig(gb.Shaft(k=100.0, c=0.1)))
    loose = gb.simulate(_rig(gb.Shaft(k=-1.0, c=0.1, allow_negative=True)), t_end=1e-3)
    with pytest.raises(gb.ParameterError, match=r"joint.k = -1.0 N m/rad must be > 0 \(or give allow_negative=True\)"):
        gb.simulate(stable, t_end=2e-3, initial=loose)
    with pytest.raises(gb.ParameterError, match=r"k = 0.0 N m/rad .* must be > 0"):
        gb.linearize(shared, parameters={"K": 0.0})
    parameters = {"joint.k": 0.0}
    scene = gb.Scene(_rig(gb.Shaft(k=100.0)), t_end=1e-3, quantity=gb.last("one.w"), within=0.1, parameters=parameters)
    with pytest.raises(gb.ParameterError, match=r"joint.k = 0.0 N m/rad must be > 0"):
        gb.price(scene)
