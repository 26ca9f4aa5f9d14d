"""A run keeps what it was given, gives it back by name, and survives storage to the last bit."""

from __future__ import annotations

import csv
import dataclasses
import errno
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearblocks.errors import GearblocksError, StorageError, UnknownNameError
from gearblocks.simulation.trajectory import EnergyLedger, Event, FinalState, Stats, Trajectory

LEDGER = EnergyLedger(
    stored={"motor": 2.0, "mesh": 1.0},
    start=1.0,
    dissipated={"mesh": 0.25, "shaft": 0.75},
    supplied={"drive": 3.0},
    exchanged=16.0,
    largest_stored=4.0,
)


def make_run(**changes: Any) -> Trajectory:
    t = np.array([0.0, 0.1, 0.1, 1.0 / 3.0])
    fields: dict[str, Any] = {
        "t": t,
        "columns": {
            "mesh.force": np.array([1.0, 2.0 / 3.0, 5e-324, -1.7976931348623157e308]),
            "mesh.deflection": np.array([0.1, -0.0, 1e-17, 3.0]),
            "wheel.w": np.array([100.0, 100.0, 100.1, np.pi]),
            "planet.sun_mesh[1].force": np.array([1.0, 2.0, 3.0, 4.0]),
        },
        "units": {"mesh.force": "N", "mesh.deflection": "m", "wheel.w": "rad/s", "planet.sun_mesh[1].force": "N"},
        "events": (Event(0.1, "mesh", "state", 1.0, 0.0), Event(0.2, "drive", "time", 0.0, 1.0)),
        "stats": Stats(steps=3, rejected=1, rhs_calls=40, events=2, cpu_seconds=1e-3, method="dp8", why="asked for"),
        "energy": LEDGER,
        "meta": {"train": "a pair", "method": "dp8", "rtol": 1e-8, "parameters": {"mesh.k": 1.5e8, "stop": math.inf}},
        "final_state": FinalState(1.0 / 3.0, np.array([0.1, 0.2]), np.array([1.0]), "abc"),
    }
    return Trajectory(**(fields | changes))


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


def test_outputs_are_found_by_name() -> None:
    run = make_run()
    assert run["wheel.w"][0] == 100.0
    assert run["t"] is run.t
    assert run.names == ("mesh.force", "mesh.deflection", "wheel.w", "planet.sun_mesh[1].force")
    assert "mesh.force" in run and "mesh.torque" not in run
    assert run.units["mesh.force"] == "N"
    assert list(run) == list(run.names)


def test_columns_may_come_as_one_table() -> None:
    table = np.arange(8.0).reshape(4, 2)
    run = make_run(columns=(("a.x", "a.y"), table))
    assert run["a.y"].tolist() == [1.0, 3.0, 5.0, 7.0]


def test_a_run_cannot_be_changed() -> None:
    run = make_run()
    for values in (run.t, run["mesh.force"], run.final_state.y if run.final_state else run.t):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 7.0
    with pytest.raises(AttributeError, match="cannot be changed"):
        run.t = np.zeros(3)
    with pytest.raises(AttributeError, match="cannot be changed"):
        del run.stats
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.stats.steps = 4  # type: ignore[misc]
    with pytest.raises(TypeError):
        run.energy.stored["mesh"] = 0.0  # type: ignore[index]
    with pytest.raises(TypeError):
        run.meta["train"] = "another"  # type: ignore[index]


def test_an_unknown_output_is_refused_with_the_near_one() -> None:
    with pytest.raises(KeyError) as caught:
        make_run()["mesh.forse"]
    assert isinstance(caught.value, GearblocksError)
    assert "mesh.forse" in str(caught.value) and "did you mean 'mesh.force'" in str(caught.value)


def test_patterns_cross_dots_and_brackets_mean_themselves() -> None:
    run = make_run()
    assert run.select("mesh.*").names == ("mesh.force", "mesh.deflection")
    assert run.select("*force").names == ("mesh.force", "planet.sun_mesh[1].force")
    assert run.find("planet.sun_mesh[1].*") == ("planet.sun_mesh[1].force",)
    assert run.select("wheel.w", "mesh.force").names == ("mesh.force", "wheel.w")
    assert run.select("mesh.*").energy is run.energy
    with pytest.raises(UnknownNameError, match="pump"):
        run.select("mesh.*", "pump.*")


def test_wrong_shapes_and_names_are_refused() -> None:
    with pytest.raises(GearblocksError, match=r"'a\.x' has shape \(3,\); the run has 4 samples"):
        make_run(columns={"a.x": np.zeros(3)})
    with pytest.raises(GearblocksError, match="cannot be named 't'"):
        make_run(columns={"t": np.zeros(4)})
    with pytest.raises(GearblocksError, match="2 names do not fit"):
        make_run(columns=(("a", "b"), np.zeros((4, 3))))


def test_the_ledger_balances() -> None:
    assert LEDGER.end == 3.0
    assert LEDGER.turnover == 20.0
    assert LEDGER.imbalance == 0.0  # 3 - 1 - 3 + 1
    assert dataclasses.replace(LEDGER, start=0.0).residual == 1.0 / 20.0
    assert EnergyLedger().residual == 0.0
    assert "supplied by drive" in str(LEDGER)


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_a_stored_run_comes_back_bit_for_bit(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"käfig mit lücke{ending}"
    run = make_run()
    run.save(path)
    assert_equal(run, Trajectory.load(path))


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_not_a_number_and_infinity_are_kept(tmp_path: Path, ending: str) -> None:
    run = make_run(columns={"a.x": np.array([np.nan, np.inf, -np.inf, 1.0])}, events=())
    run.save(tmp_path / f"r{ending}")
    loaded = Trajectory.load(tmp_path / f"r{ending}")
    np.testing.assert_array_equal(loaded["a.x"], run["a.x"])
    assert loaded.events == ()


def test_a_run_travels_between_processes() -> None:
    run = make_run()
    assert_equal(run, pickle.loads(pickle.dumps(run)))


def test_csv_has_names_and_all_digits(tmp_path: Path) -> None:
    run = make_run()
    run.to_csv(tmp_path / "r.csv")
    with open(tmp_path / "r.csv", newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == ["t", *run.names]
    read = np.array(rows, dtype=float)
    assert read[:, 0].tobytes() == run.t.tobytes()
    assert read[:, 1].tobytes() == run["mesh.force"].tobytes()


def test_dataframe_and_dataset_carry_times_and_units() -> None:
    run = make_run()
    frame = run.to_dataframe()
    assert frame.index.name == "t" and frame["wheel.w"].iloc[0] == 100.0
    data = run.to_xarray()
    assert data["mesh.force"].attrs["units"] == "N" and data["t"].attrs["units"] == "s"
    np.testing.assert_array_equal(data["event_t"], [0.1, 0.2])


def test_an_unknown_ending_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"r\.xls.*\.nc, \.json, \.csv"):
        make_run().save(tmp_path / "r.xls")


@pytest.mark.parametrize("ending", [".nc", ".json"])
def test_a_damaged_or_missing_file_is_refused_by_name(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"r{ending}"
    with pytest.raises(StorageError, match=r"cannot read .*no such file"):
        Trajectory.load(path)
    make_run().save(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(StorageError, match="damaged"):
        Trajectory.load(path)


@pytest.mark.parametrize("ending", [".nc", ".json", ".csv"])
def test_a_missing_folder_is_named(tmp_path: Path, ending: str) -> None:
    with pytest.raises(StorageError, match="there is no folder"):
        make_run().save(tmp_path / "nowhere" / f"r{ending}")


def test_a_read_only_folder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
@pytest.mark.parametrize("ending", [".nc", ".json", ".csv"])
def test_a_full_disk_leaves_the_old_file_alone(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"r{ending}"
    path.write_text("precious")
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, check=True, timeout=60
    )
    assert "cannot write" in done.stdout and "unchanged" in done.stdout
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("ending", [".png", ".svg", ".pdf"])
def test_a_plot_is_written_and_returned(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"bild{ending}"
    figure = make_run(columns={"mesh.force": np.arange(4.0), "a.w": np.ones(4)}).plot("mesh.*", "a.w", path=path)
    assert path.stat().st_size > 1000
    assert len(figure.axes) == 2


def test_a_plot_of_an_unknown_output_or_form_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"mesh\.torque"):
        make_run().plot("mesh.torque", path=tmp_path / "x.png")
    with pytest.raises(StorageError, match=r"\.png"):
        make_run().plot("wheel.w", path=tmp_path / "x.docx")
    assert not list(tmp_path.iterdir())


def test_the_representation_tells_what_the_run_is() -> None:
    words = repr(make_run())
    assert "a pair" in words and "4 samples" in words and "dp8" in words
    assert "stopped early" in repr(make_run(meta={"train": "x", "complete": False}))
