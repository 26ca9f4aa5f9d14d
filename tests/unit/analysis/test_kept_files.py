"""Files that version 0.1 wrote open: a run, a train and a study of each format are kept in tests/data/version_0_1."""

from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

KEPT = Path(__file__).parents[2] / "data" / "version_0_1"
SPEEDS = [0.0, -0.024190002560166266, -0.09919000256016632]  # [rad/s] of the load at 0, 5 and 10 ms


@pytest.mark.parametrize("name", ["run.nc", "run.json"])
def test_runs(name):
    run = gb.Trajectory.load(KEPT / name)
    assert (run.name, len(run.t), len(run.events), run.stats.steps) == ("kept", 11, 25, 38)
    assert run["load.w"][:3].tolist() == SPEEDS
    assert run.units["mesh.force"] == "N"
    assert run.events[0].component == "clutch"
    assert run.energy.dissipated["clutch"] == pytest.approx(0.02907792063259722, rel=1e-15)
    assert run.energy.residual < 1e-6


def test_a_train_which_runs_as_it_did():
    rig = gb.Drivetrain.from_json(KEPT / "train.json")
    run = gb.simulate(rig, t=np.linspace(0, 0.05, 11), rtol=1e-9)
    assert run["load.w"][:3] == pytest.approx(SPEEDS, abs=1e-7)


def test_a_study():
    study = gb.Study.load(KEPT / "study.nc")
    found = np.asarray(study["last(load.w)"])
    assert found.shape == (2, 3)
    assert found[1, 1] == -0.8991900025601677
    assert study.to_xarray()["peak(mesh.force)"].attrs["units"] == "N"
