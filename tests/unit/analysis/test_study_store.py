"""The store of a study: what was done stays done, whoever is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

pytestmark = pytest.mark.skipif(find_spec("zarr") is None, reason="zarr is not here")  # to import it takes seconds

VALUES = {"shaft.k": np.linspace(100.0, 200.0, 12), "gain": [0.0, 1e4]}
QUANTITIES = [gb.peak("shaft.torque"), gb.energy_lost("clutch")]


def _swept(model: gb.Model, store: Path, done: list[int] | None = None, **change: Any) -> gb.Study:
    tell = None if done is None else lambda count, _: done.append(count)
    arguments = {"quantity": QUANTITIES, "t_end": 0.2, "chunk": 5, "threads": 1, "progress": tell, **change}
    return gb.sweep(model, arguments.pop("values", VALUES), store=store, **arguments)


def test_a_second_call_runs_only_what_is_missing(clutch_model: gb.Model, tmp_path: Path) -> None:
    plain = gb.sweep(clutch_model, VALUES, quantity=QUANTITIES, t_end=0.2)

    def stop(count: int, _: int) -> None:
        if count >= 10:
            raise KeyboardInterrupt

    first = _swept(clutch_model, tmp_path / "out.zarr", progress=stop)
    assert first.done.sum() == 10
    counts: list[int] = []
    second = _swept(clutch_model, tmp_path / "out.zarr", counts)
    assert len(counts) == 3 and counts[-1] == 24
    assert second.complete and second.values.tobytes() == plain.values.tobytes()
    assert second.failures == plain.failures and len(second.failures) == 12
    again: list[int] = []
    third = _swept(clutch_model, tmp_path / "out.zarr", again, threads=2, chunk=3)  # what is stored keeps its chunks
    assert again == [] and third.values.tobytes() == plain.values.tobytes() and third.failures == plain.failures


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rtol": 1e-7}, "the method or tolerance"),
        ({"t_end": 0.3}, "the time"),
        ({"quantity": QUANTITIES[:1]}, "the quantities"),
        ({"values": {"shaft.k": [1.0]}}, "the grid"),
        ({"parameters": {"shaft.c": 0.3}}, "the fixed parameters"),
        ({"inputs": {"tau": 4.0}}, "the inputs"),
        ({"initial": {"motor.w": 3.0}}, "the fixed parameters, the start"),
    ],
)
@pytest.mark.few(1)
def test_a_store_of_another_study_is_refused_by_what_differs(
    clutch_model: gb.Model, tmp_path: Path, change: dict[str, Any], words: str
) -> None:
    _swept(clutch_model, tmp_path / "out.zarr", t_end=0.2)
    with pytest.raises(gb.errors.StorageError) as caught:
        _swept(clutch_model, tmp_path / "out.zarr", **change)
    assert f"holds another study (what differs: {words})" in str(caught.value)


def _scaled(k: float) -> Any:
    return lambda run: k * float(run["shaft.torque"][-1])


def _constant(x: float) -> Any:
    return lambda t: x


def test_functions_are_told_apart_by_what_they_have_from_around_them(clutch_model: gb.Model, tmp_path: Path) -> None:
    few = {"values": {"shaft.k": [100.0]}, "t_end": 0.01}
    first = _swept(clutch_model, tmp_path / "out.zarr", quantity=_scaled(1.0), **few)
    again = _swept(clutch_model, tmp_path / "out.zarr", quantity=_scaled(1.0), **few)
    assert again.values.tobytes() == first.values.tobytes()
    with pytest.raises(gb.errors.StorageError, match="what differs: the quantities"):
        _swept(clutch_model, tmp_path / "out.zarr", quantity=_scaled(2.0), **few)
    _swept(clutch_model, tmp_path / "in.zarr", inputs={"tau": _constant(1.0)}, **few)
    _swept(clutch_model, tmp_path / "in.zarr", inputs={"tau": _constant(1.0)}, **few)
    with pytest.raises(gb.errors.StorageError, match="what differs: the inputs"):
        _swept(clutch_model, tmp_path / "in.zarr", inputs={"tau": _constant(2.0)}, **few)


class _Scaled:
    """Counts its calls, as objects that are called do."""

    def __init__(self, k: float) -> None:
        self.k, self.calls = k, 0

    def __call__(self, run: gb.Trajectory) -> float:
        self.calls += 1
        return self.k * float(run["shaft.torque"][-1])

    def halved(self, run: gb.Trajectory) -> float:
        return self(run) / 2


def _by(k: float, run: gb.Trajectory) -> float:
    return k * float(run["shaft.torque"][-1])


def test_objects_that_are_called_are_told_apart_by_what_they_hold(clutch_model: gb.Model, tmp_path: Path) -> None:
    few = {"values": {"shaft.k": [100.0]}, "t_end": 0.01}
    counting = _Scaled(1.0)
    for quantity, other in (
        (counting, _Scaled(2.0)), (partial(_by, 1.0), partial(_by, 2.0)), (counting.halved, counting.__call__),
    ):  # fmt: skip
        store = tmp_path / f"{type(quantity).__name__}.zarr"
        first = _swept(clutch_model, store, quantity=quantity, **few)
        assert _swept(clutch_model, store, quantity=quantity, **few).values.tobytes() == first.values.tobytes()
        with pytest.raises(gb.errors.StorageError, match="what differs: the quantities"):
            _swept(clutch_model, store, quantity=other, **few)


def test_a_store_of_another_train_is_refused(clutch_model: gb.Model, tmp_path: Path) -> None:
    rig = gb.Drivetrain("other")
    rig.chain(
        rig.add("a", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=1.0, c=0.1)), rig.add("b", gb.Inertia(J=1.0))
    )
    values = {"shaft.k": [1.0, 2.0]}
    gb.sweep(clutch_model, values, quantity=gb.last("shaft.torque"), t_end=0.2, store=tmp_path / "out.zarr")
    with pytest.raises(gb.errors.StorageError, match="what differs: the train"):
        gb.sweep(rig, values, quantity=gb.last("shaft.torque"), t_end=0.2, store=tmp_path / "out.zarr")


def test_what_is_no_store_is_left_alone(clutch_model: gb.Model, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "mine.txt").write_text("kept")
    (tmp_path / "file").write_text("kept")
    for name in ("folder", "file"):
        with pytest.raises(gb.errors.StorageError, match="left alone"):
            _swept(clutch_model, tmp_path / name)
    assert (tmp_path / "folder" / "mine.txt").read_text() == (tmp_path / "file").read_text() == "kept"


def test_a_store_needs_zarr_and_says_so(
    clutch_model: gb.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(gb.errors.StorageError, match=r"pip install 'gearblocks\[zarr\]'"):
        _swept(clutch_model, tmp_path / "out.zarr")


SCRIPT = """
import sys
import numpy as np
import gearblocks as gb

rig = gb.Drivetrain("long study")
left, shaft = rig.add("left", gb.Inertia(J=0.1, w0=50.0)), rig.add("shaft", gb.Shaft(k=200.0, c=0.01))
rig.chain(left, shaft, rig.add("right", gb.Inertia(J=0.3)))
found = gb.sweep(
    rig, {"shaft.k": np.linspace(100.0, 200.0, 60)}, quantity=[gb.rms("shaft.torque"), gb.last("left.w")], t_end=6.0, rtol=1e-9,
    threads=1, chunk=2, store=sys.argv[1] if len(sys.argv) > 1 else None, progress=lambda done, total: print(done, flush=True),
)
print(found.values.tobytes().hex())
"""


def _script(path: Path, *arguments: str) -> list[str]:
    path.write_text(SCRIPT)
    return [sys.executable, str(path), *arguments]


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no kill -9 on this system")
def test_a_study_that_is_killed_twice_goes_on_and_ends_as_if_undisturbed(tmp_path: Path) -> None:
    plain = subprocess.run(_script(tmp_path / "study.py"), capture_output=True, text=True, check=True, timeout=60)
    store = str(tmp_path / "out.zarr")
    reached = []
    for target in (10, 30):
        with subprocess.Popen(
            _script(tmp_path / "study.py", store), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None and process.stderr is not None
            done = 0
            for line in process.stdout:
                done = int(line)
                if done >= target:
                    break
            os.kill(process.pid, signal.SIGKILL)
            assert process.wait(timeout=20) == -signal.SIGKILL, process.stderr.read()
        reached.append(done)
    assert 10 <= reached[0] < reached[1] < 60
    last = subprocess.run(_script(tmp_path / "study.py", store), capture_output=True, text=True, check=True, timeout=60)
    lines = last.stdout.split()
    assert int(lines[0]) > reached[1]  # it begins where it was killed
    assert lines[-1] == plain.stdout.split()[-1]


def test_values_are_stored_before_their_flags(clutch_model: gb.Model, tmp_path: Path) -> None:
    import zarr

    began = time.time()
    found = _swept(clutch_model, tmp_path / "out.zarr")
    group = zarr.open_group(tmp_path / "out.zarr", mode="r")
    assert (np.asarray(group["done"]) == 1).all()
    assert np.asarray(group["values"]).tobytes() == found.values.tobytes()
    chunk = sorted((tmp_path / "out.zarr" / "done").rglob("[0-9]*"))
    assert chunk and min(path.stat().st_mtime for path in chunk) >= began - 1
