"""A run survives storage to the last bit, and a failure while it is written keeps the file that was there."""

from __future__ import annotations

import csv
import errno
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import StorageError
from gearblocks.simulation.trajectory import Trajectory


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=1.0e3, c=1.0)),
        rig.add("wheel", gb.Inertia(J=0.1)),
    )
    return rig


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(_rig())


@pytest.mark.parametrize("ending", [".csv", ".nc", ".json"])
def test_a_full_disk_while_a_run_is_written_keeps_the_file_that_was_there(
    model: gb.Model, ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = gb.simulate(model, t_end=0.1)
    path = tmp_path / f"run{ending}"
    path.write_text("before")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    for call in ("fsync", "replace"):
        with monkeypatch.context() as patch:
            patch.setattr(os, call, full)
            with pytest.raises(gb.GearblocksError, match=f"run{ending}.*no space left.*unchanged"):
                run.save(path)
        assert path.read_text() == "before"
        assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(gb.GearblocksError, match="there is no folder"):
        run.save(tmp_path / "none" / f"run{ending}")
    run.save(path)
    assert path.stat().st_size > 100


def assert_equal(one: Trajectory, other: Trajectory) -> None:
    assert one.names == other.names
    assert dict(one.units) == dict(other.units)
    for name in ("t", *one.names):
        assert one[name].tobytes() == other[name].tobytes()
    assert one.events == other.events
    assert one.stats == other.stats
    assert one.energy.to_dict() == other.energy.to_dict()
    assert dict(one.meta) == dict(other.meta)
    assert one.final_state is not None and other.final_state is not None
    assert one.final_state.y.tobytes() == other.final_state.y.tobytes()
    assert one.final_state.modes.tobytes() == other.final_state.modes.tobytes()
    assert (one.final_state.t, one.final_state.key) == (other.final_state.t, other.final_state.key)


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_a_stored_run_comes_back_bit_for_bit(make_run: Callable[..., Trajectory], tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"käfig mit lücke{ending}"
    run = make_run()
    run.save(path)
    assert_equal(run, Trajectory.load(path))


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_not_a_number_and_infinity_are_kept(make_run: Callable[..., Trajectory], tmp_path: Path, ending: str) -> None:
    run = make_run(columns={"a.x": np.array([np.nan, np.inf, -np.inf, 1.0])}, events=())
    run.save(tmp_path / f"r{ending}")
    loaded = Trajectory.load(tmp_path / f"r{ending}")
    np.testing.assert_array_equal(loaded["a.x"], run["a.x"])
    assert loaded.events == ()


def test_a_run_travels_between_processes(make_run: Callable[..., Trajectory]) -> None:
    run = make_run()
    assert_equal(run, pickle.loads(pickle.dumps(run)))


def test_csv_has_names_and_all_digits(make_run: Callable[..., Trajectory], tmp_path: Path) -> None:
    run = make_run()
    run.to_csv(tmp_path / "r.csv")
    with open(tmp_path / "r.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == ["t", *run.names]
    read = np.array(rows, dtype=float)
    assert read[:, 0].tobytes() == run.t.tobytes()
    assert read[:, 1].tobytes() == run["mesh.force"].tobytes()


def test_dataframe_and_dataset_carry_times_and_units(make_run: Callable[..., Trajectory]) -> None:
    run = make_run()
    frame = run.to_dataframe()
    assert frame.index.name == "t" and frame["wheel.w"].iloc[0] == 100.0
    data = run.to_xarray()
    assert data["mesh.force"].attrs["units"] == "N" and data["t"].attrs["units"] == "s"
    np.testing.assert_array_equal(data["event_t"], [0.1, 0.2])


def test_an_unknown_ending_is_refused_by_name(make_run: Callable[..., Trajectory], tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"r\.xls.*\.nc, \.json, \.csv"):
        make_run().save(tmp_path / "r.xls")


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_a_damaged_or_missing_file_is_refused_by_name(
    make_run: Callable[..., Trajectory], tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"r{ending}"
    with pytest.raises(StorageError, match=r"cannot read .*no such file"):
        Trajectory.load(path)
    make_run().save(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(StorageError, match="damaged"):
        Trajectory.load(path)


@pytest.mark.parametrize("ending", [".nc", ".json", ".csv"])
def test_a_missing_folder_is_named(make_run: Callable[..., Trajectory], tmp_path: Path, ending: str) -> None:
    with pytest.raises(StorageError, match="there is no folder"):
        make_run().save(tmp_path / "nowhere" / f"r{ending}")


def test_a_read_only_folder_is_named(
    make_run: Callable[..., Trajectory], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr("tempfile.mkstemp", refuse)  # where root runs the tests, no folder is read-only
    with pytest.raises(StorageError, match=r"cannot write .*r\.json': read-only file system"):
        make_run().save(tmp_path / "r.json")


FULL_DISK = """
import resource, sys
import numpy as np
from gearblocks.errors import StorageError
from gearblocks.simulation.trajectory import Trajectory
t = np.linspace(0.0, 1.0, 20000)
run = Trajectory(t, {"a.x": t})
resource.setrlimit(resource.RLIMIT_FSIZE, (50000, 50000))
try:
    run.save(sys.argv[1])
except StorageError as error:
    print(error)
"""


@pytest.mark.skipif(os.name != "posix", reason="file size limits are those of Unix")
@pytest.mark.parametrize(
    "ending", [pytest.param(".nc", marks=pytest.mark.long), ".json", pytest.param(".csv", marks=pytest.mark.long)]
)
def test_a_full_disk_leaves_the_old_file_alone(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"r{ending}"
    path.write_text("precious")
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, check=True, timeout=60
    )
    assert "cannot write" in done.stdout and "unchanged" in done.stdout
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]
