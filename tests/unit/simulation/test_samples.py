"""Outputs that are evaluated when they are read: the same bits however they are asked for, and nothing before that."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation import samples
from gearblocks.simulation.samples import Outputs


def _rig() -> gb.Drivetrain:
    """A pair that rattles, a clutch that breaks away, an input and a law over time."""
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=3.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02, w0=3.0)),
        rig.add("clutch", gb.Clutch(capacity=2.0 + gb.sin(30 * gb.time))),
        rig.add("pinion", gb.Inertia(J=0.01)),
        rig.add("play", gb.Lash(k=1e4, c=1.0, half_gap=1e-3)),
        rig.add("wheel", gb.Inertia(J=0.05)),
        rig.add("load", gb.Torque(tau=-2.0 * gb.sin(12 * gb.time))),
    )
    return rig


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(_rig())


def _run(model: gb.Model, **arguments: Any) -> gb.Trajectory:
    return gb.simulate(
        model, **({"inputs": {"tau": lambda t: 3 + t}, "parameters": {"play.k": 2e4}} | (arguments or {"t_end": 1.0}))
    )


def _lazily(run: gb.Trajectory) -> Outputs:
    assert isinstance(run._columns, Outputs)
    return run._columns


def test_nothing_is_evaluated_before_it_is_read(model: gb.Model) -> None:
    run = _run(model)
    assert len(run) == len(model.program.outputs) and "motor.w" in run and run.names[0] in run
    assert not _lazily(run)._known
    first = run["play.torque"]
    assert len(first) == len(run.t) and not first.flags.writeable
    assert run["motor.w"] is run["motor.w"]


def test_the_same_bits_one_by_one_together_in_batches_and_in_another_process(
    model: gb.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    together, alone, batched, sent = (_run(model) for _ in range(4))
    assert set(_lazily(together)) == set(together.names)
    table = {name: together[name] for name in together.names}
    assert len(_lazily(together)._known) == len(table)
    monkeypatch.setattr(samples, "AT_ONCE", 0)
    monkeypatch.setattr(samples, "_BATCH", 7)
    for name in reversed(alone.names):
        assert np.array_equal(alone[name], table[name], equal_nan=True), name
        assert name in _lazily(alone)._known
    stacked = np.concatenate(list(_lazily(batched).batches()))
    assert np.array_equal(stacked, np.column_stack([*table.values()]), equal_nan=True)
    assert not _lazily(batched)._known
    loaded = pickle.loads(pickle.dumps(sent))
    assert all(np.array_equal(loaded[name], table[name], equal_nan=True) for name in table)
    assert loaded.events == together.events and loaded.energy.residual == together.energy.residual


def test_parameters_and_inputs_of_the_run_hold_when_outputs_are_read_later(model: gb.Model) -> None:
    stiff, soft = _run(model, t=[0.3]), _run(model, t=[0.3], parameters={"play.k": 1e3})
    alone = _run(model, t=[0.3], outputs=["play.*"])
    assert stiff["wheel.w"] != soft["wheel.w"]
    assert all(stiff[name] == alone[name] for name in alone.names)
    assert stiff.meta["parameters"]["play.k"] == 2e4 and dict(soft.meta["parameters"])["play.k"] == 1e3
    heavy = _run(model, t=[0.3], parameters={"motor.J": 0.03})
    assert heavy["motor.kinetic_energy"][0] == pytest.approx(0.5 * 0.03 * heavy["motor.w"][0] ** 2, rel=1e-15)
    onward = gb.simulate(model, t_end=0.4, initial=stiff)
    assert onward.t[0] == 0.3 and onward.meta["parameters"]["play.k"] == 2e4


def test_files_hold_what_is_read(model: gb.Model, tmp_path: Path) -> None:
    run = _run(model, t_end=1.0, outputs=["motor.*", "play.*"])
    for name in ("run.nc", "run.json"):
        run.save(tmp_path / name)
        loaded = gb.Trajectory.load(tmp_path / name)
        assert loaded.names == run.names and loaded.events == run.events
        assert all(np.array_equal(loaded[n], run[n], equal_nan=True) for n in run.names)
    _run(model, t_end=1.0, outputs=["motor.*", "play.*"]).to_csv(tmp_path / "run.csv")
    read = np.genfromtxt(tmp_path / "run.csv", delimiter=",", names=True)
    assert np.array_equal(read["t"], run.t) and len(read.dtype) == 1 + len(run)


@pytest.mark.long
def test_a_run_with_many_samples_keeps_them_once() -> None:
    rig = gb.Drivetrain("one")
    rig.add("motor", gb.Inertia(J=1.0, w0=1.0))
    model = gb.build(rig)
    run = gb.simulate(model, t=np.linspace(0.0, 1.0, 200_001))
    pieces = _lazily(run)._samples.pieces
    assert len(pieces) == 1 and pieces[0].nbytes <= 200_001 * 8 * (1 + model.program.n_total + 2)
    assert run["motor.phi"][-1] == pytest.approx(1.0, rel=1e-12)


def test_few_outputs_of_a_long_train_are_kept_without_its_states(
    monkeypatch: pytest.MonkeyPatch, model: gb.Model
) -> None:
    from gearblocks.simulation import run as runs

    wanted = ["wheel.w", "play.torque"]
    plain = _run(model, t_end=1.0, outputs=wanted)
    monkeypatch.setattr(runs, "WIDE", 8)
    kept = _run(model, t_end=1.0, outputs=wanted)
    assert not isinstance(kept._columns, Outputs) and isinstance(plain._columns, Outputs)
    assert np.array_equal(kept.t, plain.t) and kept.names == plain.names and kept.units == plain.units
    assert all(np.array_equal(kept[name], plain[name]) for name in wanted)
    assert kept.energy.to_dict() == plain.energy.to_dict() and kept.events == plain.events
    assert kept.final_state is not None and plain.final_state is not None
    assert np.array_equal(kept.final_state.y, plain.final_state.y)
    assert isinstance(_run(model, t_end=1.0)._columns, Outputs)  # all of them


def _alike(count: int) -> gb.Drivetrain:
    """Bodies in a row with as many alike meshes and gaps between them, and a clutch that sticks."""
    rig = gb.Drivetrain("alike")
    first = rig.add("body0", gb.Inertia(J=0.01, w0=5.0))
    parts = [rig.add("drive", gb.Torque(tau=3.0 + gb.sin(40 * gb.time))), first]
    for i in range(count):
        mesh = gb.GearMesh(
            teeth=(20 + i, 31), module=2e-3, pressure_angle=0.35, external=True, k=1e7, damping_ratio=0.1,
            stiffness_variation=gb.Fourier(cos=(0.2,)), friction=gb.ToothFriction(mu=0.05, transition=1e-2),
        )  # fmt: skip
        gap = gb.Lash(k=1e4, c=1.0, half_gap=1e-3)
        parts += [rig.add(f"mesh{i}", mesh), rig.add(f"wheel{i}", gb.Inertia(J=0.02))]
        parts += [rig.add(f"gap{i}", gap), rig.add(f"body{i + 1}", gb.Inertia(J=0.01))]
    rig.chain(*parts)
    rig.connect(rig.add("clutch", gb.Clutch(capacity=1e3)).a, first.b)
    rig.connect(rig["clutch"].b, rig.add("disc", gb.Inertia(J=0.01, w0=5.0)).a)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("count", [1, 3, pytest.param(9, marks=pytest.mark.long)])  # one by one, and in a loop
def test_an_output_alone_has_the_bits_of_all_of_them(count: int) -> None:
    run = gb.simulate(_alike(count), t_end=0.02)
    taken = _lazily(run)._samples
    every = taken.table(range(len(run)))
    assert np.array_equal(every, np.column_stack([run[name] for name in run.names]), equal_nan=True)
    random = np.random.default_rng(count)
    picks = [[i] for i in range(len(run))] + [random.choice(len(run), 3, replace=False).tolist() for _ in range(30)]
    for pick in picks:
        assert np.array_equal(taken.table(pick), every[:, pick], equal_nan=True), [run.names[i] for i in pick]
